from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from osm_builder import Area, document

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import BusStop, RoadsideKind
from osm2xodr.osmParsing import ParseOptions, parse_osm
from osm2xodr.osmParsing.options import parse_ways_option
from osm2xodr.osmParsing.roadside.things import kind_of_node, kind_of_way

ALL = frozenset({"lamps", "trees"})
STREET = {1: (0.0, 0.0), 2: (100.0, 0.0), 3: (200.0, 0.0)}


def found(area: Area, folder: Path, options: ParseOptions | None = None) -> list[tuple[str, str]]:
    network, _ = area.parse(folder, options)
    return [(thing.kind.value, thing.osm_id) for thing in network.roadside]


@pytest.mark.parametrize(
    ("tags", "kind"),
    [
        ("highway=street_lamp", RoadsideKind.STREET_LAMP),
        ("natural=tree", RoadsideKind.TREE),
        ("highway=bus_stop", RoadsideKind.BUS_STOP),
        ("highway=bus_stop public_transport=platform tram=yes", RoadsideKind.BUS_STOP),
        ("public_transport=platform", RoadsideKind.BUS_STOP),
        ("public_transport=platform tram=yes bus=yes", RoadsideKind.BUS_STOP),
        ("public_transport=platform tram=yes", None),
        ("public_transport=platform railway=platform", None),
        ("public_transport=stop_position", None),
        ("traffic_sign=DE:205", RoadsideKind.TRAFFIC_SIGN),
        ("highway=stop", RoadsideKind.TRAFFIC_SIGN),
        ("highway=give_way", RoadsideKind.TRAFFIC_SIGN),
        ("highway=street_lamp traffic_sign=city_limit", RoadsideKind.TRAFFIC_SIGN),
        ("highway=traffic_signals", RoadsideKind.TRAFFIC_SIGNALS),
        ("barrier=bollard", RoadsideKind.BOLLARD),
        ("barrier=kerb", None),
        ("barrier=gate", None),
        ("highway=crossing", None),
    ],
)
def test_nodes(tmp_path: Path, tags: str, kind: RoadsideKind | None) -> None:
    assert kind_of_node(dict(item.split("=") for item in tags.split()), ALL) == kind
    nodes = {**STREET, 9: (50.0, 6.0)}
    area = Area(nodes, {20: ([1, 2, 3], "highway=residential")}, node_tags={9: tags})
    network, _ = area.parse(tmp_path, ParseOptions(extra_objects=ALL))
    assert [thing.kind for thing in network.roadside] == ([] if kind is None else [kind])
    if kind is None:
        return
    (thing,) = network.roadside
    assert thing.osm_id == "node/9"
    assert thing.node_ids.tolist() == [9]
    assert thing.points - network.streets[0].points[0] == pytest.approx(np.array([[50.0, 6.0]]), abs=0.05)


@pytest.mark.parametrize(
    ("tags", "kind"),
    [
        ("barrier=guard_rail", RoadsideKind.GUARD_RAIL),
        ("barrier=jersey_barrier", RoadsideKind.GUARD_RAIL),
        ("barrier=wall", RoadsideKind.WALL),
        ("barrier=retaining_wall", RoadsideKind.WALL),
        ("barrier=fence", RoadsideKind.FENCE),
        ("barrier=hedge", RoadsideKind.HEDGE),
        ("barrier=kerb", RoadsideKind.KERB),
        ("railway=tram", RoadsideKind.TRAM_TRACK),
        ("natural=tree_row", RoadsideKind.TREE),
        ("railway=rail", None),
        ("barrier=yes", None),
    ],
)
def test_ways(tmp_path: Path, tags: str, kind: RoadsideKind | None) -> None:
    assert kind_of_way(dict([tags.split("=")])) == kind
    nodes = {**STREET, 7: (50.0, 9.0), 8: (60.0, 9.0), 9: (160.0, 90.0)}
    area = Area(nodes, {20: ([1, 2, 3], "highway=residential"), 30: ([7, 8, 9], tags + " name=A height=2")})
    network, _ = area.parse(tmp_path, ParseOptions(extra_objects=ALL))
    assert [(thing.kind, thing.osm_id, thing.node_ids.tolist()) for thing in network.roadside] == (
        [] if kind is None else [(kind, "way/30", [7, 8, 9])]
    )
    for thing in network.roadside:
        places = thing.points - network.streets[0].points[0]
        assert places == pytest.approx(np.array([[50.0, 9.0], [60.0, 9.0], [160.0, 90.0]]), abs=0.1)
        assert thing.facts.height == (None if kind is RoadsideKind.TRAM_TRACK else 2.0)


@pytest.mark.parametrize(
    ("tags", "height"),
    [("", None), (" kerb=lowered", 0.03), (" kerb=raised", 0.12), (" kerb=unknown height=0.2", 0.2)],
)
def test_a_kerb_is_as_high_as_its_tags_say(tmp_path: Path, tags: str, height: float | None) -> None:
    nodes = {**STREET, 7: (50.0, 9.0), 8: (60.0, 9.0)}
    area = Area(nodes, {20: ([1, 2, 3], "highway=residential"), 30: ([7, 8], "barrier=kerb" + tags)})
    network, _ = area.parse(tmp_path, ParseOptions(extra_objects=ALL))
    (thing,) = network.roadside
    assert thing.facts.height == height


@pytest.mark.parametrize(
    ("tags", "nodes", "kinds"),
    [
        ("area:highway=traffic_island", [5, 6, 7, 8, 5], [RoadsideKind.ISLAND]),
        ("traffic_calming=island barrier=kerb", [5, 6, 7, 8, 5], [RoadsideKind.ISLAND]),
        ("traffic_calming=island", [5, 6, 7], []),
        ("traffic_calming=hump", [5, 6, 7, 8, 5], []),
        ("area:highway=footway", [5, 6, 7, 8, 5], []),
    ],
)
def test_islands_are_areas(tmp_path: Path, tags: str, nodes: list[int], kinds: list[RoadsideKind]) -> None:
    places = {**STREET, 5: (40.0, 4.0), 6: (60.0, 4.0), 7: (60.0, 6.0), 8: (40.0, 6.0)}
    network, _ = Area(places, {20: ([1, 2, 3], "highway=residential"), 30: (nodes, tags)}).parse(tmp_path)
    assert [thing.kind for thing in network.roadside] == kinds
    assert [thing.node_ids.tolist() for thing in network.roadside] == [nodes] * len(kinds)


def test_a_platform_stands_in_its_middle(tmp_path: Path) -> None:
    nodes = {**STREET, 5: (40.0, 4.0), 6: (60.0, 4.0), 7: (60.0, 6.0), 8: (40.0, 6.0)}
    area = Area(
        nodes,
        {
            20: ([1, 2, 3], "highway=residential"),
            30: ([5, 6, 7, 8, 5], "public_transport=platform bus=yes area=yes name=A"),
        },
    )
    network, _ = area.parse(tmp_path)
    (stop,) = network.roadside
    assert (stop.kind, stop.osm_id) == (RoadsideKind.BUS_STOP, "way/30")
    assert stop.points - network.streets[0].points[0] == pytest.approx(np.array([[50.0, 5.0]]), abs=0.05)
    assert len(stop.node_ids) == 1
    assert stop.facts.bus_stop == BusStop("A")


def test_only_what_is_within_reach(tmp_path: Path) -> None:
    # The carriageway is 5.5 m wide: 15 m from its edge are 17.75 m from its middle.
    nodes = {**STREET, 7: (50.0, 17.0), 8: (51.0, 18.5), 9: (203.0, 0.0), 10: (5000.0, 0.0), 11: (150.0, -17.0)}
    signs = dict.fromkeys((7, 8, 9, 10, 11), "traffic_sign=DE:205")
    area = Area(nodes, {20: ([1, 2, 3], "highway=residential")}, node_tags=signs)
    assert found(area, tmp_path) == [
        ("traffic_sign", "node/7"),
        ("traffic_sign", "node/9"),
        ("traffic_sign", "node/11"),
    ]


def test_nodes_on_streets_are_none_of_them(tmp_path: Path) -> None:
    nodes = {**STREET, 7: (100.0, 5.0)}
    area = Area(
        nodes,
        {20: ([1, 2, 3], "highway=residential"), 30: ([2, 7], "highway=footway")},
        node_tags={2: "highway=traffic_signals crossing=marked crossing:island=yes", 7: "highway=traffic_signals"},
    )
    network, _ = area.parse(tmp_path)
    assert [thing.osm_id for thing in network.roadside] == ["node/7"]
    assert network.node_tags == {
        2: {"crossing": "marked", "crossing:island": "yes", "highway": "traffic_signals"},
    }


def test_lamps_and_trees_on_request(tmp_path: Path) -> None:
    nodes = {**STREET, 7: (50.0, 5.0), 8: (60.0, 5.0), 9: (70.0, 5.0), 10: (80.0, 5.0)}
    area = Area(
        nodes,
        {20: ([1, 2, 3], "highway=residential"), 30: ([9, 10], "natural=tree_row")},
        node_tags={7: "highway=street_lamp", 8: "natural=tree"},
    )
    lamp, tree, row = ("street_lamp", "node/7"), ("tree", "node/8"), ("tree", "way/30")
    assert found(area, tmp_path) == []
    assert found(area, tmp_path, ParseOptions(extra_objects=frozenset({"lamps"}))) == [lamp]
    assert found(area, tmp_path, ParseOptions(extra_objects=frozenset({"trees"}))) == [tree, row]
    assert found(area, tmp_path, ParseOptions(extra_objects=ALL)) == [lamp, tree, row]
    assert found(area, tmp_path, ParseOptions(extra_objects=ALL, furniture=False)) == []


def test_nothing_is_read_without_furniture(tmp_path: Path) -> None:
    nodes = {**STREET, 7: (50.0, 5.0), 8: (150.0, 5.0)}
    area = Area(
        nodes,
        {20: ([1, 2, 3], "highway=residential"), 30: ([7, 8], "highway=footway footway=sidewalk")},
        node_tags={2: "crossing=marked barrier=gate", 3: "highway=turning_circle crossing=no"},
    )
    network, _ = area.parse(tmp_path, ParseOptions(furniture=False))
    assert (network.footways, network.roadside) == ((), ())
    # Where people cross tells of built-up areas.
    assert network.node_tags == {3: {"highway": "turning_circle", "crossing": "no"}}
    assert network.streets[0].pieces[0][1].margin_left == ()


def test_names_are_kept_where_signs_or_stops_show_them(tmp_path: Path) -> None:
    area = Area(
        STREET,
        {20: ([1, 2, 3], "highway=residential")},
        node_tags={1: "highway=crossing name=A", 2: "traffic_sign=city_limit name=B", 3: "name=C"},
    )
    network, _ = area.parse(tmp_path)
    assert network.node_tags == {1: {"highway": "crossing"}, 2: {"name": "B", "traffic_sign": "city_limit"}}


def test_order_is_by_kind_and_id(tmp_path: Path) -> None:
    nodes = {**STREET, 10: (50.0, 5.0), 9: (60.0, 5.0), -3: (70.0, 5.0), 7: (80.0, 5.0), 8: (80.0, 9.0)}
    area = Area(
        nodes,
        {20: ([1, 2, 3], "highway=residential"), 4: ([7, 8], "barrier=bollard")},
        node_tags={10: "barrier=bollard", 9: "barrier=bollard", -3: "barrier=bollard", 7: "highway=bus_stop"},
    )
    expected = [
        ("bollard", "node/-3"),
        ("bollard", "node/9"),
        ("bollard", "node/10"),
        ("bollard", "way/4"),
        ("bus_stop", "node/7"),
    ]
    assert found(area, tmp_path) == expected
    path = tmp_path / "turned.osm"
    path.write_text(document(area.elements()[::-1]), encoding="utf-8")
    network = parse_osm(path, ParseOptions(), Diagnostics())
    assert [(thing.kind.value, thing.osm_id) for thing in network.roadside] == expected


def test_versions_and_deleted_elements(tmp_path: Path) -> None:
    area = Area(STREET, {20: ([1, 2, 3], "highway=residential")})
    elements = [
        *area.elements(),
        '<node id="7" version="1" lat="50.00005" lon="10.001"><tag k="traffic_sign" v="old"/></node>',
        '<node id="7" version="2" lat="50.00005" lon="10.002"><tag k="traffic_sign" v="new"/></node>',
        '<node id="8" version="2" visible="false"/>',
        '<node id="9" action="delete" lat="50.00005" lon="10.001"><tag k="traffic_sign" v="gone"/></node>',
        '<way id="30" version="1"><nd ref="7"/><nd ref="1"/><tag k="barrier" v="wall"/></way>',
        '<way id="30" version="2"><nd ref="7"/><nd ref="2"/><tag k="barrier" v="fence"/></way>',
        '<way id="31" version="1"><nd ref="7"/><nd ref="2"/><tag k="highway" v="footway"/></way>',
        '<way id="31" version="2"><nd ref="7"/><nd ref="2"/><tag k="highway" v="path"/></way>',
        '<way id="32" version="2" visible="false"><tag k="barrier" v="wall"/></way>',
        '<way id="33"><nd ref="7"/><nd ref="99"/><tag k="barrier" v="wall"/></way>',
        '<way id="34"><nd ref="98"/><nd ref="99"/><tag k="barrier" v="wall"/></way>',
    ]
    path = tmp_path / "area.osm"
    path.write_text(document(elements), encoding="utf-8")
    network = parse_osm(path, ParseOptions(), Diagnostics())
    assert [(thing.osm_id, thing.node_ids.tolist()) for thing in network.roadside] == [
        ("way/30", [7, 2]),
        ("node/7", [7]),
    ]
    post = network.roadside[1].facts.sign_post
    assert post is not None
    assert [face.text for signs in post.signs for face in signs.faces] == ["new"]
    assert network.footways == ()


# ---------------------------------------------------------------- footways

WAY = ([1, 2, 3], "highway=residential")
NODES = {
    1: (0.0, 0.0),
    2: (100.0, 0.0),
    3: (200.0, 0.0),
    5: (100.0, 8.0),
    6: (100.0, -8.0),
    7: (100.0, 60.0),
    8: (0.0, 60.0),
    9: (300.0, 400.0),
}


@pytest.mark.parametrize(
    ("tags", "kept", "crossing"),
    [
        ("highway=footway", True, False),
        ("highway=footway footway=crossing", True, True),
        ("highway=cycleway cycleway=crossing", True, True),
        ("highway=path path=crossing", True, True),
        ("highway=footway footway=sidewalk", True, False),
        ("highway=pedestrian", True, False),
        ("highway=pedestrian area=yes", False, False),
        ("highway=path", False, False),
        ("highway=path foot=designated", True, False),
        ("highway=path bicycle=designated segregated=no", True, False),
        ("highway=steps", False, False),
        ("highway=corridor", False, False),
    ],
)
def test_kinds(tmp_path: Path, tags: str, kept: bool, crossing: bool) -> None:
    area = Area(NODES, {20: WAY, 30: ([5, 6], f"{tags} layer=1 name=A width=3")})
    network, _ = area.parse(tmp_path)
    assert [footway.osm_way_id for footway in network.footways] == ([30] if kept else [])
    for footway in network.footways:
        assert footway.crossing is crossing
        assert footway.node_ids.tolist() == [5, 6]
        places = footway.points - network.streets[0].points[0]
        assert places == pytest.approx(np.array([[100.0, 8.0], [100.0, -8.0]]), abs=0.05)
        expected = {**dict(item.split("=") for item in tags.split()), "layer": "1", "width": "3"}
        assert footway.tags == expected


def test_within_reach_or_on_a_node_of_a_street(tmp_path: Path) -> None:
    area = Area(
        NODES,
        {
            20: WAY,
            30: ([9, 5], "highway=footway"),
            31: ([2, 7], "highway=footway"),
            32: ([7, 8], "highway=footway"),
            -33: ([6, 5], "highway=footway"),
        },
    )
    network, _ = area.parse(tmp_path)
    assert [footway.osm_way_id for footway in network.footways] == [-33, 30, 31]
    assert network.footways[2].node_ids.tolist() == [2, 7]


def test_a_way_that_is_a_street_is_no_footway(tmp_path: Path) -> None:
    area = Area(NODES, {20: WAY, 30: ([2, 7], "highway=pedestrian")})
    network, _ = area.parse(tmp_path, ParseOptions(parse_ways_option("residential,pedestrian"), include_private=True))
    assert network.footways == ()
    assert len(network.streets) == 3


def test_absent_and_repeated_nodes_are_left_out(tmp_path: Path) -> None:
    nodes = {**NODES, 10: NODES[5]}
    area = Area(nodes, {20: WAY, 30: ([5, 10, 99, 6], "highway=footway"), 31: ([5, 10], "highway=footway")})
    network, _ = area.parse(tmp_path)
    assert [(footway.osm_way_id, footway.node_ids.tolist()) for footway in network.footways] == [(30, [5, 6])]
