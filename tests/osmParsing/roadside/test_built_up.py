"""How densely residential streets lie around a street."""

from __future__ import annotations

from pathlib import Path

import pytest
from osm_builder import Area

from osm2xodr.osmParsing.roadside.built_up import residential_density


def density(folder: Path, dwellings: str, distance: float) -> dict[int, float]:
    """Return the density around a road of 200 m and a street of 200 m beside it, by the id of the way."""
    nodes = {1: (-100.0, 0.0), 2: (100.0, 0.0), 3: (-100.0, distance), 4: (100.0, distance)}
    area = Area(nodes, {20: ([1, 2], "highway=tertiary"), 21: ([3, 4], f"highway={dwellings}")})
    network, _ = area.parse(folder)
    found = residential_density(network.streets).tolist()
    return {street.pieces[0][1].osm_way_id: value for street, value in zip(network.streets, found, strict=True)}


@pytest.mark.parametrize("dwellings", ["residential", "living_street"])
def test_streets_with_houses_nearby_count(tmp_path: Path, dwellings: str) -> None:
    found = density(tmp_path, dwellings, 80.0)
    # Windows of 300 m hold all of a street that is at most 100 m away and 200 m long.
    assert found[20] == pytest.approx(200.0 / 9.0, abs=0.1)
    assert found[21] == pytest.approx(200.0 / 9.0, abs=0.1)


def test_those_farther_away_and_other_roads_do_not_count(tmp_path: Path) -> None:
    assert density(tmp_path, "residential", 320.0)[20] == 0.0
    assert density(tmp_path, "unclassified", 80.0) == {20: 0.0, 21: 0.0}
