"""Cutting areas out of maps made by hand."""

from __future__ import annotations

import gzip
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import osmium
import pytest
from osm_builder import LAT_0, LON_0, Area, write_osm
from riverside import RIVERSIDE, ROADS_ALONE, SIDE, WITH_SURROUNDINGS

from osm2xodr import projection
from osm2xodr.batching import cutting
from osm2xodr.batching.cutting import bounds_of, cut_areas, source as cut_source
from osm2xodr.batching.model import CutRequest
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError, OutputError
from osm2xodr.model import Outline
from osm2xodr.osmParsing import ParseOptions, parse_osm
from osm2xodr.osmParsing.options import parse_ways_option

SAMPLE = Path(__file__).parents[3] / "data" / "samples" / "andorra_ordino" / "area.osm"
FRAME = projection.make_frame(LAT_0, LON_0)
ROAD = "highway=residential"


def box(west: float, south: float, east: float, north: float) -> Outline:
    return Outline((np.array([[west, south], [east, south], [east, north], [west, north]], np.float64),))


def request(folder: Path, outline: Outline, name: str = "one", *, context: bool = False) -> CutRequest:
    return CutRequest(name, folder / f"{name}.osm.pbf", FRAME, outline, context)


def cut(folder: Path, area: Area, outline: Outline, *, context: bool = False) -> dict[str, list[int]]:
    """Return the ids of what is in the cut, by kind."""
    wanted = request(folder, outline, context=context)
    cut_areas(area.write(folder), [wanted])
    return contents(wanted.target)


def contents(path: Path) -> dict[str, list[int]]:
    out: dict[str, list[int]] = {"n": [], "w": [], "r": []}
    for item in osmium.FileProcessor(str(path)):
        out[item.type_str()].append(item.id)
    return out


def row(xs: Iterable[float], y: float = 0.0, first: int = 1) -> dict[int, tuple[float, float]]:
    return {first + index: (x, y) for index, x in enumerate(xs)}


# ---------------------------------------------------------------- ways


def test_a_way_with_one_node_in_the_area_is_kept_whole(tmp_path: Path) -> None:
    nodes = {**row([-500.0, 0.0, 500.0, 900.0]), **row([300.0, 400.0], 300.0, 11)}
    area = Area(nodes, {1: ([1, 2, 3, 4], ROAD), 2: ([11, 12], ROAD)})
    found = cut(tmp_path, area, box(-100, -100, 100, 100))
    assert found == {"n": [1, 2, 3, 4], "w": [1], "r": []}


def test_a_segment_through_the_area_is_enough(tmp_path: Path) -> None:
    # One way crosses a corner, the other passes it just outside.
    nodes = {1: (-500.0, 390.0), 2: (390.0, -500.0), 3: (-500.0, 300.0), 4: (300.0, -505.0)}
    area = Area(nodes, {1: ([1, 2], ROAD), 2: ([3, 4], ROAD)})
    outline = box(-100, -100, 100, 100)
    assert cut(tmp_path, area, outline)["w"] == [1]
    # Turned by half a turn, corner to corner.
    turned = Area({number: (-x, -y) for number, (x, y) in nodes.items()}, area.ways)
    assert cut(tmp_path, turned, outline)["w"] == [1]


def test_holes_are_not_of_the_area(tmp_path: Path) -> None:
    outline = Outline((*box(-500, -500, 500, 500).rings, *box(-200, -200, 200, 200).rings))
    nodes = {**row([-50.0, 50.0]), **row([-50.0, 250.0], 20.0, 11)}
    assert cut(tmp_path, Area(nodes, {1: ([1, 2], ROAD), 2: ([11, 12], ROAD)}), outline)["w"] == [2]


def test_what_is_read_beside_streets_is_kept_and_nothing_else(tmp_path: Path) -> None:
    ways = {
        1: ROAD,
        2: "railway=tram",
        3: "railway=rail",
        4: "barrier=kerb",
        5: "barrier=gate",
        6: "highway=footway footway=crossing",
        7: "highway=construction",
        8: "natural=tree_row",
        9: "natural=water",
        10: "building=yes",
        11: "public_transport=platform",
        12: "highway=odd",
    }
    area = Area(row([0.0, 50.0]), {number: ([1, 2], tags) for number, tags in ways.items()})
    assert cut(tmp_path, area, box(-100, -100, 100, 100))["w"] == [1, 2, 4, 6, 7, 8, 11, 12]


def test_nodes_that_stand_for_something_are_kept_in_the_area_only(tmp_path: Path) -> None:
    tags = {
        10: "traffic_sign=DE:274",
        11: "highway=traffic_signals",
        12: "highway=street_lamp",
        13: "natural=tree",
        14: "highway=bus_stop",
        15: "amenity=bench",
        16: "barrier=bollard",
        17: "natural=tree",
    }
    nodes = {**row([0.0, 50.0]), **{number: (10.0, 20.0) for number in tags}, 17: (10.0, 150.0)}
    area = Area(nodes, {1: ([1, 2], ROAD)}, node_tags=tags)
    assert cut(tmp_path, area, box(-100, -100, 100, 100))["n"] == [1, 2, 10, 11, 12, 13, 14, 16]


def test_all_tags_are_kept_and_who_made_them_is_not(tmp_path: Path) -> None:
    source = write_osm(
        tmp_path,
        [
            '<node id="1" version="3" user="someone" uid="7" changeset="9" lat="50.0" lon="10.0">',
            '<tag k="note" v="here"/><tag k="ele" v="12"/></node>',
            '<node id="2" lat="50.001" lon="10.0"/>',
            '<way id="1" version="2" user="someone"><nd ref="1"/><nd ref="2"/>',
            '<tag k="highway" v="service"/><tag k="note:de" v="hier"/></way>',
        ],
    )
    wanted = request(tmp_path, box(-500, -500, 500, 500))
    cut_areas(source, [wanted])
    found = [(item.id, dict(item.tags), item.user) for item in osmium.FileProcessor(str(wanted.target))]
    assert found == [
        (1, {"note": "here", "ele": "12"}, ""),
        (2, {}, ""),
        (1, {"highway": "service", "note:de": "hier"}, ""),
    ]
    assert b"someone" not in wanted.target.read_bytes()


# ---------------------------------------------------------------- relations


def crossing(relations: Mapping[int, tuple[Sequence[tuple[str, int, str]], str]]) -> Area:
    """Five ways in a row of 400 m each, and one that leaves the first joint to the north."""
    nodes = {**row([0.0, 400.0, 800.0, 1200.0, 1600.0, 2000.0]), 7: (400.0, 400.0)}
    ways = {number: ([number, number + 1], ROAD) for number in range(1, 6)}
    return Area(nodes, {**ways, 6: ([2, 7], ROAD)}, relations)


def test_relations_about_a_way_bring_along_what_they_name(tmp_path: Path) -> None:
    turn = "type=restriction restriction=no_left_turn"
    area = crossing(
        {
            1: ([("way", 1, "from"), ("way", 2, "via"), ("way", 3, "to")], turn),
            2: ([("way", 3, "from"), ("node", 4, "via"), ("way", 4, "to")], turn),
            3: ([("way", 2, "from"), ("node", 3, "via"), ("way", 3, "to")], "type=connectivity connectivity=1:1"),
            4: ([("way", 1, "")], "type=route route=bus"),
            5: ([("way", 6, "from"), ("node", 2, "via"), ("way", 99, "to")], turn),
        }
    )
    # Only the first way is in the area; relation 3 needs nothing more once relation 1 is there.
    found = cut(tmp_path, area, box(-100, -100, 100, 100))
    assert found == {"n": [1, 2, 3, 4, 7], "w": [1, 2, 3, 6], "r": [1, 3, 5]}
    network, _ = Area.parse(area, tmp_path)
    kept = parse_osm(tmp_path / "one.osm.pbf", ParseOptions(), Diagnostics())
    assert [item.osm_relation_id for item in network.restrictions] == [1, 2]
    assert [item.osm_relation_id for item in kept.restrictions] == [1]


# ---------------------------------------------------------------- buildings and water

AROUND = box(-SIDE, -SIDE, SIDE, SIDE)


def cut_with_surroundings(source: Path, *, context: bool = False) -> Path:
    """Return a cut of the riverside with its buildings and water."""
    wanted = replace(request(source.parent, AROUND, context=context), surroundings=True)
    cut_areas(source, [wanted])
    return wanted.target


def test_buildings_and_water_on_request(tmp_path: Path) -> None:
    source = RIVERSIDE.write(tmp_path)
    cut_areas(source, [request(tmp_path, AROUND)])
    assert tuple(contents(tmp_path / "one.osm.pbf").values()) == ROADS_ALONE
    assert tuple(contents(cut_with_surroundings(source)).values()) == WITH_SURROUNDINGS


def test_what_only_outlines_need_means_nothing_to_conversions(tmp_path: Path) -> None:
    path = cut_with_surroundings(RIVERSIDE.write(tmp_path))
    tags = {(item.type_str(), item.id): dict(item.tags) for item in osmium.FileProcessor(str(path))}
    assert tags["n", 22] == {}
    assert tags["w", 41] == {"height": "2"}
    # A wall in the area stays one.
    assert tags["w", 80] == {"natural": "water", "barrier": "wall"}
    # With the surroundings of streets both belong to the map anyway.
    tags = {
        (item.type_str(), item.id): dict(item.tags)
        for item in osmium.FileProcessor(str(cut_with_surroundings(tmp_path / "area.osm", context=True)))
    }
    assert tags["n", 22] == {"traffic_sign": "DE:274-30", "direction": "90"}
    assert tags["w", 41] == {"barrier": "wall", "height": "2"}


def test_requests_with_and_without_buildings_share_a_pass(tmp_path: Path) -> None:
    source = RIVERSIDE.write(tmp_path)
    wanted = [request(tmp_path, AROUND, "a"), replace(request(tmp_path, AROUND, "b"), surroundings=True)]
    cut_areas(source, wanted)
    alone = request(tmp_path, AROUND, "c")
    cut_areas(source, [alone])
    assert wanted[0].target.read_bytes() == alone.target.read_bytes()
    assert tuple(contents(wanted[1].target).values()) == WITH_SURROUNDINGS


def test_the_order_of_elements_does_not_matter(tmp_path: Path) -> None:
    first = cut_with_surroundings(RIVERSIDE.write(tmp_path)).read_bytes()
    (tmp_path / "other").mkdir()
    second = cut_with_surroundings(write_osm(tmp_path / "other", RIVERSIDE.elements()[::-1])).read_bytes()
    found = [
        [(str(item), dict(item.tags)) for item in osmium.FileProcessor(osmium.io.FileBuffer(data, "pbf"))]
        for data in (first, second)
    ]
    assert found[0] == found[1]


def test_a_cut_of_a_cut_is_the_same(tmp_path: Path) -> None:
    path = cut_with_surroundings(RIVERSIDE.write(tmp_path))
    (tmp_path / "again").mkdir()
    wanted = replace(request(tmp_path / "again", AROUND), surroundings=True)
    cut_areas(path, [wanted])
    assert wanted.target.read_bytes() == path.read_bytes()


def test_ways_of_relations_are_no_streets(tmp_path: Path) -> None:
    """Corrections keep ways that become streets; an outline that they name does not."""
    wanted = replace(request(tmp_path, AROUND), surroundings=True, kept=frozenset({40}))
    assert cut_areas(RIVERSIDE.write(tmp_path), [wanted]) == {"one": 2}


# ---------------------------------------------------------------- surroundings


def test_streets_that_come_near_are_kept_to_their_ends(tmp_path: Path) -> None:
    # Ways of 1 km in a row to the east, up to a crossing at 5 km; beyond it only what is within 200 m.
    nodes = {
        **row([1000.0 * number for number in range(8)]),
        20: (5000.0, 150.0),
        21: (5000.0, 900.0),
        30: (5190.0, 50.0),
        31: (5190.0, 90.0),
        32: (5250.0, 50.0),
        33: (5250.0, 90.0),
        40: (5100.0, 30.0),
        41: (5100.0, 230.0),
    }
    ways = {number: ([number, number + 1], ROAD) for number in range(1, 8)}
    ways |= {
        20: ([6, 20], ROAD),
        21: ([20, 21], ROAD),
        30: ([30, 31], "barrier=wall"),
        32: ([32, 33], "barrier=wall"),
    }
    area = Area(nodes, ways, node_tags={40: "traffic_sign=stop", 41: "traffic_sign=stop"})
    outline = box(-300, -300, 200, 300)
    assert cut(tmp_path, area, outline)["w"] == [1]
    found = cut(tmp_path, area, outline, context=True)
    assert found["w"] == [1, 2, 3, 4, 5, 6, 20, 21, 30]
    assert found["n"] == [1, 2, 3, 4, 5, 6, 7, 20, 21, 30, 31, 40]


def test_only_streets_within_reach_of_the_border_go_on(tmp_path: Path) -> None:
    # 450 m off: kept as it is, but the next way of the same street is not.
    nodes = {**row([650.0, 1000.0, 2000.0]), **row([0.0, 50.0], 0.0, 11)}
    area = Area(nodes, {1: ([1, 2], ROAD), 2: ([2, 3], ROAD), 3: ([11, 12], ROAD)})
    outline = box(-200, -200, 200, 200)
    assert cut(tmp_path, area, outline, context=True)["w"] == [1, 3]
    moved = Area({**nodes, 1: (450.0, 0.0)}, area.ways)
    assert cut(tmp_path, moved, outline, context=True)["w"] == [1, 2, 3]
    # So far off is none of it.
    gone = Area({**nodes, 1: (750.0, 0.0)}, area.ways)
    assert cut(tmp_path, gone, outline, context=True)["w"] == [3]


def test_streets_go_on_over_ways_that_are_usually_left_out(tmp_path: Path) -> None:
    nodes = {**row([0.0, 1000.0, 2000.0, 3000.0]), 10: (1000.0, 100.0)}
    ways = {number: ([number, number + 1], ROAD) for number in (1, 2, 3)}
    drive = Area(nodes, {**ways, 10: ([2, 10], "highway=service service=driveway")})
    outline = box(-200, -200, 200, 200)
    assert cut(tmp_path, drive, outline, context=True)["w"] == [1, 2, 3, 10]
    lane = Area(nodes, {**ways, 10: ([2, 10], "highway=service")})
    assert cut(tmp_path, lane, outline, context=True)["w"] == [1, 2, 10]


def test_what_becomes_a_street_can_be_said(tmp_path: Path) -> None:
    nodes = {**row([0.0, 1000.0, 2000.0, 3000.0]), 10: (1000.0, 100.0)}
    ways = {number: ([number, number + 1], "highway=primary") for number in (1, 2, 3)}
    source = Area(nodes, {**ways, 10: ([2, 10], ROAD), 11: ([1, 10], "highway=track access=private")}).write(tmp_path)
    target, outline = tmp_path / "one.osm.pbf", box(-200, -200, 200, 200)
    found = {}
    for name in ("major", "drivable", "all"):
        wanted = CutRequest("one", target, FRAME, outline, True, parse_ways_option(name))
        found[name] = cut_areas(source, [wanted])["one"], contents(target)["w"]
    # The residential street is no end of a major one.
    assert found == {"major": (1, [1, 2, 3, 10, 11]), "drivable": (1, [1, 2, 10, 11]), "all": (1, [1, 2, 10, 11])}
    wanted = CutRequest("one", target, FRAME, outline, True, parse_ways_option("all"), True)
    assert cut_areas(source, [wanted]) == {"one": 2}
    wanted = CutRequest("one", target, FRAME, outline, True, parse_ways_option("motorway"))
    assert cut_areas(source, [wanted]) == {"one": 0}
    assert not target.exists()


def test_what_lies_beside_these_streets_is_kept_all_along(tmp_path: Path) -> None:
    # A sidewalk in the middle of a road of 6 km says that all of it is in a built-up area.
    nodes = {**row([0.0, 6000.0]), **row([3000.0, 3100.0], 8.0, 11), **row([3000.0, 3100.0], 200.0, 21)}
    nodes |= {31: (4000.0, 20.0), 32: (4000.0, 200.0)}
    ways = {1: ([1, 2], "highway=tertiary"), 2: ([11, 12], "highway=footway"), 3: ([21, 22], "highway=footway")}
    area = Area(nodes, ways, node_tags={31: "highway=bus_stop", 32: "highway=bus_stop"})
    found = cut(tmp_path, area, box(-200, -200, 200, 200), context=True)
    assert found == {"n": [1, 2, 11, 12, 31], "w": [1, 2], "r": []}


def test_a_ring_is_kept_whole(tmp_path: Path) -> None:
    nodes = {1: (0.0, 0.0), 2: (2000.0, 0.0), 3: (2000.0, 2000.0), 4: (0.0, 2000.0)}
    ways = {1: ([1, 2], ROAD), 2: ([2, 3], ROAD), 3: ([3, 4, 1], ROAD)}
    assert cut(tmp_path, Area(nodes, ways), box(-200, -200, 200, 200), context=True)["w"] == [1, 2, 3]


def test_neighbours_hold_the_same_where_a_road_crosses_their_border(tmp_path: Path) -> None:
    source = Path(SAMPLE)
    west, south, east, north = bounds_of(source)
    frame = projection.make_frame((south + north) / 2.0, (west + east) / 2.0)
    low = CutRequest("low", tmp_path / "low.osm.pbf", frame, box(-5000, -5000, 5000, 0), True)
    high = CutRequest("high", tmp_path / "high.osm.pbf", frame, box(-5000, 0, 5000, 5000), True)
    cut_areas(source, [low, high])
    networks = [parse_osm(item.target, ParseOptions(frame=frame), Diagnostics()) for item in (low, high)]
    near = [
        {
            (street.node_ids.tobytes(), street.points.tobytes(), street.pieces)
            for street in network.streets
            if np.abs(street.points[:, 1]).min() <= 300.0
        }
        for network in networks
    ]
    assert len(near[0]) > 20
    assert near[0] == near[1]


# ---------------------------------------------------------------- files


def test_counts_are_of_ways_in_the_area_and_empty_areas_leave_no_file(tmp_path: Path) -> None:
    area = Area(
        {**row([0.0, 50.0]), **row([1000.0, 1050.0], 0.0, 11)},
        {
            1: ([1, 2], ROAD),
            2: ([1, 2], "highway=footway"),
            3: ([11, 12], "highway=path"),
            4: ([1, 2], "highway=track"),
        },
    )
    wanted = [
        request(tmp_path, box(-100, -100, 100, 100), "full"),
        request(tmp_path, box(900, -100, 1100, 100), "walkers"),
        request(tmp_path, box(200, -100, 300, 100), "beside", context=True),
    ]
    wanted[1].target.write_bytes(b"of an earlier run")
    assert cut_areas(area.write(tmp_path), wanted) == {"full": 1, "walkers": 0, "beside": 0}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["area.osm", "full.osm.pbf"]


def test_several_areas_at_once_are_as_one_by_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    area = Area(
        row([300.0 * number for number in range(12)]),
        {number: ([number, number + 1], ROAD) for number in range(1, 12)},
        node_tags={5: "highway=crossing"},
    )
    source = area.write(tmp_path)
    outlines = [box(500.0 * number, -100, 500.0 * number + 500.0, 100) for number in range(5)]
    alone = []
    for number, outline in enumerate(outlines):
        wanted = request(tmp_path, outline, f"alone{number}")
        cut_areas(source, [wanted])
        alone.append(wanted.target.read_bytes())
    # In three groups.
    monkeypatch.setattr(cutting, "_OPEN_MAX", 2)
    together = [request(tmp_path, outline, f"all{number}") for number, outline in enumerate(outlines)]
    cut_areas(source, together)
    assert [item.target.read_bytes() for item in together] == alone
    assert len(set(alone)) == 5


def test_the_header_says_what_it_is(tmp_path: Path) -> None:
    wanted = request(tmp_path, box(-1000, -1000, 1000, 1000))
    cut_areas(Area(row([0.0, 50.0]), {1: ([1, 2], ROAD)}).write(tmp_path), [wanted])
    header = osmium.io.Reader(str(wanted.target), osmium.osm.NOTHING).header()
    assert (header.get("generator"), header.get("sorting")) == ("osm2xodr", "Type_then_ID")
    corners = header.box().bottom_left, header.box().top_right
    lon, lat = projection.to_geographic(FRAME, [-1000.0, 1000.0], [-1000.0, 1000.0])
    # The widest of the box's sides.
    assert [corner.lat for corner in corners] == pytest.approx(lat, abs=2e-5)
    assert [corner.lon for corner in corners] == pytest.approx(lon, abs=2e-5)


@pytest.mark.parametrize("large", [0, 1 << 40], ids=["by id", "all"])
def test_the_newest_of_several_versions_counts_whatever_the_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, large: int
) -> None:
    monkeypatch.setattr(cut_source, "_LARGE", large)
    tagged = '<tag k="highway" v="service"/><tag k="lanes" v="{}"/></way>'
    source = write_osm(
        tmp_path,
        [
            '<relation id="4" version="1"><member type="way" ref="5" role="from"/>',
            '<tag k="type" v="restriction"/></relation>',
            '<way id="9" version="1"><nd ref="2"/><nd ref="3"/><tag k="highway" v="service"/></way>',
            '<way id="5" version="2"><nd ref="1"/><nd ref="2"/>' + tagged.format(2),
            '<way id="5" version="1"><nd ref="1"/><nd ref="3"/>' + tagged.format(1),
            '<way id="6" version="1" action="delete"><nd ref="1"/><nd ref="3"/><tag k="highway" v="service"/></way>',
            '<node id="3" version="1" lat="50.0" lon="10.002"/>',
            '<node id="2" version="2" lat="50.0" lon="10.001"><tag k="ele" v="2"/></node>',
            '<node id="2" version="1" lat="50.5" lon="10.001"><tag k="ele" v="1"/></node>',
            '<node id="1" version="1" lat="50.0" lon="10.0"/>',
        ],
    )
    wanted = request(tmp_path, box(-1000, -1000, 1000, 1000))
    assert cut_areas(source, [wanted]) == {"one": 2}
    assert contents(wanted.target) == {"n": [1, 2, 3], "w": [5, 9], "r": [4]}
    tags = {(item.type_str(), item.id): dict(item.tags) for item in osmium.FileProcessor(str(wanted.target))}
    assert tags["n", 2] == {"ele": "2"}
    assert tags["w", 5] == {"highway": "service", "lanes": "2"}
    nodes = (item for item in osmium.FileProcessor(str(wanted.target)) if isinstance(item, osmium.osm.Node))
    places = {node.id: node.location.lat for node in nodes}
    assert places == {1: 50.0, 2: 50.0, 3: 50.0}


def test_large_files_are_read_to_the_same_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = CutRequest(
        "one", tmp_path / "one.osm.pbf", projection.make_frame(42.555, 1.533), box(-800, -800, 300, 500)
    )
    cut_areas(SAMPLE, [wanted])
    expected = wanted.target.read_bytes()
    monkeypatch.setattr(cut_source, "_LARGE", 0)
    cut_areas(SAMPLE, [wanted])
    assert wanted.target.read_bytes() == expected


def test_ids_of_editors_are_kept(tmp_path: Path) -> None:
    nodes = {-1: (0.0, 0.0), -2: (50.0, 0.0), 3: (100.0, 0.0)}
    found = cut(tmp_path, Area(nodes, {-7: ([-1, -2, 3], ROAD)}), box(-500, -500, 500, 500))
    assert found == {"n": [-1, -2, 3], "w": [-7], "r": []}


def test_nodes_that_are_not_there_are_passed_over(tmp_path: Path) -> None:
    area = Area(row([0.0, 50.0]), {1: ([1, 99, 2], ROAD), 2: ([97, 98], ROAD)})
    found = cut(tmp_path, area, box(-500, -500, 500, 500))
    assert found == {"n": [1, 2], "w": [1], "r": []}


def test_areas_on_both_sides_of_the_180th_meridian(tmp_path: Path) -> None:
    area = Area(
        {1: (-300.0, 0.0), 2: (300.0, 0.0), 3: (5000.0, 0.0), 4: (6000.0, 0.0)},
        {1: ([1, 2], ROAD), 2: ([3, 4], ROAD)},
        lat_0=-17.0,
        lon_0=180.0,
    )
    source = area.write(tmp_path)
    west, south, east, north = bounds_of(source)
    assert west == pytest.approx(179.996, abs=1e-3)
    assert east == pytest.approx(180.084, abs=1e-3)
    assert (south, north) == pytest.approx((-17.0, -17.0))
    for name, lon in (("west", 179.9999), ("east", -179.9999)):
        frame = projection.make_frame(-17.0, lon)
        wanted = CutRequest(name, tmp_path / f"{name}.osm.pbf", frame, box(-100, -100, 100, 100), True)
        assert cut_areas(source, [wanted]) == {name: 1}
        assert contents(wanted.target)["w"] == [1]


def test_bounds_are_those_of_roads(tmp_path: Path) -> None:
    area = Area(
        {1: (0.0, 0.0), 2: (1000.0, 500.0), 3: (-9000.0, 0.0)},
        {1: ([1, 2], "highway=track"), 2: ([1, 3], "highway=footway")},
    )
    lon, lat = LON_0 + 1000.0 / 71_696.0, LAT_0 + 500.0 / 111_229.0
    assert bounds_of(area.write(tmp_path)) == pytest.approx((LON_0, LAT_0, lon, lat), abs=2e-7)
    assert bounds_of(area.write(tmp_path)) == bounds_of(_zipped(tmp_path / "area.osm"))


def _zipped(path: Path) -> Path:
    out = path.with_name("area.osm.gz")
    out.write_bytes(gzip.compress(path.read_bytes()))
    return out


# ---------------------------------------------------------------- what goes wrong


def test_bad_sources_are_named(tmp_path: Path) -> None:
    wanted = request(tmp_path, box(-500, -500, 500, 500))
    with pytest.raises(InputError, match=r"nowhere\.osm does not exist"):
        cut_areas(tmp_path / "nowhere.osm", [wanted])
    broken = tmp_path / "broken.osm"
    broken.write_text('<osm version="0.6"><node id="1" lat="50" lon="10"/><way id="1">', encoding="utf-8")
    for attempt in (lambda: cut_areas(broken, [wanted]), lambda: bounds_of(broken)):
        with pytest.raises(InputError, match=r"broken\.osm cannot be read as OSM data"):
            attempt()
    with pytest.raises(InputError, match="no way that cars can drive on"):
        bounds_of(Area(row([0.0, 50.0]), {1: ([1, 2], "highway=footway")}).write(tmp_path))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["area.osm", "broken.osm"]


def test_targets_that_cannot_be_written_are_named_and_nothing_is_left(tmp_path: Path) -> None:
    source = Area(row([0.0, 50.0]), {1: ([1, 2], ROAD)}).write(tmp_path)
    good = request(tmp_path, box(-500, -500, 500, 500))
    bad = CutRequest("bad", tmp_path / "none" / "bad.osm.pbf", FRAME, good.outline)
    with pytest.raises(OutputError, match=r"bad\.osm\.pbf cannot be written"):
        cut_areas(source, [good, bad])
    assert [path.name for path in tmp_path.iterdir()] == ["area.osm"]


def test_a_failure_while_writing_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = Area(row([0.0, 50.0]), {1: ([1, 2], ROAD)}).write(tmp_path)

    def fails(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cutting, "_add", fails)
    with pytest.raises(KeyboardInterrupt):
        cut_areas(source, [request(tmp_path, box(-500, -500, 500, 500))])
    assert [path.name for path in tmp_path.iterdir()] == ["area.osm"]


# ---------------------------------------------------------------- the whole of it


def test_all_of_a_map_is_read_as_the_map_itself(tmp_path: Path) -> None:
    frame = projection.make_frame(42.55, 1.53)
    wanted = CutRequest("all", tmp_path / "all.osm.pbf", frame, box(-20e3, -20e3, 20e3, 20e3))
    cut_areas(SAMPLE, [wanted])
    options = ParseOptions(extra_objects=frozenset({"lamps", "trees"}))
    said = [Diagnostics(), Diagnostics()]
    whole, part = (parse_osm(path, options, told) for path, told in zip((SAMPLE, wanted.target), said, strict=True))
    assert list(said[0]) == list(said[1])
    assert len(whole.streets) > 100
    for name in type(whole).__dataclass_fields__:
        assert repr(getattr(whole, name)) == repr(getattr(part, name)), name
    assert all(
        (one.points == other.points).all() and (one.node_ids == other.node_ids).all()
        for one, other in zip(whole.streets, part.streets, strict=True)
    )
