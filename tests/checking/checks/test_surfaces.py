"""Surfaces: heights of a junction, carriageways that overlap."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from checked import checked
from lxml import etree
from t_junction import Tree, one, road, sound_tree

from osm2xodr.checking.checks import lanes, surfaces
from osm2xodr.errors import InputError


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


@pytest.mark.parametrize(("east", "north"), [(313.0, 259.0), (-313.0, 259.0), (-313.0, -259.0), (313.0, -259.0)])
def test_where_an_overlap_lies_does_not_matter(tree: Tree, path: Path, east: float, north: float) -> None:
    geometry = one(tree, "road[@id='4']/planView/geometry")
    geometry.set("x", "-55")
    geometry.set("y", "0")
    for item in tree.iter("geometry"):
        item.set("x", repr(float(item.get("x", "")) + east))
        item.set("y", repr(float(item.get("y", "")) + north))
    found = checked(tree, path, only=("overlap",), ignore=()).findings
    assert [(item.road, item.text.split()[-1]) for item in found] == [("1", "4")]
    assert found[0].value == pytest.approx((40 - 2 * 1.5 + 0.7) * (7 - 2 * 0.4 + 0.7), rel=0.05)


def test_large_files_are_compared_part_by_part(tree: Tree, path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    geometry = one(tree, "road[@id='4']/planView/geometry")
    geometry.set("x", "-55")
    geometry.set("y", "0")
    for number, start in ((10, "10"), (11, "10.3")):
        one(road(tree, number), "elevationProfile/elevation").set("a", start)
    only = ("junction-surface", "overlap", "folded-lane", "tight-curve")
    whole = checked(tree, path, only=only, ignore=()).findings
    assert "overlap" in {item.rule for item in whole}
    points = []

    def counted(*args: Any) -> Any:
        points.append(len(args[1].s))
        return cells(*args)

    cells = surfaces._shared_cells
    monkeypatch.setattr(surfaces, "_shared_cells", counted)
    monkeypatch.setattr(surfaces, "_BLOCK", 20)
    monkeypatch.setattr(surfaces, "_POINTS", 100)
    monkeypatch.setattr(lanes, "_BLOCK", 1)
    assert checked(tree, path, only=only, ignore=()).findings == whole
    # In more than one band of the roads, and one of those that overlap.
    assert len(points) > 2


def test_wide_roads_are_compared_band_by_band_whatever_their_heading(tree: Tree, path: Path) -> None:
    areas = []
    for heading in ("0", "0.785398", "1.570796", "3.141593", "-2.0"):
        for number, y in ((1, "0"), (4, "0.01")):
            geometry = one(road(tree, number), "planView/geometry")
            geometry.attrib.update({"x": "-500", "y": y, "hdg": heading})
            for width in road(tree, number).iter("width"):
                width.set("a", "40")
        areas += [item.value for item in checked(tree, path, only=("overlap",), ignore=()).findings]
    assert areas == pytest.approx([2290.0] * 5, rel=0.03)


def test_roads_on_each_other_by_the_hundred_are_refused(tree: Tree, path: Path) -> None:
    for k in range(1, 600):
        copy = etree.fromstring(etree.tostring(road(tree, 4)))
        copy.set("id", str(1000 + k))
        one(copy, "planView/geometry").set("x", str(200.0 + k * 1e-3))
        tree.append(copy)
    with pytest.raises(InputError, match=r"map.xodr: too many roads lie on each other .* at road '\d+', s ="):
        checked(tree, path)
    assert checked(tree, path, only=("record-gap",), ignore=()).findings == ()


def test_large_areas_that_roads_share_are_refused(tree: Tree, path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    one(road(tree, 4), "planView/geometry").attrib.update({"x": "-55", "y": "0"})
    monkeypatch.setattr(surfaces, "_SHARED", 100.0)
    monkeypatch.setattr(surfaces, "_SHARED_EACH", 1.0)
    with pytest.raises(InputError, match=r"too large an area to compare them, such as road '[14]'"):
        checked(tree, path)
