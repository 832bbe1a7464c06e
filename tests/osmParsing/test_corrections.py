"""Corrections of what is read: left out, kept, with other tags."""

from __future__ import annotations

from pathlib import Path

import pytest
from corrected_cases import said
from osm_builder import ROW, Area

from osm2xodr.model import Corrections, Direction, NodeCorrection, StreetAttributes, StreetNetwork, WayCorrection
from osm2xodr.osmParsing import ParseOptions

Said = dict[tuple[str, str], tuple[bool, str]]


def parse(area: Area, folder: Path, corrections: Corrections, **options: object) -> tuple[StreetNetwork, Said]:
    how = ParseOptions(default_speeds=False, corrections=corrections, **options)  # type: ignore[arg-type]
    network, diagnostics = area.parse(folder, how)
    return network, said(diagnostics)


def corrected(tags: str, known: WayCorrection, folder: Path) -> tuple[StreetAttributes, Said]:
    """Return what a way with tags is read as, and what is said of its correction."""
    network, found = parse(Area(ROW, {7: ([1, 2, 3], tags)}), folder, Corrections({7: known}))
    ((_, attributes),) = network.streets[0].pieces
    return attributes, found


def ways_of(network: StreetNetwork) -> list[int]:
    return [attributes.osm_way_id for street in network.streets for _, attributes in street.pieces]


TWO_WAY = "highway=residential lanes=2 width=6"
ONE_WAY = "highway=residential oneway=yes lanes=2 turn:lanes=left|through"


@pytest.mark.parametrize(
    ("tags", "lanes", "directions", "words"),
    [
        (TWO_WAY, {"": 4}, (-1, -1, 1, 1), "lanes=4 in place of lanes=2"),
        (TWO_WAY, {"forward": 2, "backward": 1}, (-1, 1, 1), "in place of lanes=2"),
        (ONE_WAY, {"": 3}, (1, 1, 1), "lanes=3 in place of lanes=2, turn:lanes=left|through"),
        (ONE_WAY, {"forward": 1}, (1,), "lanes:forward=1 in place of"),
        ("highway=residential", {"": 2}, (-1, 1), "lanes=2, which OSM lacks"),
    ],
)
def test_lanes(tags: str, lanes: dict[str, int], directions: tuple[int, ...], words: str, tmp_path: Path) -> None:
    found, about = corrected(tags, WayCorrection(lanes=lanes), tmp_path)
    assert tuple(lane.direction.value for lane in found.lanes_ltr) == directions
    applied, text = about["way/7", "lanes"]
    assert applied
    assert words in text


def test_lists_of_the_corrected_length_stay(tmp_path: Path) -> None:
    found, _ = corrected(ONE_WAY.replace("lanes=2", "lanes=5", 1), WayCorrection(lanes={"": 2}), tmp_path)
    assert [sorted(lane.turns) for lane in found.lanes_ltr] == [["left"], ["through"]]


def test_the_width_of_the_carriageway(tmp_path: Path) -> None:
    tags = "highway=residential oneway=yes lanes=2 width:lanes=2.5|2.5 est_width=5"
    found, about = corrected(tags, WayCorrection(width=7.0), tmp_path)
    assert [lane.width for lane in found.lanes_ltr] == [3.5, 3.5]
    assert about["way/7", "width"] == (True, "width=7 in place of est_width=5, width:lanes=2.5|2.5")


@pytest.mark.parametrize(
    ("known", "widths"), [({0: 3.25}, [3.25, 3.25, 3.25]), ({2: 2.5}, [3.25, 2.5, 3.25]), ({1: 4, 3: 2}, [4, 3, 2])]
)
def test_the_width_of_lanes(known: dict[int, float], widths: list[float], tmp_path: Path) -> None:
    """Other lanes share what is left of the carriageway."""
    found, about = corrected("highway=tertiary oneway=yes lanes=3 width=9", WayCorrection(lane_width=known), tmp_path)
    assert [lane.width for lane in found.lanes_ltr] == widths
    assert about["way/7", "lane-width"][0]


def test_a_lane_that_is_not_there_has_no_width(tmp_path: Path) -> None:
    found, about = corrected(TWO_WAY, WayCorrection(lane_width={3: 2.5}), tmp_path)
    assert [lane.width for lane in found.lanes_ltr] == [3.0, 3.0]
    assert about["way/7", "lane-width"] == (False, "it has no lane 3, only 2 of them")


def test_speeds(tmp_path: Path) -> None:
    tags = f"{TWO_WAY} maxspeed=50 maxspeed:forward=30"
    found, about = corrected(tags, WayCorrection(speed={"": "36"}), tmp_path)
    assert (found.speed_forward, found.speed_backward) == (10.0, 10.0)
    assert about["way/7", "speed"] == (True, "maxspeed=36 in place of maxspeed=50, maxspeed:forward=30")
    found, _ = corrected(tags, WayCorrection(speed={"backward": "72"}), tmp_path)
    assert found.speed_forward == pytest.approx(30 / 3.6)
    assert found.speed_backward == 20.0


def test_layer_and_clearance(tmp_path: Path) -> None:
    found, about = corrected(TWO_WAY, WayCorrection(layer=2, clearance=4.5), tmp_path)
    assert (found.layer, found.clearance) == (2, 4.5)
    # The clearance is applied, and reported, where heights are solved.
    assert about == {("way/7", "layer"): (True, "layer=2, which OSM lacks")}


def test_what_osm_says_by_now_is_no_longer_needed(tmp_path: Path) -> None:
    known = WayCorrection(lanes={"": 2}, width=6.0, lane_width={0: 3.0}, speed={"": "50"}, layer=1)
    found, about = corrected(f"{TWO_WAY} maxspeed=50 layer=1", known, tmp_path)
    assert len(found.lanes_ltr) == 2
    assert {key: applied for (_, key), (applied, _) in about.items()} == dict.fromkeys(
        ("lanes", "width", "lane-width", "speed", "layer"), False
    )


ROWS = {1: ([1, 2], TWO_WAY), 2: ([2, 3], TWO_WAY), 3: ([3, 4], "highway=service access=private")}
OTHERS = {4: ([2, 12], "highway=footway"), 5: ([3, 13], "highway=construction construction=residential")}


def test_what_is_dropped_is_not_there(tmp_path: Path) -> None:
    network, about = parse(
        Area(ROW, ROWS), tmp_path, Corrections({2: WayCorrection(drop=True), 9: WayCorrection(drop=True)})
    )
    assert ways_of(network) == [1]
    assert about["way/2", "drop"] == (True, "it is left out")
    assert about["way/9", "drop"] == (False, "no such way is read of the map")


@pytest.mark.parametrize(
    ("way", "known", "kept", "words"),
    [
        (3, WayCorrection(keep=True), "service", "access=private closes it to cars"),
        (4, WayCorrection(keep=True, highway="service"), "service", "highway=footway is not among the ways"),
        (5, WayCorrection(keep=True, highway="residential"), "residential", "highway=construction is not among"),
        (4, WayCorrection(keep=True), "", "highway=footway is no class that can be carried"),
        (1, WayCorrection(keep=True), "residential", "it is a street without it"),
        (8, WayCorrection(keep=True), "", "no such way is read"),
    ],
)
def test_what_is_kept_becomes_a_street(way: int, known: WayCorrection, kept: str, words: str, tmp_path: Path) -> None:
    network, about = parse(Area(ROW, ROWS | OTHERS), tmp_path, Corrections({way: known}))
    found = {item.osm_way_id: item.highway for street in network.streets for _, item in street.pieces}
    assert found.get(way, "") == kept
    applied, text = about[f"way/{way}", "keep"]
    assert applied == (way in (3, 4, 5) and bool(kept))
    assert words in text


def test_a_kept_way_has_its_tags_and_its_corrections(tmp_path: Path) -> None:
    known = WayCorrection(keep=True, highway="service", lanes={"": 1}, speed={"": "18"})
    area = Area(ROW, ROWS | {4: ([2, 12], "highway=footway oneway=yes width=3")})
    network, about = parse(area, tmp_path, Corrections({4: known}))
    (attributes,) = (item for street in network.streets for _, item in street.pieces if item.osm_way_id == 4)
    assert attributes.car_directions() == {Direction.FORWARD}
    assert [lane.width for lane in attributes.lanes_ltr] == [3.0]
    assert attributes.speed_forward == 5.0
    assert {key for _, key in about} == {"keep", "lanes", "speed"}
    assert all(applied for applied, _ in about.values())


def test_tags_of_ways_that_are_no_streets_match_nothing(tmp_path: Path) -> None:
    known = {3: WayCorrection(lanes={"": 1}, lane_width={0: 3.0}), 9: WayCorrection(layer=1)}
    _, about = parse(Area(ROW, ROWS), tmp_path, Corrections(known))
    assert about == {
        ("way/3", "lanes"): (False, "it is no street, and left out"),
        ("way/3", "lane-width"): (False, "it is no street, and left out"),
        ("way/9", "layer"): (False, "no such way is read of the map"),
    }


def test_a_dropped_node_says_nothing(tmp_path: Path) -> None:
    area = Area(ROW, ROWS, node_tags={2: "highway=traffic_signals", 3: "highway=stop"})
    known = {node: NodeCorrection(drop=True) for node in (2, 4)}
    network, about = parse(area, tmp_path, Corrections(nodes=known))
    assert set(network.node_tags) == {3}
    assert about == {
        ("node/2", "drop"): (True, "without highway=traffic_signals"),
        ("node/4", "drop"): (False, "no such node with tags is read of the map"),
    }


def test_a_dropped_relation_restricts_nothing(tmp_path: Path) -> None:
    members = (("way", 1, "from"), ("node", 2, "via"), ("way", 2, "to"))
    rules = {60 + k: (members, "type=restriction restriction=no_u_turn") for k in (0, 1)}
    network, about = parse(Area(ROW, ROWS, rules), tmp_path, Corrections(relations=frozenset({60, 70})))
    assert [item.osm_relation_id for item in network.restrictions] == [61]
    assert {element: applied for (element, _), (applied, _) in about.items()} == {
        "relation/60": True,
        "relation/70": False,
    }


def test_without_corrections_nothing_is_said(tmp_path: Path) -> None:
    area = Area(ROW, ROWS | OTHERS, node_tags={2: "highway=traffic_signals"})
    network, about = parse(area, tmp_path, Corrections())
    assert about == {}
    assert ways_of(network) == [1, 2]
