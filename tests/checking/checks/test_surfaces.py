"""Surfaces: heights of a junction, carriageways that overlap.

Clearances: the height from one carriageway to another.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from checked import checked
from lxml import etree
from map_damage import add_bridge
from t_junction import Tree, one, road, sound_tree

from osm2xodr.checking import Finding, Severity
from osm2xodr.checking.checks import roads, surfaces
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
    monkeypatch.setattr(roads, "_BLOCK", 1)
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


def found_in(tree: Tree, folder: Path) -> list[Finding]:
    return list(checked(tree, folder / "map.xodr", only=("clearance",), ignore=()).findings)


@pytest.mark.parametrize(
    ("height", "severity"),
    [(4.01, None), (3.99, Severity.WARNING), (2.01, Severity.WARNING), (1.99, Severity.ERROR), (0.0, Severity.ERROR)],
)
def test_a_lorry_passes_and_a_car_must(tree: Tree, tmp_path: Path, height: float, severity: Severity | None) -> None:
    add_bridge(tree, height)
    found = found_in(tree, tmp_path)
    assert [item.severity for item in found] == ([] if severity is None else [severity])
    if found:
        assert found[0].value == pytest.approx(height, abs=1e-9)
        assert found[0].limit == 4.0
        assert {found[0].road, found[0].text.split()[-1]} == {"2", "5"}
        assert found[0].s == pytest.approx(30.0, abs=4.0)


def test_bridge_is_no_higher_than_over_the_connecting_roads_below_it(tree: Tree, tmp_path: Path) -> None:
    # Between roads 2 and 3, which it does not reach.
    add_bridge(tree, 3.0, x=6.75)
    (finding,) = found_in(tree, tmp_path)
    assert finding.value == pytest.approx(3.0)
    assert {finding.road, finding.text.split()[-1]} & {"10", "11", "13", "15"}


def test_lowest_edge_of_a_sloping_bridge_counts(tree: Tree, tmp_path: Path) -> None:
    add_bridge(tree, 4.5)
    elevation = one(road(tree, 5), "elevationProfile/elevation")
    # It falls by 1 m in 4 m: 4.5 m over the middle of road 2, 25 m from its start.
    elevation.set("a", str(14.5 + 25.0 / 4.0))
    elevation.set("b", "-0.25")
    (finding,) = found_in(tree, tmp_path)
    # The last piece that reaches 0.3 m and more below its edge, 3.5 m away, ends at 4 m; its middle is at 3 m.
    assert finding.value == pytest.approx(4.5 - 0.75, abs=0.26)


def test_roads_that_meet_are_one_surface(tree: Tree, tmp_path: Path) -> None:
    # Road 4 folds back onto road 2, which it is linked to.
    geometry = one(road(tree, 4), "planView/geometry")
    geometry.set("hdg", "3.05")
    assert found_in(tree, tmp_path) == []
    # Roads 1 and 3 share the junction, but lie on each other 30 m from it, square.
    geometry = one(road(tree, 3), "planView/geometry")
    geometry.set("x", "-50.0")
    geometry.set("y", "-25.0")
    for number in (1, 3):
        profile = one(road(tree, number), "elevationProfile")
        for record in profile.findall("elevation")[1:]:
            profile.remove(record)
        for key, value in (("a", "10"), ("c", "0")):
            profile[0].set(key, value)
    assert [item.value for item in found_in(tree, tmp_path)] == []
    geometry.set("x", "-15.0")
    assert [item.value for item in found_in(tree, tmp_path)] == []


def test_ramp_that_climbs_beside_its_road_is_no_clearance(tree: Tree, tmp_path: Path) -> None:
    # Road 4 runs back over road 2 from their common end, and climbs to 3 m above it.
    geometry = one(road(tree, 4), "planView/geometry")
    geometry.set("hdg", "3.05")
    one(road(tree, 4), "elevationProfile/elevation").set("b", "0.075")
    assert found_in(tree, tmp_path) == []


def test_road_passes_below_itself(tree: Tree, tmp_path: Path) -> None:
    # A loop of 10 m radius: after 5/4 turns the road crosses its own start, 10 m on, 3 m higher.
    loop = one(road(tree, 3), "planView/geometry")
    road(tree, 3).remove(one(road(tree, 3), "link"))
    length = 10.0 + 2.0 * 3.141592653589793 * 10.0 + 10.0
    loop.set("length", "10")
    loop.set("x", "300")
    for s, x, y, part, curvature in (
        (10.0, 300.0, -50.0, length - 20.0, 0.1),
        (length - 10.0, 300.0, -50.0, 10.0, 0.0),
    ):
        record = one(sound_tree(), "road[@id='3']/planView/geometry")
        for key, value in (("s", s), ("x", x), ("y", y), ("length", part)):
            record.set(key, repr(value))
        if curvature:
            shape = record[0]
            shape.tag = "arc"
            shape.set("curvature", repr(curvature))
        one(road(tree, 3), "planView").append(record)
    road(tree, 3).set("length", repr(length))
    one(road(tree, 3), "elevationProfile/elevation").set("b", repr(3.0 / (length - 20.0)))
    found = [item for item in found_in(tree, tmp_path) if item.road == "3"]
    assert len(found) == 1
    assert found[0].text.split()[-1] == "3"
    assert found[0].value is not None
    assert 2.0 < found[0].value < 3.3
