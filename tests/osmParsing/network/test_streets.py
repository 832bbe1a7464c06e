"""Areas made by hand become streets and intersections."""

from __future__ import annotations

from pathlib import Path

import pytest
from osm_builder import ONEWAY, ROAD, ROW, Area, about, ends_of, nodes_of, ways_of

from osm2xodr.model import Direction

# ---------------------------------------------------------------- streets and intersections


def test_ways_in_a_row_are_one_street(tmp_path: Path) -> None:
    area = Area(ROW, {20: ([3, 2, 1], ROAD), 21: ([3, 4], ROAD + " name=B"), 22: ([4, 5, 6], ROAD)})
    network, diagnostics = area.parse(tmp_path)
    assert nodes_of(network) == [[6, 5, 4, 3, 2, 1]]
    assert ways_of(network) == [[(22, True), (21, True), (20, False)]]
    assert [index for index, _ in network.streets[0].pieces] == [0, 2, 3]
    assert network.streets[0].pieces[1][1].name == "B"
    assert ends_of(network) == [(6, 1)]
    assert [item.arms for item in network.intersections] == [((0, False),), ((0, True),)]
    assert list(diagnostics) == []


def test_where_three_meet_there_is_an_intersection(tmp_path: Path) -> None:
    network, _ = Area(ROW, {20: ([1, 2, 3, 4, 5], ROAD), 21: ([13, 3], ROAD), 22: ([14, 13], ROAD)}).parse(tmp_path)
    assert nodes_of(network) == [[1, 2, 3], [3, 4, 5], [14, 13, 3]]
    assert ways_of(network) == [[(20, False)], [(20, False)], [(22, False), (21, False)]]
    assert [(item.osm_node_id, item.arms) for item in network.intersections] == [
        (1, ((0, True),)),
        (3, ((0, False), (1, True), (2, False))),
        (5, ((1, False),)),
        (14, ((2, True),)),
    ]


def test_streets_run_along_one_way_pieces(tmp_path: Path) -> None:
    area = Area(ROW, {20: ([1, 2], ROAD), 21: ([3, 2], ONEWAY), 22: ([3, 4], "highway=primary oneway=-1 lanes=2")})
    network, _ = area.parse(tmp_path)
    assert nodes_of(network) == [[4, 3, 2, 1]]
    assert ways_of(network) == [[(22, True), (21, False), (20, True)]]
    runs = [[lane.direction for lane in piece.lanes_ltr] for _, piece in network.streets[0].pieces]
    assert runs == [[Direction.FORWARD] * 2, [Direction.FORWARD], [Direction.BACKWARD, Direction.FORWARD]]


def test_head_on_one_ways_meet_at_an_intersection(tmp_path: Path) -> None:
    network, _ = Area(ROW, {20: ([1, 2], ONEWAY), 21: ([3, 2], ONEWAY)}).parse(tmp_path)
    assert nodes_of(network) == [[1, 2], [3, 2]]
    assert [item.arms for item in network.intersections if item.osm_node_id == 2] == [((0, False), (1, False))]


@pytest.mark.parametrize(
    ("middle", "said"),
    [
        ([3, 2], {"node/2": "meet head-on here and no way leads on", "node/3": "part here and no way leads here"}),
        ([2, 3], {}),
    ],
)
def test_one_ways_that_meet_head_on_are_reported(tmp_path: Path, middle: list[int], said: dict[str, str]) -> None:
    ways = {20: ([1, 2], ONEWAY), 21: (middle, ONEWAY), 22: ([3, 4], ONEWAY)}
    _, diagnostics = Area(ROW, ways).parse(tmp_path)
    found = about(diagnostics, "oneway-head-on")
    assert {note.osm_id: note.message.partition("way/21 ")[2].removeprefix("and way/22 ") for note in found} == said


@pytest.mark.parametrize(
    "ways",
    [
        # Another street leads on; a side street parts; ways merge at the edge of an area; a road of another kind.
        {20: ([1, 2], ONEWAY), 21: ([3, 2], ONEWAY), 22: ([2, 12], ROAD)},
        {20: ([2, 1], ONEWAY), 21: ([2, 12], ONEWAY)},
        {20: ([1, 2], ONEWAY), 21: ([11, 2], ONEWAY)},
        {20: ([1, 2], ONEWAY), 21: ([3, 2], "highway=motorway_link")},
    ],
)
def test_one_ways_that_do_not_meet_head_on_are_not(tmp_path: Path, ways: dict[int, tuple[list[int], str]]) -> None:
    _, diagnostics = Area(ROW, ways).parse(tmp_path)
    assert about(diagnostics, "oneway-head-on") == []


def test_one_ways_against_each_other_break_a_street(tmp_path: Path) -> None:
    network, _ = Area(ROW, {20: ([1, 2], ONEWAY), 21: ([2, 3], ROAD), 22: ([4, 3], ONEWAY)}).parse(tmp_path)
    assert nodes_of(network) == [[1, 2, 3], [4, 3]]


# ---------------------------------------------------------------- tags


def test_tags_of_nodes_on_streets(tmp_path: Path) -> None:
    area = Area(ROW, {20: ([1, 2, 3], ROAD)}, node_tags={2: "highway=stop direction=forward", 5: "highway=stop"})
    network, _ = area.parse(tmp_path)
    assert network.node_tags == {2: {"highway": "stop", "direction": "forward"}}


# ---------------------------------------------------------------- which ways


# ---------------------------------------------------------------- order


# ---------------------------------------------------------------- the side of the road


# ---------------------------------------------------------------- where on Earth


def test_the_line_moves_among_the_lanes(tmp_path: Path) -> None:
    """Three lanes of 3 m: the line is 3 m right of the left edge at first (offset -1.5 m), 9 m at last (4.5 m)."""
    road = "highway=primary oneway=yes lanes=3 width=9 placement={}"
    ways = {
        20: ([1, 2], road.format("right_of:1")),
        21: ([2, 3], road.format("transition")),
        22: ([3, 4], road.format("transition")),
        23: ([4, 5], road.format("right_of:3")),
        24: ([5, 6], road.format("transition")),
    }
    network, diagnostics = Area(ROW, ways).parse(tmp_path)
    (street,) = network.streets
    offsets = [piece.middle_offset for _, piece in street.pieces]
    assert offsets == pytest.approx([-1.5, 0.5, 2.5, 4.5, 0.0])
    assert [item.osm_id for item in about(diagnostics, "placement")] == ["way/21", "way/22", "way/24"]
