"""What ways of the same street tell of a way's lanes and of its width."""

from __future__ import annotations

import pytest
from osm_builder import tags_of

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import Rule
from osm2xodr.osmParsing.file.access import RawWay
from osm2xodr.osmParsing.tags.cross_sections import Kerbs, StreetFacts
from osm2xodr.osmParsing.tags.neighbours import _WAYS_SEARCHED, lanes_of_neighbours, widths_of_neighbours
from osm2xodr.osmParsing.tags.ways import way_attributes


def row(*tags: str, street: str = "highway=primary name=A") -> list[RawWay]:
    """Ways end to end, the second one drawn against the others."""
    ways = []
    for k, text in enumerate(tags):
        refs = [k + 1, k] if k == 1 else [k, k + 1]
        ways.append(RawWay(k + 1, refs, tags_of(f"{street} {text}")))
    return ways


@pytest.mark.parametrize(
    ("tags", "found"),
    [
        (("lanes=2", "", "lanes=2"), {1: 2}),
        (("lanes=4", "", "lanes=4"), {1: 4}),
        # Lanes that one side has more, and the odd one of a two-way street, are turning lanes.
        (("lanes=4", "", "lanes=2"), {1: 2}),
        (("lanes=3", "", "lanes=3"), {1: 2}),
        (("lanes=1", "", "lanes=2"), {1: 1}),
        (("lanes=4", "", "", "lanes=4"), {1: 4, 2: 4}),
        # Known on one side only, or not a number.
        (("lanes=4", ""), {}),
        (("lanes=4", "", ""), {}),
        (("lanes=4", "", "lanes=many"), {}),
        (("lanes=4", "", "lanes=99"), {}),
        # Ways that say something about their lanes are not silent.
        (("lanes=4", "lanes:forward=1", "lanes=4"), {}),
        (("lanes=4", "turn:lanes:forward=left|right", "lanes=4"), {}),
        # Another street.
        (("lanes=4", "name=B", "lanes=4"), {}),
        (("lanes=4", "highway=secondary", "lanes=4"), {}),
        (("lanes=4", "oneway=yes", "lanes=4"), {}),
        (("lanes=4", "junction=roundabout", "lanes=4"), {}),
    ],
)
def test_two_way_streets(tags: tuple[str, ...], found: dict[int, int]) -> None:
    assert lanes_of_neighbours(row(*tags)) == found


def test_one_way_streets() -> None:
    street = "highway=primary ref=1 oneway=yes"
    assert lanes_of_neighbours(row("lanes=3", "oneway=-1", "lanes=3", street=street)) == {1: 3}
    assert lanes_of_neighbours(row("lanes=3", "oneway=-1", "lanes=2", street=street)) == {1: 2}


def test_streets_without_a_name_have_no_neighbours() -> None:
    assert lanes_of_neighbours(row("lanes=4", "", "lanes=4", street="highway=primary")) == {}


def test_ways_without_nodes_have_no_neighbours() -> None:
    ways = row("lanes=4", "", "lanes=4")
    assert lanes_of_neighbours([*ways, RawWay(9, [], tags_of("highway=primary name=A"))]) == {1: 4}


def test_a_fork_tells_nothing() -> None:
    ways = [*row("lanes=4", "", "lanes=4"), RawWay(9, [2, 20], tags_of("highway=primary name=A lanes=4"))]
    assert lanes_of_neighbours(ways) == {}


def test_a_ring_of_silent_ways_ends() -> None:
    tags = tags_of("highway=primary name=A")
    assert lanes_of_neighbours([RawWay(1, [1, 2, 3], tags), RawWay(2, [3, 4, 1], tags)]) == {}
    assert lanes_of_neighbours([RawWay(1, [1, 2, 3, 1], tags)]) == {}


def test_only_so_many_silent_ways_are_stepped_over() -> None:
    most = _WAYS_SEARCHED
    assert len(lanes_of_neighbours(row("lanes=4", *[""] * most, "lanes=4"))) == most
    assert lanes_of_neighbours(row("lanes=4", *[""] * (2 * most), "lanes=4")) == {}


def test_the_guess_is_told() -> None:
    diagnostics = Diagnostics()
    attributes, _ = way_attributes(row("lanes=4", "width=13", "lanes=4"), Rule.RIGHT_HAND, None, diagnostics)
    assert [len(item.lanes_ltr) for item in attributes] == [4, 4, 4]
    said = [(item.kind, item.code, item.message) for item in diagnostics if item.osm_id == "way/2"]
    words = "no lanes given, lanes=4 as on the same street on both sides"
    assert said == [(Kind.GUESSED, "lane-count", words)]


@pytest.mark.parametrize(
    ("tags", "found"),
    [
        (("width=7", ""), {1: 7.0}),
        (("width:carriageway=8 width=7", "", ""), {1: 8.0, 2: 8.0}),
        # Of both sides the mean.
        (("width=6", "", "width=7"), {1: 6.5}),
        # Estimates are no better than the usual widths, and mistakes are no widths.
        (("est_width=7", ""), {}),
        (("width=700", ""), {}),
        # Other numbers of lanes have other widths.
        (("width=7 lanes=2", "lanes=3"), {}),
        (("width=7 lanes=3", "lanes=3"), {1: 7.0}),
        # Another street.
        (("width=7", "name=B"), {}),
        (("width=7", "oneway=yes"), {}),
        (("width=7", "junction=roundabout"), {}),
    ],
)
def test_widths_of_the_same_street(tags: tuple[str, ...], found: dict[int, float]) -> None:
    assert widths_of_neighbours(row(*tags), {}) == found


def test_kerbs_tell_the_width_of_the_same_street() -> None:
    assert widths_of_neighbours(row("", "", ""), {0: StreetFacts(Kerbs(4.0, -4.1))}) == {1: 8.1, 2: 8.1}
    # One of them tells none.
    assert widths_of_neighbours(row("", "", ""), {0: StreetFacts(Kerbs(4.0, None))}) == {}


def test_a_lane_width_of_the_user_comes_before_the_same_street() -> None:
    for chosen, width in ((None, 3.5), (2.8, 2.8)):
        attributes, _ = way_attributes(row("width=7 lanes=2", "lanes=2"), Rule.RIGHT_HAND, chosen, Diagnostics())
        assert [lane.width for lane in attributes[1].lanes_ltr] == [width, width]
