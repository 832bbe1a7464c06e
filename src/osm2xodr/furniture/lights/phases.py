"""Which lights of a junction may be green together, and signal programmes: which movements are, and for how long.

Heads of different approaches conflict if movements of theirs come so near to each other that cars would touch, or end
on the same lane; where a short road has no lights at its far end, what they let go there counts as theirs. Heads of
one approach never do: cars side by side look out for each other. The graph of conflicts is coloured with few colours
(DSATUR: D. Brélaz, New methods to color the vertices of a graph, Communications of the ACM 22, 1979). Traffic
straight on from opposite arms shares a colour where that takes no further one. People cross while all cars wait, as
some movement of cars leads across each arm.

In these groups nobody ever meets anybody. In programmes, of which OpenStreetMap has none, drivers who turn across
oncoming traffic yield to it within the green, as at most real lights: each stage is for arms of which at most such
turns meet. Green lasts as long as vehicles that it lets go lose time, within limits.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from itertools import combinations, pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import heading_at, lengths, repeated, starts
from osm2xodr.furniture import defaults
from osm2xodr.furniture.lights.heads import THROUGH, Head, turn_of
from osm2xodr.furniture.world import Approach, Movement, World, lane_at_other_end, points_beside
from osm2xodr.model import (
    VEHICLE_LANES,
    BoolArray,
    Controller,
    FloatArray,
    IntArray,
    Rule,
    SignalLink,
    SignalPhase,
    SignalProgramme,
)

# Arms are opposite if a straight line bends by at most this from one to the other, rad (45 degrees); a choice.
_OPPOSITE: Final = 0.785
# Paths through a junction whose middles come this near to each other conflict, m: a car is 1.76 m wide without its
# mirrors (design vehicle of RASt 06).
_PATHS_APART: Final = 2.0
# Distance of the points by which paths are compared, m; a choice.
_PATH_STEP: Final = 1.0

# The letters of `osm2xodr.model.SignalPhase`.
_GO_FIRST: Final = "G"
_YIELD: Final = "g"
_YELLOW: Final = "y"
_RED: Final = "r"
_NO_LIGHT: Final = "o"
_GREEN: Final = _GO_FIRST + _YIELD


class Phases:
    """Finds out which of the heads for cars at junctions may be green together."""

    def __init__(
        self, world: World, approaches: Sequence[Approach], heads: Sequence[Head], passed: Collection[int]
    ) -> None:
        self._heads = heads
        rows = [(k, movement) for k, head in enumerate(heads) for movement in head.movements]
        own = len(rows)
        inner = {(approaches[k].road, approaches[k].at_end): approaches[k] for k in passed}
        rows += [(k, item) for k, head in enumerate(heads) for item in _beyond(world, head.movements, inner)]
        self._movements = [movement for _, movement in rows]
        self._of_head: dict[int, list[int]] = defaultdict(list)
        self._all_of_head: dict[int, list[int]] = defaultdict(list)  # With those beyond roads without lights
        for row, (k, _) in enumerate(rows):
            self._all_of_head[k].append(row)
            if row < own:
                self._of_head[k].append(row)
        connecting = [world.lanes.road(item.connecting_road).junction for item in self._movements]
        self._junction = np.array([-1 if item is None else item for item in connecting], np.int64)
        self._first, self._x, self._y = _paths(world, self._movements)
        of_head = [approaches[head.approach] for head in heads]
        self._heading = _headings(world, of_head)
        self._approach = of_head

    def groups(self, heads: Sequence[int]) -> list[list[int]]:
        """Group all heads of an installation, by their indices, into those that may be green together.

        Who goes straight on over a short road to the next junction of the installation has green there, too, and
        straight traffic of opposite arms is green together, where either takes no further group.
        """
        arms = [self._heads[k].approach for k in heads]
        together = [*self._onwards(heads), *self._opposite(heads)]
        found = grouped(self.conflicts(heads), arms, together)
        out: dict[int, list[int]] = defaultdict(list)
        for k, group in zip(heads, found, strict=True):
            out[group].append(k)
        return sorted(out.values())

    def conflicts(self, heads: Sequence[int]) -> BoolArray:
        """Return which of n heads conflict, (n, n)."""
        rows = [row for k in heads for row in self._all_of_head[k]]
        owner = repeated([len(self._all_of_head[k]) for k in heads])
        junction = self._junction[rows]
        one, other = np.nonzero(self._meeting(rows) & (junction[:, None] == junction))
        out = np.zeros((len(heads), len(heads)), bool)
        out[owner[one], owner[other]] = True
        arm = np.array([self._heads[k].approach for k in heads], np.int64)
        found: BoolArray = out & (arm[:, None] != arm)
        return found

    def meeting(self, heads: Sequence[int]) -> tuple[list[int], list[Movement], BoolArray]:
        """Return the movements of some heads: each one's head and itself, and which of these n meet, (n, n)."""
        rows = [row for k in heads for row in self._of_head[k]]
        owners = [k for k in heads for _ in self._of_head[k]]
        return owners, [self._movements[row] for row in rows], self._meeting(rows)

    def opposite(self, one: int, other: int) -> float | None:
        """Return by how much the arms of two heads are off being opposite, rad; None where they are not opposite."""
        off = abs(math.remainder(self._heading[one] - self._heading[other] - math.pi, 2 * math.pi))
        return off if off <= _OPPOSITE else None

    def _meeting(self, rows: Sequence[int]) -> BoolArray:
        """Return which of n movements end on the same lane, cross or come near to each other, (n, n)."""
        movements = [self._movements[row] for row in rows]
        exits = [(item.exit_road, item.exit_at_start, item.exit_lane) for item in movements]
        number = {key: k for k, key in enumerate(dict.fromkeys(exits))}
        exit_ = np.array([number[key] for key in exits], np.int64)
        points = np.concatenate([np.arange(self._first[row], self._first[row + 1]) for row in rows])
        first = starts([self._first[row + 1] - self._first[row] for row in rows])
        x, y = self._x[points], self._y[points]
        nearest = np.empty((len(rows), len(rows)))
        # One movement after the other: all distances of a large junction at once would take too much memory.
        for k, (lo, hi) in enumerate(pairwise(first.tolist())):
            gap = (x[lo:hi, None] - x) ** 2 + (y[lo:hi, None] - y) ** 2
            nearest[k] = np.minimum.reduceat(gap.min(axis=0), first[:-1])
        out: BoolArray = (nearest < _PATHS_APART**2) | (exit_[:, None] == exit_)
        return out

    def _onwards(self, heads: Sequence[int]) -> list[tuple[int, int]]:
        """Return pairs of indices into `heads`: of straight traffic, and of the next junction that it comes to."""
        straight = [
            (k, item)
            for k, head in enumerate(heads)
            for item in self._heads[head].movements
            if turn_of(item) == THROUGH
        ]
        to: dict[tuple[int, bool], list[int]] = defaultdict(list)
        for k in dict.fromkeys(k for k, _ in straight):
            approach = self._approach[heads[k]]
            to[approach.road, approach.at_end].append(k)
        found = ((k, other) for k, item in straight for other in to[item.exit_road, item.exit_at_start])
        return sorted(dict.fromkeys((k, other) for k, other in found if k != other))

    def _opposite(self, heads: Sequence[int]) -> list[tuple[int, int]]:
        """Return pairs of indices into `heads` of straight traffic from opposite arms, the most opposite first."""
        straight = [
            (k, head)
            for k, head in enumerate(heads)
            if any(turn_of(item) == THROUGH for item in self._heads[head].movements)
        ]
        found = sorted(
            (round(off, 6), one, other)
            for (one, head), (other, its) in combinations(straight, 2)
            if (off := self.opposite(head, its)) is not None
        )
        return [(one, other) for _, one, other in found]


def controllers_of(
    world: World,
    junctions: Sequence[int],
    heads: Sequence[Head],
    groups: Sequence[Sequence[int]],
    people: Sequence[int],
) -> list[Controller]:
    """Make the controllers of the junctions of an installation, by their ascending ids.

    One for each group of `Phases.groups`, and one for the heads for people.
    """
    place = f"junction {junctions[0]}" if len(junctions) == 1 else f"junctions {', '.join(map(str, junctions))}"
    members = [("traffic", "", [heads[row].signal.id for row in group]) for group in groups]
    if people:
        members.append(("pedestrian", ", people", list(people)))
    out = []
    for k, (kind, who, ids) in enumerate(members):
        name, first, further = f"{place}, phase {k + 1}{who}", junctions[0], tuple(junctions[1:])
        out.append(Controller(world.ids.controller(), name, tuple(sorted(ids)), first, k, kind, further))
    return out


def _beyond(
    world: World, movements: Sequence[Movement], inner: Mapping[tuple[int, bool], Approach]
) -> list[Movement]:
    """Return the movements on from roads that some movements lead to and that have no lights of their own.

    `inner` are the approaches of these roads, by road and whether traffic comes to its end.
    """
    out: dict[Movement, None] = {}
    reached = list(movements)
    while reached:
        item = reached.pop()
        approach = inner.get((item.exit_road, item.exit_at_start))
        if approach is None:
            continue
        lane = lane_at_other_end(world, item.exit_road, item.exit_lane, along=item.exit_at_start)
        onwards = [one for one in approach.movements if one.entry_lane == lane and one not in out]
        out |= dict.fromkeys(onwards)
        reached += onwards
    return list(out)


def _paths(world: World, movements: Sequence[Movement]) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return points on the middles of the lanes of movements: index of each one's first point (n + 1,), x, y, m."""
    curve = np.array([world.lanes.index(item.connecting_road) for item in movements], np.int64)
    length = lengths(world.road_map.plan_view, curve)
    steps = np.maximum(np.ceil(length / _PATH_STEP), 1).astype(np.int64)
    first = starts(steps + 1)
    owner = repeated(steps + 1)
    share = (np.arange(first[-1]) - first[owner]) / steps[owner]
    # The widths of lanes through a junction change linearly.
    ends = np.array([_middles(world, item) for item in movements], float).reshape(-1, 2)
    t = ends[owner, 0] + share * (ends[owner, 1] - ends[owner, 0])
    x, y, _ = points_beside(world.road_map.plan_view, curve[owner], share * length[owner], t)
    return first, x, y


def _middles(world: World, movement: Movement) -> tuple[float, float]:
    """Return t of the middle of a movement's lane at the start and end of its connecting road, m."""
    road = world.lanes.road(movement.connecting_road)
    first, last = ([lane for lane in road.lane_sections[k].lanes if lane.type in VEHICLE_LANES] for k in (0, -1))
    before = next(lane.id for lane in first if lane.predecessor == movement.entry_lane)
    after = next(lane.id for lane in last if lane.successor == movement.exit_lane)
    ends = ((before, 0.0), (after, world.lanes.length(road.id)))
    start, end = (next(at.middle for at in world.lanes.at(road.id, s) if at.id == lane) for lane, s in ends)
    return start, end


def _headings(world: World, approaches: Sequence[Approach]) -> list[float]:
    """Return the headings of traffic on approaches where they reach their junctions, rad."""
    curve = np.array([world.lanes.index(item.road) for item in approaches], np.int64)
    at_end = np.array([item.at_end for item in approaches], bool)
    s = np.where(at_end, lengths(world.road_map.plan_view, curve), 0.0)
    hdg = heading_at(world.road_map.plan_view, curve, s)
    out: list[float] = (hdg + np.where(at_end, 0.0, np.pi)).tolist()
    return out


def grouped(conflict: BoolArray, arms: Sequence[int], together: Sequence[tuple[int, int]]) -> list[int]:
    """Return the number of each of n nodes' group, from 0; with or without the pairs, whichever takes fewer groups.

    Conflict, (n, n), says which nodes may not be in one group; nodes of one arm share a group where that takes no
    further one; the pairs that belong together are grouped before all others.
    """
    return min((_coloured(conflict, arms, pairs) for pairs in (together, ())), key=max)


def _coloured(conflict: BoolArray, arms: Sequence[int], together: Sequence[tuple[int, int]]) -> list[int]:
    """Colour a graph so that neighbours differ, with few colours (DSATUR)."""
    count = len(conflict)
    colour = [-1] * count
    neighbours = [np.flatnonzero(row).tolist() for row in conflict]
    for one, other in together:
        if colour[one] < 0 and colour[other] < 0 and not conflict[one, other]:
            taken = {colour[k] for node in (one, other) for k in neighbours[node]}
            colour[one] = colour[other] = next(k for k in range(count + 1) if k not in taken)

    def order(node: int) -> tuple[int, int, int]:
        return len({colour[other] for other in neighbours[node]} - {-1}), len(neighbours[node]), -node

    while -1 in colour:
        node = max((k for k in range(count) if colour[k] < 0), key=order)
        taken = {colour[other] for other in neighbours[node]}
        own = {colour[k] for k in range(count) if arms[k] == arms[node]} - {-1}
        colour[node] = min((k for k in range(count + 1) if k not in taken), key=lambda k: (k not in own, k))
    return colour


def junction_programmes(
    world: World,
    approaches: Sequence[Approach],
    heads: Sequence[Head],
    members: Mapping[int, Sequence[int]],
    phases: Phases,
) -> list[SignalProgramme]:
    """Make the programmes of junctions; `members` are the heads of each, by its id."""
    out = []
    for junction, rows in sorted(members.items()):
        stages = _Stages(world, heads, rows, phases)
        green = stages.greens()
        lit = {(heads[k].approach, movement): n for n, (k, movement) in enumerate(stages.movements)}
        links: dict[SignalLink, int] = {}
        for k, approach in enumerate(approaches):
            for movement in approach.movements if approach.junction == junction else ():
                links.setdefault(_link(approach, movement), lit.get((k, movement), -1))
        states = ["".join(_NO_LIGHT if n < 0 else stage[n] for n in links.values()) for stage in green]
        detectors = defaults.DETECTOR_RANGE if len(states) > 1 else 0.0
        out.append(SignalProgramme(junction, tuple(links), tuple(_phases(states)), detectors))
    return out


def _link(approach: Approach, movement: Movement) -> SignalLink:
    return SignalLink(
        movement.connecting_road,
        approach.road,
        approach.at_end,
        movement.entry_lane,
        movement.exit_road,
        movement.exit_at_start,
        movement.exit_lane,
    )


class _Stages:
    """The stages of one junction."""

    def __init__(self, world: World, heads: Sequence[Head], rows: Sequence[int], phases: Phases) -> None:
        owners, movements, self._meet = phases.meeting(rows)
        self.movements = list(zip(owners, movements, strict=True))  # Each with its head
        self._heads = rows
        self._owner = owners
        self._arms = list(dict.fromkeys(heads[k].approach for k in owners))
        self._arm = np.array([self._arms.index(heads[k].approach) for k in owners], np.int64)
        # Whether a movement turns across oncoming traffic: to the side on which that drives.
        far = 1.0 if world.road_map.rule is Rule.RIGHT_HAND else -1.0
        self._across = np.array([turn_of(item) != THROUGH and item.turn * far > 0.0 for item in movements], bool)
        first = {self._arms.index(heads[k].approach): k for k in reversed(rows)}
        self._opposite = {
            (one, other): off
            for one, other in combinations(range(len(self._arms)), 2)
            if (off := phases.opposite(first[one], first[other])) is not None
        }

    def greens(self) -> list[list[str]]:
        """Return what each movement shows in each stage."""
        pairs = sorted(self._opposite, key=lambda pair: (round(self._opposite[pair], 6), pair))
        stage_of = grouped(self._apart(), range(len(self._arms)), pairs)
        out = []
        for stage in dict.fromkeys(stage_of):
            green = np.array([stage_of[arm] == stage for arm in self._arm.tolist()], bool)
            out.append(self._letters(self._with_free(green)))
        return out

    def _apart(self) -> BoolArray:
        """Return which arms can never be green together, (n, n)."""
        out = np.zeros((len(self._arms), len(self._arms)), bool)
        for i, j in np.argwhere(self._meet).tolist():
            one, other = int(self._arm[i]), int(self._arm[j])
            facing = (min(one, other), max(one, other)) in self._opposite
            if one != other and not (facing and (self._across[i] or self._across[j])):
                out[one, other] = out[other, one] = True
        return out

    def _with_free(self, green: BoolArray) -> BoolArray:
        """Return which movements are green when the heads whose movements meet none of these are green as well."""
        out = green.copy()
        owner = np.array(self._owner, np.int64)
        for head in self._heads:
            own = owner == head
            if not out[own].any() and not self._meet[np.ix_(own, out)].any():
                out |= own
        return out

    def _letters(self, green: BoolArray) -> list[str]:
        """Return the letter of each movement; those that turn across yield to those that they meet."""
        others = green[None, :] & self._meet & (self._arm[:, None] != self._arm[None, :])
        yields = self._across & others.any(axis=1)
        letters = np.where(green, np.where(yields, _YIELD, _GO_FIRST), _RED)
        out: list[str] = letters.tolist()
        return out


def _phases(stages: Sequence[str]) -> list[SignalPhase]:
    """Return the phases of stages: green, yellow where it ends, and red for all that do not go on."""
    between = defaults.YELLOW_TIME + defaults.RED_TIME
    if len(stages) == 1:
        # Cars wait for people only.
        stages = (stages[0], "".join(letter if letter == _NO_LIGHT else _RED for letter in stages[0]))
        times = [defaults.CYCLE_TIME - between - defaults.PEOPLE_TIME, defaults.PEOPLE_TIME]
        limits = None
    else:
        limits = defaults.GREEN_TIMES
        times = [max(defaults.CYCLE_TIME / len(stages) - between, limits[0])] * len(stages)
    out = []
    for k, (stage, time) in enumerate(zip(stages, times, strict=True)):
        then = stages[(k + 1) % len(stages)]
        ends = [now in _GREEN and letter == _RED for now, letter in zip(stage, then, strict=True)]
        out.append(SignalPhase(stage, time, limits))
        for letter, pause in ((_YELLOW, defaults.YELLOW_TIME), (_RED, defaults.RED_TIME)) if any(ends) else ():
            shown = (letter if end else now for now, end in zip(stage, ends, strict=True))
            out.append(SignalPhase("".join(shown), pause))
    return out
