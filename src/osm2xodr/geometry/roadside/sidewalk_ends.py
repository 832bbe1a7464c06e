"""Sidewalks and shoulders that no corner leads on go on along their kerb, as wide as there is room, and end there.

Where the next arm has one as well, as at an acute fork, each gets what lies on its side of the middle between both
kerbs, so that both end at the nose. Where it has none, they become narrower until nothing is left.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import (
    Table,
    cosine,
    curvature_at,
    pose,
    ranks,
    repeated,
    sine,
    smooth_cubic,
    smooth_step,
    sorted_unique,
    starts,
    value_of_cubics,
)
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.roadside import defaults
from osm2xodr.geometry.roadside.corner_pairs import Place, arms_in_order, places_of, walks_at
from osm2xodr.geometry.roadside.corner_strips import Sidewalk
from osm2xodr.geometry.roadside.corner_wedges import simple
from osm2xodr.geometry.roadside.strips import Margins, Wedge, with_wedge
from osm2xodr.model import BoolArray, Cubic, FloatArray, IntArray, LaneType, Rule
from osm2xodr.system import record

# Over so many metres strips end that nothing continues. A choice.
_LONGEST: Final = 12.0
# Beside an edge that does not lead to that of a carriageway, they end on this share of the way. A choice.
_PART: Final = 0.5
# Those beside a road do so on this share of it at most: where two meet, the narrower one counts.
_MOST_OF_ROAD: Final = 0.95
# Room is looked for at places along kerbs so far apart, m, where it ends at a nose, and else as far as the discs
# that stand for lanes and kerbs.
_SPACING: Final = 0.25
_DISCS: Final = 1.0
# Beside arms as far as this from their ends, m: wedges (`corner_wedges`) are no longer.
_FARTHEST: Final = 25.0
# Strips with less room have none, m: about a kerbstone's width.
_LEAST: Final = 0.1
# They are so wide at their tip, m: rounded numbers in the file may not lead below 0.
_TIP: Final = 0.001
# Radius of the discs inside kerbs, m: between two of them a kerb lies 13 cm farther back.
_KERB: Final = 1.0


@record(eq=False)
class SidewalkEnds(Table):
    """Sidewalks and shoulders that end beside lanes of connecting roads, (n,)."""

    row: IntArray  # Index of the connecting road
    side: IntArray  # The side of it: left 1, right -1
    height: FloatArray  # Above the road, m
    shoulder: BoolArray  # Whether it is a shoulder
    length: FloatArray  # Of the connecting road, m
    # Their widths along it, and those of the border between them and the lane
    widths: tuple[tuple[Cubic, ...], ...]
    border: tuple[tuple[Cubic, ...], ...]

    def lanes(
        self, k: int, road: float, covered: tuple[Cubic, ...] = ()
    ) -> Iterator[tuple[LaneType, tuple[Cubic, ...], float]]:
        """Yield type, widths and height, m, of the lanes of the k-th one, outwards; its road is so long now, m.

        Of them, so much beside the lane is `covered`.
        """
        share, height = float(self.length[k]) / road, float(self.height[k])
        own = LaneType.SHOULDER if self.shoulder[k] else LaneType.SIDEWALK
        at = np.linspace(0.0, road, int(road / _SPACING) + 2)
        taken = np.array([value_of_cubics(covered, s) for s in at.tolist()]) if covered else np.zeros(len(at))
        for kind, widths in ((LaneType.BORDER, self.border[k]), (own, self.widths[k])):
            if widths:
                along = tuple(Cubic(c.s / share, c.a, c.b * share, c.c * share**2, c.d * share**3) for c in widths)
                if covered:
                    width = np.array([value_of_cubics(along, s) for s in at.tolist()])
                    along = _lines(at, np.maximum(width - taken, 0.0))
                    taken = np.maximum(taken - width, 0.0)
                yield kind, along, height


def _lines(s: FloatArray, width: FloatArray) -> tuple[Cubic, ...]:
    """Return widths that are linear between places along a road, 0 before and behind the first and last with any."""
    some = np.flatnonzero(width > _TIP)
    if not len(some):
        return (Cubic(0.0, 0.0),)
    here = slice(max(int(some[0]) - 1, 0), int(some[-1]) + 2)
    points = simple(list(zip(s[here].tolist(), np.maximum(width[here], _TIP).tolist(), strict=True)))
    out = [Cubic(a, wide, (then - wide) / (b - a)) for (a, wide), (b, then) in pairwise(points)]
    before = [Cubic(0.0, 0.0)] if points[0][0] > 0.0 else []
    behind = [Cubic(points[-1][0], 0.0)] if points[-1][0] < s[-1] - defaults.SAME_PLACE else []
    return (*before, *out, *behind)


def find_sidewalk_ends(
    parts: RoadParts, margins: tuple[Margins, ...], cars: ConnectingRoads, corners: ConnectingRoads, rule: Rule
) -> tuple[tuple[Margins, ...], SidewalkEnds, IntArray]:
    """Return how sidewalks and shoulders that no corner joins go on and end, beside the roads of `cars`.

    Returns strips beside roads, narrower where these leave them no more room, and the junctions of sidewalks that end
    before them, too, one for each, (k,).
    """
    joined = {place for pair in places_of(corners) for place in pair}
    ends = dict.fromkeys(np.union1d(cars.entry, cars.exit).tolist())
    places = [(end, side) for end in ends for side in (1, -1) if (end, side) not in joined]
    known = walks_at(parts, margins, places)
    walks = {place: walk for place, walk in known.items() if walk.type is not LaneType.BIKING}
    incoming = 1 if rule is Rule.RIGHT_HAND else -1
    rings = arms_in_order(parts, walks, incoming) if walks else ()
    connected = [[end for end in arms if end in ends] for _, arms in rings]
    # Seen from each arm, the next one in that order and in the other one.
    following = {end: (arms[k + 1 - len(arms)], arms[k - 1]) for arms in connected for k, end in enumerate(arms)}
    facing: dict[Place, Place] = {}
    for end, side in walks:
        # Road ends run inwards, starts outwards.
        ahead = side == (incoming if end % 2 == 0 else -incoming)
        arm = following[end][0 if ahead else 1]
        facing[end, side] = arm, -side if arm % 2 == end % 2 else side
    walks = {place: walk for place, walk in walks.items() if facing[place][0] != place[0]}
    ground = _Ground.of(parts, cars, np.array(sorted({end for end, _ in walks}), np.int64))
    shared = [place for place in walks if facing[place] in walks]
    room = {place: ground.beside_arm(place, walks[place], facing[place][0]) for place in shared}
    narrow = walks | {place: _narrowed(walks[place], float(most[0])) for place, (_, most) in room.items()}
    found = _led_on(ground, narrow, facing)
    out, blunt = list(margins), []
    for place, walk in walks.items():
        begin = float(found[place].width()[0]) if place in found else 0.0
        if place in room or begin < walk.width - _LEAST:
            most = room.get(place) or ground.beside_arm(place, walk, -1)
            out[place[0] // 2] = _tapered(parts, out[place[0] // 2], place, walk.type, walk.width, begin, most)
            blunt += [place[0]] if walk.type is LaneType.SIDEWALK and not begin else []
    return tuple(out), _as_ends(found, narrow, cars), parts.end_junction.ravel()[np.array(blunt, np.int64)]


def _narrowed(walk: Sidewalk, room: float) -> Sidewalk:
    """Return a sidewalk no wider than its room, at its kerb."""
    less = max(walk.width - max(room, _LEAST), 0.0)
    return replace(walk, width=walk.width - less, t=walk.t - np.sign(walk.lane) * less / 2)


def ends_instead(
    parts: RoadParts, margins: Sequence[Margins], cars: ConnectingRoads, corners: ConnectingRoads
) -> SidewalkEnds:
    """Return how the sidewalks of corners that are left out go on and end instead, beside the roads of `cars`."""
    facing = dict(pair for pair in places_of(corners) for pair in (pair, pair[::-1]))
    walks = walks_at(parts, margins, facing)
    ground = _Ground.of(parts, cars, np.array(sorted({end for end, _ in walks}), np.int64))
    return _as_ends(_led_on(ground, walks, facing), walks, cars)


def run_out(parts: RoadParts, margins: tuple[Margins, ...], places: Iterable[Place]) -> tuple[Margins, ...]:
    """Return strips of which the outermost become narrower up to some places until nothing is left."""
    out = list(margins)
    for end, side in places:
        last = out[end // 2][-(end % 2)].strips(side)[-1]
        out[end // 2] = _tapered(parts, out[end // 2], (end, side), last.type, last.width, 0.0)
    return tuple(out)


def _tapered(
    parts: RoadParts,
    beside: Margins,
    place: Place,
    kind: LaneType,
    width: float,
    begin: float,
    room: tuple[FloatArray, FloatArray] | None = None,
) -> Margins:
    """Return strips of which one, of a type and width, is so wide where the road ends, and has no more than its room.

    The room is given at distances from there.
    """
    end, side = place
    length = min(_LONGEST, _MOST_OF_ROAD * float(parts.length[end // 2]))
    u, most = (np.linspace(0.0, length, 9), np.inf) if room is None else room
    wide = np.minimum(most, begin + (width - begin) * smooth_step(np.minimum(u / length, 1.0)))
    full = np.flatnonzero(wide < width - defaults.SAME_PLACE).max(initial=-1) + 1
    if not full:
        return beside
    u, wide = np.append(u, u[-1] + _SPACING)[: full + 1], np.append(wide[:full].clip(_TIP), width)
    points = simple(list(zip(u.tolist(), wide.tolist(), strict=True)))
    return with_wedge(beside, Wedge(side, end % 2 == 1, points, kind))


@record
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

    def off_kerb(self, parts: RoadParts) -> float:
        """Return how far from that of the carriageway it is where it leads to, m."""
        section = parts.at_end(self.other).section
        side = self.side if (self.other % 2 == 0) == self.at_start else -self.side
        kerb = section.left_edge if side > 0 else section.right_edge
        return abs(self.other_middle + side * self.other_width / 2 - kerb)


# None is beside it: strips beside arms.
_NO_EDGE: Final = _Edge(-2, 1, True, 0.0, -1, 0.0, 0.0)


def _edges(cars: ConnectingRoads, ends: IntArray) -> dict[Place, list[_Edge]]:
    """Return the edges of lanes at some road ends, (n,), by the end and the side of its road."""
    out: dict[Place, list[_Edge]] = {}
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


def _candidates(walk: Sidewalk, edges: Iterable[_Edge], parts: RoadParts, arm: int) -> list[tuple[_Edge, float]]:
    """Return the edges beside a sidewalk, and the width between, m: if any leads to an arm, that along its kerb."""
    side = 1 if walk.lane > 0 else -1
    kerb = walk.t - side * walk.width / 2
    inner = sum(strip.width for _, strip in walk.inner)
    beside = [(edge, side * (kerb - edge.t)) for edge in edges]
    beside = [(edge, gap) for edge, gap in beside if abs(gap - inner) < defaults.CORNER_ONTO_LANE]
    there = [item for item in beside if item[0].other == arm]
    return [min(there, key=lambda item: item[0].off_kerb(parts))] if there else beside


@record
class _Asked:
    """A strip that goes on from a road end, beside an edge of a connecting road's lane."""

    edge: _Edge
    width: float  # At the road end, m
    gap: float  # Between the edge and it there, m
    end: int  # That road end
    beyond: int  # The one whose strip it shares its room with; -1 for none


@record
class _Strip:
    """How wide such a strip may be, and is."""

    asked: _Asked
    road: float  # Length of the connecting road, m
    away: FloatArray  # (m,) Distances on it from the arm that the strip comes from, ascending, m
    room: FloatArray  # (m,) How far the strip may reach beyond the edge there, m
    # (m,) How wide it would be with room everywhere, and how wide what lies between the edge and it is, m
    wish: FloatArray
    border: FloatArray
    length: float  # Over which it ends where it has room, m; infinite where it goes on as long as it has any
    has_room: bool  # Whether it is as wide as it would be

    def shorter(self, length: float) -> _Strip:
        """Return it as it ends over that length, m."""
        left = _left(self.away, length)
        border = np.minimum(self.border, self.asked.gap * left)
        return replace(self, wish=self.asked.width * left, border=border, length=length)

    def width(self) -> FloatArray:
        """Return how wide it is, (m,), m."""
        if self.has_room:
            return self.wish
        width = np.minimum(self.wish, self.room - self.border)
        return np.asarray(np.where(np.logical_and.accumulate(width >= _LEAST), width, 0.0))

    def reach(self) -> float:
        """Return how far from the arm it has any width, m."""
        return float(self.away[: np.flatnonzero(self.width())[-1] + 2][-1])

    def lanes(self) -> tuple[tuple[Cubic, ...], tuple[Cubic, ...]]:
        """Return its widths along the road, and those of the border."""
        even = self.has_room and np.isfinite(self.length)
        widths = self._step(self.asked.width, self.length) if even else self._along(self.width())
        over = min(self.length, _LONGEST, self.road)
        free = bool((self.border >= self.asked.gap * _left(self.away, over) - defaults.SAME_PLACE).all())
        return widths, self._step(self.asked.gap, over) if free else self._along(self.border)

    def _step(self, width: float, length: float) -> tuple[Cubic, ...]:
        """Return widths that become 0 in a smooth step over a length from the arm on."""
        if width < defaults.NARROWEST_FILLING:
            return ()
        if self.asked.edge.at_start:
            step, rest = smooth_cubic(0.0, length, width, 0.0), Cubic(length, 0.0)
        else:
            rest, step = Cubic(0.0, 0.0), smooth_cubic(self.road - length, length, 0.0, width)
        return tuple(sorted((step, rest), key=lambda part: part.s)) if length < self.road else (step,)

    def _along(self, width: FloatArray) -> tuple[Cubic, ...]:
        """Return widths at its places as records along the road."""
        away, wide = self.away, width
        if away[-1] < self.road - defaults.SAME_PLACE:
            away, wide = np.append(away, self.road), np.append(wide, 0.0)
        return _lines(away, wide) if self.asked.edge.at_start else _lines((self.road - away)[::-1], wide[::-1])


def _led_on(ground: _Ground, walks: Mapping[Place, Sidewalk], facing: Mapping[Place, Place]) -> dict[Place, _Strip]:
    """Lead strips at some places on along their kerbs; those that face one share the room with it."""
    edges = _edges(ground.cars, np.array(sorted({end for end, _ in walks}), np.int64))
    places: list[Place] = []
    asked: list[_Asked] = []
    for place, walk in walks.items():
        arm, shared = facing[place][0], facing[place] in walks
        for edge, gap in _candidates(walk, edges.get(place, ()), ground.parts, -1 if shared else arm):
            places.append(place)
            between = gap if gap >= defaults.NARROWEST_FILLING else 0.0
            asked.append(_Asked(edge, walk.width, between, place[0], arm if shared else -1))
    found: dict[Place, tuple[float, _Strip]] = {}
    for place, strip in zip(places, ground.strips(asked), strict=True):
        width = strip.width()
        area = float(width.sum() * strip.away[1])
        if width[0] >= _LEAST and area > found.get(place, (0.0,))[0]:
            found[place] = area, strip
    return {place: strip for place, (_, strip) in found.items()}


def _as_ends(found: Mapping[Place, _Strip], walks: Mapping[Place, Sidewalk], cars: ConnectingRoads) -> SidewalkEnds:
    """Return strips as lanes; two that come towards each other beside one edge share its length."""
    at_edge: dict[tuple[int, int], list[Place]] = {}
    for place, strip in found.items():
        at_edge.setdefault((strip.asked.edge.row, strip.asked.edge.side), []).append(place)
    rows = []
    for edge, places in at_edge.items():
        strips = [found[place] for place in places]
        road, far = strips[0].road, [strip.reach() for strip in strips]
        if sum(far) > road:
            strips = [strip.shorter(road / sum(far) * most) for strip, most in zip(strips, far, strict=True)]
        for place, strip in zip(places, strips, strict=True):
            walk = walks[place]
            rows.append((*edge, walk.height, walk.type is LaneType.SHOULDER, road, *strip.lanes()))
    row, side, height, shoulder, length, widths, border = zip(*rows, strict=True) if rows else [()] * 7
    numbers = np.array(row, np.int64), np.array(side, np.int64), np.array(height, np.float64)
    return SidewalkEnds(*numbers, np.array(shoulder, bool), np.array(length, np.float64), widths, border)


@record(eq=False)
class _Ground:
    """What leaves strips little room within junctions: lanes, and the kerbs of arms, as rows of discs."""

    parts: RoadParts
    cars: ConnectingRoads
    slices: dict[int, slice]  # Of the discs, by junction
    # (n,) Their middles and radii, m
    x: FloatArray
    y: FloatArray
    radius: FloatArray
    row: IntArray  # The connecting road; -1 for kerbs
    # The road ends that it touches; that of the kerb
    one: IntArray
    other: IntArray
    widest: float  # The largest radius, m

    @classmethod
    def of(cls, parts: RoadParts, cars: ConnectingRoads, ends: IntArray) -> _Ground:
        """Return what lies in the junctions of some road ends."""
        end_junction = parts.end_junction.ravel()
        junctions = sorted_unique(end_junction[ends])
        rows = np.flatnonzero(np.isin(cars.junction, junctions))
        arms = np.flatnonzero(np.isin(end_junction, junctions) & (end_junction >= 0))
        count = (cars.length[rows] / _DISCS).astype(np.int64) + 2
        of, share = np.repeat(rows, count), ranks(count) / np.repeat(count - 1, count)
        x, y, hdg, aside, half = _lane(cars, of, share * cars.length[of])
        reach = np.minimum(parts.length[arms // 2], _FARTHEST)
        many = (reach / _DISCS).astype(np.int64)
        arm, u = np.repeat(arms, many), (ranks(many) + 1) * _DISCS
        kx, ky, khdg = pose(parts.plan_view, arm // 2, np.where(arm % 2 == 1, parts.length[arm // 2] - u, u))
        sections = [parts.at_end(end).section for end in arms.tolist()]
        left = np.repeat([item.left_edge for item in sections], many) - _KERB
        right = np.repeat([item.right_edge for item in sections], many) + _KERB
        columns = (
            (x - aside * sine(hdg), *(kx - t * sine(khdg) for t in (left, right))),
            (y + aside * cosine(hdg), *(ky + t * cosine(khdg) for t in (left, right))),
            (half, np.full(2 * len(arm), _KERB)),
            (of, np.full(2 * len(arm), -1)),
            (cars.entry[of], arm, arm),
            (cars.exit[of], arm, arm),
        )
        junction = np.concatenate([cars.junction[of], end_junction[arm], end_junction[arm]])
        order = np.argsort(junction, kind="stable")
        first, last = (np.searchsorted(junction[order], junctions, side).tolist() for side in ("left", "right"))
        slices = dict(zip(junctions.tolist(), map(slice, first, last), strict=True))
        x, y, radius, row, one, other = (np.concatenate(column)[order] for column in columns)
        return cls(parts, cars, slices, x, y, radius, row, one, other, float(radius.max(initial=0.0)))

    def strips(self, asked: Sequence[_Asked]) -> list[_Strip]:
        """Return strips with the room that they have beside their edges."""
        row = np.array([item.edge.row for item in asked], np.int64)
        side = np.array([item.edge.side for item in asked], np.int64)
        at_start = np.array([item.edge.at_start for item in asked], bool)
        road = self.cars.length[row]
        whole = [item.edge.off_kerb(self.parts) < defaults.CORNER_ONTO_LANE for item in asked]
        length = np.minimum(np.where(whole, 1.0, _PART) * road, _LONGEST)
        length = np.where([item.beyond >= 0 for item in asked], np.inf, length)
        reach = np.minimum(length, road)
        count = (reach / np.where(np.isfinite(length), _DISCS, _SPACING)).astype(np.int64) + 2
        of = repeated(count)
        away = reach[of] * ranks(count) / (count - 1)[of]
        s = np.where(at_start[of], away, road[of] - away)
        x, y, hdg, aside, half = _lane(self.cars, row[of], s)
        t = aside + side[of] * half
        x, y, nx, ny = x - t * sine(hdg), y + t * cosine(hdg), -side[of] * sine(hdg), side[of] * cosine(hdg)
        # No farther than the centre of a bend, which may begin between two places.
        bend = _largest_beside(side[of] * curvature_at(self.cars.plan_view, row[of], s), of)
        inside = 1.0 / np.maximum(bend, defaults.SAME_PLACE) - side[of] * t - defaults.CORNER_EDGE_RADIUS
        width, gap = np.array([(item.width, item.gap) for item in asked]).reshape(-1, 2).T
        wish = width[of] * _left(away, length[of])
        border = np.minimum(gap[of] * _left(away, np.minimum(length, _LONGEST)[of]), np.maximum(inside, 0.0))
        bounds = list(pairwise(starts(count).tolist()))
        room = [
            self._room(x[a:b], y[a:b], nx[a:b], ny[a:b], item) for item, (a, b) in zip(asked, bounds, strict=True)
        ]
        most = np.minimum(inside, np.concatenate([inside[:0], *room]))
        tight = (most < wish + border) & (wish >= _LEAST)
        fits = np.bincount(of[tight], minlength=len(asked)) == 0
        columns = (road.tolist(), length.tolist(), fits.tolist())
        return [
            _Strip(item, total, away[a:b], most[a:b], wish[a:b], border[a:b], over, free)
            for item, (a, b), total, over, free in zip(asked, bounds, *columns, strict=True)
        ]

    def beside_arm(self, place: Place, walk: Sidewalk, beyond: int) -> tuple[FloatArray, FloatArray]:
        """Return distances from a road end, m, and how wide its sidewalk may be there, m, both (m,)."""
        end, side = place
        road = float(self.parts.length[end // 2])
        u = np.arange(0.0, min(_FARTHEST, _MOST_OF_ROAD * road), _SPACING)
        x, y, hdg = pose(self.parts.plan_view, np.full(len(u), end // 2), road - u if end % 2 else u)
        t = walk.t - side * walk.width / 2
        x, y = x - t * sine(hdg), y + t * cosine(hdg)
        asked = _Asked(_NO_EDGE, walk.width, 0.0, end, beyond)
        return u, self._room(x, y, -side * sine(hdg), side * cosine(hdg), asked)

    def _room(self, x: FloatArray, y: FloatArray, nx: FloatArray, ny: FloatArray, asked: _Asked) -> FloatArray:
        """Return how far a strip may reach from places (m,) in directions nx, ny up to lanes and kerbs, (m,), m.

        What belongs to the arm beyond alone counts from the middle on.
        """
        here = self.slices[int(self.parts.end_junction.ravel()[asked.end])]
        cx, cy = self.x[here], self.y[here]
        # From the middle on, what is twice as far away matters.
        reach = (asked.width + asked.gap) * (1.0 if asked.beyond < 0 else 2.0) + self.widest
        near = (cx > x.min() - reach) & (cx < x.max() + reach) & (cy > y.min() - reach) & (cy < y.max() + reach)
        one, other = self.one[here], self.other[here]
        near &= (self.row[here] != asked.edge.row) & ((one != asked.end) | (other != asked.end))
        at = np.flatnonzero(near)
        one, other, radius = one[at], other[at], self.radius[here][at]
        dx, dy = cx[at] - x[:, None], cy[at] - y[:, None]
        ahead, along = dx * nx[:, None] + dy * ny[:, None], dx * ny[:, None] - dy * nx[:, None]
        depth = radius**2 - along**2
        half = np.sqrt(np.maximum(depth, 0.0))
        out = np.where((depth > 0.0) & (ahead + half > defaults.CORNER_ONTO_LANE), ahead - half, np.inf)
        if asked.beyond >= 0:
            shared = ((one == asked.beyond) | (other == asked.beyond)) & (one != asked.end) & (other != asked.end)
            # As far from the disc as from the place.
            over = ahead + radius
            middle = (ahead**2 + along**2 - radius**2) / (2.0 * np.maximum(over, defaults.CORNER_ONTO_LANE))
            out = np.where(shared, np.where(over > defaults.CORNER_ONTO_LANE, middle, np.inf), out)
        return np.asarray(out.min(axis=1, initial=np.inf))


def _largest_beside(values: FloatArray, of: IntArray) -> FloatArray:
    """Return the largest of values at places in a row and at those beside them, of the same row, (n,)."""
    out, same = values.copy(), of[1:] == of[:-1]
    out[1:][same] = np.maximum(out[1:][same], values[:-1][same])
    out[:-1][same] = np.maximum(out[:-1][same], values[1:][same])
    return out


def _left(away: FloatArray, length: FloatArray | float) -> FloatArray:
    """Return which share of a width is left at places so far from where it begins to become 0 over a length, m."""
    return np.asarray(1.0 - smooth_step(np.minimum(away / length, 1.0)))


def _lane(
    cars: ConnectingRoads, row: IntArray, s: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return x, y and heading of places on reference lines, t of the middle of the lane there, and half its width."""
    x, y, hdg = pose(cars.plan_view, row, s)
    start = cars.change_start()[row]
    step = smooth_step(np.clip((s - start) / (cars.length[row] - start), 0.0, 1.0))
    aside = cars.entry_aside[row] + (cars.exit_aside - cars.entry_aside)[row] * step
    width = cars.entry_width[row] + (cars.exit_width - cars.entry_width)[row] * step
    return x, y, hdg, aside, width / 2
