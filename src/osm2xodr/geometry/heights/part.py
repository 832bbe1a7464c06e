"""Part of a network's roads, as a problem of its own."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, Final, TypeVar

import numpy as np

from osm2xodr.curves import chosen_curves, runs
from osm2xodr.geometry.heights.problem import ConnectorProblem, KnownHeights, ProfileProblem
from osm2xodr.model import BoolArray, FloatArray, IntArray

_Column = TypeVar("_Column", FloatArray, IntArray, BoolArray)
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
        span_start=np.concatenate([[0], np.cumsum(spans)]).astype(np.int64),
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
