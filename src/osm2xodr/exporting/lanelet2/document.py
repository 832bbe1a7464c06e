"""Primitives as OSM XML."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, islice
from typing import Final
from xml.sax.saxutils import quoteattr

from osm2xodr.exporting.lanelet2.primitives import Primitives
from osm2xodr.exporting.lanelet2.projector import Places, grid_references
from osm2xodr.exporting.lanelet2.words import Tags
from osm2xodr.system import ByteSink

# Lines of text that are written at a time.
_BLOCK: Final = 10_000


def write_document(primitives: Primitives, places: Places, credit: str, version: str, stream: ByteSink) -> None:
    """Write OSM XML; ids count from 1 over nodes, ways and relations, for Lanelet2 has one space of ids for all."""
    source = f" attribution={quoteattr(credit)}" if credit else ""
    head = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<osm version="0.6" generator="osm2xodr {version}"{source}>',
        ' <MetaInfo format_version="1" map_version="1"/>',
    ]
    lines = chain(head, _nodes(places), _ways(primitives, len(places.lat)), _relations(primitives, len(places.lat)))
    while block := list(islice(lines, _BLOCK)):
        stream.write(("\n".join(block) + "\n").encode())
    stream.write(b"</osm>\n")


def _nodes(places: Places) -> Iterator[str]:
    """Yield nodes, to 0.1 mm."""
    columns = (places.lat, places.lon, places.height, places.local_x, places.local_y)
    # A negative zero has another text.
    rows = zip(*((column + 0.0).tolist() for column in columns), strict=True)
    codes = grid_references(places) if places.square else None
    for k, (lat, lon, height, x, y) in enumerate(rows):
        code = f'<tag k="mgrs_code" v="{codes[k]}"/>' if codes else ""
        yield (
            f' <node id="{k + 1}" version="1" lat="{lat:.9f}" lon="{lon:.9f}"><tag k="ele" v="{height:.4f}"/>'
            f'<tag k="local_x" v="{x:.4f}"/><tag k="local_y" v="{y:.4f}"/>{code}</node>'
        )


def _ways(primitives: Primitives, nodes: int) -> Iterator[str]:
    """Yield ways after a number of nodes."""
    for k, line in enumerate(primitives.lines):
        members = "".join(f'<nd ref="{node + 1}"/>' for node in line.nodes)
        yield f' <way id="{nodes + k + 1}" version="1">{members}{_tags(line.tags)}</way>'


def _relations(primitives: Primitives, nodes: int) -> Iterator[str]:
    """Yield lanelets and regulatory elements after the ways."""
    first = nodes + len(primitives.lines) + 1
    rules = first + len(primitives.lanelets)
    for k, lanelet in enumerate(primitives.lanelets):
        members = [("way", nodes + lanelet.left + 1, "left"), ("way", nodes + lanelet.right + 1, "right")]
        members += [("relation", rules + rule, "regulatory_element") for rule in lanelet.rules]
        yield _relation(first + k, members, lanelet.tags)
    for k, rule in enumerate(primitives.rules):
        found = [
            ("way", nodes + number + 1, role) if kind == "way" else ("relation", first + number, role)
            for role, kind, number in rule.members
        ]
        yield _relation(rules + k, found, rule.tags)


def _relation(number: int, members: list[tuple[str, int, str]], tags: Tags) -> str:
    text = "".join(f'<member type="{kind}" ref="{ref}" role="{role}"/>' for kind, ref, role in members)
    return f' <relation id="{number}" version="1">{text}{_tags(tags)}</relation>'


def _tags(tags: Tags) -> str:
    return "".join(f"<tag k={quoteattr(key)} v={quoteattr(value)}/>" for key, value in tags.items())
