"""Which stretches of roads, and which junctions, a part of a network has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from osm2xodr.crop_and_merge.defaults import CELL, STUB
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, LinkKind, OpenDrive, Shape, pose

# Says which points, x and y (n,), are inside.
Inside = Callable[[FloatArray, FloatArray], BoolArray]


@dataclass(frozen=True)
class Stretch:
    """A part of a road that is kept, from s to s, m."""

    road: int
    begin: float
    end: float
    # Whether it has the begin and the end of the road
    has_start: bool
    has_end: bool


@dataclass(frozen=True)
class Choice:
    """What is kept: stretches of roads, in the order of the file, and junctions."""

    stretches: tuple[Stretch, ...]
    junctions: frozenset[int]


def choose_inside(file: OpenDrive, inside: Inside) -> Choice:
    """Choose what lies inside an area.

    A junction is inside if the middle of its connecting roads is; these and the ends of its arms go with it. Other
    places of roads are decided by their reference line, in stretches of about `CELL`, so that areas side by side have
    everything exactly once.
    """
    kept = _junctions_inside(file, inside)
    whole = _whole_roads(file)
    stretches: list[Stretch] = []
    for road in range(len(file.roads.id)):
        length = float(file.roads.length[road])
        if not length > 0:
            continue
        if whole[road] != ABSENT:
            if kept[whole[road]]:
                stretches.append(Stretch(road, 0.0, length, True, True))
            continue
        stretches += _stretches_inside(file, road, inside, kept)
    return Choice(tuple(stretches), frozenset(np.flatnonzero(kept).tolist()))


def choose_roads(file: OpenDrive, names: frozenset[str]) -> Choice:
    """Choose roads by id, each as a whole, and the junctions of which they are all arms."""
    chosen = {k for k, name in enumerate(file.roads.id) if name in names}
    whole = _whole_roads(file)
    table = file.connections
    missing = {
        int(table.junction[k])
        for k in range(len(table.id))
        if table.incoming[k] != ABSENT and whole[table.incoming[k]] == ABSENT and int(table.incoming[k]) not in chosen
    }
    junctions = frozenset(range(len(file.junctions.id))) - missing - _without_arms(file)
    kept = [
        road
        for road in range(len(file.roads.id))
        if (whole[road] in junctions if whole[road] != ABSENT else road in chosen)
    ]
    length = file.roads.length
    stretches = tuple(Stretch(road, 0.0, float(length[road]), True, True) for road in kept if length[road] > 0)
    return Choice(stretches, junctions)


def _whole_roads(file: OpenDrive) -> IntArray:
    """Return the junction that each road is never parted from, (roads,); `ABSENT` for roads that may be cut."""
    return np.where(file.roads.junction >= 0, file.roads.junction, ABSENT)


def _without_arms(file: OpenDrive) -> frozenset[int]:
    """Return junctions without a connection."""
    return frozenset(np.flatnonzero(np.diff(file.junctions.start) == 0).tolist())


def _junctions_inside(file: OpenDrive, inside: Inside) -> BoolArray:
    """Return which junctions are inside, (junctions,): those whose roads have their middle there."""
    roads = file.roads
    count = len(file.junctions.id)
    member = np.flatnonzero((roads.junction >= 0) & (roads.length > 0))
    owner = roads.junction[member]
    # Direct junctions have no roads of their own: their arms count.
    bare = ~np.isin(np.arange(count), owner)
    table = file.connections
    arms = np.flatnonzero((table.incoming != ABSENT) & bare[table.junction])
    x, y, _ = pose(file, member, 0.5 * roads.length[member])
    at = _ends_at(file, table.incoming[arms], table.junction[arms])
    arm_x, arm_y, _ = pose(file, table.incoming[arms], at)
    owner = np.concatenate([owner, table.junction[arms]])
    x, y = np.concatenate([x, arm_x]), np.concatenate([y, arm_y])
    good = np.isfinite(x + y)
    number = np.bincount(owner[good], minlength=count)
    sums = [np.bincount(owner[good], values[good], minlength=count) for values in (x, y)]
    has = number > 0
    out = np.zeros(count, np.bool_)
    out[has] = inside(*(total[has] / number[has] for total in sums))
    return out


def _ends_at(file: OpenDrive, road: IntArray, junction: IntArray) -> FloatArray:
    """Return s of the end of roads at which junctions lie, (n,)."""
    roads = file.roads
    at_end = (roads.link_kind[road, 1] == LinkKind.JUNCTION) & (roads.link[road, 1] == junction)
    return np.where(at_end, roads.length[road], 0.0)


def _stretches_inside(file: OpenDrive, road: int, inside: Inside, kept: BoolArray) -> list[Stretch]:
    """Return the stretches of a road that are inside, along s."""
    length = float(file.roads.length[road])
    cuts = _cells(file, road)
    middle = 0.5 * (cuts[1:] + cuts[:-1])
    x, y, _ = pose(file, np.full(len(middle), road), middle)
    in_cell = np.zeros(len(middle), np.bool_)
    known = np.isfinite(x + y)
    in_cell[known] = inside(x[known], y[known])
    for end, off in ((0, middle), (1, length - middle)):
        near = (off < STUB) & (off <= length / 2)
        junction = int(file.roads.link[road, end])
        if file.roads.link_kind[road, end] == LinkKind.JUNCTION and junction != ABSENT:
            in_cell[near] = kept[junction]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], in_cell, [False]]).astype(np.int8)))
    return [
        Stretch(road, float(cuts[first]), float(cuts[last]), first == 0, last == len(middle))
        for first, last in edges.reshape(-1, 2).tolist()
    ]


def _cells(file: OpenDrive, road: int) -> FloatArray:
    """Return where a road may be cut, with its ends; polynomials of plan views are not cut."""
    length = float(file.roads.length[road])
    # Two at least where the junctions of both ends may be parted.
    fewest = 1 + bool((file.roads.link_kind[road] == LinkKind.JUNCTION).all())
    cuts = np.linspace(0.0, length, max(fewest, round(length / CELL)) + 1)
    plan = file.plan_view
    free = np.ones(len(cuts), np.bool_)
    more = []
    for k in range(int(plan.start[road]), int(plan.start[road + 1])):
        if plan.shape[k] in (Shape.POLY3, Shape.PARAM_POLY3):
            begin, end = float(plan.s[k]), float(plan.s[k] + plan.length[k])
            free &= (cuts <= begin - CELL / 2) | (cuts >= end + CELL / 2)
            more += [begin, end]
    inner = [s for s in more if CELL / 2 < s < length - CELL / 2]
    found = np.unique(np.concatenate([cuts[free], inner, [0.0, length]]))
    # Records that are shorter than a cell are not parted from the one before.
    wide = np.concatenate([[True], np.diff(found) > min(CELL / 4, length / 3)])
    wide[-1] = True
    return np.asarray(found[wide], np.float64)
