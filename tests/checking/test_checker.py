"""What a check gives: findings with their places, ranked and counted, for the readers and rules that are asked."""

from __future__ import annotations

import gzip
import math
from pathlib import Path

import pytest
from lxml import etree
from t_junction import Tree, one, road, sound_map, sound_tree

from osm2xodr.checking import READERS, RULES, CheckOptions, CheckResult, Severity, check_file
from osm2xodr.errors import InputError

NO_SCHEMA = ("schema",)


@pytest.fixture
def tree() -> Tree:
    return sound_tree()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "map.xodr"


def checked(tree: Tree, path: Path, **options: object) -> CheckResult:
    """Write a file and check it."""
    path.write_bytes(etree.tostring(tree))
    return check_file(path, CheckOptions(**{"ignore": NO_SCHEMA, **options}))  # type: ignore[arg-type]


def test_a_gap_is_measured_where_it_is(tree: Tree, path: Path) -> None:
    one(tree, "road[@id='1']/planView/geometry[@s='30.0']").set("y", "0.25")
    found = [item for item in checked(tree, path).findings if item.rule == "record-gap"]
    assert len(found) == 1
    finding = found[0]
    assert (finding.road, finding.lane, finding.severity) == ("1", None, Severity.ERROR)
    assert finding.s == 30.0
    assert (finding.x, finding.y) == (-30.0, 0.25)
    assert finding.value == pytest.approx(0.25)
    assert finding.limit == 0.01
    assert finding.text == "the record begins 0.25 m away from the end of the previous one"
    # 30 m west of the origin at 49 N, 11 E: a metre of longitude there is 1 / 73172 degrees.
    assert finding.lat == pytest.approx(49 + 0.25 / 111229, abs=1e-7)
    assert finding.lon == pytest.approx(11 - 30 / 73172, abs=1e-6)
    text = path.read_text().splitlines()[finding.line - 1]
    assert '<geometry s="30.0"' in text


def test_small_gaps_are_warnings_and_large_ones_errors(tree: Tree, path: Path) -> None:
    geometry = one(tree, "road[@id='1']/planView/geometry[@s='30.0']")
    severities = []
    for gap in ("0.005", "0.02", "0.2"):
        geometry.set("y", gap)
        counts = checked(tree, path, only=("record-gap",), ignore=()).counts
        severities.append([item.severity for item in counts])
    assert severities == [[], [Severity.WARNING], [Severity.ERROR]]


def test_lanes_at_links_are_measured(tree: Tree, path: Path) -> None:
    one(tree, "road[@id='4']/planView/geometry").set("y", "0.3")
    one(tree, "road[@id='4']/planView/geometry").set("hdg", str(math.radians(2)))
    one(tree, "road[@id='4']/elevationProfile/elevation").set("a", "10.04")
    one(tree, "road[@id='4']/elevationProfile/elevation").set("b", "0.03")
    found = {(item.rule, item.road, item.lane): item for item in checked(tree, path).findings}
    # Both roads name each other, and each has two lanes.
    places = {("2", 1), ("2", -1), ("4", 1), ("4", -1)}
    for rule in ("lane-gap", "lane-edge-gap", "lane-height-step", "link-kink", "link-grade-step"):
        assert {(road_id, lane) for name, road_id, lane in found if name == rule} == places
    gap = found["lane-gap", "2", -1]
    # The middle of the lane is 1.75 m to the right, and turns with the road: (x, y) = 1.75 (sin 2°, 1 - cos 2°).
    turned = math.hypot(1.75 * math.sin(math.radians(2)), 0.3 + 1.75 * (1 - math.cos(math.radians(2))))
    assert gap.value == pytest.approx(turned, abs=1e-9)
    assert (gap.s, gap.x, gap.y) == (50.0, 60.0, 0.0)
    assert found["lane-height-step", "2", -1].value == pytest.approx(0.04)
    assert found["link-kink", "2", -1].value == pytest.approx(2.0)
    assert found["link-grade-step", "2", -1].value == pytest.approx(3.0)


def test_a_fold_is_measured(tree: Tree, path: Path) -> None:
    replaced = one(tree, "road[@id='4']/planView/geometry/line")
    replaced.tag = "arc"
    replaced.set("curvature", "0.4")
    found = [item for item in checked(tree, path).findings if item.rule == "folded-lane"]
    # The left lane's border is 3.5 m from a line that turns round 2.5 m to its left.
    assert [(item.road, item.lane) for item in found] == [("4", 1)]
    assert found[0].value == pytest.approx(1.0)


def test_grades_are_found_between_records(tree: Tree, path: Path) -> None:
    elevation = one(tree, "road[@id='4']/elevationProfile/elevation")
    # Level at both ends of 40 m, and 2 + 18 % in the middle: z' = 6 h s (l - s) / l³.
    elevation.set("c", repr(3 * 5.6 / 40**2))
    elevation.set("d", repr(-2 * 5.6 / 40**3))
    found = checked(tree, path).findings
    assert [(item.rule, item.road) for item in found] == [("grade-steep", "4")]
    assert found[0].s == pytest.approx(20.0)
    assert found[0].value == pytest.approx(100 * 1.5 * 5.6 / 40)


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


def test_what_the_standard_allows_is_no_finding(tree: Tree, path: Path) -> None:
    # A road that goes on through a virtual junction, a crossing without connections, lanes with traffic turned round.
    tree.append(
        etree.fromstring(
            '<junction id="200" name="" type="virtual" mainRoad="4" sStart="10" sEnd="20" orientation="none">'
            '<connection id="0" incomingRoad="4" connectingRoad="5" contactPoint="start">'
            '<laneLink from="-1" to="-1"/></connection></junction>'
        )
    )
    tree.append(etree.fromstring('<junction id="201" name="" type="crossing"/>'))
    aside = etree.fromstring(etree.tostring(road(tree, 4)))
    aside.set("id", "5")
    aside.set("junction", "200")
    aside.remove(one(aside, "link"))
    one(aside, "planView/geometry").set("y", "30")
    link = etree.fromstring('<link><predecessor elementType="road" elementId="4" contactPoint="start"/></link>')
    aside.insert(0, link)
    for lane in aside.iter("lane"):
        one(lane, "link").clear()
    tree.insert(5, aside)
    names = {"incoming-elsewhere", "incoming-road", "connecting-elsewhere", "junction-empty"}
    assert names.isdisjoint(checked(tree, path).by_rule())


def test_lanes_turned_round_carry_traffic_the_other_way(tree: Tree, path: Path) -> None:
    assert "lane-link-other-way" not in checked(tree, path).by_rule()
    for lane in road(tree, 10).iter("lane"):
        if lane.get("id") != "0":
            lane.set("direction", "reversed")
    found = [item for item in checked(tree, path).findings if item.rule == "lane-link-other-way"]
    assert {item.road for item in found} == {"1", "10"}
    for lane in road(tree, 10).iter("lane"):
        if lane.get("id") != "0":
            lane.set("direction", "both")
    assert "lane-link-other-way" not in checked(tree, path).by_rule()


# ---------------------------------------------------------------- what is asked for


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


# ---------------------------------------------------------------- files


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


def test_every_rule_says_what_to_do() -> None:
    for rule in RULES.values():
        assert rule.meaning.endswith(".")
        assert rule.remedy.endswith(".")
        assert set(rule.readers) <= set(READERS)
        assert rule.standard or rule.readers
        assert (rule.limit is None) <= ("{value}" not in rule.text)
        assert rule.limit is None or rule.limit.error is None or rule.limit.error >= rule.limit.value
