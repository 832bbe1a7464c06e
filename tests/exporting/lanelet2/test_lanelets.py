"""Lanelets and their bounds: shared by neighbours, joined where lanes are linked, in the direction of traffic."""

from __future__ import annotations

from pathlib import Path

import pytest
from exported_network import network
from lanelet_text import Written, written
from xodr_text import cubics, document, geometry, lane, read_text, road, section

from osm2xodr.errors import InputError

NEXT = '<successor elementType="road" elementId="2" contactPoint="start"/>'
BACK = '<predecessor elementType="road" elementId="1" contactPoint="end"/>'
TO = '<link><successor id="-1"/></link>'
FROM = '<link><predecessor id="-1"/></link>'
RULE = ' rule="LHT"'


def two_roads(folder: Path, first: str, second: str, beyond: str | None = None) -> Written:
    """Return a map of two roads in line; the left lane is linked, the right one as the texts say."""
    roads = [
        road("1", lanes=section(0.0, right=lane(-1, (0, 3.0), more=TO) + lane(-2, (0, 3.0), more=first)), link=NEXT),
        road(
            "2",
            beyond or geometry("<line/>", 50.0, x=100.0),
            50.0,
            lanes=section(0.0, right=lane(-1, (0, 3.0), more=FROM) + lane(-2, (0, 3.0), more=second)),
            link=BACK,
        ),
    ]
    return written(read_text(folder, document(*roads)))


def ends(found: Written, number: str, row: int) -> list[str]:
    return [found.ways[found.bound(number, side)][row] for side in ("left", "right")]


def test_neighbours_share_their_bound(tmp_path: Path) -> None:
    found = two_roads(tmp_path, "", "")
    left, right = found.lanelet("1", "-1"), found.lanelet("1", "-2")
    assert found.bound(left, "right") == found.bound(right, "left")
    assert found.points(found.bound(left, "left"))[0] == (0, 0, 0)
    assert found.points(found.bound(right, "right"))[-1] == (100, -6, 0)


def test_linked_lanes_share_their_end_nodes(tmp_path: Path) -> None:
    found = two_roads(tmp_path, TO.replace("-1", "-2"), FROM.replace("-1", "-2"))
    for number in ("-1", "-2"):
        assert ends(found, found.lanelet("1", number), -1) == ends(found, found.lanelet("2", number), 0)


def test_lanes_that_only_touch_share_no_pair_of_nodes(tmp_path: Path) -> None:
    found = two_roads(tmp_path, "", "")
    one, other = ends(found, found.lanelet("1", "-2"), -1), ends(found, found.lanelet("2", "-2"), 0)
    # The bound to the linked neighbour is joined, the edge is not.
    assert one[0] == other[0]
    assert one[1] != other[1]


def test_ends_that_do_not_meet_are_joined_in_the_middle_and_reported(tmp_path: Path) -> None:
    found = two_roads(tmp_path, "", "", geometry("<line/>", 50.0, x=100.0, y=0.4))
    assert found.points(found.bound(found.lanelet("1", "-1"), "left"))[-1] == (100, 0.2, 0)
    assert found.lost == ["2 ends of linked lanes lie up to 0.40 m apart and meet in the middle"]


@pytest.mark.parametrize("left_hand", [False, True])
def test_lanelets_run_with_the_traffic(tmp_path: Path, left_hand: bool) -> None:
    text = road(elevation=cubics("elevation", (0, 7.0, 0.01)))
    text = text.replace(' junction="-1"', ' junction="-1"' + (RULE if left_hand else ""), 1)
    found = written(read_text(tmp_path, document(text)))
    for number, y in (("1", 3.5), ("-1", -3.5)):
        lanelet = found.lanelet("1", number)
        centre, edge = ("right", "left") if left_hand else ("left", "right")
        assert found.points(found.bound(lanelet, centre))[0] == (0, 0, 7)
        assert found.points(found.bound(lanelet, edge))[-1] == (100, y, 8)
    assert found.bound(found.lanelet("1", "1"), centre) == found.bound(found.lanelet("1", "-1"), centre)


def test_turns_are_named_in_junctions_alone(tmp_path: Path) -> None:
    bend = [geometry(f'<arc curvature="{k}"/>', 10.0) for k in (0.1, -0.1, 0.03)]
    roads = [road(str(k), plan, 10.0, junction="9") for k, plan in enumerate(bend)]
    found = written(read_text(tmp_path, document(*roads, road("8", bend[0], 10.0), '<junction id="9" name=""/>')))
    turns = [found.tags[found.lanelet(str(k), "-1")].get("turn_direction") for k in (0, 1, 2, 8)]
    assert turns == ["left", "right", "straight", None]
    # Against s a bend to the left leads to the right.
    assert found.tags[found.lanelet("0", "1")]["turn_direction"] == "right"


def test_what_lanes_become(tmp_path: Path) -> None:
    kinds = ("bus", "biking", "sidewalk", "parking")
    lanes = section(0.0, right="".join(lane(-k, (0, 2.0), kind=kind) for k, kind in enumerate(kinds, 1)))
    found = written(read_text(tmp_path, document(road(lanes=lanes))))
    tags = [found.tags[found.lanelet("1", str(-k))] for k in (1, 2, 3)]
    assert [one["subtype"] for one in tags] == ["bus_lane", "bicycle_lane", "walkway"]
    assert [one["one_way"] for one in tags] == ["yes", "yes", "no"]
    who = [[key for key in one if key.startswith("participant")] for one in tags]
    assert who == [["participant:vehicle:bus"], ["participant:bicycle"], ["participant:pedestrian"]]
    assert found.lost == ["lanes that Lanelet2 has no lanelets for are left out: 1 parking"]


def test_ids_are_unique_over_all_kinds(tmp_path: Path) -> None:
    found = written(network(tmp_path))
    numbers = [int(number) for number in (*found.nodes, *found.ways, *found.relations)]
    assert numbers == list(range(1, len(numbers) + 1))


def test_a_file_without_lanes_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no lane that Lanelet2 knows"):
        written(read_text(tmp_path, document(road(lanes=section(0.0)))))
