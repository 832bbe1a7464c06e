"""OpenDRIVE's words as Lanelet2's tags."""

from __future__ import annotations

import math

import pytest

from osm2xodr.exporting.lanelet2.words import lanelet_tags, location_of, mark_of, sign_type


@pytest.mark.parametrize(
    ("kind", "change", "tags"),
    [
        ("solid", "", {"type": "line_thin", "subtype": "solid", "lane_change": "no"}),
        ("broken", "", {"type": "line_thin", "subtype": "dashed", "lane_change": "yes"}),
        ("broken", "none", {"type": "line_thin", "subtype": "dashed", "lane_change": "no"}),
        ("solid solid", "", {"type": "line_thin", "subtype": "solid_solid", "lane_change": "no"}),
        # Right of the centre the first line is the inner, left one: who is right of it may cross to the left.
        (
            "solid broken",
            "",
            {"type": "line_thin", "subtype": "solid_dashed", "lane_change:left": "yes", "lane_change:right": "no"},
        ),
        (
            "broken",
            "increase",
            {"type": "line_thin", "subtype": "dashed", "lane_change:left": "yes", "lane_change:right": "no"},
        ),
        ("curb", "", {"type": "curbstone", "subtype": "high", "lane_change": "no"}),
        ("none", "", {"type": "virtual", "lane_change": "yes"}),
        ("none", "none", {"type": "virtual", "lane_change": "no"}),
        ("what", "", {"type": "line_thin", "subtype": "solid", "lane_change": "no"}),
    ],
)
def test_marks(kind: str, change: str, tags: dict[str, str]) -> None:
    assert mark_of(kind, change, outwards_left=False, low=False, bare="virtual").tags() == tags


def test_marks_left_of_the_centre_count_to_the_left() -> None:
    mark = mark_of("solid broken", "", outwards_left=True, low=False, bare="virtual")
    assert (mark.subtype, mark.to_left, mark.to_right) == ("dashed_solid", False, True)


def test_edges_and_kerbs() -> None:
    assert mark_of("none", "", outwards_left=False, low=False, bare="road_border").tags()["lane_change"] == "no"
    assert mark_of("curb", "", outwards_left=False, low=True, bare="virtual").subtype == "low"


def test_lanelets() -> None:
    tags = lanelet_tags("road", ("vehicle",), location="urban", both_ways=False, speed=50 / 3.6)
    assert tags == {
        "type": "lanelet",
        "subtype": "road",
        "location": "urban",
        "one_way": "yes",
        "speed_limit": "50",
        "participant:vehicle": "yes",
    }
    assert lanelet_tags("road", (), location="", both_ways=True, speed=30 * 0.44704)["speed_limit"] == "48.28"
    for speed in (math.inf, math.nan):
        assert "speed_limit" not in lanelet_tags("road", (), location="", both_ways=True, speed=speed)


def test_places_and_signs() -> None:
    words = ("town", "rural", "motorway", "", "unknown")
    assert [location_of(word) for word in words] == ["urban", "nonurban", "nonurban", "", ""]
    assert sign_type("DE", "274", "50") == "de274-50"
    assert sign_type("DE", "206", "-1") == "de206"
    assert sign_type("OpenDRIVE", "1000003", "") == "1000003"
