"""How a car goes along lanes: which lead to which, places along their middles, and speeds along a path.

It keeps within limits, is slower in bends, and does not go through red lights, which change by their programmes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import accumulate
from typing import Final

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from osm2xodr.checking import driving_of
from osm2xodr.curves import wrapped
from osm2xodr.model import BoolArray, FloatArray, Furniture, IntArray, Signal, SignalLink, SignalProgramme
from osm2xodr.opendrive import OpenDrive, lane_borders, pose, speed_limits, surface_points
from osm2xodr.system import record

# Acceleration and deceleration, m/s2, less than cruise controls may take (ISO 15622: 2 and 3.5 m/s2); and to the side
# as of a friction of 0.2, for which bends of slow roads are designed (AASHTO, Policy on Geometric Design).
_ACCELERATION: Final = 1.5
_DECELERATION: Final = 2.0
_SIDEWAYS: Final = 2.0
# Where no limit is known, m/s, and the most of all: vehicles are watched.
_NO_LIMIT: Final = 50.0 / 3.6
_FASTEST: Final = 100.0 / 3.6
# Length over which the bend of a path is measured, m: a wheelbase, so that corners between roads do not count.
_BEND_LENGTH: Final = 3.0
# How far before the end of a path a car stops, m.
_END_ROOM: Final = 8.0
# How long drivers look at a green light before they go, s.
_REACTION: Final = 1.0
# Speeds of a profile lie within this of what was planned, m/s.
_TOLERANCE: Final = 0.02

# A car stops this far before a junction with its reference point, the middle of the rear axle, m: a metre, and the
# length of a car before that point.
_STOP_BEFORE: Final = 5.0
# OpenDRIVE's type of lights for vehicles.
_LIGHT: Final = "1000001"
# What vehicles may go at.
_GO: Final = frozenset("Ggo")
# Letters of programmes in the order in which one of several ways of a light decides what it shows.
_RANKS: Final = "Ggyro"

# Distance of places along lanes, m: a car is longer.
STEP: Final = 1.0
# Of this type are lanes that all cars may use, for all simulators.
_DRIVING: Final = "driving"


@record
class Light:
    """A light on a path."""

    distance: float  # Where the car has to stop, m along the path
    green: Callable[[float], bool]  # Whether it may go at a time, s
    change: Callable[[float], float]  # When it is green next, s


@record(eq=False)
class Motion:
    """How a car goes: its speed changes evenly between times."""

    time: FloatArray  # (n,) s
    speed: FloatArray  # (n,) m/s
    _distance: FloatArray  # (n,) m

    def distance(self, time: FloatArray) -> FloatArray:
        """Return how far the car is at times, m."""
        k = np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, len(self.time) - 2)
        dt = np.clip(time - self.time[k], 0.0, None)
        span = self.time[k + 1] - self.time[k]
        dt = np.minimum(dt, span)
        slope = (self.speed[k + 1] - self.speed[k]) / np.where(span > 0.0, span, 1.0)
        return np.asarray(self._distance[k] + self.speed[k] * dt + 0.5 * slope * dt**2)

    @property
    def entries(self) -> list[tuple[float, float]]:
        """Times since the entry before, s, and speeds, m/s, such that speeds between lie on lines."""
        kept = _corners(self.time, self.speed)
        steps = np.diff(self.time[kept], prepend=self.time[0])
        return list(zip(steps.tolist(), self.speed[kept].tolist(), strict=True))


def plan_motion(path: Path, lights: Sequence[Light], delay: float = 0.0) -> Motion:
    """Return how a car goes along a path that passes lights, in the order in which it does.

    It sets out after a delay, s; without one it is on its way from the begin.
    """
    most = _most(path)
    # Until when, s, it waits at which place of the path.
    waits = {0: delay} if delay else {}
    motion = _driven(path, most, waits)
    for light in lights:
        at = int(np.searchsorted(path.distance, light.distance, side="right")) - 1
        if at <= 0:
            continue
        arrival = _arrival(motion, path, at)
        if light.green(arrival):
            continue
        waits[at] = light.change(arrival) + _REACTION
        motion = _driven(path, most, waits)
    return motion


def _most(path: Path) -> FloatArray:
    """Return the greatest speed at each place, m/s."""
    limit = np.fmin(np.where(np.isnan(path.limit), _NO_LIMIT, path.limit), _FASTEST)
    ahead = np.minimum(np.searchsorted(path.distance, path.distance + _BEND_LENGTH), len(path.distance) - 1)
    behind = np.maximum(np.searchsorted(path.distance, path.distance - _BEND_LENGTH), 0)
    span = np.maximum(path.distance[ahead] - path.distance[behind], _BEND_LENGTH)
    bend = np.abs(wrapped(path.hdg[ahead] - path.hdg[behind])) / span
    return np.minimum(limit, np.sqrt(_SIDEWAYS / np.maximum(bend, 1e-9)))


def _driven(path: Path, most: FloatArray, waits: dict[int, float]) -> Motion:
    """Return how a car goes that stops at the end, and waits at places until times."""
    speed = most.copy()
    stop = int(np.searchsorted(path.distance, max(path.length - _END_ROOM, 0.0)))
    speed[stop:] = 0.0
    speed[list(waits)] = 0.0
    step = np.diff(path.distance)
    for k in range(len(step) - 1, -1, -1):
        speed[k] = min(speed[k], np.sqrt(speed[k + 1] ** 2 + 2.0 * _DECELERATION * step[k]))
    for k in range(len(step)):
        speed[k + 1] = min(speed[k + 1], np.sqrt(speed[k] ** 2 + 2.0 * _ACCELERATION * step[k]))
    times, speeds, distances = [0.0], [float(speed[0])], [0.0]
    if 0 in waits and stop:
        times, speeds, distances = [0.0, waits[0]], [0.0, 0.0], [0.0, 0.0]
    for k in range(stop):
        times.append(times[-1] + 2.0 * float(step[k]) / float(speed[k] + speed[k + 1]))
        speeds.append(float(speed[k + 1]))
        distances.append(float(path.distance[k + 1]))
        if k + 1 in waits and times[-1] < waits[k + 1]:
            times.append(waits[k + 1])
            speeds.append(0.0)
            distances.append(distances[-1])
    # It stands at the end.
    if len(times) == 1:
        speeds[0] = 0.0
    times.append(times[-1] + 1.0)
    speeds.append(0.0)
    distances.append(distances[-1])
    return Motion(np.array(times), np.array(speeds), np.array(distances))


def _arrival(motion: Motion, path: Path, at: int) -> float:
    """Return when a car gets to a place of its path, s."""
    return float(np.interp(path.distance[at], motion._distance, motion.time))


def _corners(time: FloatArray, speed: FloatArray) -> list[int]:
    """Return the rows between which speeds lie on lines (Ramer, Douglas and Peucker)."""
    kept, todo = {0, len(time) - 1}, [(0, len(time) - 1)]
    while todo:
        low, high = todo.pop()
        if high - low < 2:
            continue
        inner = np.arange(low + 1, high)
        share = (time[inner] - time[low]) / max(time[high] - time[low], 1e-9)
        off = np.abs(speed[inner] - (speed[low] + share * (speed[high] - speed[low])))
        if off.max() > _TOLERANCE:
            middle = int(inner[np.argmax(off)])
            kept.add(middle)
            todo += [(low, middle), (middle, high)]
    return sorted(kept)


@dataclass(frozen=True)
class Programme:
    """The programme of a junction's lights, with what each shows in each phase."""

    plan: SignalProgramme
    signals: dict[int, str]  # Letters of each light, a phase each, by the id of the signal

    @cached_property
    def ends(self) -> list[float]:
        """When each phase ends, s from the begin of the cycle."""
        return list(accumulate(phase.duration for phase in self.plan.phases))

    @property
    def cycle(self) -> float:
        """How long all phases take, s."""
        return self.ends[-1]

    def letter(self, link: int, time: float) -> str:
        """Return what a link of the programme shows at a time, s."""
        at = time % self.cycle
        k = next((k for k, end in enumerate(self.ends) if at < end), 0)
        return self.plan.phases[k].state[link]

    def next_green(self, link: int, time: float) -> float:
        """Return when a link may be used from a time on, s; the time itself if it is never shut."""
        begin = time - time % self.cycle
        starts = [0.0, *self.ends[:-1]]
        times = [begin + turn * self.cycle + start for turn in (0, 1) for start in starts]
        return next((at for at in times if at >= time and self.letter(link, at) in _GO), time)


def programmes_of(furniture: Furniture) -> list[Programme]:
    """Return the programmes of all junctions that have one."""
    lights = [item for item in furniture.signals if item.type == _LIGHT and item.validity]
    out = []
    for plan in furniture.programmes:
        shown = {}
        for light in lights:
            links = [k for k, link in enumerate(plan.links) if _governs(light, link)]
            if links:
                letters = (min((phase.state[k] for k in links), key=_RANKS.index) for phase in plan.phases)
                shown[light.id] = "".join(letters)
        out.append(Programme(plan, shown))
    return out


def _governs(light: Signal, link: SignalLink) -> bool:
    """Whether a light is for a way through a junction: it has the lane that this begins on."""
    here = light.road == link.road and (light.orientation == "+") == link.at_end
    return here and any(min(pair) <= link.lane <= max(pair) for pair in light.validity)


def lights_on(path: Path, network: LaneNetwork, programmes: list[Programme]) -> list[Light]:
    """Return the lights that a car passes on a path."""
    by_way = {
        (str(link.connecting_road), link.lane): (programme, k)
        for programme in programmes
        for k, link in enumerate(programme.plan.links)
    }
    out = []
    for n in range(1, len(path.nodes)):
        way, before = network.lane(path.nodes[n]), network.lane(path.nodes[n - 1])
        found = by_way.get((way[0], before[1]))
        if found is not None and network.in_junction[path.nodes[n]]:
            programme, link = found
            at = float(path.distance[np.searchsorted(path.node, n)]) - _STOP_BEFORE
            green = partial(_is_green, programme, link)
            out.append(Light(at, green, partial(programme.next_green, link)))
    return out


def _is_green(programme: Programme, link: int, time: float) -> bool:
    return programme.letter(link, time) in _GO


@dataclass(frozen=True, eq=False)
class LaneNetwork:
    """Where cars can go in a file.

    A node is a lane in a direction, as of `osm2xodr.checking.Driving`: twice its row, plus 1 against s.
    """

    file: OpenDrive
    nodes: IntArray  # (n,) All of them, ascending
    length: FloatArray  # (2 x lanes,) Of the lane's section along the reference line, m
    # (steps,) Nodes: from the end of one to the beginning of the other
    start: IntArray
    end: IntArray

    @cached_property
    def road(self) -> IntArray:
        """Index of each node's road, (2 x lanes,)."""
        return np.repeat(self.file.sections.road[self.file.lanes.section], 2)

    @cached_property
    def in_junction(self) -> BoolArray:
        """Whether each node is a way through a junction, (2 x lanes,)."""
        return np.asarray(self.file.roads.junction[self.road] != -1)

    @cached_property
    def _metres(self) -> csr_matrix[np.float64]:
        """How much longer a way gets by each step, m."""
        size = len(self.length)
        return csr_matrix((self.length[self.end], (self.start, self.end)), shape=(size, size))

    def ways_from(self, node: int) -> tuple[FloatArray, IntArray]:
        """Return how far it is from the end of a node to that of every other, m, and the node before each."""
        far, before = dijkstra(self._metres, indices=[node], return_predecessors=True)
        return np.asarray(far[0], np.float64), np.asarray(before[0], np.int64)

    def lane(self, node: int) -> tuple[str, int]:
        """Return the ids of the road and the lane of a node."""
        row = node // 2
        return self.file.roads.id[int(self.road[node])], int(self.file.lanes.id[row])

    def section(self, node: int) -> tuple[float, float]:
        """Return s of the begin and end of a node's section, m."""
        section = self.file.lanes.section[node // 2]
        return float(self.file.sections.s[section]), float(self.file.sections.end[section])

    def middle(self, node: int, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return places in the middle of a node's lane at s: x, y, z, (n, 3), m, and headings of traffic, rad."""
        road, row = np.full(len(s), self.road[node]), np.full(len(s), node // 2)
        inner, outer = lane_borders(self.file, row, s)
        places = np.column_stack(surface_points(self.file, road, s, 0.5 * (inner + outer)))
        hdg = np.asarray(pose(self.file, road, s)[2]) + (np.pi if node % 2 else 0.0)
        return places, wrapped(hdg)

    @cached_property
    def _limits(self) -> FloatArray:
        return speed_limits(self.file)

    def limit(self, node: int) -> float:
        """Return the speed limit of a node, m/s; NaN where there is none."""
        found = float(self._limits[node // 2])
        return found if np.isfinite(found) else float("nan")


def lane_network(file: OpenDrive) -> LaneNetwork:
    """Return the network of the lanes of type ``driving`` of a file."""
    driving = driving_of(file)
    for_all = np.array([kind == _DRIVING for kind in file.lanes.type], np.bool_)
    is_open = np.column_stack([driving.along & for_all, driving.against & for_all]).ravel()
    kept = is_open[driving.start] & is_open[driving.end]
    section = file.lanes.section
    length = np.repeat(file.sections.end[section] - file.sections.s[section], 2)
    nodes = np.flatnonzero(is_open & (length > 0.0))
    return LaneNetwork(file, nodes, length, driving.start[kept], driving.end[kept])


@record(eq=False)
class Path:
    """A way from lane to lane, as places at even distances."""

    nodes: tuple[int, ...]
    # Each place belongs to one of them, whose s it has
    node: IntArray  # (n,) Index into `nodes`
    s: FloatArray
    place: FloatArray  # (n, 3) x, y, z, m
    hdg: FloatArray  # (n,) Of traffic, rad
    distance: FloatArray  # (n,) From the first place, along the middles of lanes, m
    limit: FloatArray  # (n,) Speed limit, m/s; NaN where there is none

    @property
    def length(self) -> float:
        """How long it is, m."""
        return float(self.distance[-1])

    def at(self, distance: FloatArray) -> FloatArray:
        """Return the places at distances, x, y, (n, 2), m."""
        return np.column_stack([np.interp(distance, self.distance, self.place[:, k]) for k in (0, 1)])


def path_along(network: LaneNetwork, nodes: tuple[int, ...], start: float) -> Path:
    """Return the way along nodes, from a distance from the begin of the first of them on, m."""
    columns: list[tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray]] = []
    for k, node in enumerate(nodes):
        low, high = network.section(node)
        first = start if k == 0 else 0.0
        count = max(int(np.ceil((high - low - first) / STEP)), 1)
        ahead = first + (high - low - first) * np.arange(count + (k == len(nodes) - 1)) / count
        s = high - ahead if node % 2 else low + ahead
        places, hdg = network.middle(node, s)
        columns.append((np.full(len(s), k), s, places, hdg, np.full(len(s), network.limit(node))))
    node_of, s, places, hdg, limit = (np.concatenate(parts) for parts in zip(*columns, strict=True))
    apart = np.hypot(*np.diff(places[:, :2], axis=0).T)
    distance = np.concatenate([[0.0], np.cumsum(apart)])
    kept = np.concatenate([[True], apart > 0.0])
    return Path(nodes, *(column[kept] for column in (node_of, s, places, hdg, distance, limit)))
