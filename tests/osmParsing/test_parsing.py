"""Whole files: what cannot be read, and real places."""

from __future__ import annotations

import gzip
import itertools
import logging
from pathlib import Path

import osmium
import pytest
from osm_builder import Area, about, document

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.model import Direction, LaneType, Rule, StreetNetwork, Structure
from osm2xodr.osmParsing import ParseOptions, parse_osm, parse_ways_option
from osm2xodr.projection import make_frame

ROOT = Path(__file__).parents[2]
ORDINO = ROOT / "data/samples/andorra_ordino/area.osm"
NODES = {1: (0.0, 0.0), 2: (100.0, 0.0), 3: (200.0, 0.0)}


@pytest.mark.parametrize(
    ("area", "words"),
    [
        (Area({}), "has no nodes and no ways; check the area that it covers"),
        (Area(NODES), "has no ways with highway=*; export the area with its roads"),
        (
            Area(NODES, {20: ([1, 2], "highway=footway"), 21: ([2, 3], "highway=residential access=private")}),
            (
                "has no way to drive on, all 2 ways with highway=* are left out; --ways all reads more kinds of "
                "ways, --include-private reads the 1 that are closed to cars"
            ),
        ),
        (
            Area(NODES, {20: ([1, 2], "highway=track")}),
            "has no way to drive on, all 1 ways with highway=* are left out; --ways all reads more kinds of ways",
        ),
        (
            Area({1: (0.0, 0.0)}, {20: ([8, 9], "highway=primary")}),
            "has ways but not the nodes that they are made of; export the area with its nodes",
        ),
        (
            Area({1: (0.0, 0.0), 2: (0.0004, 0.0)}, {20: ([1, 2], "highway=primary")}),
            "has no way of any length to drive on; check the area that it covers",
        ),
        (
            Area(NODES, {20: ([1, 2], "highway=primary")}, lat_0=-85.5),
            (
                "reaches to latitude -85.50, but the local projection is of use up to 84 degrees; "
                "choose an area off the poles"
            ),
        ),
        (
            Area({**NODES, 4: (11_622_000.0, 0.0)}, {20: ([1, 2, 3, 4], "highway=primary")}, lat_0=2.0),
            (
                "reaches over 162 degrees of longitude, but the local projection is of use over 160; "
                "choose a smaller area, without node/4"
            ),
        ),
    ],
)
def test_nothing_to_drive_on(tmp_path: Path, area: Area, words: str) -> None:
    path = area.write(tmp_path)
    with pytest.raises(InputError) as caught:
        parse_osm(path, ParseOptions(), Diagnostics())
    assert str(caught.value) == f"{path} {words}"


def test_an_origin_on_the_other_side_of_the_earth(tmp_path: Path) -> None:
    path = Area(NODES, {20: ([1, 2, 3], "highway=primary")}, lat_0=1.0).write(tmp_path)
    with pytest.raises(InputError) as caught:
        parse_osm(path, ParseOptions(frame=make_frame(1.0, 100.0)), Diagnostics())
    assert str(caught.value) == (
        f"{path} reaches to the other side of the Earth from the origin at 1, 100; give an origin near it"
    )


def test_a_compressed_bomb_is_refused_at_once(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    entities = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 50}">' for k in range(1, 12))
    text = document([]).replace("<osm", f'<!DOCTYPE osm [<!ENTITY e0 "x">{entities}]><osm')
    path = tmp_path / "bomb.osm.gz"
    path.write_bytes(gzip.compress(text.encode()))
    with caplog.at_level(logging.DEBUG), pytest.raises(InputError, match="document type declaration"):
        parse_osm(path, ParseOptions(), Diagnostics())


# ---------------------------------------------------------------- real places


def drivable(path: Path) -> dict[int, tuple[list[int], dict[str, str]]]:
    """Ways of a file that must be carried, read anew: cars may use them, and all of their nodes are there."""
    classes = {
        *("motorway", "trunk", "primary", "secondary", "tertiary", "unclassified", "residential", "living_street"),
        *("motorway_link", "trunk_link", "primary_link", "secondary_link", "tertiary_link"),
    }
    found = {}
    for item in osmium.FileProcessor(str(path), osmium.osm.WAY):
        assert isinstance(item, osmium.osm.Way)
        tags = {tag.k: tag.v for tag in item.tags}
        access = next((tags[key] for key in ("motorcar", "motor_vehicle", "vehicle", "access") if key in tags), "yes")
        if tags.get("highway") in classes and access in {"yes", "destination", "permissive", "customers"}:
            found[item.id] = [node.ref for node in item.nodes], tags
    return found


def edges(network: StreetNetwork) -> set[tuple[int, int, int]]:
    """All steps from node to node on streets: way, node, node along the way."""
    found = set()
    for street in network.streets:
        ids = street.node_ids.tolist()
        starts = [index for index, _ in street.pieces] + [len(ids) - 1]
        for (begin, piece), end in zip(street.pieces, starts[1:], strict=True):
            for a, b in zip(ids[begin:end], ids[begin + 1 : end + 1], strict=True):
                found.add((piece.osm_way_id, *((b, a) if piece.reversed else (a, b))))
    return found


SCENES = sorted([ORDINO, *(ROOT / "tests/scenes").glob("*/area.osm*")])


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.parent.name)
def test_every_step_of_every_way_is_carried_once(path: Path) -> None:
    network = parse_osm(path, ParseOptions(), Diagnostics())
    carried = edges(network)
    expected = {
        (number, a, b) for number, (refs, _) in drivable(path).items() for a, b in itertools.pairwise(refs) if a != b
    }
    assert expected <= carried
    assert len(carried) == sum(len(street.node_ids) - 1 for street in network.streets)


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.parent.name)
def test_lanes_and_limits_are_those_of_the_tags(path: Path) -> None:
    network = parse_osm(path, ParseOptions(), Diagnostics())
    pieces = {piece.osm_way_id: piece for street in network.streets for _, piece in street.pieces}
    motor = {LaneType.DRIVING, LaneType.BUS, LaneType.TAXI}
    compared = 0
    for number, (_, tags) in drivable(path).items():
        piece = pieces[number]
        lanes = sum(lane.type in motor for lane in piece.lanes_ltr)
        two_way = {lane.direction for lane in piece.lanes_ltr} >= {Direction.FORWARD, Direction.BACKWARD}
        if tags.get("lanes", "").isdigit():
            assert lanes == max(int(tags["lanes"]), 2 if two_way else 1), number
            compared += 1
        if tags.get("maxspeed", "").isdigit() and not any(key.startswith("maxspeed:") for key in tags):
            assert piece.speed_forward == pytest.approx(int(tags["maxspeed"]) / 3.6)
        if tags.get("oneway") in {"yes", "no", "-1"}:
            assert two_way == (tags["oneway"] == "no"), number
            assert two_way or piece.reversed == (tags["oneway"] == "-1"), number
    assert compared >= 3


def test_ordino() -> None:
    diagnostics = Diagnostics()
    network = parse_osm(ORDINO, ParseOptions(), diagnostics)
    assert (network.country, network.rule) == ("AD", Rule.RIGHT_HAND)
    assert (len(network.streets), len(network.intersections), len(network.restrictions)) == (173, 140, 13)
    assert sum(item.osm_node_id in network.node_tags for item in network.intersections) > 0
    structures = [piece.structure for street in network.streets for _, piece in street.pieces]
    assert structures.count(Structure.BRIDGE) >= 10
    assert [item.osm_id for item in about(diagnostics, "closed")] != []
    everything = parse_osm(ORDINO, ParseOptions(parse_ways_option("all"), include_private=True), Diagnostics())
    assert len(everything.streets) > len(network.streets)
    major = parse_osm(ORDINO, ParseOptions(parse_ways_option("major")), Diagnostics())
    assert 0 < len(major.streets) < len(network.streets)
    classes = {piece.highway for street in major.streets for _, piece in street.pieces}
    assert classes <= {"primary", "secondary", "tertiary", "trunk"}


def test_fremantle_drives_on_the_left() -> None:
    network = parse_osm(ROOT / "tests/scenes/fremantle_placement/area.osm.gz", ParseOptions(), Diagnostics())
    assert (network.country, network.rule) == ("AU", Rule.LEFT_HAND)
    two_way = [
        [lane.direction for lane in piece.lanes_ltr]
        for street in network.streets
        for _, piece in street.pieces
        if len({lane.direction for lane in piece.lanes_ltr}) > 1
    ]
    assert two_way
    assert all(runs == sorted(runs, reverse=True) for runs in two_way)
