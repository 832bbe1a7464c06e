"""How a car goes along a path: within limits, slower in bends, and not through red lights, by their programmes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import accumulate
from typing import Final

import numpy as np

from osm2xodr.curves import wrapped
from osm2xodr.model import FloatArray, Furniture, Signal, SignalLink, SignalProgramme
from osm2xodr.starting.lanes import LaneNetwork, Path

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


@dataclass(frozen=True)
class Light:
    """A light on a path."""

    distance: float  # Where the car has to stop, m along the path
    green: Callable[[float], bool]  # Whether it may go at a time, s
    change: Callable[[float], float]  # When it is green next, s


@dataclass(frozen=True, eq=False)
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
