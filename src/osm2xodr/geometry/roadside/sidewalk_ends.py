"""Sidewalks and shoulders that lead nowhere at a junction, as the next arm has none, end along its corner's kerb."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from osm2xodr.curves import (
    Table,
    cosine,
    pose,
    record_ends,
    sine,
    sine_cosine,
    smooth_cubic,
    smooth_step,
    unique_inverse,
)
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.roadside import defaults
from osm2xodr.geometry.roadside.corner_overlaps import PROBES, onto_lanes, onto_roads
from osm2xodr.geometry.roadside.corner_pairs import arms_in_order, walks_at
from osm2xodr.geometry.roadside.corner_strips import Sidewalk
from osm2xodr.geometry.roadside.strips import Margins, Wedge
from osm2xodr.model import BoolArray, Cubic, FloatArray, IntArray, LaneType, Rule

# Such a sidewalk ends over at most so many metres, those of a turn, or over fewer where it has no room. Choices.
_LONGEST: Final = (12.0, 6.0, 3.0)
# Beside an edge that does not lead to that of a carriageway, it ends on this share of the way. A choice.
_PART: Final = 0.5
# On this share of its length it is compared with lanes: the rest is as narrow as what lanes may cover. A choice.
_COMPARED: Final = 0.6
# Those that end where the arm does have a quarter of an ellipse there, through these angles, as long as they are
# wide, and no longer than this share of their road. Choices.
_ROUND: Final = tuple(sine_cosine(math.radians(angle)) for angle in (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0))
_ROUND_SHARE: Final = 0.3
# They are so wide at their tip, m: rounded numbers in the file may not lead below 0.
_ROUND_TIP: Final = 0.001


@dataclass(frozen=True, slots=True, eq=False)
class SidewalkEnds(Table):
    """Sidewalks and shoulders that narrow to nothing, in a smooth step, beside lanes of connecting roads, (n,)."""

    row: IntArray  # Index of the connecting road
    side: IntArray  # The side of it: left 1, right -1
    at_start: BoolArray  # Whether they come from its start, else from its end
    # Where they come from: their width, and that of the border between them and the lane, m
    width: FloatArray
    gap: FloatArray
    height: FloatArray  # Above the road, m
    shoulder: BoolArray  # Whether it is a shoulder
    length: FloatArray  # Over which they end, m

    def lanes(self, k: int, road: float) -> Iterator[tuple[LaneType, tuple[Cubic, ...], float]]:
        """Yield type, widths and height, m, of the lanes of the k-th one, outwards; its road is so long, m."""
        length, height = min(float(self.length[k]), road), float(self.height[k])
        own = LaneType.SHOULDER if self.shoulder[k] else LaneType.SIDEWALK
        for kind, width in ((LaneType.BORDER, float(self.gap[k])), (own, float(self.width[k]))):
            if width < defaults.NARROWEST_FILLING:
                continue
            if self.at_start[k]:
                step, rest = smooth_cubic(0.0, length, width, 0.0), Cubic(length, 0.0)
            else:
                rest, step = Cubic(0.0, 0.0), smooth_cubic(road - length, length, 0.0, width)
            yield kind, tuple(sorted((step, rest), key=lambda part: part.s)) if length < road else (step,), height


def find_sidewalk_ends(
    parts: RoadParts, margins: Sequence[Margins], cars: ConnectingRoads, corners: ConnectingRoads, rule: Rule
) -> tuple[SidewalkEnds, tuple[tuple[int, int], ...]]:
    """Return where sidewalks and shoulders that no corner joins end within junctions, beside the roads of `cars`.

    Returns the road ends of sidewalks without room for that, too, each with the side of its road: left 1, right -1.
    """
    joined = {
        (end, lane > 0)
        for ends, lanes in ((corners.entry, corners.entry_lane), (corners.exit, corners.exit_lane))
        for end, lane in zip(ends.tolist(), lanes.tolist(), strict=True)
    }
    ends = dict.fromkeys(np.union1d(cars.entry, cars.exit).tolist())
    places = [(end, side) for end in ends for side in (1, -1) if (end, side > 0) not in joined]
    known = walks_at(parts, margins, places)
    walks = {place: walk for place, walk in known.items() if walk.type is not LaneType.BIKING}
    incoming = 1 if rule is Rule.RIGHT_HAND else -1
    rings = arms_in_order(parts, walks, incoming) if walks else ()
    connected = [[end for end in arms if end in ends] for _, arms in rings]
    # Seen from each arm, the next one in that order and in the other one.
    following = {end: (arms[k + 1 - len(arms)], arms[k - 1]) for arms in connected for k, end in enumerate(arms)}
    edges = _edges(cars, np.array([end for end, _ in walks], np.int64))
    found: list[tuple[_Edge, Sidewalk, float]] = []
    for (end, side), walk in walks.items():
        if following[end][0] == end:
            continue
        # Road ends run inwards, starts outwards.
        ahead = side == (incoming if end % 2 == 0 else -incoming)
        found += _nearest(walk, edges[end, side], following[end][0 if ahead else 1], parts)
    out = _that_fit(found, parts, cars)
    led = set(zip(*(item.tolist() for item in _places(out, cars)), strict=True))
    walking = (place for place, walk in walks.items() if walk.type is LaneType.SIDEWALK)
    return out, tuple(place for place in walking if place not in led)


def _places(ends: SidewalkEnds, cars: ConnectingRoads) -> tuple[IntArray, IntArray]:
    """Return the road ends that sidewalks come from, and on which side of these roads they lie, both (n,)."""
    end = np.where(ends.at_start, cars.entry[ends.row], cars.exit[ends.row])
    return end, np.where((end % 2 == 1) == ends.at_start, ends.side, -ends.side)


def round_off(
    parts: RoadParts, margins: tuple[Margins, ...], places: Iterable[tuple[int, int]], kind: LaneType
) -> tuple[Margins, ...]:
    """Return strips of which those of a type have round ends at some places: their back bends to their kerb."""
    out = list(margins)
    for end, side in places:
        beside = out[end // 2]
        here = beside[-(end % 2)]
        width = next(item.width for item in here.strips(side) if item.type is kind)
        length = min(width, _ROUND_SHARE * float(parts.length[end // 2]))
        widths = tuple((length * (1.0 - cos), max(width * sin, _ROUND_TIP)) for sin, cos in _ROUND)
        kept = (item for item in here.wedges if not item.lies_at(end, side, kind))
        last = replace(here, wedges=(*kept, Wedge(side, end % 2 == 1, widths, kind)))
        out[end // 2] = (*beside[:-1], last) if end % 2 else (last, *beside[1:])
    return tuple(out)


@dataclass(frozen=True, slots=True)
class _Edge:
    """An edge of a connecting road's lane where that touches a road end."""

    row: int
    side: int  # Which edge: left 1, right -1, in its own direction
    at_start: bool  # Whether it is its start
    t: float  # On the road that it touches, m
    other: int  # The road end at its other end
    # There, the middle of the lane, t on that road, and its width, m
    other_middle: float
    other_width: float

    def other_side(self) -> int:
        """Return which edge of the road at its other end it leads to: left 1, right -1."""
        return self.side if (self.other % 2 == 0) == self.at_start else -self.side


def _edges(cars: ConnectingRoads, ends: IntArray) -> dict[tuple[int, int], list[_Edge]]:
    """Return the edges of lanes at some road ends, (n,), by the end and the side of its road."""
    out: dict[tuple[int, int], list[_Edge]] = {}
    entry = cars.entry, cars.entry_middle(), cars.entry_width
    exit_ = cars.exit, cars.exit_middle(), cars.exit_width
    for at_start, here, there in ((True, entry, exit_), (False, exit_, entry)):
        rows = np.flatnonzero(np.isin(here[0], ends))
        values = (column[rows].tolist() for column in (*here, *there))
        for row, end, t, width, *other in zip(rows.tolist(), *values, strict=True):
            for side in (1, -1):
                along = (end % 2 == 1) == at_start
                edge = _Edge(row, side if along else -side, at_start, t + side * width / 2, *other)
                out.setdefault((end, side), []).append(edge)
    return out


def _nearest(
    walk: Sidewalk, edges: Iterable[_Edge], arm: int, parts: RoadParts
) -> list[tuple[_Edge, Sidewalk, float]]:
    """Return the edge beside a sidewalk that leads to an arm, nearest to its kerb, and the width between, m."""
    side = 1 if walk.lane > 0 else -1
    kerb = walk.t - side * walk.width / 2
    inner = sum(strip.width for _, strip in walk.inner)
    beside = [
        (edge, walk, side * (kerb - edge.t))
        for edge in edges
        if edge.other == arm and abs(side * (kerb - edge.t) - inner) < defaults.CORNER_ONTO_LANE
    ]
    return sorted(beside, key=lambda item: _off_kerb(item[0], parts))[:1]


def _that_fit(
    found: Sequence[tuple[_Edge, Sidewalk, float]], parts: RoadParts, cars: ConnectingRoads
) -> SidewalkEnds:
    """Return the sidewalks that have room beside edges of lanes, each as long as it has."""
    row, side = (np.array([getattr(edge, k) for edge, *_ in found], np.int64) for k in ("row", "side"))
    at_start = np.array([edge.at_start for edge, *_ in found], bool)
    width, gap, height = np.array([(walk.width, gap, walk.height) for _, walk, gap in found]).reshape(-1, 3).T
    gap = np.where(gap < defaults.NARROWEST_FILLING, 0.0, gap)
    off = np.array([_off_kerb(edge, parts) for edge, *_ in found])
    whole = off < defaults.CORNER_ONTO_LANE
    most = cars.length[row] * np.where(whole, 1.0, _PART)
    shoulder = np.array([walk.type is LaneType.SHOULDER for _, walk, _ in found], bool)
    ends = SidewalkEnds(row, side, at_start, width, gap, height, shoulder, most)
    good = np.zeros(len(row), bool)
    for longest in _LONGEST:
        ends = replace(ends, length=np.where(good, ends.length, np.minimum(most, longest)))
        tried = np.flatnonzero(~good)
        good[tried] = _have_room(ends.chosen(tried), parts, cars)
    return _apart(ends.chosen(good), cars)


def _apart(ends: SidewalkEnds, cars: ConnectingRoads) -> SidewalkEnds:
    """Shorten those that end towards each other beside one edge, so that one ends before the other begins."""
    edge = unique_inverse(2 * ends.row + (ends.side > 0))[1]
    both = np.bincount(edge, ends.length)[edge] if len(edge) else ends.length
    return replace(ends, length=ends.length * np.minimum(1.0, cars.length[ends.row] / both))


def _off_kerb(edge: _Edge, parts: RoadParts) -> float:
    """Return how far from that of the carriageway the edge of a lane is where it leads to, m."""
    section, side = parts.at_end(edge.other).section, edge.other_side()
    kerb = section.left_edge if side > 0 else section.right_edge
    return abs(edge.other_middle + side * edge.other_width / 2 - kerb)


def _have_room(ends: SidewalkEnds, parts: RoadParts, cars: ConnectingRoads) -> BoolArray:
    """Say which sidewalks neither fold, nor lie on lanes, (n,)."""
    rows = cars.chosen(ends.row)
    share = ends.length[:, None] * PROBES / rows.length[:, None]
    share = np.where(ends.at_start[:, None], share, 1.0 - share)
    lane = rows.entry_width[:, None] + (rows.exit_width - rows.entry_width)[:, None] * smooth_step(share)
    left = 1.0 - smooth_step(PROBES)
    inner = lane / 2 + ends.gap[:, None] * left
    outer = inner + ends.width[:, None] * left
    curve, s = np.repeat(np.arange(len(share)), len(PROBES)), (share * rows.length[:, None]).ravel()
    x, y, hdg = (item.reshape(share.shape) for item in pose(rows.plan_view, curve, s))
    t = ends.side[:, None] * (inner + outer) / 2
    # Behind that, the first place counts again.
    at = np.where(PROBES <= _COMPARED, np.arange(len(PROBES)), 0)
    x, y = (x - t * sine(hdg))[:, at], (y + t * cosine(hdg))[:, at]
    return np.asarray(
        ~_fold(ends, rows) & ~onto_lanes(rows, cars, x, y, np.zeros_like(x)) & ~onto_roads(rows.junction, parts, x, y)
    )


def _fold(ends: SidewalkEnds, rows: ConnectingRoads) -> BoolArray:
    """Say which sidewalks reach beyond the centre of a bend of their roads, (n,)."""
    row, s, curvature = record_ends(rows.plan_view)
    along = np.clip(s / rows.length[row], 0.0, 1.0)
    lane = rows.entry_width[row] + (rows.exit_width - rows.entry_width)[row] * smooth_step(along)
    gone = np.where(ends.at_start[row], along, 1.0 - along) * rows.length[row] / ends.length[row]
    reach = lane / 2 + (ends.gap + ends.width)[row] * (1.0 - smooth_step(np.clip(gone, 0.0, 1.0)))
    out = np.zeros(len(ends.row), bool)
    out[row[(gone < 1.0) & (ends.side[row] * curvature * (reach + defaults.CORNER_EDGE_RADIUS) > 1.0)]] = True
    return out
