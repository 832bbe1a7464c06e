"""The document as a whole: header, roads, junctions, as bytes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.conventions import Target
from osm2xodr.curves import advance
from osm2xodr.defaults import NEGATED_LANES
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import FloatArray, IntArray, PlanView, RoadMap, Rule
from osm2xodr.system import ByteSink, map_parallel
from osm2xodr.xodrWriter.check import check_road_map
from osm2xodr.xodrWriter.even_steps import plan_of_even_steps
from osm2xodr.xodrWriter.flat_curves import without_flat_curves
from osm2xodr.xodrWriter.formatting import attribute, number, user_data
from osm2xodr.xodrWriter.furniture_text import FurnitureWriter, controllers_text, junction_controllers
from osm2xodr.xodrWriter.options import WriteOptions
from osm2xodr.xodrWriter.road_text import RoadTables, RoadWriter, junction_text
from osm2xodr.xodrWriter.shared_exits import with_exits_for_all
from osm2xodr.xodrWriter.tables import cubic_texts, plan_view_texts
from osm2xodr.xodrWriter.words import Words

# Roads and junctions per block of text, 1 to 2 MB: processes that make them in turns take about equally long, and
# hold little at a time. The least number of blocks that is worth another process.
_ROADS_PER_BLOCK: Final = 1000
_JUNCTIONS_PER_BLOCK: Final = 4000
_BLOCKS_PER_PROCESS: Final = 5

_ATTRIBUTION: Final = "© OpenStreetMap contributors, Open Database License 1.0 (ODbL)"
# Headings at which an arc reaches farthest.
_CARDINAL: Final = (0.0, np.pi / 2.0, np.pi, -np.pi / 2.0)
_LICENSE: Final = '<license name="Open Data Commons Open Database License v1.0" spdxid="ODbL-1.0"/>\n'


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
        said = f"traffic drives on the left, so lane ids are negated: only --target {target.name} reads them right"
        diagnostics.note("left-hand-negated", "", said)
    for word, other in sorted(words.replaced):
        if (word, other) in target.lane_types:
            wanted = f"{word!r} is written as {other!r}, as --target {target.name} wants"
            diagnostics.note("word-for-reader", "", wanted)
        else:
            diagnostics.note("word-lost", "", f"{version} has no {word!r}: written as {other!r}")
