"""Clearances: the height from one carriageway to another."""

from __future__ import annotations

from pathlib import Path

import pytest
from checked import checked
from map_damage import add_bridge
from t_junction import Tree, one, road, sound_tree

from osm2xodr.checking import Finding, Severity


@pytest.fixture
def tree() -> Tree:
    return sound_tree()


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
