"""The question that the elevation solve answers, and its answer, as flat arrays over the whole network."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, fields, replace
from typing import Any, Final, TypeVar

import numpy as np

from osm2xodr.curves import chosen_curves, find_record, runs, starts
from osm2xodr.geometry.defaults import FAST_HIGHWAYS
from osm2xodr.geometry.heights.defaults import CLEARANCE, CLEARANCE_OTHER, DECK
from osm2xodr.model import BoolArray, CubicProfile, ElevationReport, FloatArray, IntArray, PlanView, Rule, Structure
from osm2xodr.system import record

_Column = TypeVar("_Column", FloatArray, IntArray, BoolArray)
# Width of a carriageway that is not known, m.
_UNKNOWN_WIDTH: Final = 6.0


@record(eq=False)
class Pins:
    """Places at which profiles have a knot, and the heights and grades that roads are held to there."""

    # (P,) Road and place along it, m
    road: IntArray
    s: FloatArray
    # (P,) Height, m, and rise per metre along +s; NaN for none
    z: FloatArray
    grade: FloatArray


@record(eq=False)
class KnownHeights:
    """Heights that the user knows of nodes, on roads and in junctions."""

    node: IntArray  # (n,) OSM ids, for reports
    # (n,) Road, -1 in a junction, and place along it, m
    road: IntArray
    s: FloatArray
    # (n,) Junction, -1 on a road, and (n, 2) the place from its origin, m
    junction: IntArray
    offset: FloatArray
    z: FloatArray  # (n,) m


@record(eq=False)
class ProfileProblem:
    """Roads outside junctions whose heights are wanted.

    R roads, J junctions, K spans (pieces of roads with the same attributes). A road end is named by one number,
    2 * road + (0 for its start, 1 for its end).
    """

    plan_view: PlanView  # Reference lines of the R roads, already trimmed at junctions
    end_junction: IntArray  # (R, 2) Junction at each road's start and end, -1 where there is none
    end_link: IntArray  # (R, 2) The road end that each road end touches directly, -1 where there is none. Symmetric.
    junction_xy: FloatArray  # (J, 2) Origin of each junction, local x, y, m
    span_start: IntArray  # (R + 1,) Index of each road's first span; every road has at least one
    span_s: FloatArray  # (K,) Where each span starts along its road, m; it holds to the next one or to the road's end
    # (K,) `Structure` values and OSM's ``layer``
    span_structure: IntArray
    span_layer: IntArray
    span_highway: tuple[str, ...]  # K values of OSM's ``highway``
    span_grade: FloatArray  # (K,) Rise per metre along +s that OSM's ``incline`` gives, NaN where it gives none
    span_way: IntArray  # (K,) OSM way ids, for reports
    # (K,) Equal numbers for equal names or refs, -1 for none; carriageways of one street are found by it
    span_name: IntArray | None = None
    span_oneway: IntArray | None = None  # (K,) 1 where traffic runs along +s only, -1 against it only, 0 both ways
    span_width: FloatArray | None = None  # (K,) Width of the carriageway, m
    span_max_height: FloatArray | None = (
        None  # (K,) Height that OSM's ``maxheight`` gives, m; NaN where it gives none
    )
    span_speed: FloatArray | None = None  # (K,) Speed limit of the faster direction, m/s; NaN if unknown
    span_middle: FloatArray | None = None  # (K,) t of the carriageway's middle, m; 0 where not given
    # (M,) Heights that OSM's ``ele`` gives: road, place along it and height, m
    ele_road: IntArray | None = None
    ele_s: FloatArray | None = None
    ele_z: FloatArray | None = None
    rule: Rule = Rule.RIGHT_HAND  # The side that traffic drives on
    span_clearance: FloatArray | None = None  # (K,) Height to roads above or below that is known, m; NaN for none
    known: KnownHeights | None = None  # Heights that the user knows
    road_id: IntArray | None = None  # (R,) Ids of the roads, for reports; their index where not given
    pins: Pins | None = None  # Where profiles have knots, and are held
    connectors: ConnectorProblem | None = None  # Roads through junctions, which keep clear of others as roads do
    carried: BoolArray | None = None  # (J,) Junctions through which crossfall may run on; none where not given
    warped: BoolArray | None = None  # (J,) Junctions whose arms may end on its plane also across; likewise


@record(eq=False)
class ProfileSolution:
    """Heights of roads and junctions."""

    # R curves over the roads' s, m; value and slope are continuous along every road and across every link
    elevation: CubicProfile
    # (J, 3) Height and gradient (x, y) of each junction's plane about its origin, m and rise per metre. Every road
    # that ends at the junction ends on the plane and runs along it there.
    junction_plane: FloatArray
    # (R, 2) Height, m, and grade along +s at each road's start and end
    end_z: FloatArray
    end_grade: FloatArray
    statistics: Mapping[str, float] = field(default_factory=dict)  # Figures about the solution, for reports
    # The same, place by place; None on a level world where no road passes over another
    report: ElevationReport | None = None
    # R curves, rad, with slope 0 at junctions; None where it was not asked for
    superelevation: CubicProfile | None = None
    # (R, 2) Superelevation at each road's start and end, rad; None for 0. At a junction it is the same for all arms,
    # seen along their traffic.
    end_superelevation: FloatArray | None = None


@record(eq=False)
class ConnectorProblem:
    """Connecting roads whose heights are wanted."""

    plan_view: PlanView  # Reference lines of the C connecting roads; they run along the middle of the carriageway
    junction: IntArray  # (C,) Junction that each belongs to
    # (C,) Road end (2 * road + 0 | 1) that each touches with its start and with its end
    start_end: IntArray
    end_end: IntArray
    # (C,) Where the connecting road's reference line touches, t in the touched road's own frame, m
    start_t: FloatArray
    end_t: FloatArray
    half_width: FloatArray  # (C,) Half the width of the carriageway, m
    beside: BoolArray | None = None  # (C,) Those beside the carriageway, which follow its surface
    inside: LevelsInside | None = None  # Where the ways in junctions change their level

    def chosen(self, row: IntArray) -> ConnectorProblem:
        """Return some of them; `row` ascends."""
        return ConnectorProblem(
            chosen_curves(self.plan_view, row),
            self.junction[row],
            self.start_end[row],
            self.end_end[row],
            self.start_t[row],
            self.end_t[row],
            self.half_width[row],
            None if self.beside is None else self.beside[row],
            None if self.inside is None else self.inside.chosen(row),
        )


@record(eq=False)
class LevelsInside:
    """Levels along connecting roads that take the place of ways which change theirs, in order of these and of s."""

    connector: IntArray  # (n,) Number of the connecting road
    s: FloatArray  # (n,) Where it begins along it, m; it holds to the next one
    # (n,) `Structure` values and OSM's ``layer``
    structure: IntArray
    layer: IntArray

    def chosen(self, row: IntArray) -> LevelsInside:
        """Return those of some connecting roads, with their new numbers; `row` ascends."""
        k = np.flatnonzero(np.isin(self.connector, row))
        number = np.searchsorted(row, self.connector[k])
        return LevelsInside(number, self.s[k], self.structure[k], self.layer[k])


def span_at(problem: ProfileProblem, road: IntArray, s: FloatArray) -> IntArray:
    """Return the index of the span that holds at s of roads, both (n,)."""
    return find_record(problem.span_start, problem.span_s, road, s)


def fast_spans(problem: ProfileProblem) -> BoolArray:
    """Return which spans are of classes that are built for speed, (K,)."""
    return np.array([highway in FAST_HIGHWAYS for highway in problem.span_highway], bool)


def one_way_fast_ends(problem: ProfileProblem) -> IntArray:
    """Return 1 for ends, (2 R,), of fast roads whose traffic all runs along +s, -1 where it runs against, 0 else."""
    span = end_spans(problem).ravel()
    if problem.span_oneway is None:
        return np.zeros(len(span), np.int64)
    return np.where(fast_spans(problem)[span], problem.span_oneway[span], 0)


def span_sides(problem: ProfileProblem) -> tuple[FloatArray, FloatArray]:
    """Return half the width of the carriageway and t of its middle on each span, (K,), m."""
    count = len(problem.span_s)
    width = np.full(count, _UNKNOWN_WIDTH) if problem.span_width is None else problem.span_width
    return 0.5 * width, np.zeros(count) if problem.span_middle is None else problem.span_middle


def end_spans(problem: ProfileProblem) -> IntArray:
    """Return the first and last span of each road, (R, 2)."""
    return np.column_stack([problem.span_start[:-1], problem.span_start[1:] - 1])


def span_roads(problem: ProfileProblem) -> IntArray:
    """Return the road of each span, (K,)."""
    counts = np.diff(problem.span_start)
    return np.repeat(np.arange(len(counts), dtype=np.int64), counts)


def connector_spans(problem: ProfileProblem, *, far: bool = False) -> IntArray:
    """Return the span of each connecting road, (C,): the one at its ends that is closer to the ground, or `far`."""
    connectors = problem.connectors
    if connectors is None:
        return np.zeros(0, np.int64)
    spans = end_spans(problem).ravel()
    entry, exit_ = spans[connectors.start_end], spans[connectors.end_end]
    height = 2 * np.abs(problem.span_layer) + (problem.span_structure != Structure.GROUND)
    return np.where((height[exit_] < height[entry]) ^ far, exit_, entry)


def curve_spans(problem: ProfileProblem, curve: IntArray, s: FloatArray, *, far: bool = False) -> IntArray:
    """Return the span that holds at s of curves, both (n,); `far` is that of `connector_spans`."""
    roads = len(problem.end_junction)
    out = np.zeros(len(curve), np.int64)
    plain = curve < roads
    out[plain] = span_at(problem, curve[plain], s[plain])
    out[~plain] = connector_spans(problem, far=far)[curve[~plain] - roads]
    return out


def structures_at(problem: ProfileProblem, curve: IntArray, s: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the structure and the layer that curves have at s, (n,): connecting roads those of the ways there."""
    span = curve_spans(problem, curve, s)
    structure, layer = problem.span_structure[span], problem.span_layer[span]
    inside = None if problem.connectors is None else problem.connectors.inside
    if inside is not None:
        number = curve - len(problem.end_junction)
        known = np.flatnonzero(np.isin(number, inside.connector))
        start = np.searchsorted(inside.connector, np.arange(number.max(initial=-1) + 2))
        at = find_record(start, inside.s, number[known], s[known])
        structure[known], layer[known] = inside.structure[at], inside.layer[at]
    return structure, layer


def level_numbers(structure: IntArray, layer: IntArray) -> IntArray:
    """Return numbers for levels, (n,): by layer, and in one layer bridges above the ground above tunnels."""
    rank = np.zeros(int(Structure.TUNNEL) + 1, np.int64)
    rank[Structure.BRIDGE], rank[Structure.TUNNEL] = 1, -1
    return np.asarray(3 * layer + rank[structure], np.int64)


def levels_at(problem: ProfileProblem, curve: IntArray, s: FloatArray) -> IntArray:
    """Return numbers for the levels that curves are on at s, (n,): the higher number passes over the lower one."""
    return level_numbers(*structures_at(problem, curve, s))


def wanted_clearances(problem: ProfileProblem, upper: IntArray, lower: IntArray) -> tuple[FloatArray, IntArray]:
    """Return the clearance between spans, all (n,), m, and the way whose correction says so, 0 where none does.

    Without a correction it is that of the lower span: by its class, or by the height that a sign allows there. A
    correction of the upper way counts more than one of the lower.
    """
    clearance = _clearances(problem)[lower]
    way = np.zeros(len(clearance), np.int64)
    if problem.span_clearance is None:
        return clearance, way
    for span in (lower, upper):
        known = np.isfinite(problem.span_clearance[span])
        clearance[known], way[known] = problem.span_clearance[span[known]], problem.span_way[span[known]]
    return clearance, way


def _clearances(problem: ProfileProblem) -> FloatArray:
    """Return the clearance above each span, (K,), m: by its class, or by the height that a sign allows there."""
    usual = np.array([CLEARANCE.get(name, CLEARANCE_OTHER) for name in problem.span_highway], np.float64)
    if problem.span_max_height is None:
        return usual
    signed = problem.span_max_height + DECK
    return np.asarray(np.where(np.isfinite(signed), signed, usual), np.float64)


def class_values(problem: ProfileProblem, table: Mapping[str, float], other: float) -> FloatArray:
    """Return a table's value for each span's class, (K,)."""
    return np.array([table.get(highway, other) for highway in problem.span_highway], np.float64)


def at_junctions(chosen: BoolArray | None, junction: IntArray) -> BoolArray:
    """Say which of some places, of any shape, lie at junctions that are chosen, (J,); those at none, -1, do not."""
    return np.zeros(junction.shape, bool) if chosen is None else np.append(chosen, False)[junction]


# ---------------------------------------------------------------- part of a network, as a problem of its own

_SPAN_COLUMNS: Final = tuple(
    name
    for name in (item.name for item in fields(ProfileProblem))
    if name.startswith("span_") and name not in ("span_start", "span_highway")
)


def chosen_junctions(problem: ProfileProblem, chosen: IntArray) -> IntArray:
    """Return the junctions that some of the roads meet at, ascending."""
    junctions = np.unique(problem.end_junction[chosen])
    return np.asarray(junctions[junctions >= 0])


def chosen_roads(problem: ProfileProblem, chosen: IntArray) -> ProfileProblem:
    """Return the problem of some of the roads, as if there were no others; `chosen` (n,) ascends strictly.

    Junctions are those of `chosen_junctions`. Heights that are known in junctions are left out, and so are connecting
    roads that lead to roads which are not there.
    """
    number = np.full(len(problem.end_junction) + 1, -1, np.int64)
    number[chosen] = np.arange(len(chosen))
    spans = np.diff(problem.span_start)[chosen]
    span = runs(problem.span_start[chosen], spans)
    junctions = chosen_junctions(problem, chosen)
    of_junction = np.full(len(problem.junction_xy) + 1, -1, np.int64)
    of_junction[junctions] = np.arange(len(junctions))
    ele = np.flatnonzero(number[problem.ele_road] >= 0) if problem.ele_road is not None else None
    columns: dict[str, Any] = {name: _rows(getattr(problem, name), span) for name in _SPAN_COLUMNS}
    return replace(
        problem,
        plan_view=chosen_curves(problem.plan_view, chosen),
        end_junction=of_junction[problem.end_junction[chosen]],
        end_link=_renumbered(problem.end_link[chosen], number),
        junction_xy=problem.junction_xy[junctions],
        span_start=starts(spans),
        span_highway=tuple(problem.span_highway[k] for k in span.tolist()),
        **columns,
        ele_road=None if ele is None or problem.ele_road is None else number[problem.ele_road[ele]],
        ele_s=_rows(problem.ele_s, ele),
        ele_z=_rows(problem.ele_z, ele),
        known=_known_on(problem.known, number),
        road_id=_rows(problem.road_id, chosen),
        pins=None,
        connectors=_connectors_between(problem.connectors, number, of_junction),
        carried=_rows(problem.carried, junctions),
        warped=_rows(problem.warped, junctions),
    )


def _renumbered(end: IntArray, number: IntArray) -> IntArray:
    """Return road ends with the new numbers of their roads, -1 where there is none or its road is not there."""
    road = np.where(end >= 0, number[end // 2], -1)
    return np.where(road >= 0, 2 * road + end % 2, -1)


def _known_on(known: KnownHeights | None, number: IntArray) -> KnownHeights | None:
    """Return the known heights on the roads that are there."""
    if known is None:
        return None
    of = np.flatnonzero((known.road >= 0) & (number[known.road] >= 0))
    return KnownHeights(
        known.node[of], number[known.road[of]], known.s[of], known.junction[of], known.offset[of], known.z[of]
    )


def _connectors_between(
    connectors: ConnectorProblem | None, number: IntArray, of_junction: IntArray
) -> ConnectorProblem | None:
    """Return the connecting roads between roads that are there."""
    if connectors is None:
        return None
    ends = _renumbered(np.column_stack([connectors.start_end, connectors.end_end]), number)
    row = np.flatnonzero((ends >= 0).all(axis=1))
    out = connectors.chosen(row)
    return replace(out, junction=of_junction[out.junction], start_end=ends[row, 0], end_end=ends[row, 1])


def _rows(column: _Column | None, rows: IntArray | None) -> _Column | None:
    """Return some rows of a column, None if it is missing."""
    return None if column is None or rows is None else column[rows]
