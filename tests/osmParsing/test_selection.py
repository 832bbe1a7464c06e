from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from osm_builder import ROAD, ROW, Area, about, ways_of

from osm2xodr.osmParsing import ParseOptions, parse_ways_option


def test_which_ways_are_carried(tmp_path: Path) -> None:
    area = Area(
        ROW,
        {
            20: ([1, 2], ROAD),
            21: ([2, 3], "highway=service service=driveway"),
            22: ([3, 4], ROAD + " access=private"),
            23: ([4, 5], "highway=footway"),
            24: ([5, 6], "highway=construction construction=primary"),
            25: ([6, 7, 17, 6], "highway=service area=yes"),
            26: ([7, 8], "highway=track"),
            27: ([8, 9], "building=yes"),
            28: ([8, 9], "highway=track"),
            29: ([8, 10], "highway=pedestrian"),
            30: ([9, 10], "highway=Primary"),
            31: ([9, 11], "highway=bus_guideway barrier=fence"),
            32: ([9, 12], "highway=track area=yes"),
            33: ([9, 12], "highway=steps"),
        },
    )

    def carried(options: ParseOptions) -> tuple[list[int], list[tuple[str, str, str]]]:
        network, diagnostics = area.parse(tmp_path, options)
        ways = sorted({way for street in ways_of(network) for way, _ in street})
        return ways, [(item.kind.value, item.code, item.osm_id) for item in diagnostics if "lane" not in item.code]

    told = [
        ("dropped", "closed", "way/22"),
        ("dropped", "not-built", "way/24"),
        ("dropped", "area", "way/25"),
        ("note", "way-selection", ""),
        ("dropped", "highway-class", "way/30"),
        ("dropped", "highway-class", "way/31"),
        ("note", "way-selection", ""),
        ("note", "way-selection", ""),
    ]
    assert carried(ParseOptions(default_speeds=False)) == ([20], told)
    assert carried(ParseOptions(furniture=False, default_speeds=False)) == ([20], told)
    assert carried(ParseOptions(include_private=True))[0] == [20, 22]
    assert carried(ParseOptions(parse_ways_option("all")))[0] == [20, 21, 26, 28]
    assert carried(ParseOptions(parse_ways_option("track,unclassified"), include_private=True))[0] == [20, 22, 26, 28]


def test_ways_that_are_left_out_are_told_by_kind(tmp_path: Path) -> None:
    ways = {20: ([1, 2], ROAD), 21: ([2, 3], "highway=track"), 22: ([3, 4], "highway=track access=no")}
    ways |= {23: ([4, 5], "highway=service service=driveway"), 24: ([5, 6], "highway=" + "x" * 99)}
    _, diagnostics = Area(ROW, ways).parse(tmp_path)
    assert [item.message for item in about(diagnostics, "way-selection")] == [
        "1 way left out: service=driveway is not among the ways asked for",
        "2 ways left out: highway=track is not among the ways asked for",
    ]
    assert [(item.osm_id, item.message) for item in about(diagnostics, "highway-class")] == [
        ("way/24", f"highway={'x' * 37}... is not a class of roads that can be carried, it is left out")
    ]


def test_what_stands_on_the_road_and_is_not_carried_is_told(tmp_path: Path) -> None:
    tags = {
        2: "barrier=lift_gate access=no",
        3: "railway=tram_level_crossing",
        5: "barrier=entrance",
        6: "highway=crossing",
        8: "barrier=gate",
    }
    area = Area(ROW, {20: ([1, 2, 3, 4, 5, 6], ROAD), 21: ([7, 8, 9], "highway=footway")}, node_tags=tags)
    _, diagnostics = area.parse(tmp_path)
    told = [(item.kind.value, item.osm_id, item.message) for item in about(diagnostics, "street-node")]
    assert told == [
        ("dropped", "node/2", "barrier=lift_gate on the road is not carried, the street is open there"),
        ("dropped", "node/3", "railway=tram_level_crossing is not carried, the street is open there"),
    ]


def test_roads_of_unknown_class_are_carried_as_unclassified(tmp_path: Path) -> None:
    found = {}
    for highway in ("road", "unclassified"):
        network, diagnostics = Area(ROW, {20: ([1, 2], f"highway={highway}")}).parse(tmp_path)
        ((_, piece),) = network.streets[0].pieces
        assert piece.highway == highway
        found[highway] = replace(piece, highway="")
        told = [(item.kind.value, item.osm_id, item.message) for item in about(diagnostics, "highway-class")]
        words = "highway=road has no known class, taken as unclassified"
        assert told == ([("guessed", "way/20", words)] if highway == "road" else [])
    assert found["road"] == found["unclassified"]
