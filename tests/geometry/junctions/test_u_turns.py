"""Which U-turns between carriageways are kept: by room, by law and signals, by what OSM maps."""

from __future__ import annotations

from dataclasses import replace

import pytest
from dual_carriageways import built, dual
from street_cases import Case, built_links

from osm2xodr.geometry import RoadOptions
from osm2xodr.model import Rule

_ONE_LANE = "lanes=1 width=3"


def kept_u_turns(case: Case, rule: Rule, option: str = "law", country: str = "") -> set[tuple[int, int]]:
    """Return (from way, to way) of the U-turns that are built."""
    found = {(one, to) for one, _, to, _ in built_links(built(case, rule, option, country))}
    return found & {(2, 1), (3, 4)}


def test_the_law_decides_if_nothing_else_is_said() -> None:
    assert RoadOptions().u_turns == "law"


@pytest.mark.parametrize("rule", list(Rule))
@pytest.mark.parametrize(("apart", "kept"), [(3.4, False), (3.6, True), (12.0, True)])
def test_lanes_beside_each_other_leave_no_room(apart: float, kept: bool, rule: Rule) -> None:
    assert kept_u_turns(dual(apart, _ONE_LANE), rule) == ({(2, 1), (3, 4)} if kept else set())


@pytest.mark.parametrize("rule", list(Rule))
@pytest.mark.parametrize(
    ("option", "country", "signals", "kept"),
    [
        ("law", "DE", True, True),
        ("law", "AU", True, False),
        ("law", "AU", False, True),
        ("all", "AU", True, True),
        ("mapped", "DE", False, False),
        ("none", "DE", False, False),
    ],
)
def test_law_signals_and_the_option(option: str, country: str, signals: bool, kept: bool, rule: Rule) -> None:
    case = dual(12.0, _ONE_LANE)
    if signals:
        lights = "highway=traffic_signals"
        case = replace(case, node_tags={"o1": lights, "o2": lights})
    assert kept_u_turns(case, rule, option, country) == ({(2, 1), (3, 4)} if kept else set())


@pytest.mark.parametrize("rule", list(Rule))
def test_a_lane_for_it_or_a_crossing_made_for_it_maps_a_u_turn(rule: Rule) -> None:
    case = dual(12.0)
    two = dict(case.ways)
    two[2] = ("w2 o2", "oneway=yes lanes=2 turn:lanes=reverse|through")
    assert kept_u_turns(replace(case, ways=two), rule, "mapped") == {(2, 1)}
    alone = {way: found for way, found in case.ways.items() if way not in (5, 7)}
    assert kept_u_turns(replace(case, ways=alone), rule, "mapped") == {(2, 1), (3, 4)}


@pytest.mark.parametrize("rule", list(Rule))
def test_the_only_way_on_is_kept(rule: Rule) -> None:
    case = dual(3.4, _ONE_LANE)
    ends = {way: found for way, found in case.ways.items() if way in (1, 2, 6)}
    assert kept_u_turns(replace(case, ways=ends), rule, "none") <= {(2, 1)}
    assert kept_u_turns(replace(dual(12.0, _ONE_LANE), ways=ends), rule, "none") <= {(2, 1)}
