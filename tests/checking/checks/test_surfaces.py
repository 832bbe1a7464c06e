"""Surfaces: heights of a junction, carriageways that overlap."""

from __future__ import annotations

from pathlib import Path

import pytest
from checked import checked
from t_junction import Tree, one, road, sound_tree


@pytest.fixture
def tree() -> Tree:
    return sound_tree()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "map.xodr"


def test_surfaces_of_a_junction_are_compared_in_one_place(tree: Tree, path: Path) -> None:
    # A slope of 10 % over the whole junction is one surface, though it differs from place to place.
    for number, rise, start in ((10, 0.1, 10.0), (11, -0.1, 12.0)):
        elevation = one(road(tree, number), "elevationProfile/elevation")
        elevation.set("a", str(start))
        elevation.set("b", str(rise))
    only = ("junction-surface",)
    found = checked(tree, path, only=only, ignore=()).findings
    assert {tuple(sorted((item.road, item.text.split()[-1]))) for item in found}.isdisjoint({("10", "11")})
    one(road(tree, 11), "elevationProfile/elevation").set("a", "12.25")
    found = checked(tree, path, only=only, ignore=()).findings
    # Roads 10 and 11 lie side by side and share only their common edge's surroundings.
    assert all(item.value is not None and item.value > 0.12 for item in found)


def test_an_overlap_is_an_area(tree: Tree, path: Path) -> None:
    geometry = one(tree, "road[@id='4']/planView/geometry")
    geometry.set("x", "-55")
    geometry.set("y", "0")
    found = [item for item in checked(tree, path).findings if item.rule == "overlap"]
    assert [(item.road, item.text.split()[-1]) for item in found] == [("1", "4")]
    # 40 m of 7 m of carriageway, less margins at the edges and ends, in whole cells of 0.7 m.
    assert found[0].value == pytest.approx((40 - 2 * 1.5 + 0.7) * (7 - 2 * 0.4 + 0.7), rel=0.05)
