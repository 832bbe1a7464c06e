"""The document as a whole: header, roads, junctions, as bytes."""

from __future__ import annotations

from typing import Final

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import CubicProfile, FloatArray, RoadMap, Rule
from osm2xodr.system import ByteSink, map_parallel
from osm2xodr.xodrWriter.bounds import plan_view_bounds
from osm2xodr.xodrWriter.check import check_road_map
from osm2xodr.xodrWriter.crosswalk_offsets import crosswalk_offsets
from osm2xodr.xodrWriter.elements import RoadTables, RoadWriter, junction_text
from osm2xodr.xodrWriter.formatting import attribute, number
from osm2xodr.xodrWriter.furniture_text import FurnitureWriter, controllers_text, junction_controllers
from osm2xodr.xodrWriter.options import WriteOptions
from osm2xodr.xodrWriter.tables import cubic_texts, plan_view_texts, says_nothing
from osm2xodr.xodrWriter.words import Words

# Roads (or junctions) whose text is made at a time, 1 to 3 MB, and how many times each process does it before what it
# made is written: enough to be worth the copy of the process, and few enough to hold in memory.
_BLOCK: Final = 1000
_BLOCKS_EACH: Final = 5

_ATTRIBUTION: Final = "© OpenStreetMap contributors, Open Database License 1.0 (ODbL)"
_LICENSE: Final = '  <license name="Open Data Commons Open Database License v1.0" spdxid="ODbL-1.0"/>\n'


def write_document(
    road_map: RoadMap, stream: ByteSink, options: WriteOptions, diagnostics: Diagnostics, jobs: int = 1
) -> None:
    """Write an OpenDRIVE document to a binary stream; see `osm2xodr.xodrWriter.write_xodr`."""
    lengths = check_road_map(road_map)
    target = options.target
    words = Words(options.dialect, target.lane_types, changes_as_driven=target.changes_as_driven)
    rule = road_map.rule.value if options.dialect.has_rule else None
    furniture = FurnitureWriter(
        road_map.furniture, options.dialect, words, target.crosswalks, crosswalk_offsets(road_map)
    )
    writer = RoadWriter(rule, words, furniture)
    stream.write(_header(road_map, options).encode())
    _write_roads(road_map, stream, _RoadBlocks(road_map, lengths, writer, words), words, jobs)
    _write_junctions(road_map, stream)
    stream.write(b"</OpenDRIVE>\n")
    _note_what_is_lost(road_map, options, words, diagnostics)


def _header(road_map: RoadMap, options: WriteOptions) -> str:
    """Everything before the first road."""
    dialect = options.dialect
    west, south, east, north = plan_view_bounds(road_map.plan_view)
    date = f' date="{attribute(options.date)}"' if options.date else ""
    # One line, and nothing before or after the text: readers split it at blanks.
    reference = f"  <geoReference><![CDATA[{road_map.frame.proj}]]></geoReference>\n"
    license_ = _LICENSE if options.osm_data and dialect.has_license else ""
    user_data = f'  <userData code="osm2xodr" value="{attribute(options.tool_version)}"/>\n'
    if options.osm_data:
        user_data += f'  <userData code="attribution" value="{_ATTRIBUTION}"/>\n'
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        "<OpenDRIVE>\n"
        f' <header revMajor="1" revMinor="{dialect.rev_minor}" name="{attribute(options.name)}" version="1.00"{date}'
        f' north="{number(north)}" south="{number(south)}" east="{number(east)}" west="{number(west)}"'
        ' vendor="osm2xodr">\n'
        f"{reference}{license_}{user_data}"
        " </header>\n"
    )


class _RoadBlocks:
    """Makes the text of a block of roads, in this process or a copy of it."""

    def __init__(self, road_map: RoadMap, lengths: FloatArray, writer: RoadWriter, words: Words) -> None:
        self._map = road_map
        self._lengths = lengths
        self._words = words
        self._writer = writer

    def __call__(self, first: int) -> tuple[bytes, frozenset[tuple[str, str]]]:
        """Return the text from road `first` on, and the words that have been replaced so far."""
        road_map, lengths = self._map, self._lengths
        last = min(first + _BLOCK, len(road_map.roads))
        tables = map(
            RoadTables,
            lengths[first:last].tolist(),
            plan_view_texts(road_map.plan_view, first, last),
            cubic_texts(road_map.elevation, lengths, "elevation", first, last),
            _where_it_matters(road_map.superelevation, lengths, "superelevation", first, last),
            _where_it_matters(road_map.lane_offset, lengths, "laneOffset", first, last),
        )
        roads = road_map.roads[first:last]
        texts = [self._writer.road(road, table) for road, table in zip(roads, tables, strict=True)]
        return "".join(texts).encode(), frozenset(self._words.replaced)


def _write_roads(road_map: RoadMap, stream: ByteSink, blocks: _RoadBlocks, words: Words, jobs: int) -> None:
    """Write all roads, in rounds, so that the text of few of them is held at a time."""
    firsts = range(0, len(road_map.roads), _BLOCK)
    # Less than two rounds' work is done sooner than the process is copied.
    jobs = min(jobs, len(firsts) // _BLOCKS_EACH)
    each = jobs * _BLOCKS_EACH if jobs > 1 else 1
    for at in range(0, len(firsts), each):
        for text, replaced in map_parallel(blocks, firsts[at : at + each], jobs):
            stream.write(text)
            # What a copy of the process found out is unknown here.
            words.replaced |= replaced


def _write_junctions(road_map: RoadMap, stream: ByteSink) -> None:
    """Write the controllers and the junctions."""
    controllers = road_map.furniture.controllers
    stream.write(controllers_text(controllers).encode())
    inner = junction_controllers(controllers)
    for first in range(0, len(road_map.junctions), _BLOCK):
        block = road_map.junctions[first : first + _BLOCK]
        stream.write("".join([junction_text(item, inner.get(item.id, "")) for item in block]).encode())


def _where_it_matters(profile: CubicProfile, lengths: FloatArray, element: str, first: int, last: int) -> list[str]:
    """Make the records of profiles that are 0 where there are none, and leave out those that are 0 throughout."""
    texts = cubic_texts(profile, lengths, element, first, last)
    return [
        "" if zero else text for text, zero in zip(texts, says_nothing(profile, lengths, first, last), strict=True)
    ]


def _note_what_is_lost(road_map: RoadMap, options: WriteOptions, words: Words, diagnostics: Diagnostics) -> None:
    """Say what the chosen version cannot express."""
    if road_map.rule is Rule.LEFT_HAND and not options.dialect.has_rule:
        diagnostics.note(
            "left-hand-lost",
            "",
            f"OpenDRIVE {options.version} cannot say that traffic drives on the left: readers will take it to drive"
            " on the right; write 1.6 or later",
        )
    for word, other in sorted(words.replaced):
        if (word, other) in options.target.lane_types:
            target = options.target.name
            diagnostics.note("word-for-reader", "", f"{word!r} is written as {other!r}, as --target {target} wants")
            continue
        diagnostics.note("word-lost", "", f"OpenDRIVE {options.version} has no {word!r}: written as {other!r}")
