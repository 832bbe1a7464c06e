"""Lanes of streets that run side by side become narrow enough, and their lines move apart, for both to fit.

First it is found where there is too little room, and what each of them should give.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from osm2xodr.curves import (
    PointTree,
    Table,
    cosine,
    find_record,
    hypot,
    join_tables,
    lengths,
    pose,
    ranks,
    repeated,
    sine,
    sorted_unique,
    starts,
)
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import (
    ARM_REACH,
    ARM_REACH_MOTORWAY,
    FAST_HIGHWAYS,
    LEAST_MEDIAN,
    PARALLEL_GAP,
    PARALLEL_SINE,
    PARALLEL_SPACING,
)
from osm2xodr.geometry.lanes import Piece, cross_section
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.streets import FittedStreets
from osm2xodr.model import (
    VEHICLE_LANES,
    BoolArray,
    FloatArray,
    IntArray,
    LaneSpec,
    PlanView,
    Rule,
    StreetAttributes,
    StreetNetwork,
)
from osm2xodr.system import record

# Streets move aside by this or more, m; a choice.
_LEAST_ASIDE: Final = 0.15
# Streets side by side lack less than this share of their widths: others lie on each other. A choice.
_MOST_LACK: Final = 0.5
# What streets lack less than this is no reason to change them, m; a choice.
_LEAST_LACK: Final = 0.1
# Room for rounding where places of two streets are abreast, m, and of shares, %.
_ABREAST_SLACK: Final = 0.1
_ROUNDING: Final = 1e-6
# Where a street in a bend passes another one, places this far apart are compared, m; within half of
# `PARALLEL_SPACING` the bend turns by less than the angle of this sine (50 degrees). Choices.
_BEND_SPACING: Final = 1.0
_BENT_SINE: Final = 0.77


def separate_parallel_streets(
    network: StreetNetwork, fitted: FittedStreets, diagnostics: Diagnostics
) -> FittedStreets:
    """Move streets aside, and narrow their lanes, where their carriageways would overlap those of a parallel street.

    OSM gives the middle of carriageways, seldom their width, and neither is exact. Lanes become as narrow as any that
    are built; for what is lacking still lines move a little, then lanes become narrower, then lines move on.
    """
    abreast = places_abreast(network, fitted)
    tight = tight_places(abreast, fitted)
    tight = tight.chosen(np.flatnonzero(np.abs(tight.aside) > _LEAST_ASIDE))
    moved = _changed(fitted, tight, network.rule, partial(_moved, diagnostics))
    tight = tight_places(abreast, moved)
    tight = tight.chosen(np.flatnonzero(tight.share < 1.0))
    return _changed(moved, tight, network.rule, partial(_narrowed, diagnostics))


def _changed(
    fitted: FittedStreets,
    tight: TightPlaces,
    rule: Rule,
    change: Callable[[StreetAttributes, TightPlaces], StreetAttributes],
) -> FittedStreets:
    """Return streets of which the parts around tight places change."""
    first = starts([len(pieces) for pieces in fitted.pieces])
    length = lengths(fitted.plan_view)
    out = list(fitted.pieces)
    for k in sorted_unique(tight.street).tolist():
        ends = [*(s for s, _, _ in fitted.pieces[k][1:]), float(length[k])]
        own: list[Piece] = []
        for number, (piece, end) in enumerate(zip(fitted.pieces[k], ends, strict=True), start=int(first[k])):
            places = tight.chosen(slice(*np.searchsorted(tight.piece, (number, number + 1)).tolist()))
            for s, rows in _stretches(places.s, piece[0], end):
                new = change(piece[1], places.chosen(rows)) if len(rows) else piece[1]
                own.append((s, new, piece[2] if new is piece[1] else cross_section(new, rule)))
        out[k] = tuple(own)
    return replace(fitted, pieces=tuple(out))


def _stretches(s: FloatArray, begin: float, end: float) -> list[tuple[float, IntArray]]:
    """Return where stretches begin along a piece of a street, and which of its tight places lie on them."""
    if not len(s):
        return [(begin, np.arange(0))]
    # What lies between and beside them has to be worth a change.
    reach = 0.5 * PARALLEL_SPACING + defaults.SEPARATED_BEYOND
    apart = np.flatnonzero(np.diff(s) > 2.0 * reach + defaults.SHORTEST_BETWEEN) + 1
    out: list[tuple[float, IntArray]] = []
    for rows in np.split(np.arange(len(s)), apart):
        first, last = float(s[rows[0]]) - reach, float(s[rows[-1]]) + reach
        if not out and first - begin < defaults.SHORTEST_BETWEEN:
            first = begin
        elif not out:
            out.append((begin, np.arange(0)))
        out.append((first, rows))
        if end - last >= defaults.SHORTEST_BETWEEN:
            out.append((last, np.arange(0)))
    return out


def _moved(diagnostics: Diagnostics, attributes: StreetAttributes, tight: TightPlaces) -> StreetAttributes:
    """Return a part of a street that moves away from others beside it."""
    aside = round(float(max(tight.aside.max(), 0.0) + min(tight.aside.min(), 0.0)), 2)
    if abs(aside) <= _LEAST_ASIDE:
        # Streets on both sides want about as much.
        return attributes
    text = f"it lies {abs(aside):.2f} m farther from a parallel road than OSM's lines, which leave no room for both"
    diagnostics.repaired("moved-aside", f"way/{attributes.osm_way_id}", text)
    return replace(attributes, moved_aside=aside)


def _narrowed(diagnostics: Diagnostics, attributes: StreetAttributes, tight: TightPlaces) -> StreetAttributes:
    """Return a part of a street with lanes as narrow as others beside it want."""
    share = float(tight.share.min())
    lanes = tuple(replace(lane, width=_width(lane, share)) for lane in attributes.lanes_ltr)
    text = f"its lanes are drawn at {100 * share:.0f} % of their width, a parallel road leaves no more room"
    both = zip(lanes, attributes.lanes_ltr, strict=True)
    if any(lane.width > round(old.width * share, 2) for lane, old in both):
        text += f"; lanes for cars do not get below {defaults.NARROWEST_LANE:g} m and may overlap it"
    diagnostics.repaired("lanes-narrowed", f"way/{attributes.osm_way_id}", text)
    return replace(attributes, lanes_ltr=lanes)


def _width(lane: LaneSpec, share: float) -> float:
    """Return the width of a lane that may keep a share of it, m."""
    width = round(lane.width * share, 2)
    return max(width, min(lane.width, defaults.NARROWEST_LANE)) if lane.type in VEHICLE_LANES else width


@record(eq=False)
class TightPlaces(Table):
    """Places along streets at which a parallel street leaves too little room, by piece, then s."""

    street: IntArray  # (n,)
    piece: IntArray  # (n,) Piece of its street, over all streets
    s: FloatArray  # (n,) m
    aside: FloatArray  # (n,) How far it should move to the left, m
    share: FloatArray  # (n,) Of the width of its lanes that fits where nothing moves


@record(eq=False)
class _Places(Table):
    """Places along streets."""

    street: IntArray  # (n,)
    # (n,) Chainage, position, m, and heading, rad
    s: FloatArray
    x: FloatArray
    y: FloatArray
    hdg: FloatArray

    @classmethod
    def on(cls, plan: PlanView, street: IntArray, s: FloatArray) -> _Places:
        """Return the places at s of streets."""
        return cls(street, s, *pose(plan, street, s))


@record(eq=False)
class PlacesAbreast(Table):
    """Places along streets that lie beside a place of another street, (n,), whatever the widths of both."""

    street: IntArray
    s: FloatArray  # m
    # The other street, and where on it, m
    other: IntArray
    other_s: FloatArray
    left: FloatArray  # How far to the left the other one lies, m
    same_way: BoolArray  # Whether it runs the same way


def places_abreast(network: StreetNetwork, fitted: FittedStreets) -> PlacesAbreast:
    """Find the places along streets that lie beside other streets."""
    plan = fitted.plan_view
    length = lengths(plan)
    # Places `PARALLEL_SPACING` or a little more apart along all streets.
    count = np.maximum((length / PARALLEL_SPACING).astype(np.int64), 1)
    spaced = _Places.on(plan, repeated(count), (ranks(count) + 0.5) * np.repeat(length / count, count))
    places = np.column_stack([spaced.x, spaced.y])
    one, other = PointTree(places).within(places, defaults.PARALLEL_REACH)
    one, other = one[one < other], other[one < other]
    sides = _sides(fitted)
    piece = sides.at(spaced.street, spaced.s)
    apart = (spaced.street[one] != spaced.street[other]) & (sides.layer[piece[one]] == sides.layer[piece[other]])
    one, other = one[apart], other[apart]
    across = np.abs(sine(spaced.hdg[one] - spaced.hdg[other]))
    parallel, half = across < PARALLEL_SINE, sides.edges.max(axis=1)[piece]
    distance = hypot(spaced.x[one] - spaced.x[other], spaced.y[one] - spaced.y[other])
    bent = np.flatnonzero(
        ~parallel & (across < _BENT_SINE) & (distance < half[one] + half[other] + 0.5 * PARALLEL_SPACING)
    )
    nodes = _StreetNodes.of(network)
    bent = bent[~nodes.shared_near(spaced.chosen(one[bent]), spaced.chosen(other[bent]))]
    nearest = _nearest_places(plan, length, spaced.chosen(one[bent]), spaced.chosen(other[bent]))
    found = [
        _abreast(nodes, p, q, slack)
        for a, b, slack in (
            (spaced.chosen(one[parallel]), spaced.chosen(other[parallel]), 0.5 * PARALLEL_SPACING),
            (*nearest, _BEND_SPACING),
        )
        for p, q in ((a, b), (b, a))
    ]
    return join_tables(found)


def tight_places(abreast: PlacesAbreast, fitted: FittedStreets) -> TightPlaces:
    """Return the places at which streets, as wide as they are now, leave too little room for both."""
    sides = _sides(fitted)
    one, two = sides.at(abreast.street, abreast.s), sides.at(abreast.other, abreast.other_s)
    own = sides.edges[one, np.where(abreast.left > 0, 0, 1)]
    other = sides.edges[two, np.where((abreast.left > 0) == abreast.same_way, 1, 0)]
    overlap = own + other - np.abs(abreast.left)
    motorways = sides.motorway[one] & sides.motorway[two] & ~abreast.same_way
    lack = overlap + np.where(motorways, LEAST_MEDIAN, PARALLEL_GAP)
    beside = (overlap < _MOST_LACK * (own + other)) & (own > 0) & (other > 0)
    chosen = np.flatnonzero(beside & (lack > _LEAST_LACK))
    chosen = chosen[np.lexsort((abreast.s[chosen], one[chosen]))]
    one, two, overlap, lack = one[chosen], two[chosen], overlap[chosen], lack[chosen]
    # Of two carriageways with lanes that OSM's line may leave aside it is the one with more of them.
    more, less = sides.of_place[one], sides.of_place[two]
    line = sides.of_line[one] + np.where(more >= less, more, 0.0)
    other_line = sides.of_line[two] + np.where(less >= more, less, 0.0)
    usual = sides.room[one] + sides.room[two]
    most = (1.0 - defaults.NARROWEST_SHARE) * sides.half
    lines = np.minimum(np.maximum(lack - usual, 0.0), line + other_line)
    lines += np.maximum(lack - lines - np.maximum(most[one] + most[two], usual), 0.0)
    aside = -np.sign(abreast.left[chosen]) * lines * line / np.maximum(line + other_line, _ROUNDING)
    both = sides.of_width[one] + sides.of_width[two]
    lack = np.maximum(overlap + PARALLEL_GAP, 0.0)
    narrower = np.minimum(np.maximum(lack * sides.of_width[one] / both, lack - most[two]), most[one])
    share = np.floor(100.0 * (1.0 - narrower / sides.half[one]) + _ROUNDING) / 100.0
    return TightPlaces(abreast.street[chosen], one, abreast.s[chosen], aside, share)


@record(eq=False)
class _Sides:
    """What streets beside a piece of a street want to know of it."""

    # (streets + 1,) Index of each street's first piece; (pieces,) where each begins, m, and its layer
    first: IntArray
    begin: FloatArray
    layer: IntArray
    edges: FloatArray  # (pieces, 2) Distance of its left and right edge from OSM's line, m
    half: FloatArray  # (pieces,) Half of its width, m
    motorway: BoolArray  # (pieces,)
    # (pieces,) How far OSM's line may lie off the middle of the lanes, and off that of those that lead on, m
    of_line: FloatArray
    of_place: FloatArray
    room: FloatArray  # (pieces,) What lanes as narrow as any of their class leave of half of the width, m
    of_width: FloatArray  # (pieces,) Variance of half of the width, m2

    def at(self, street: IntArray, s: FloatArray) -> IntArray:
        """Return the pieces at s of streets, (n,)."""
        return find_record(self.first, self.begin, street, s)


def _sides(fitted: FittedStreets) -> _Sides:
    """Return what streets beside them want to know of all pieces."""
    every = [piece for pieces in fitted.pieces for piece in pieces]
    first = starts([len(pieces) for pieces in fitted.pieces])
    begin = np.array([s for s, _, _ in every])
    layer = np.array([attributes.layer for _, attributes, _ in every], np.int64)
    edges = np.array([(section.left_edge, -section.right_edge) for _, _, section in every]).reshape(-1, 2)
    motorway = np.array([attributes.highway == "motorway" for _, attributes, _ in every], bool)
    give = np.array([_give(attributes) for _, attributes, _ in every]).reshape(-1, 4)
    return _Sides(first, begin, layer, edges, edges.mean(axis=1), motorway, *give.T)


def _give(attributes: StreetAttributes) -> tuple[float, float, float, float]:
    """Return what a street may give to others beside it: see `_Sides`, its last four fields.

    The line of a fast one-way road with more than two lanes may lie in the middle of those that lead on.
    """
    lanes = attributes.lanes_ltr
    fast = attributes.highway in FAST_HIGHWAYS
    line = 0.0 if attributes.roundabout else defaults.LINE_ASIDE
    place = 0.5 * sum(lane.width for lane in lanes[2:]) if fast and len(attributes.car_directions()) == 1 else 0.0
    narrow = (defaults.NARROW_LANE_BUILT / lane.width for lane in lanes if lane.type in VEHICLE_LANES)
    share = 1.0 if attributes.highway == "motorway" else min(max(narrow, default=1.0), 1.0)
    width = defaults.ONE_LANE_ERROR if len(lanes) == 1 else len(lanes) * defaults.LANE_ERROR
    return line, place, 0.5 * (1.0 - share) * sum(lane.width for lane in lanes), (0.5 * width) ** 2


def _nearest_places(plan: PlanView, length: FloatArray, a: _Places, b: _Places) -> tuple[_Places, _Places]:
    """Return where two streets come nearest to each other around places of theirs, if they run side by side there.

    A street in a bend may touch another one between two places that are not abreast.
    """
    steps = np.arange(-0.5 * PARALLEL_SPACING, 0.5 * PARALLEL_SPACING + _BEND_SPACING, _BEND_SPACING)
    around = []
    for item in (a, b):
        s = np.clip(item.s[:, None] + steps, 0.0, length[item.street][:, None])
        around.append(_Places.on(plan, np.repeat(item.street, len(steps)), s.ravel()))
    p, q = around
    shape = (len(a.s), len(steps))
    dx = p.x.reshape(shape)[:, :, None] - q.x.reshape(shape)[:, None, :]
    dy = p.y.reshape(shape)[:, :, None] - q.y.reshape(shape)[:, None, :]
    nearest = np.argmin((dx * dx + dy * dy).reshape(len(a.s), len(steps) ** 2), axis=1)
    row = len(steps) * np.arange(len(a.s))
    p, q = p.chosen(row + nearest // len(steps)), q.chosen(row + nearest % len(steps))
    parallel = np.flatnonzero(np.abs(sine(p.hdg - q.hdg)) < PARALLEL_SINE)
    return p.chosen(parallel), q.chosen(parallel)


def _abreast(nodes: _StreetNodes, a: _Places, b: _Places, slack: float) -> PlacesAbreast:
    """Return which of places a lie beside places b of other streets, both (n,), and are no arms of one junction.

    Places are abreast if one is at most `slack` ahead of the other, m.
    """
    dx, dy = b.x - a.x, b.y - a.y
    ahead = dx * cosine(a.hdg) + dy * sine(a.hdg)
    left = dy * cosine(a.hdg) - dx * sine(a.hdg)
    rows = np.flatnonzero((np.abs(ahead) <= slack + _ABREAST_SLACK) & ~nodes.shared_near(a, b))
    a, b = a.chosen(rows), b.chosen(rows)
    return PlacesAbreast(a.street, a.s, b.street, b.s, left[rows], cosine(a.hdg - b.hdg) > 0)


@record(eq=False)
class _StreetNodes:
    """The nodes at which streets end."""

    xy: FloatArray  # (nodes, 2) m
    ends: IntArray  # (streets, 2) Those of each street, below 0 for none
    fast: BoolArray  # (streets,) Whether it is a fast road somewhere

    @classmethod
    def of(cls, network: StreetNetwork) -> _StreetNodes:
        """Return those of a network."""
        xy = np.array([(node.x, node.y) for node in network.intersections] or [(0.0, 0.0)])
        ends = np.array([(street.start, street.end) for street in network.streets])
        fast = [any(item.highway in FAST_HIGHWAYS for _, item in street.pieces) for street in network.streets]
        return cls(xy, ends, np.array(fast))

    def shared_near(self, a: _Places, b: _Places) -> BoolArray:
        """Say which places a are close to a node at which their streets and those of b end: arms of one junction."""
        reach = np.where(self.fast[a.street] | self.fast[b.street], ARM_REACH_MOTORWAY, ARM_REACH)
        near = np.zeros(len(a.s), bool)
        for p in (0, 1):
            node = self.ends[a.street, p]
            shared = (node >= 0) & ((node == self.ends[b.street, 0]) | (node == self.ends[b.street, 1]))
            near |= shared & (hypot(a.x - self.xy[node, 0], a.y - self.xy[node, 1]) < reach)
        return near
