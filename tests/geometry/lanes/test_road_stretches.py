"""Where along a road lanes may change: pieces cut to the road, none too short for the tapers of its lanes."""

from __future__ import annotations

import pytest
from lane_cases import cut, in_a_row, section, street

from osm2xodr.geometry import defaults
from osm2xodr.geometry.lanes.road_stretches import Stretch, stretches, with_narrow_ends
from osm2xodr.model import Direction, LaneType, MarginSpec, Rule, StreetAttributes

ONE, TWO, THREE = street("d< d>"), street("d< d> d>"), street("d< d> d> d>")


def borders(found: list[Stretch]) -> list[float]:
    """Return where stretches begin, and the end."""
    return [*(item.start for item in found), found[-1].end]


def lanes(found: list[Stretch]) -> list[int]:
    return [len(item.section.right) for item in found]


def test_pieces_are_cut_to_the_road() -> None:
    found = cut((0.0, ONE), (40.0, TWO), (70.0, ONE), begin=10.0, end=60.0)
    assert (borders(found), lanes(found)) == ([0.0, 30.0, 50.0], [1, 2])
    found = cut((0.0, ONE), (40.0, TWO), begin=45.0, end=60.0)
    assert (borders(found), lanes(found)) == ([0.0, 15.0], [2])
    found = cut((0.0, ONE), (40.0, TWO), begin=10.0, end=40.0)
    assert (borders(found), lanes(found), found[0].ways) == ([0.0, 30.0], [1], (1,))
    found = cut((0.0, TWO), (40.0, ONE), (70.0, TWO), begin=40.0, end=70.0)
    assert (borders(found), lanes(found), found[0].ways) == ([0.0, 30.0], [1], (1,))
    # A road of no length at a border has the lanes from there on.
    found = cut((0.0, ONE), (40.0, TWO), begin=40.0, end=40.0)
    assert (borders(found), lanes(found)) == ([0.0, 0.0], [2])
    assert borders(cut((0.0, ONE), begin=10.0, end=60.0)) == [0.0, 50.0]


@pytest.mark.parametrize(
    "other",
    [
        street("d< d>", speed_forward=10.0),
        street("d< d>", speed_backward=10.0),
        street("d< d>", no_overtaking=frozenset({Direction.FORWARD})),
        street("d< d>", marked=True),
        street("d< d>", divider="solid_line"),
        street("d< d>", width=3.0),
        street("d> d>"),
        street("b< d>"),
        street("d< d>", middle_offset=1.0),
        street("d< d<"),
    ],
)
def test_what_lanes_share_a_stretch(other: object) -> None:
    assert len(in_a_row((50.0, ONE), (50.0, other))) == 2  # type: ignore[arg-type]


def test_equal_lanes_are_one_stretch() -> None:
    again = street("d< d>/left", osm_way_id=2, surface="asphalt", margin_left=(MarginSpec(LaneType.SIDEWALK, 2.0),))
    (found,) = in_a_row((50.0, ONE), (50.0, again), (50.0, street("d< d>", osm_way_id=3)))
    assert (found.start, found.end, found.length) == (0.0, 150.0, 150.0)
    assert found.ways == (1, 2, 3)
    # Turns count at the road's end, those of the last piece.
    assert found.attributes.osm_way_id == 3


def test_tags_about_lane_changes_matter_where_there_are_lanes_to_change_to() -> None:
    assert len(in_a_row((50.0, street("d< d>")), (50.0, street("d< d>:no")))) == 1
    assert len(in_a_row((50.0, street("d< d> d>")), (50.0, street("d< d>:no d>:no")))) == 2
    assert len(in_a_row((50.0, street("d< d> d>")), (50.0, street("d< d>:yes d>")))) == 1


@pytest.mark.parametrize(
    ("middle", "expected"),
    [
        (12.0, [1, 2, 3]),
        (11.999, [1, 3]),
        (0.5, [1, 3]),
    ],
)
def test_the_longer_neighbour_takes_over_what_is_too_short(middle: float, expected: list[int]) -> None:
    assert defaults.SHORTEST_LANE_SECTION == 12.0
    found = in_a_row((50.0, ONE), (middle, TWO), (60.0, THREE))
    assert lanes(found) == expected
    if len(expected) == 2:
        assert borders(found) == pytest.approx([0.0, 50.0, 110.0 + middle])
        assert [len(item.ways) for item in found] == [1, 2]
    found = in_a_row((60.0, THREE), (middle, TWO), (50.0, ONE))
    assert lanes(found) == expected[::-1]


SLOW, FAST = street("d< d>", speed_forward=5.0), street("d< d>", speed_forward=15.0)
MARKED = street("d< d>", marked=True)


@pytest.mark.parametrize(
    ("pieces", "expected"),
    [
        # Lanes that stay need no room for tapers.
        ([(50.0, ONE), (6.0, SLOW), (40.0, FAST)], [0.0, 50.0, 56.0, 96.0]),
        ([(6.0, SLOW), (40.0, FAST)], [0.0, 6.0, 46.0]),
        ([(40.0, FAST), (6.0, SLOW), (30.0, TWO)], [0.0, 40.0, 46.0, 76.0]),
        ([(6.0, SLOW), (6.0, FAST), (30.0, TWO)], [0.0, 6.0, 12.0, 42.0]),
        # Where there is no room for a car, there is none for a limit; nor between other lanes that are near.
        ([(50.0, ONE), (5.9, SLOW), (40.0, FAST)], [0.0, 55.9, 95.9]),
        ([(5.9, SLOW), (40.0, FAST)], [0.0, 45.9]),
        ([(50.0, TWO), (6.0, SLOW), (5.0, FAST), (40.0, TWO)], [0.0, 56.0, 101.0]),
        # Lines are longer.
        ([(6.0, MARKED), (40.0, ONE)], [0.0, 12.0, 46.0]),
        ([(50.0, ONE), (6.0, MARKED), (40.0, ONE)], [0.0, 56.0, 96.0]),
    ],
)
def test_limits_begin_where_they_do(pieces: list[tuple[float, StreetAttributes]], expected: list[float]) -> None:
    assert borders(in_a_row(*pieces)) == pytest.approx(expected)
    assert borders(in_a_row(*pieces[::-1])) == pytest.approx([expected[-1] - s for s in reversed(expected)])


def test_traffic_is_never_turned_round_for_the_sake_of_tapers() -> None:
    """A short piece of a one-way street stays, unless it is shorter than any road."""
    one_way = street("d> d>")
    assert lanes(in_a_row((50.0, ONE), (5.0, one_way), (60.0, THREE))) == [1, 2, 3]
    assert defaults.SHORTEST_ROAD == 1.0
    assert lanes(in_a_row((50.0, ONE), (1.0, one_way), (60.0, THREE))) == [1, 2, 3]
    assert lanes(in_a_row((50.0, ONE), (0.999, one_way), (60.0, THREE))) == [1, 3]
    # The one neighbour whose traffic runs alike takes over, however short.
    found = in_a_row((60.0, one_way), (5.0, ONE), (60.0, TWO), (60.0, one_way))
    assert lanes(found) == [2, 2, 2]
    assert borders(found) == [0.0, 60.0, 125.0, 185.0]


ONE_WAY = street("d>", osm_way_id=4)


@pytest.mark.parametrize(("length", "kept"), [(30.75, True), (30.74, False)])
def test_lanes_against_one_way_streets_need_room_to_end(length: float, kept: bool) -> None:
    """A lane of 3.5 m ends over 8.5 times that, 1 m off the road's end: 30.75 m, or there is none."""
    found = in_a_row((length, ONE), (60.0, ONE_WAY))
    assert [len(item.section.left) for item in found] == ([1, 0] if kept else [0])
    assert found[-1].end == length + 60.0
    assert [way for item in found for way in item.ways] == [1, 4]
    # Whichever way the road is drawn, and whichever way cars run.
    found = in_a_row((60.0, ONE_WAY), (length, ONE))
    assert [len(item.section.left) for item in found] == ([0, 1] if kept else [0])
    found = in_a_row((60.0, street("d<")), (length, ONE))
    assert [len(item.section.right) for item in found] == ([0, 1] if kept else [0])


@pytest.mark.parametrize(("length", "kept"), [(59.51, True), (59.49, False)])
def test_lanes_against_one_way_streets_at_both_ends_need_room_twice(length: float, kept: bool) -> None:
    found = in_a_row((60.0, ONE_WAY), (length, ONE), (60.0, ONE_WAY))
    assert [len(item.section.left) for item in found] == ([0, 1, 0] if kept else [0])
    assert found[-1].end == 120.0 + length
    # One-way streets that differ share what they take over.
    found = in_a_row((60.0, ONE_WAY), (20.0, ONE), (60.0, street("d> d>")))
    assert (borders(found), lanes(found)) == ([0.0, 70.0, 140.0], [1, 2])


def test_a_street_between_one_way_streets_that_meet_stays() -> None:
    """Neither can take it over without traffic that meets head on."""
    found = in_a_row((60.0, ONE_WAY), (20.0, ONE), (60.0, street("d<")))
    assert [(len(item.section.left), len(item.section.right)) for item in found] == [(0, 1), (1, 1), (1, 0)]


def test_turn_lanes_before_a_junction_stay_behind_a_one_way_street() -> None:
    """What has more lanes along the one-way street stays, though the lane against it has no room to end."""
    found = in_a_row((60.0, ONE_WAY), (20.0, street("d< d>/left d>/right")))
    assert [(len(item.section.left), len(item.section.right)) for item in found] == [(0, 1), (1, 2)]
    # Lanes that continue and shift to the side need no room for that.
    found = in_a_row((60.0, ONE_WAY), (31.0, street("d< d>", middle_offset=5.0)))
    assert [len(item.section.left) for item in found] == [0, 1]


def test_a_lane_for_bicycles_against_cars_needs_no_such_room() -> None:
    found = in_a_row((20.0, street("c< d>")), (60.0, ONE_WAY))
    assert [len(item.section.left) for item in found] == [1, 0]


@pytest.mark.parametrize(
    ("lengths", "expected"),
    [
        # At the end of a road a stretch grows to 12 m if its neighbour, which is an end too, keeps more than that.
        ((8.0, 24.1), [0.0, 12.0, 32.1]),
        # A lane of 3.5 m has no room to open.
        ((8.0, 16.1), [0.0, 24.1]),
        # Of a neighbour in the middle it takes less than half, though the rest may be too short then.
        ((1.0, 22.1, 60.0), [0.0, 12.0, 83.1]),
        ((1.0, 22.0, 60.0), [0.0, 23.0, 83.0]),
        # What a junction leaves of a stretch, less than a metre, does not grow.
        ((0.999, 50.0, 60.0), [0.0, 50.999, 110.999]),
        ((1.0, 50.0, 60.0), [0.0, 12.0, 51.0, 111.0]),
        ((12.0, 50.0, 60.0), [0.0, 12.0, 62.0, 122.0]),
    ],
)
def test_short_stretches_at_the_ends_of_roads_grow(lengths: tuple[float, ...], expected: list[float]) -> None:
    kinds = (ONE, TWO, THREE)
    assert borders(in_a_row(*zip(lengths, kinds, strict=False))) == pytest.approx(expected)
    back = [expected[-1] - s for s in reversed(expected)]
    turned = zip(reversed(lengths), reversed(kinds[: len(lengths)]), strict=True)
    assert borders(in_a_row(*turned)) == pytest.approx(back)


@pytest.mark.parametrize("text", ["d< d>/left d>", "d</left d> d>"])
def test_the_last_bit_of_a_turn_lane_grows(text: str) -> None:
    assert borders(in_a_row((50.0, ONE), (0.5, street(text)))) == pytest.approx([0.0, 38.5, 50.5])


def test_lanes_that_only_lead_in_do_not_grow() -> None:
    """Behind a junction a one-way road has the lanes that it goes on with; before one, those that it ends with."""
    one, two = street("d>"), street("d> d>")
    assert lanes(in_a_row((8.0, two), (60.0, one))) == [1]
    assert borders(in_a_row((60.0, one), (8.0, two))) == [0.0, 56.0, 68.0]


def test_what_a_junction_leaves_of_other_lanes_is_no_pocket() -> None:
    assert borders(cut((0.0, ONE), (20.5, TWO), begin=20.0)) == [0.0, 80.0]
    # A metre and more grows to the length of a taper.
    longest = defaults.SHORTEST_LANE_SECTION
    assert borders(cut((0.0, ONE), (25.0, TWO), begin=20.0)) == [0.0, longest, 80.0]


@pytest.mark.parametrize(
    ("lengths", "expected"),
    [
        # Too little for two: the longer one stays alone.
        ((10.0, 8.76), (1,)),
        ((13.0, 8.0), (1,)),
        ((8.0, 30.0), (1, 2)),
        # In the middle, half of what there is can be spared: by the end that lacks less first.
        ((4.0, 20.0, 8.0), (2, 3)),
        ((8.0, 46.0, 8.0), (1, 2, 3)),
        # Twice a lane of 3 m opens over 25.5 m, a metre is left at either end of the road: the shortest gives way.
        ((15.0, 21.0, 17.0), (1, 2, 3)),
        ((15.0, 20.9, 17.0), (2, 3)),
    ],
)
def test_short_stretches_are_mended_alike_whichever_way_the_road_is_drawn(
    lengths: tuple[float, ...], expected: tuple[int, ...]
) -> None:
    for order in (1, -1):
        kinds = [section(" ".join(["d<", *["d>"] * k])) for k in range(1, len(lengths) + 1)][::order]
        starts = [0.0]
        for length in lengths[::order]:
            starts.append(starts[-1] + length)
        pieces = [(s, ONE, kind) for s, kind in zip(starts, kinds, strict=False)]
        assert lanes(stretches(pieces, 0.0, starts[-1], Rule.RIGHT_HAND))[::order] == list(expected)


def test_turn_lanes_give_way_last() -> None:
    """There is no room for both: the turn lane at the end of the road is on all of it, however short it was."""
    found = in_a_row((12.5, ONE), (12.0, street("d< d>/left d>")))
    assert (lanes(found), borders(found)) == ([2], [0.0, 24.5])
    found = in_a_row((12.5, ONE), (12.0, TWO))
    assert (lanes(found), borders(found)) == ([1], [0.0, 24.5])
    # What leads into the road is no turn lane of it.
    found = in_a_row((12.0, street("d< d>/left d>")), (12.5, ONE))
    assert lanes(found) == [1]
    # Of two turn lanes at either end neither gives way to what lies between them.
    found = in_a_row((12.0, street("d</left d< d>")), (14.0, ONE), (12.0, street("d< d>/left d>")))
    assert (lanes(found), borders(found)) == ([1, 2], [0.0, 19.0, 38.0])


def test_lanes_narrow_at_the_ends_of_roads() -> None:
    """A lane of 5.5 m that has 3.5 m at the road's end, about the middle of the carriageway."""
    (wide,) = cut((0.0, street("d>", width=5.5)), end=50.0)
    found = with_narrow_ends([wide], None, {-1: 3.5}, Rule.RIGHT_HAND)
    assert borders(list(found)) == [0.0, 49.0, 50.0]
    assert [item.section.right[0].width for item in found] == [5.5, 3.5]
    assert (found[1].section.left_edge, found[1].section.right_edge) == (1.75, -1.75)
    assert [lane.width for lane in found[1].attributes.lanes_ltr] == [3.5]
    # Where there is no room for two changes, the lane changes once, from end to end.
    (short,) = cut((0.0, street("d>", width=5.5)), end=20.0)
    found = with_narrow_ends([short], {-1: 3.0}, {-1: 3.5}, Rule.RIGHT_HAND)
    assert [item.section.right[0].width for item in found] == [3.0, 3.5]
