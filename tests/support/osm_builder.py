"""Small OSM files for tests."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.sax.saxutils import quoteattr

from osm2xodr.diagnostics import Diagnostic, Diagnostics
from osm2xodr.model import StreetNetwork
from osm2xodr.osmParsing import ParseOptions, parse_osm

# Degrees per metre at 50 degrees north, where the areas lie (in Germany) unless they say otherwise.
LAT_0, LON_0 = 50.0, 10.0
LAT_PER_METRE = 1.0 / 111_229.0
LON_PER_METRE = 1.0 / 71_696.0

ROAD = "highway=unclassified lanes=2 width=6"
ONEWAY = "highway=residential oneway=yes lanes=1 width=3"
# Nodes 1 to 9 in a row from west to east, every 100 m, and nodes 11 to 19 100 m north of them.
ROW = {k: (100.0 * k, 0.0) for k in range(1, 10)} | {10 + k: (100.0 * k, 100.0) for k in range(1, 10)}


def tags_of(text: str) -> dict[str, str]:
    """Read ``key=value key=value``."""
    return dict(item.split("=", 1) for item in text.split())


@dataclass
class Area:
    """An area: nodes as x, y (m), ways as (node ids, tags), relations as (members, tags)."""

    nodes: Mapping[int, tuple[float, float]]
    ways: Mapping[int, tuple[Sequence[int], str]] = field(default_factory=dict)
    relations: Mapping[int, tuple[Iterable[tuple[str, int, str]], str]] = field(default_factory=dict)
    node_tags: Mapping[int, str] = field(default_factory=dict)
    lat_0: float = LAT_0
    lon_0: float = LON_0

    def elements(self) -> list[str]:
        """Return the area's elements, one string each."""
        out = []
        for number, (x, y) in self.nodes.items():
            lat, lon = self.lat_0 + y * LAT_PER_METRE, self.lon_0 + x * LON_PER_METRE
            lon = (lon + 180.0) % 360.0 - 180.0
            out.append(
                f'<node id="{number}" lat="{lat:.9f}" lon="{lon:.9f}">{_tags(self.node_tags.get(number, ""))}</node>'
            )
        for number, (refs, tags) in self.ways.items():
            nodes = "".join(f'<nd ref="{ref}"/>' for ref in refs)
            out.append(f'<way id="{number}">{nodes}{_tags(tags)}</way>')
        for number, (members, tags) in self.relations.items():
            text = "".join(f'<member type="{kind}" ref="{ref}" role="{role}"/>' for kind, ref, role in members)
            out.append(f'<relation id="{number}">{text}{_tags(tags)}</relation>')
        return out

    def write(self, folder: Path, name: str = "area.osm") -> Path:
        """Write the area as OSM XML."""
        return write_osm(folder, self.elements(), name)

    def parse(self, folder: Path, options: ParseOptions | None = None) -> tuple[StreetNetwork, Diagnostics]:
        """Write the area and read it; by default, limits and sidewalks are not guessed."""
        diagnostics = Diagnostics()
        plain = ParseOptions(default_speeds=False, guessed_sidewalks=False, guessed_shoulders=False)
        network = parse_osm(self.write(folder), options or plain, diagnostics)
        return network, diagnostics


def write_osm(folder: Path, elements: Iterable[str], name: str = "area.osm") -> Path:
    """Write elements as OSM XML."""
    path = folder / name
    path.write_text(document(elements), encoding="utf-8")
    return path


def document(elements: Iterable[str]) -> str:
    """Return OSM XML."""
    return '<?xml version="1.0" encoding="UTF-8"?>\n<osm version="0.6">\n' + "\n".join(elements) + "\n</osm>\n"


def about(diagnostics: Diagnostics, code: str) -> list[Diagnostic]:
    """Return the diagnostics with a code."""
    return [item for item in diagnostics if item.code == code]


def ways_of(network: StreetNetwork) -> list[list[tuple[int, bool]]]:
    """Return the ways of each street, each with whether the street runs against it."""
    return [[(piece.osm_way_id, piece.reversed) for _, piece in street.pieces] for street in network.streets]


def ends_of(network: StreetNetwork) -> list[tuple[int, int]]:
    """Return the OSM ids of the nodes at the ends of each street; -1 for rings."""
    ids = {item.id: item.osm_node_id for item in network.intersections} | {-1: -1}
    return [(ids[street.start], ids[street.end]) for street in network.streets]


def nodes_of(network: StreetNetwork) -> list[list[int]]:
    """Return the nodes of each street."""
    return [street.node_ids.tolist() for street in network.streets]


def _tags(text: str) -> str:
    pairs = tags_of(text).items()
    return "".join(f"<tag k={quoteattr(key)} v={quoteattr(value)}/>" for key, value in pairs)
