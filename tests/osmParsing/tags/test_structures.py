from __future__ import annotations

from pathlib import Path

import pytest
from osm_builder import ROAD, ROW, Area

from osm2xodr.model import Structure


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
