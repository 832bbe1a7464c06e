"""Dead ends: those that lie on other streets are cut back, and turning circles get loops."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from osm2xodr.curves import (
    PointTree,
    arctan2,
    cosine,
    curves_of,
    find_record,
    hypot,
    lengths,
    pose,
    ranks,
    repeated,
    replace_curves,
    sine,
    starts,
    unique_inverse,
    unique_rows,
)
from osm2xodr.defaults import CONNECTING_RADIUS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import SHORTEST_ROAD, SHORTEST_STREET, U_TURN_RADIUS, U_TURN_RADIUS_MAX
from osm2xodr.geometry.junctions import defaults
from osm2xodr.geometry.junctions.clusters import JunctionLayout
from osm2xodr.geometry.junctions.movements import Loop, Movement
from osm2xodr.geometry.lanes import end_lanes
from osm2xodr.geometry.options import RoadOptions
from osm2xodr.geometry.plan_view import FittedStreets, StreetEnds, outward_pose
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView, StreetNetwork

# Places along streets at which it is asked whether a dead end lies on them, and along dead ends, m.
_SPACING: Final = 4.0
_STEP: Final = 0.5
# Dead ends are cut back by this at most, m: across a wide carriageway at a slant, or by the entrance of a car park
# behind a street. What lies on another street for longer runs along it. And they keep this share of their length.
# Choices.
_MOST: Final = 15.0
_LEAST_SHARE: Final = 0.5
# Carriageways count as apart from this distance on, m. A choice.
_GAP: Final = 0.3

# Free space between a loop and the next carriageway, m. A choice.
_LOOP_CLEARANCE: Final = 0.5
# Streets are compared with loops in straight pieces of at most this length, m.
_PIECE_LENGTH: Final = 40.0
# Lanes whose distance makes all but this much of their loop's radius go round half a circle without curves before and
# after it, m.
_LEAST_ASIDE: Final = 0.05


def ends_on_streets(fitted: FittedStreets, ends: StreetEnds) -> list[tuple[int, BoolArray]]:
    """Return the dead ends on or just behind a street of their layer that they do not meet; some come several times.

    With each comes whether it lies there if it is cut back, (n,), by 0 m, then by steps of `_STEP`.
    """
    node = ends.node
    dead = np.flatnonzero(node >= 0)
    dead = dead[np.bincount(node[dead])[node[dead]] == 1]
    streets = _Streets(fitted)
    found = []
    for end, street in streets.under(ends, dead):
        if np.isin(node[[2 * street, 2 * street + 1]], node[[end, end ^ 1]]).any():
            continue
        u = _back(ends, end)
        on = np.zeros(len(u), bool)
        x, y, hdg = outward_pose(ends, np.full(len(u), end), u)
        for edge in (float(ends.left[end]), float(ends.right[end])):
            on |= streets.covers(street, x - edge * sine(hdg), y + edge * cosine(hdg), _GAP)
        found.append((end, on))
    return found


def cut_back_ends_on_streets(
    network: StreetNetwork,
    ends: StreetEnds,
    layout: JunctionLayout,
    found: Iterable[tuple[int, BoolArray]],
    diagnostics: Diagnostics,
) -> JunctionLayout:
    """Cut back the dead ends that `ends_on_streets` has found and that are roads' ends, and report them.

    Most were meant to join that street, but nothing says so: roads would lie on each other that know nothing of it.
    """
    free = (layout.junction < 0) & ~np.repeat(layout.inner, 2) & (layout.trim == 0)
    trim, most = layout.trim.copy(), layout.most.copy()
    for end, on in found:
        if not free[end]:
            continue
        spare = float(ends.length[end]) - SHORTEST_STREET
        u = _back(ends, end)
        u = u[: max(1, int(np.count_nonzero(u <= spare - trim[end ^ 1])))]
        on = on[: len(u)]
        if not on[-1]:
            trim[end] = max(trim[end], u[np.flatnonzero(on)[-1] + 1] if on.any() else 0.0)
            most[end] = max(most[end], trim[end])
            most[end ^ 1] = max(trim[end ^ 1], min(most[end ^ 1], spare - trim[end]))
            way = network.streets[end // 2].attributes_at_end(end).osm_way_id
            text = "it ends on or behind another road without a common node, and is cut back to where it is apart"
            diagnostics.repaired("lies-on-another", f"way/{way}", text)
    return replace(layout, trim=trim, most=most)


def _back(ends: StreetEnds, end: int) -> FloatArray:
    """Return how far from a dead end it may be cut back, (n,), m, from 0 on."""
    return np.arange(0.0, max(min(_MOST, _LEAST_SHARE * float(ends.length[end])), _STEP), _STEP)


class _Streets:
    """Carriageways of all streets at places along them."""

    def __init__(self, fitted: FittedStreets) -> None:
        length = lengths(fitted.plan_view)
        count = np.maximum(np.ceil(length / _SPACING).astype(np.int64), 1) + 1
        self._first = starts(count.tolist())
        self.street = repeated(count)
        s = ranks(count) * (length / (count - 1))[self.street]
        x, y, hdg = pose(fitted.plan_view, self.street, s)
        self._xy, self._along = np.column_stack([x, y]), np.column_stack([cosine(hdg), sine(hdg)])
        every = [piece for pieces in fitted.pieces for piece in pieces]
        begin = np.array([first for first, _, _ in every])
        piece = find_record(starts([len(pieces) for pieces in fitted.pieces]), begin, self.street, s)
        self._left = np.array([section.left_edge for _, _, section in every])[piece]
        self._right = np.array([section.right_edge for _, _, section in every])[piece]
        # By layer, and bridges, tunnels and what lies on the ground apart.
        level = [3 * attributes.layer + attributes.structure for _, attributes, _ in every]
        self._level = np.array(level)[piece]

    def under(self, ends: StreetEnds, found: IntArray) -> list[tuple[int, int]]:
        """Return the ends, of those asked about, that lie on a street of their level, and that street.

        Their middle does, there or some way before them, or one of their corners.
        """
        if not len(found):
            return []
        back = [_back(ends, end) for end in found.tolist()]
        end = np.concatenate([np.repeat(found, [len(u) for u in back]), found, found])
        x, y, hdg = outward_pose(ends, end, np.concatenate([*back, np.zeros(2 * len(found))]))
        middles = np.zeros(len(end) - 2 * len(found))
        aside = np.concatenate([middles, ends.left[found], ends.right[found]])
        x, y = x - aside * sine(hdg), y + aside * cosine(hdg)
        reach = float(np.maximum(self._left, -self._right).max()) + _SPACING
        row, place = PointTree(self._xy).within(np.column_stack([x, y]), reach)
        own = np.where(end % 2 == 1, self._first[end // 2 + 1] - 1, self._first[end // 2])
        other = (self.street[place] != end[row] // 2) & (self._level[place] == self._level[own[row]])
        row, place = row[other], place[other]
        on = self._on(place, x[row], y[row], 0.0)
        pairs = unique_rows(np.column_stack([end[row[on]], self.street[place[on]]])).values
        return [(end, street) for end, street in pairs.tolist()]

    def covers(self, street: int, x: FloatArray, y: FloatArray, gap: float) -> BoolArray:
        """Return which points, (n,), m, lie on a street or nearer to it than a gap, m."""
        places = np.arange(self._first[street], self._first[street + 1])
        nearest = places[PointTree(self._xy[places]).nearest(np.column_stack([x, y]))[1]]
        return self._on(nearest, x, y, gap)

    def _on(self, place: IntArray, x: FloatArray, y: FloatArray, gap: float) -> BoolArray:
        """Return whether points, (n,), m, lie beside places, (n,), within the carriageway widened by a gap, m."""
        dx, dy = (np.column_stack([x, y]) - self._xy[place]).T
        cos, sin = self._along[place].T
        ds, dt = dx * cos + dy * sin, dy * cos - dx * sin
        beside = np.abs(ds) <= 0.5 * _SPACING + gap
        out: BoolArray = beside & (dt < self._left[place] + gap) & (dt > self._right[place] - gap)
        return out


class _PlacedLoop(NamedTuple):
    """A loop at the end of a street."""

    loop: Loop
    length: float  # What it takes of its street, m
    # Its outer edge: middle and radius, m; the layer that it lies on
    x: float
    y: float
    radius: float
    layer: int


def add_turnarounds(
    network: StreetNetwork,
    fitted: FittedStreets,
    ends: StreetEnds,
    layout: JunctionLayout,
    options: RoadOptions,
    diagnostics: Diagnostics,
) -> tuple[JunctionLayout, list[Movement]]:
    """Make junctions of one arm of those dead ends where cars turn round, and return their movements.

    `diagnostics` gets the dead ends that have no room for a loop.
    """
    wanted = _wanted(network, ends, layout, options)
    free = _free_space(network, list(wanted), ends)
    placed: dict[int, _PlacedLoop] = {}
    for end, (diameter, most_radius) in wanted.items():
        found = _largest_loop(end, diameter, most_radius, fitted, network, ends, layout, free[end])
        if found is None or _collides(found, placed.get(end ^ 1), placed.values(), float(ends.length[end])):
            osm_id = network.intersections[int(ends.node[end])].osm_node_id
            diagnostics.note("no-room-to-turn", f"node/{osm_id}", "no room for a loop, the dead end is left as it is")
        else:
            placed[end] = found
    if not placed:
        return layout, []
    junction, trim, most = layout.junction.copy(), layout.trim.copy(), layout.most.copy()
    least = layout.least.copy()
    movements = []
    for number, (end, item) in enumerate(placed.items(), start=len(layout.arms)):
        junction[end], trim[end], most[end] = number, item.length, item.length
        most[end ^ 1] = min(most[end ^ 1], ends.length[end] - item.length - SHORTEST_STREET)
        least[end // 2] = SHORTEST_STREET
        movements.append(Movement(number, end, end, (), loop=item.loop))
    layout = replace(
        layout,
        arms=(*layout.arms, *((end,) for end in placed)),
        nodes=(*layout.nodes, *((int(ends.node[end]),) for end in placed)),
        junction=junction,
        trim=trim,
        most=most,
        least=least,
    )
    return layout, movements


def _wanted(
    network: StreetNetwork, ends: StreetEnds, layout: JunctionLayout, options: RoadOptions
) -> dict[int, tuple[float, float]]:
    """Return the street ends where cars turn round, with the diameter and largest radius of loops there, m.

    In a circle whose size nobody mapped, cars turn as they do elsewhere, not along its edge.
    """
    barred = {(item.from_ways[0], item.via_node) for item in network.restrictions if item.from_ways == item.to_ways}
    out: dict[int, tuple[float, float]] = {}
    for node in network.intersections:
        if len(node.arms) != 1:
            continue
        street, at_start = node.arms[0]
        end = 2 * street + (not at_start)
        circle = node.osm_node_id in network.turning_circles
        if not (circle or options.turnarounds) or layout.junction[end] >= 0 or layout.inner[street]:
            continue
        way = network.streets[street].pieces[0 if at_start else -1][1].osm_way_id
        if ends.enters[end] and ends.leaves[end] and (way, node.osm_node_id) not in barred:
            usual = defaults.TURNING_CIRCLE_DIAMETER if circle else defaults.TURNAROUND_DIAMETER
            tagged = network.turning_circles.get(node.osm_node_id)
            wanted = min(max(tagged or usual, defaults.TURNAROUND_DIAMETER_MIN), defaults.TURNAROUND_DIAMETER_MAX)
            out[end] = wanted, math.inf if tagged else U_TURN_RADIUS_MAX
    return out


def _largest_loop(
    end: int,
    diameter: float,
    most: float,
    fitted: FittedStreets,
    network: StreetNetwork,
    ends: StreetEnds,
    layout: JunctionLayout,
    free: float,
) -> _PlacedLoop | None:
    """Return the largest loop for which there is room; `free` is the distance to the next carriageway, m.

    `most` is its largest radius, m, unless it has several lanes.
    """
    section = fitted.pieces[end // 2][-1 if end % 2 else 0][2]
    into, out = end_lanes(section, network.rule, end % 2 == 1), end_lanes(section, network.rule, end % 2 == 0)
    if not into or not out:
        return None
    apart = [abs(one.t - other.t) / 2 for one in into for other in out]
    inner, outer = min(apart), max(apart)
    width = max(lane.spec.width for lane in (*into, *out))
    room = float(ends.length[end] - layout.trim[end ^ 1]) - SHORTEST_STREET
    least = CONNECTING_RADIUS
    wanted = max(min((diameter - width) / 2, most) - outer, least - inner, 0.0)
    for aside in (wanted, max((wanted + least - inner) / 2, 0.0), max(least - inner, 0.0)):
        radius = outer + aside
        for ease in (min(radius, U_TURN_RADIUS), least):
            length = _middle_beyond_end(outer, aside, ease)
            size = radius + width / 2
            if length <= room and size + _LOOP_CLEARANCE <= free:
                node = network.intersections[int(ends.node[end])]
                return _PlacedLoop(Loop(aside, ease), length, node.x, node.y, size, int(ends.layer[end]))
    return None


def _collides(
    loop: _PlacedLoop, opposite: _PlacedLoop | None, placed: Iterable[_PlacedLoop], street_length: float
) -> bool:
    """Say whether a loop lies on others, or leaves no road between it and the opposite one of its street."""
    if opposite is not None and street_length - opposite.length - loop.length < 2 * SHORTEST_ROAD:
        return True
    x, y, layer, radius = loop.x, loop.y, loop.layer, loop.radius
    return any(
        layer == other.layer and float(hypot(x - other.x, y - other.y)) < radius + other.radius for other in placed
    )


def _middle_beyond_end(half: float, aside: float, ease: float) -> float:
    """Return how far a loop's middle lies beyond the end of its road, m.

    `half` is half of the distance of the outermost lanes, m; `aside` and `ease` are as in `Loop`.
    """
    return math.sqrt(max((half + aside + ease) ** 2 - (half + ease) ** 2, 0.0))


def _free_space(network: StreetNetwork, wanted: Sequence[int], ends: StreetEnds) -> dict[int, float]:
    """Return the distance from dead ends to the nearest carriageway of another street of the layer, m.

    The own street counts from where it is farther away along itself than any loop reaches.
    """
    if not wanted:
        return {}
    start, end, street, run = _short_lines(network)
    half = np.maximum(ends.left, -ends.right)[0::2]
    reach = defaults.TURNAROUND_DIAMETER_MAX + float(half.max()) + _PIECE_LENGTH / 2
    nodes = [network.intersections[int(ends.node[item])] for item in wanted]
    xy = np.array([(node.x, node.y) for node in nodes])
    close = np.flatnonzero(PointTree(xy).nearest((start + end) / 2, reach)[1] >= 0)
    lines = PointTree((start[close] + end[close]) / 2)
    whole = ends.length[0::2]
    out: dict[int, float] = {}
    for item, place in zip(wanted, xy, strict=True):
        found = close[lines.within(place[None], reach)[1]]
        away = whole[item // 2] - run[found] if item % 2 else run[found]
        own = (street[found] == item // 2) & (away < 3 * defaults.TURNAROUND_DIAMETER_MAX)
        found = found[~own & (ends.layer[2 * street[found]] == ends.layer[item])]
        from_start, along = place - start[found], (end - start)[found]
        share = (from_start * along).sum(1) / np.maximum((along * along).sum(1), 1e-12)
        distance = hypot(*(from_start - np.clip(share, 0.0, 1.0)[:, None] * along).T)
        out[item] = float((distance - half[street[found]]).min(initial=math.inf))
    return out


def _short_lines(network: StreetNetwork) -> tuple[FloatArray, FloatArray, IntArray, FloatArray]:
    """Return all streets in short straight pieces: start, end (n, 2), street and run of the middle (n,)."""
    points = np.concatenate([street.points for street in network.streets])
    owner = repeated([len(street.points) for street in network.streets])
    first = np.flatnonzero(owner[1:] == owner[:-1])
    size = hypot(*(points[first + 1] - points[first]).T)
    run = np.cumsum(size) - size
    run -= run[np.searchsorted(owner[first], owner[first])]
    count = np.maximum(np.ceil(size / _PIECE_LENGTH).astype(np.int64), 1)
    line = repeated(count)
    share = ranks(count) / count[line]
    step = (points[first + 1] - points[first])[line]
    start = points[first][line] + share[:, None] * step
    middle = run[line] + (share + 0.5 / count[line]) * size[line]
    return start, start + step / count[line][:, None], owner[first][line], middle


def draw_loops(
    plan: PlanView, row: IntArray, movement: IntArray, loop: Sequence[Loop], half: FloatArray, left: bool
) -> PlanView:
    """Return the curves of connecting roads, some of them (`row`) replaced by loops that start in the same poses.

    `movement` is that of each, whose loops go round one middle, `half` half of the distance between its lanes, m, all
    (n,). With traffic on the `left`, loops go round clockwise.
    """
    if not len(row):
        return plan
    first = plan.start[row]
    number = unique_inverse(movement)[1]
    outermost = np.zeros(len(row))
    np.maximum.at(outermost, number, half)
    middle = np.array(
        [
            _middle_beyond_end(g, item.aside, item.ease)
            for g, item in zip(outermost[number].tolist(), loop, strict=True)
        ]
    )
    aside = np.array([item.aside for item in loop])
    wide = aside > _LEAST_ASIDE
    safe = np.where(wide, aside, 1.0)
    radius = half + np.where(wide, aside, 0.0)
    # Circles that touch both the lane and the loop from outside: (radius + ease)² = middle² + (half + ease)².
    ease = np.where(wide, (middle**2 + half**2 - radius**2) / (2 * safe), 1.0)
    bend = np.where(wide, arctan2(middle, half + ease), 0.0)
    sign = -1.0 if left else 1.0
    curvature = sign * np.column_stack([-1 / ease, 1 / radius, -1 / ease])
    length = np.column_stack([ease * bend, radius * (np.pi + 2 * bend), ease * bend])
    loops = curves_of(plan.x[first], plan.y[first], plan.hdg[first], length, curvature)
    return replace_curves(plan, row, loops, np.arange(len(row)))
