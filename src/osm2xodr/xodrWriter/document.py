"""The document as a whole: header, roads, junctions, as bytes.

Formatting a thousand records of plan views and profiles with one ``%`` is several times faster than one element at a
time in any XML library.

For readers that make polylines of reference lines these are cut. The points of polylines lie at equal steps from the
start of each record, and where lane sections and lane offsets begin. The rest behind the last step, or before such a
place, may be a few centimetres long. Where a polyline is moved aside, as to a lane, so short a piece turns by
degrees, or folds back on itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.conventions import Target
from osm2xodr.curves import advance, cut_records, end_curvature, find_record, owners, starts
from osm2xodr.defaults import NEGATED_LANES
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import BoolArray, CubicProfile, FloatArray, IntArray, PlanView, RoadMap, Rule
from osm2xodr.system import ByteSink, map_parallel
from osm2xodr.xodrWriter.formatting import (
    CURVATURE,
    NUMBER,
    POSITION_DECIMALS,
    Words,
    attribute,
    digits_before_point,
    number,
    rounded,
    user_data,
)
from osm2xodr.xodrWriter.furniture_text import FurnitureWriter, controllers_text, junction_controllers
from osm2xodr.xodrWriter.options import WriteOptions
from osm2xodr.xodrWriter.preparation import check_road_map, with_exits_for_all, without_flat_curves
from osm2xodr.xodrWriter.road_text import RoadTables, RoadWriter, junction_text

# Roads and junctions per block of text, 1 to 2 MB: processes that make them in turns take about equally long, and
# hold little at a time. The least number of blocks that is worth another process.
_ROADS_PER_BLOCK: Final = 1000
_JUNCTIONS_PER_BLOCK: Final = 4000
_BLOCKS_PER_PROCESS: Final = 5

_ATTRIBUTION: Final = "© OpenStreetMap contributors, Open Database License 1.0 (ODbL)"
# Headings at which an arc reaches farthest.
_CARDINAL: Final = (0.0, np.pi / 2.0, np.pi, -np.pi / 2.0)
_LICENSE: Final = '<license name="Open Data Commons Open Database License v1.0" spdxid="ODbL-1.0"/>\n'
_GEOMETRY: Final = f'<geometry s="{NUMBER}" x="{NUMBER}" y="{NUMBER}" hdg="{NUMBER}" length="{NUMBER}">'
_ARC: Final = f'{_GEOMETRY}<arc curvature="{CURVATURE}"/></geometry>\n'
_SPIRAL: Final = f'{_GEOMETRY}<spiral curvStart="{CURVATURE}" curvEnd="{CURVATURE}"/></geometry>\n'
_LINE: Final = f"{_GEOMETRY}<line/></geometry>\n"
_CUBIC: Final = f'<%s s="{NUMBER}" a="{NUMBER}" b="{NUMBER}" c="{NUMBER}" d="{NUMBER}"/>\n'
# Separates the texts of curves while they are made together; not allowed in XML, so in none of them.
_BETWEEN: Final = "\0"

# Decimals of what headings and the terms of a cubic come to at the end of their record (10 nm): readers compute
# positions from them to well below a micrometre, and no digit is superfluous.
_END_DECIMALS: Final = 8
# Shorter rests, as a share of the step, are made equal to the step before them; records are cut no nearer than that
# to their ends. A choice.
_SHORT_REST: Final = 0.25
# Share of a step that counts as a rounding error.
_ROUNDING: Final = 1e-9


def write_document(
    road_map: RoadMap, stream: ByteSink, options: WriteOptions, diagnostics: Diagnostics, jobs: int = 1
) -> None:
    """Write an OpenDRIVE document to a binary stream; see `osm2xodr.xodrWriter.write_xodr`."""
    lengths = check_road_map(road_map)
    target, words = options.target, words_for(road_map, options)
    road_map = replace(with_exits_for_all(road_map, words), plan_view=without_flat_curves(road_map.plan_view))
    if target.polyline_step:
        road_map = replace(road_map, plan_view=plan_of_even_steps(road_map, target.polyline_step))
    how = {
        "as_met": target.priority_signs,
        "object_ids": target.object_ids,
        "one_validity": target.one_validity,
    }
    furniture = FurnitureWriter(road_map, options.dialect, words, target.crosswalks, **how)
    left_hand = options.dialect.has_rule and road_map.rule is Rule.LEFT_HAND
    writer = RoadWriter(words, furniture, left_hand=left_hand, marks_in_junctions=target.marks_in_junctions)
    stream.write(_header(road_map, options).encode())
    _write_blocks(road_map, stream, _RoadBlocks(road_map, lengths, writer), words, jobs)
    stream.write(b"</OpenDRIVE>\n")
    _note_what_is_lost(road_map, options, words, diagnostics)


def words_for(road_map: RoadMap, options: WriteOptions) -> Words:
    """Return what translates the words of a road map."""
    target = options.target
    return Words(
        options.dialect,
        target.lane_types,
        changes_as_driven=target.changes_as_driven,
        negated=is_negated(road_map, target),
    )


def is_negated(road_map: RoadMap, target: Target) -> bool:
    """Say whether lane ids are written with the opposite sign."""
    return road_map.rule is Rule.LEFT_HAND and target.negated_left_hand


def _header(road_map: RoadMap, options: WriteOptions) -> str:
    """Return everything before the first road."""
    dialect = options.dialect
    west, south, east, north = plan_view_bounds(road_map.plan_view)
    date = f' date="{attribute(options.date)}"' if options.date else ""
    # One line, and nothing before or after the text: readers split it at blanks.
    reference = f"<geoReference><![CDATA[{road_map.frame.proj}]]></geoReference>\n"
    license_ = _LICENSE if options.osm_data and dialect.has_license else ""
    origin = f'<userData code="osm2xodr" value="{attribute(options.tool_version)}"/>\n'
    origin += user_data("attribution", _ATTRIBUTION if options.osm_data else "")
    origin += user_data("attribution_elevation", "; ".join(options.elevation_credits))
    if is_negated(road_map, options.target):
        origin += user_data(*NEGATED_LANES)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        "<OpenDRIVE>\n"
        f'<header revMajor="1" revMinor="{dialect.rev_minor}" name="{attribute(options.name)}" version="1.00"{date}'
        f' north="{number(north)}" south="{number(south)}" east="{number(east)}" west="{number(west)}"'
        ' vendor="osm2xodr">\n'
        f"{reference}{license_}{origin}</header>\n"
    )


def plan_view_bounds(plan: PlanView) -> tuple[float, float, float, float]:
    """Return west, south, east, north of all reference lines (at least one record), m.

    Where an arc runs parallel to an axis it may reach farther than its ends, so the points at which its heading is a
    multiple of 90 degrees count as well.
    """
    x, y = _points_on(plan, slice(None), plan.length)
    xs, ys = [plan.x, x], [plan.y, y]
    bent = np.flatnonzero((plan.curvature != 0.0) | (plan.rate != 0.0))
    for heading in _CARDINAL:
        for records, ds in _turns_to(plan, bent, heading):
            x, y = _points_on(plan, records, ds)
            xs.append(x)
            ys.append(y)
    all_x, all_y = np.concatenate(xs), np.concatenate(ys)
    return float(all_x.min()), float(all_y.min()), float(all_x.max()), float(all_y.max())


def _points_on(plan: PlanView, records: IntArray | slice, ds: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return local x, y at ds (n,) from the start of n records."""
    start = plan.x[records], plan.y[records], plan.hdg[records], plan.curvature[records]
    return advance(*start, ds, plan.rate[records])[:2]


def _turns_to(plan: PlanView, records: IntArray, heading: float) -> Iterator[tuple[IntArray, FloatArray]]:
    """Yield records that somewhere have a heading, and how far along each that is, (n,), m.

    Of the two roots of ahead = curvature · ds + rate / 2 · ds², spirals that turn back have both.
    """
    first, rate, length = plan.curvature[records], plan.rate[records], plan.length[records]
    for sense in (1.0, -1.0):
        ahead = sense * np.mod(sense * (heading - plan.hdg[records]), 2.0 * np.pi)
        square = first * first + 2.0 * rate * ahead
        root = np.where(rate == 0.0, np.abs(first), np.sqrt(np.maximum(square, 0.0)))
        for sign in (1.0, -1.0):
            # The form that does not cancel, and holds for arcs.
            below = 0.5 * (first + sign * root)
            on = (square >= 0.0) & (ahead * np.sign(below) >= 0.0) & (np.abs(ahead) <= np.abs(below) * length)
            on &= below != 0.0
            yield records[on], ahead[on] / below[on]


class _RoadBlocks:
    """Make the text of a block of roads, in this process or a copy of it."""

    def __init__(self, road_map: RoadMap, lengths: FloatArray, writer: RoadWriter) -> None:
        self._map = road_map
        self._lengths = lengths
        self._writer = writer

    def __call__(self, first: int) -> str:
        """Return the text from road `first` on."""
        road_map, lengths = self._map, self._lengths
        last = min(first + _ROADS_PER_BLOCK, len(road_map.roads))
        tables = map(
            RoadTables,
            lengths[first:last].tolist(),
            plan_view_texts(road_map.plan_view, first, last),
            cubic_texts(road_map.elevation, lengths, "elevation", first, last),
            cubic_texts(road_map.superelevation, lengths, "superelevation", first, last),
            cubic_texts(road_map.lane_offset, lengths, "laneOffset", first, last),
            _unmeasured_texts(road_map, first, last),
        )
        roads = road_map.roads[first:last]
        return "".join([self._writer.road(road, table) for road, table in zip(roads, tables, strict=True)])


def _write_blocks(road_map: RoadMap, stream: ByteSink, roads: _RoadBlocks, words: Words, jobs: int) -> None:
    """Write all roads, controllers and junctions, in blocks, so that only the text of some is held at a time."""
    controllers = road_map.furniture.controllers
    junctions = partial(_junctions, road_map, words, junction_controllers(controllers))
    blocks = [
        *(partial(roads, first) for first in range(0, len(road_map.roads), _ROADS_PER_BLOCK)),
        partial(controllers_text, controllers),
        *(partial(junctions, first) for first in range(0, len(road_map.junctions), _JUNCTIONS_PER_BLOCK)),
    ]

    def made(block: Callable[[], str]) -> tuple[bytes, frozenset[tuple[str, str]]]:
        """Return the text of a block, and the words that have been replaced so far: copies keep their own record."""
        return block().encode(), frozenset(words.replaced)

    # Less work is done sooner than the process is copied.
    for text, replaced in map_parallel(made, blocks, min(jobs, len(blocks) // _BLOCKS_PER_PROCESS)):
        stream.write(text)
        words.replaced |= replaced


def _junctions(road_map: RoadMap, words: Words, controllers: Mapping[int, str], first: int) -> str:
    """Return the text of a block of junctions; `controllers` is what is within them."""
    block = road_map.junctions[first : first + _JUNCTIONS_PER_BLOCK]
    return "".join([junction_text(item, words, controllers.get(item.id, "")) for item in block])


def _unmeasured_texts(road_map: RoadMap, first: int, last: int) -> list[str]:
    """Return begin and end of the stretches without a measured height, one text per road, m."""
    found = road_map.unmeasured
    if found is None or not len(found.begin):
        return [""] * (last - first)
    places = np.stack([found.begin, found.end], axis=1)
    start = found.start[first : last + 1].tolist()
    return [" ".join(map(number, places[a:b].ravel().tolist())) for a, b in pairwise(start)]


def _note_what_is_lost(road_map: RoadMap, options: WriteOptions, words: Words, diagnostics: Diagnostics) -> None:
    """Note what the chosen version cannot express."""
    version, target = f"OpenDRIVE {options.version}", options.target
    if road_map.rule is Rule.LEFT_HAND and not options.dialect.has_rule:
        lost = "cannot say that traffic drives on the left: readers will take it to drive on the right"
        diagnostics.note("left-hand-lost", "", f"{version} {lost}; write 1.6 or later")
    if is_negated(road_map, target):
        message = f"traffic drives on the left, so lane ids are negated: only --target {target.name} reads them right"
        diagnostics.note("left-hand-negated", "", message)
    for word, other in sorted(words.replaced):
        if (word, other) in target.lane_types:
            wanted = f"{word!r} is written as {other!r}, as --target {target.name} wants"
            diagnostics.note("word-for-reader", "", wanted)
        else:
            diagnostics.note("word-lost", "", f"{version} has no {word!r}: written as {other!r}")


def plan_view_texts(plan: PlanView, first: int, last: int) -> list[str]:
    """Return the ``<geometry>`` elements of the curves from `first` up to `last`, one text per curve.

    Every curve has records.
    """
    start = plan.start[first : last + 1]
    records = slice(int(start[0]), int(start[-1]))
    curvature, end, bends = plan.curvature[records], end_curvature(plan, records), plan.rate[records] != 0.0
    s, x, y, length = (rounded(item[records], POSITION_DECIMALS) for item in (plan.s, plan.x, plan.y, plan.length))
    hdg = rounded(plan.hdg[records], _END_DECIMALS + digits_before_point(length))
    shape = np.where(bends, 2, curvature != 0.0).astype(np.int64)
    patterns = [(_LINE, _ARC, _SPIRAL)[k] for k in shape.tolist()]
    for record in (start[1:-1] - start[0]).tolist():
        patterns[record] = _BETWEEN + patterns[record]
    table = np.column_stack([s, x, y, hdg, length, curvature, end])
    written = np.ones(table.shape, np.bool_)
    written[:, -2], written[:, -1] = shape > 0, bends
    return _per_curve("".join(patterns) % tuple(table[written].tolist()), last - first)


def cubic_texts(profile: CubicProfile, lengths: FloatArray, element: str, first: int, last: int) -> list[str]:
    """Return the records of the curves from `first` up to `last` as `element`, one text per curve.

    It is empty for curves that are 0 everywhere or have no records. `lengths` (curves,), m, are those of all curves:
    where last records end.
    """
    start = profile.start[first : last + 1] - profile.start[first]
    table = np.column_stack(_cubic_columns(profile, lengths, first, last))
    before = starts(table[:, 1:].any(axis=1))
    written = np.diff(before[start]) > 0
    counts = np.diff(start)
    values = table[np.repeat(written, counts)].ravel()
    pattern = _CUBIC.replace("%s", element)
    patterns = [pattern * count if count else "" for count in np.where(written, counts, 0).tolist()]
    return _per_curve(_BETWEEN.join(patterns) % tuple(values.tolist()), last - first)


def _cubic_columns(profile: CubicProfile, lengths: FloatArray, first: int, last: int) -> list[FloatArray]:
    """Return s, a, b, c, d with as many decimals as they need: the longer a record, the more for its higher terms."""
    start = profile.start[first : last + 1]
    records = slice(int(start[0]), int(start[-1]))
    s = profile.s[records]
    end = np.append(s[1:], 0.0)
    filled = np.diff(start) > 0
    end[start[1:][filled] - 1 - records.start] = lengths[first:last][filled]
    digits = digits_before_point(end - s)
    coefficients = (profile.a, profile.b, profile.c, profile.d)
    return [
        rounded(s, POSITION_DECIMALS),
        rounded(profile.a[records], POSITION_DECIMALS),
        *(rounded(coefficients[k][records], _END_DECIMALS + k * digits) for k in (1, 2, 3)),
    ]


def _per_curve(text: str, count: int) -> list[str]:
    """Cut the text of several curves."""
    return text.split(_BETWEEN) if count else []


def plan_of_even_steps(road_map: RoadMap, step: float) -> PlanView:
    """Cut the reference lines of roads outside junctions so that their polylines have no short pieces.

    `step` is the distance between points of the polylines, m.
    """
    plain = np.array([road.junction is None for road in road_map.roads], bool)
    sections = [(k, section.s) for k, road in enumerate(road_map.roads) for section in road.lane_sections[1:]]
    curve, s = np.array(sections, float).reshape(-1, 2).T
    offset = road_map.lane_offset
    curve, s = np.concatenate([curve.astype(np.int64), owners(offset.start)]), np.concatenate([s, offset.s])
    chosen = plain[curve]
    plan = cut_at(road_map.plan_view, curve[chosen], s[chosen], _SHORT_REST * step)
    return with_even_ends(plan, plain, step)


def cut_at(plan: PlanView, curve: IntArray, s: FloatArray, least: float) -> PlanView:
    """Cut arcs and spirals at places (n,), m, none nearer than `least` to a record's ends or the place before it."""
    row = find_record(plan.start, plan.s, curve, s)
    ds = s - plan.s[row]
    bent = (plan.curvature[row] != 0.0) | (plan.rate[row] != 0.0)
    inside = bent & (ds >= least) & (plan.length[row] - ds >= least)
    order = np.lexsort((ds[inside], row[inside]))
    row, ds = row[inside][order], ds[inside][order]
    apart = np.ones(len(row), bool)
    apart[1:] = (row[1:] != row[:-1]) | (ds[1:] - ds[:-1] >= least)
    return cut_records(plan, row[apart], ds[apart])


def with_even_ends(plan: PlanView, curves: BoolArray, step: float) -> PlanView:
    """Cut records of some curves, (curves,), so that the last two pieces of their polylines are equally long.

    `step` is the distance between their points, m.
    """
    count = np.ceil(plan.length / step - _ROUNDING)
    rest = plan.length - step * (count - 1.0)
    short = np.flatnonzero(curves[owners(plan.start)] & (count > 1) & (rest < _SHORT_REST * step))
    half, end = 0.5 * (step + rest[short]), plan.length[short]
    long = count[short] > 2
    row = np.concatenate([short[long], short])
    return cut_records(plan, row, np.concatenate([end[long] - 2.0 * half[long], end - half]))
