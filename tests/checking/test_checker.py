"""What a check gives: findings with their places, ranked and counted, for the readers and rules that are asked.

What can be asked of a check.
"""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest
from checked import checked
from lxml import etree
from t_junction import Tree, one, road, sound_map, sound_tree

from osm2xodr.checking import READERS, CheckOptions, Severity, check_file
from osm2xodr.errors import InputError

NO_SCHEMA = ("schema",)


@pytest.fixture
def tree() -> Tree:
    return sound_tree()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "map.xodr"


def test_errors_come_first_and_the_worst_of_them(tree: Tree, path: Path) -> None:
    one(tree, "road[@id='3']/elevationProfile/elevation").set("b", "0.2")
    one(tree, "road[@id='4']/elevationProfile/elevation").set("a", "10.05")
    road(tree, 10).set("length", "20.5")
    result = checked(tree, path)
    severities = [item.severity for item in result.findings]
    assert severities == sorted(severities, reverse=True)
    assert {Severity.ERROR, Severity.WARNING, Severity.INFO} == set(severities)
    first = [item for item in result.findings if item.rule == "lane-height-step" and item.severity is Severity.ERROR]
    assert [item.value for item in first] == sorted((item.value or 0 for item in first), reverse=True)


def test_all_are_counted_and_the_worst_listed(tree: Tree, path: Path) -> None:
    for number in (10, 11, 12, 13, 14, 15):
        road(tree, number).set("length", str(float(road(tree, number).get("length", "")) + number))
    result = checked(tree, path, most=2, only=("road-length",), ignore=())
    assert [(item.rule, item.findings) for item in result.counts] == [("road-length", 6)]
    assert [item.road for item in result.findings] == ["15", "14"]
    assert result.count(Severity.ERROR) == 6
    assert "4 of them not listed" in "\n".join(result.lines())


def test_rules_can_be_chosen_and_left_out(tree: Tree, path: Path) -> None:
    road(tree, 4).set("length", "40.5")
    one(tree, "junction/connection").attrib.pop("id")
    assert set(checked(tree, path).by_rule()) == {"road-length", "connection-without-id"}
    assert set(checked(tree, path, only=("road-length",), ignore=()).by_rule()) == {"road-length"}
    assert set(checked(tree, path, ignore=("road-length", "schema")).by_rule()) == {"connection-without-id"}


def test_readers_have_rules_of_their_own(tree: Tree, path: Path) -> None:
    header = one(tree, "header")
    header.append(etree.fromstring('<offset x="5" y="0" z="0" hdg="0"/>'))
    one(tree, "header/geoReference").text = etree.CDATA("EPSG:25832")
    found = {reader: set(checked(tree, path, readers=(reader,)).by_rule()) for reader in ("carla", "esmini", "sumo")}
    assert found == {
        "carla": {"header-offset", "georeference-without-origin"},
        "esmini": {"header-offset"},
        "sumo": {"georeference-not-proj"},
    }
    assert checked(tree, path, readers=()).by_rule() == {}


def test_findings_name_the_affected_readers(tree: Tree, path: Path) -> None:
    one(tree, "road[@id='3']/lanes/laneSection").remove(one(tree, "road[@id='3']/lanes/laneSection/center"))
    for readers, expected in (
        (("carla", "sumo"), ("carla",)),
        (("roadrunner",), ()),
        (READERS, ("carla", "esmini", "libopendrive")),
    ):
        result = checked(tree, path, readers=readers)
        assert [item.readers for item in result.findings if item.rule == "no-centre-lane"] == [expected]


def test_packed_files_are_read(tmp_path: Path) -> None:
    path = tmp_path / "map.xodr.gz"
    text = sound_map().replace("<outline id", "<outlines><outline id").replace("</outline>", "</outline></outlines>")
    path.write_bytes(gzip.compress(text.replace('revMinor="6"', 'revMinor="7"').encode()))
    result = check_file(path)
    assert result.version == "1.7"
    assert set(result.by_rule()) == {"outlines-unseen"}


def test_what_is_no_opendrive_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "map.xodr"
    for text in ("", "<osm/>", "<OpenDRIVE>", "no XML"):
        path.write_text(text)
        with pytest.raises(InputError, match=r"map\.xodr"):
            check_file(path)


def test_an_empty_network_is_checked(tmp_path: Path) -> None:
    path = tmp_path / "map.xodr"
    path.write_text('<OpenDRIVE><header revMajor="1" revMinor="6"/></OpenDRIVE>')
    result = check_file(path, CheckOptions(ignore=NO_SCHEMA))
    assert result.size == (0, 0, 0.0)
    assert set(result.by_rule()) == {"no-georeference"}


def test_numbers_that_are_missing_everywhere_do_no_harm(tree: Tree, path: Path) -> None:
    for element in tree.iter():
        for name in ("s", "x", "y", "hdg", "length", "a", "b", "curvature", "sOffset"):
            if name in element.attrib:
                del element.attrib[name]
    result = checked(tree, path)
    assert result.by_rule()["unreadable"] > 100


@pytest.mark.parametrize(
    "name", ["link", "planView", "lanes", "laneSection", "width", "geometry", "elevation", "header"]
)
def test_elements_that_are_missing_everywhere_do_no_harm(name: str, tree: Tree, path: Path) -> None:
    for element in list(tree.iter(name)):
        parent = element.getparent()
        assert parent is not None
        parent.remove(element)
    result = checked(tree, path)
    assert result.failed(Severity.WARNING) == (name != "elevation")


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"readers": ("carl",)}, "carl is no reader"),
        ({"only": ("gap",)}, "gap is no rule"),
        ({"ignore": ("gap",)}, "gap is no rule"),
        ({"most": -1}, "-1 findings"),
    ],
)
def test_what_is_unknown_is_refused(options: dict[str, object], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        CheckOptions(**options)  # type: ignore[arg-type]
