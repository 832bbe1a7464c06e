"""Whole files: what cannot be read, and real places."""

from __future__ import annotations

import gzip
import itertools
import logging
import math
import random
from pathlib import Path

import numpy as np
import osmium
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from osm_builder import ONEWAY, ROAD, ROW, Area, about, document, nodes_of, ways_of, write_osm

from osm2xodr.diagnostics import Diagnostics, Kind
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
                "has no way to drive on: 1 footway, 1 residential left out; "
                "--include-private reads the 1 that are closed to cars"
            ),
        ),
        (
            Area(NODES, {20: ([1, 2], "highway=track")}),
            "has no way to drive on: 1 track left out; --ways track reads more of them",
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
            Area(
                {**NODES, 4: (11_622_000.0, 0.0), 5: (11_622_000.0, 90.0)},
                {20: ([1, 2, 3], "highway=primary"), 21: ([4, 5], "highway=primary")},
                lat_0=2.0,
            ),
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


def test_points_are_metres_from_the_middle(tmp_path: Path) -> None:
    network, _ = Area(ROW, {20: ([1, 2, 3, 12], ROAD)}).parse(tmp_path)
    (street,) = network.streets
    assert street.points - street.points[1] == pytest.approx(
        np.array([[-100, 0], [0, 0], [100, 0], [0, 100]]), abs=0.05
    )
    # The origin is rounded to 1e-5 degrees.
    assert street.points.min(axis=0) == pytest.approx([-100.0, -50.0], abs=0.6)
    assert not street.points.flags.writeable
    assert (network.frame.lat_0_deg, network.frame.lon_0_deg) == (50.00045, 10.00279)
    assert [(item.x, item.y) for item in network.intersections] == [tuple(street.points[0]), tuple(street.points[3])]
    assert network.bounds_deg == pytest.approx((10.0013948, 50.0, 10.0041843, 50.0008991), abs=1e-6)


def test_repeated_elements_count_once(tmp_path: Path) -> None:
    elements = Area(ROW, {20: ([1, 2], ROAD), 21: ([2, 3], ROAD)}).elements()
    diagnostics = Diagnostics()
    network = parse_osm(write_osm(tmp_path, elements + elements), ParseOptions(default_speeds=False), diagnostics)
    assert nodes_of(network) == [[1, 2, 3]]
    assert list(diagnostics) == []


def test_large_and_negative_ids(tmp_path: Path) -> None:
    big = 2**62
    area = Area(
        {big: (0.0, 0.0), -1: (50.0, 0.0), -big: (100.0, 0.0)}, {big: ([big, -1], ROAD), -big: ([-1, -big], ROAD)}
    )
    network, _ = area.parse(tmp_path)
    assert nodes_of(network) == [[big, -1, -big]]
    assert ways_of(network) == [[(big, False), (-big, False)]]


def same(one: StreetNetwork, other: StreetNetwork) -> bool:
    """Whether two networks are equal in all that they hold."""
    return (
        (one.frame, one.rule, one.country, one.intersections, one.restrictions, one.node_tags, one.bounds_deg)
        == (
            other.frame,
            other.rule,
            other.country,
            other.intersections,
            other.restrictions,
            other.node_tags,
            other.bounds_deg,
        )
        and list(one.node_tags) == list(other.node_tags)
        and len(one.streets) == len(other.streets)
        and all(
            (a.id, a.start, a.end, a.pieces) == (b.id, b.start, b.end, b.pieces)
            and a.points.tobytes() == b.points.tobytes()
            and a.node_ids.tobytes() == b.node_ids.tobytes()
            for a, b in zip(one.streets, other.streets, strict=True)
        )
    )


@st.composite
def areas(draw: st.DrawFn) -> Area:
    place = st.integers(0, 5)
    nodes = {
        number: (40.0 * draw(place), 40.0 * draw(place))
        for number in draw(st.lists(st.integers(1, 12), min_size=3, unique=True))
    }
    refs = st.lists(st.integers(1, 12), min_size=1, max_size=6)
    tags = st.sampled_from([ROAD, ONEWAY, "highway=primary oneway=-1", "highway=service", "highway=tertiary lanes=3"])
    ways = {
        number: (draw(refs), draw(tags))
        for number in draw(st.lists(st.integers(1, 99), min_size=1, max_size=8, unique=True))
    }
    marked = {number: "highway=stop" for number in list(nodes)[::2]}
    return Area(nodes, ways, node_tags=marked)


def parsed_or_error(path: Path) -> tuple[StreetNetwork | None, str, list[object]]:
    diagnostics = Diagnostics()
    try:
        return parse_osm(path, ParseOptions(), diagnostics), "", list(diagnostics)
    except Exception as error:  # whatever it is, it must be the same
        return None, f"{type(error).__name__} {error}", []


@given(areas(), st.randoms(use_true_random=False))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_the_order_of_elements_does_not_matter(tmp_path: Path, area: Area, rng: random.Random) -> None:
    elements = area.elements()
    one, error, said = parsed_or_error(write_osm(tmp_path, elements))
    shuffled = elements.copy()
    rng.shuffle(shuffled)
    other, other_error, other_said = parsed_or_error(write_osm(tmp_path, shuffled))
    assert (error, said) == (other_error, other_said)
    assert error == "" or error.startswith("InputError ")
    if one is not None and other is not None:
        assert same(one, other)


@given(areas())
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_what_holds_of_every_network(tmp_path: Path, area: Area) -> None:
    network, error, _ = parsed_or_error(area.write(tmp_path))
    if network is None:
        assert error.startswith("InputError ")
        return
    for number, street in enumerate(network.streets):
        assert street.id == number
        assert len(street.points) == len(street.node_ids) >= 2
        assert (np.hypot(*np.diff(street.points, axis=0).T) >= 1e-3).all()
        assert (street.start < 0) == (street.end < 0)
        assert street.start >= 0 or street.node_ids[0] == street.node_ids[-1]
        indices = [index for index, _ in street.pieces]
        assert indices == sorted(set(indices))
        assert indices[0] == 0
        assert indices[-1] < len(street.points) - 1
        for _, piece in street.pieces:
            assert Direction.FORWARD in {lane.direction for lane in piece.lanes_ltr}
    arms = sorted((street, at_start) for item in network.intersections for street, at_start in item.arms)
    assert arms == sorted((s.id, at_start) for s in network.streets if s.start >= 0 for at_start in (True, False))
    for item in network.intersections:
        for number, at_start in item.arms:
            street = network.streets[number]
            assert (street.start if at_start else street.end) == item.id
            assert street.node_ids[0 if at_start else -1] == item.osm_node_id
            assert tuple(street.points[0 if at_start else -1]) == (item.x, item.y)
    assert [item.osm_node_id for item in network.intersections] == sorted(
        i.osm_node_id for i in network.intersections
    )


@pytest.mark.parametrize(
    ("lat", "lon", "tags", "asked", "country", "rule", "codes"),
    [
        (50.0, 10.0, "", None, "DE", Rule.RIGHT_HAND, []),
        (51.5, -0.1, "", None, "GB", Rule.LEFT_HAND, []),
        (51.5, -0.1, "", Rule.RIGHT_HAND, "GB", Rule.RIGHT_HAND, []),
        (50.0, 10.0, "", Rule.LEFT_HAND, "DE", Rule.LEFT_HAND, []),
        # Most streets are tagged, or one of many.
        (50.0, 10.0, "driving_side=left", None, "DE", Rule.LEFT_HAND, []),
        (50.0, 10.0, "driving_side=left", Rule.RIGHT_HAND, "DE", Rule.RIGHT_HAND, ["driving-side"] * 2),
        (50.45, -1.0, "", None, "GB", Rule.LEFT_HAND, []),
        (50.2, -1.0, "", None, "", Rule.RIGHT_HAND, ["driving-side"]),
        (30.0, -40.0, "", None, "", Rule.RIGHT_HAND, ["driving-side"]),
    ],
)
def test_driving_side(
    tmp_path: Path, lat: float, lon: float, tags: str, asked: Rule | None, country: str, rule: Rule, codes: list[str]
) -> None:
    ways = {20: ([1, 2], f"{ROAD} {tags}"), 21: ([2, 3], f"{ROAD} {tags}"), 22: ([3, 4], ROAD)}
    network, diagnostics = Area(ROW, ways, lat_0=lat, lon_0=lon).parse(
        tmp_path, ParseOptions(rule=asked, default_speeds=False)
    )
    assert (network.country, network.rule) == (country, rule)
    assert [item.code for item in diagnostics] == codes
    runs = [int(lane.direction) for lane in network.streets[0].pieces[0][1].lanes_ltr]
    assert runs == ([-1, 1] if rule is Rule.RIGHT_HAND else [1, -1])


def test_a_single_exception_does_not_turn_the_city_round(tmp_path: Path) -> None:
    ways = {20: ([1, 2], ROAD), 21: ([2, 3], ROAD), 22: ([3, 4], ROAD + " driving_side=left")}
    network, diagnostics = Area(ROW, ways).parse(tmp_path)
    assert network.rule is Rule.RIGHT_HAND
    assert [(item.kind, item.code, item.osm_id) for item in diagnostics] == [(Kind.DROPPED, "driving-side", "way/22")]


def test_across_the_180th_meridian(tmp_path: Path) -> None:
    network, _ = Area(ROW, {20: ([1, 2, 3], ROAD)}, lat_0=-16.8, lon_0=179.998).parse(tmp_path)
    assert network.country == "FJ"
    assert network.frame.lon_0_deg == pytest.approx(-179.99921, abs=1e-5)
    west, _, east, _ = network.bounds_deg
    assert 179.999 < west < 180.0 < east < 180.01
    # Longitudes are shorter in metres at 50 than at 16.8 degrees.
    length = np.hypot(*np.diff(network.streets[0].points, axis=0).T)
    assert length == pytest.approx(
        np.full(2, 100.0 * math.cos(math.radians(16.8)) / math.cos(math.radians(50.0))), rel=2e-3
    )


def test_a_large_area_is_said(tmp_path: Path) -> None:
    _, diagnostics = Area({k: (42e3 * k, 0.0) for k in range(1, 7)}, {20: (range(1, 7), ROAD)}).parse(tmp_path)
    (item,) = diagnostics
    assert (item.kind, item.code) == (Kind.NOTE, "extent")
    assert "105 km" in item.message


@pytest.mark.parametrize(("metres", "kmh"), [(700.0, 50.0), (900.0, 110.0)])
@pytest.mark.parametrize("furniture", [True, False])
def test_streets_that_people_often_cross_have_the_limit_of_towns(
    tmp_path: Path, metres: float, kmh: float, furniture: bool
) -> None:
    # Two crossings for every 800 m at least. OSM's wiki, Default speed limits: in France 50 km/h in built-up areas,
    # 110 on dual carriageways outside of them.
    nodes = {1: (0.0, 0.0), 2: (100.0, 0.0), 3: (600.0, 0.0), 4: (metres, 0.0)}
    crossed = {2: "highway=crossing", 3: "highway=crossing crossing=marked"}
    area = Area(nodes, {20: ([1, 2, 3, 4], "highway=primary oneway=yes")}, {}, crossed, lon_0=2.5)
    network = parse_osm(write_osm(tmp_path, area.elements()), ParseOptions(furniture=furniture), Diagnostics())
    ((_, piece),) = network.streets[0].pieces
    assert piece.default_speed == pytest.approx(kmh / 3.6)


def test_of_several_classes_the_first_is_taken(tmp_path: Path) -> None:
    ways = {20: ([1, 2], "highway=primary;secondary"), 21: ([2, 3], "highway=footway;service")}
    network, diagnostics = Area(ROW, ways).parse(tmp_path)
    assert [street.pieces[0][1].highway for street in network.streets] == ["primary"]
    said = [(item.osm_id, item.kind, item.message) for item in about(diagnostics, "highway-class")]
    assert ("way/20", Kind.GUESSED, "highway=primary;secondary has several classes, the first is taken") in said
