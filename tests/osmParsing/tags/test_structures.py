from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import quoteattr

import pytest
from osm_builder import ROAD, ROW, Area, about, write_osm

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Structure
from osm2xodr.osmParsing import ParseOptions, parse_osm


@pytest.mark.parametrize(
    ("text", "height"),
    [("4", 4.0), ("3.6 m", 3.6), ("12'6\"", 3.81), ("default", None), ("none", None), ("25", None), ("high", None)],
)
def test_max_height(tmp_path: Path, text: str, height: float | None) -> None:
    area = Area(ROW, {20: ([1, 2], ROAD)})
    path = write_osm(
        tmp_path,
        [line.replace("</way>", f"<tag k='maxheight' v={quoteattr(text)}/></way>") for line in area.elements()],
    )
    diagnostics = Diagnostics()
    network = parse_osm(path, ParseOptions(), diagnostics)
    ((_, attributes),) = network.streets[0].pieces
    assert attributes.max_height == (None if height is None else pytest.approx(height))
    assert len(about(diagnostics, "max-height")) == (text in ("25", "high"))


@pytest.mark.parametrize(
    ("tags", "structure", "layer"),
    [
        ("", Structure.GROUND, 0),
        ("bridge=yes", Structure.BRIDGE, 1),
        ("bridge=viaduct layer=2", Structure.BRIDGE, 2),
        ("bridge=no", Structure.GROUND, 0),
        ("tunnel=yes", Structure.TUNNEL, -1),
        ("tunnel=yes layer=-3", Structure.TUNNEL, -3),
        ("tunnel=no", Structure.GROUND, 0),
        ("tunnel=building_passage", Structure.GROUND, 0),
        ("tunnel=avalanche_protector", Structure.GROUND, 0),
        ("covered=yes layer=-1", Structure.GROUND, -1),
        ("bridge=yes layer=0", Structure.BRIDGE, 0),
        ("tunnel=yes layer=-1;0", Structure.TUNNEL, -1),
        ("bridge=yes layer=high", Structure.BRIDGE, 1),
    ],
)
def test_structures(tmp_path: Path, tags: str, structure: Structure, layer: int) -> None:
    network, _ = Area(ROW, {20: ([1, 2], f"{ROAD} {tags}")}).parse(tmp_path)
    ((_, piece),) = network.streets[0].pieces
    assert (piece.structure, piece.layer) == (structure, layer)
