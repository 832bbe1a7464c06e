"""Which sidewalks face each other round the corners of junctions: those of each arm and of its neighbour.

Cycle tracks without a sidewalk beside them, and shoulders without either, count as such.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import product, takewhile

import numpy as np

from osm2xodr.curves import Table, arctan2, cosine, sine, sorted_unique, unique_all, wrapped
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junctions import RoadParts, end_poses
from osm2xodr.geometry.roadside import defaults
from osm2xodr.geometry.roadside.corner_lanes import strips_at_end
from osm2xodr.geometry.roadside.corner_strips import Sidewalk
from osm2xodr.geometry.roadside.strips import Margins
from osm2xodr.model import BoolArray, FloatArray, IntArray, LaneType, MarginSpec, Rule
from osm2xodr.system import record

Place = tuple[int, int]  # (road end, side of the road: left 1, right -1)


@record(eq=False)
class Walks(Table):
    """Sidewalks at road ends, as columns: see `Sidewalk`."""

    walks: tuple[Sidewalk, ...]
    lane: IntArray
    t: FloatArray
    width: FloatArray
    height: FloatArray

    @classmethod
    def of(cls, walks: Sequence[Sidewalk]) -> Walks:
        """Return the columns of sidewalks, (n,)."""
        t, width, height = np.array([(walk.t, walk.width, walk.height) for walk in walks]).reshape(-1, 3).T
        return cls(tuple(walks), np.array([walk.lane for walk in walks], np.int64), t, width, height)


@record(eq=False)
class Corners(Table):
    """Neighbouring arms whose sidewalks face each other, in the direction of the roads that connect them, (n,).

    By their lane ids, the first sidewalks lead into the junctions, the second ones out of them.
    """

    junction: IntArray
    # Road ends of the first and the second arms
    entry: IntArray
    exit: IntArray
    first: Walks
    second: Walks
    passed: tuple[tuple[int, ...], ...]  # The arms between them

    @property
    def past(self) -> BoolArray:
        """Whether arms lie between them."""
        return np.array([bool(arms) for arms in self.passed], bool)


def find_corners(parts: RoadParts, margins: Sequence[Margins], cars: ConnectingRoads, rule: Rule) -> Corners | None:
    """Return the neighbouring arms whose sidewalks face each other; None for none."""
    found = list(_pairs(parts, margins, cars, rule))
    if not found:
        return None
    *ends, first, second, passed = zip(*found, strict=True)
    junction, entry, exit_ = (np.array(column, np.int64) for column in ends)
    return Corners(junction, entry, exit_, Walks.of(first), Walks.of(second), passed)


def places_of(corners: ConnectingRoads) -> list[tuple[Place, Place]]:
    """Return the two places that each corner connects."""
    entry = zip(corners.entry.tolist(), np.sign(corners.entry_lane).tolist(), strict=True)
    exit_ = zip(corners.exit.tolist(), np.sign(corners.exit_lane).tolist(), strict=True)
    return list(zip(entry, exit_, strict=True))


def walks_at(parts: RoadParts, margins: Sequence[Margins], places: Iterable[Place]) -> dict[Place, Sidewalk]:
    """Return the sidewalks, or cycle tracks or shoulders without one, at road ends and sides of their roads."""
    found = (
        ((end, side), _sidewalk(parts, margins[end // 2], end, side)) for end, side in places if margins[end // 2]
    )
    return {place: walk for place, walk in found if walk is not None}


def _sidewalk(parts: RoadParts, margins: Margins, end: int, side: int) -> Sidewalk | None:
    """Return the sidewalk, else track, else shoulder at a side (left 1, right -1, along the road) of a road end."""
    section = parts.at_end(end).section
    t = section.left_edge if side > 0 else section.right_edge
    inner: list[tuple[int, MarginSpec]] = []
    track: Sidewalk | None = None
    for lane, strip in strips_at_end(parts, margins, end, side):
        if strip.type in (LaneType.SIDEWALK, LaneType.BIKING) or (strip.type is LaneType.SHOULDER and not inner):
            track = Sidewalk(lane, t + side * strip.width / 2, strip.width, strip.height, tuple(inner), strip.type)
        if strip.type is LaneType.SIDEWALK:
            return track
        inner.insert(0, (lane, strip))
        t += side * strip.width
    return track


def _pairs(
    parts: RoadParts, margins: Sequence[Margins], cars: ConnectingRoads, rule: Rule
) -> Iterator[tuple[int, int, int, Sidewalk, Sidewalk, tuple[int, ...]]]:
    """Find the pairs of neighbouring arms whose facing sides both have a sidewalk: the values of `Corners`.

    The last value are the arms between them.
    """
    touched = np.union1d(cars.entry, cars.exit)
    walks = walks_at(parts, margins, product(touched.tolist(), (1, -1)))
    if not walks:
        return
    # Side on which traffic comes in, seen outwards: left with right-hand traffic, right with left-hand traffic.
    incoming = 1 if rule is Rule.RIGHT_HAND else -1
    connected = set(touched.tolist())
    for junction, around in arms_in_order(parts, walks, incoming):
        for k, end in enumerate(around):
            # Road ends run inwards, starts outwards.
            first = walks.get((end, incoming if end % 2 == 0 else -incoming))
            if first is None or end not in connected:
                continue
            beyond = [*around[k + 1 :], *around[:k]]
            passed = tuple(takewhile(partial(_is_passed, parts, walks, first.type), beyond))
            following = beyond[len(passed)] if len(passed) < len(beyond) else end
            second = walks.get((following, -incoming if following % 2 == 0 else incoming))
            # A sidewalk leads back to its own arm round the loop of a dead end alone.
            if (following == end and len(around) > 1) or following not in connected or second is None:
                continue
            if first.type is second.type:
                yield junction, end, following, first, second, passed


def _is_passed(parts: RoadParts, walks: Mapping[Place, Sidewalk], kind: LaneType, end: int) -> bool:
    """Whether sidewalks run on past a road end: a driveway's without any.

    Shoulders do not: what comes in from there crosses them. How cycle tracks do is said in `cycle_tracks`.
    """
    if kind is not LaneType.SIDEWALK or any((end, side) in walks for side in (1, -1)):
        return False
    return parts.at_end(end).attributes.highway in defaults.PASSED_HIGHWAYS


def arms_in_order(parts: RoadParts, walks: Iterable[Place], sense: int) -> Iterator[tuple[int, list[int]]]:
    """Yield junctions with their arms in order around their middle, from the arm of the least number on.

    They are the junctions of some sidewalks, by the road end and the side of the road.

    A pedestrian who keeps to the near side meets them in this order: counter-clockwise with right-hand traffic
    (sense 1), else clockwise (-1).
    """
    end_junction = parts.end_junction.ravel()
    with_walks = sorted_unique(end_junction[np.array(sorted({end for end, _ in walks}), np.int64)])
    arms = np.flatnonzero(np.isin(end_junction, with_walks) & (end_junction >= 0))
    x, y, hdg = end_poses(parts, arms)
    sections = [parts.at_end(end).section for end in arms.tolist()]
    middle = np.array([(section.left_edge + section.right_edge) / 2 for section in sections])
    x, y = x - middle * sine(hdg), y + middle * cosine(hdg)
    junction = end_junction[arms]
    _, _, group, count = unique_all(junction)
    cx, cy = np.bincount(group, x) / count, np.bincount(group, y) / count
    angle = sense * wrapped(arctan2(y - cy[group], x - cx[group]))
    order = np.lexsort((arms, angle, junction))
    for rows in np.split(order, np.cumsum(count)[:-1]):
        listed = arms[rows].tolist()
        # A fixed start, so that rounding at half a turn does not matter.
        start = listed.index(min(listed))
        yield int(junction[rows[0]]), listed[start:] + listed[:start]
