"""Small networks converted with corrections."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import RoadOptions, build_roads
from osm2xodr.model import Corrections, NodeCorrection, RoadMap, Rule, Surface, WayCorrection
from osm2xodr.osmParsing import ParseOptions, parse_osm
from osm2xodr.surface import FlatSurface


def node_of(case: Case, name: str) -> int:
    """Return the OSM id of a node of a case."""
    return 1001 + list(case.nodes).index(name)


def build_corrected(
    case: Case,
    ways: dict[int, WayCorrection] | None = None,
    nodes: dict[str, NodeCorrection] | None = None,
    *,
    surface: Surface | None = None,
    u_turns: str = "law",
) -> tuple[RoadMap, Diagnostics]:
    """Convert a case with corrections, those of nodes by name; on flat ground unless a surface is given."""
    diagnostics = Diagnostics()
    known = Corrections(ways or {}, {node_of(case, name): item for name, item in (nodes or {}).items()})
    with TemporaryDirectory() as folder:
        path = Path(folder) / "case.osm"
        path.write_text(case.osm(), encoding="utf-8")
        network = parse_osm(path, ParseOptions(rule=Rule.RIGHT_HAND, corrections=known), diagnostics)
    options = RoadOptions(u_turns=u_turns)
    return build_roads(network, surface or FlatSurface(), diagnostics, road_options=options), diagnostics


def said(diagnostics: Diagnostics) -> dict[tuple[str, str], tuple[bool, str]]:
    """Return what is said of each correction, by element and key: whether it is applied, and the words."""
    found: dict[tuple[str, str], tuple[bool, str]] = {}
    for item in diagnostics:
        if item.code in ("correction", "correction-unused"):
            key, _, words = item.message.partition(": ")
            assert (item.osm_id, key) not in found
            found[item.osm_id, key] = item.code == "correction", words
    return found
