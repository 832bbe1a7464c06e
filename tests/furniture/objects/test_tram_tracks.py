"""Rails of tram tracks in carriageways."""

from __future__ import annotations

import pytest
from object_cases import ROAD, STREET, placed, s_of, side, thing, with_things, world_of
from street_cases import Case

from osm2xodr.model import RoadsideKind, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule))
NEAR = 0.02


@EITHER
def test_tram_tracks_lie_where_their_way_runs(rule: Rule) -> None:
    track = thing(RoadsideKind.TRAM_TRACK, [(-50.0, 1.5), (50.0, 1.5)], rule, gauge="1000")
    found = placed(world_of(ROAD, rule, network=with_things(track)))
    assert [(item.type, item.subtype, item.name) for item in found] == [("patch", "tramTrack", "tram track")] * 2
    assert sorted(round(item.t * side(rule), 1) for item in found) == [1.0, 2.0]
    assert all(item.repeat is not None and item.repeat.length == pytest.approx(100.0, abs=NEAR) for item in found)


@EITHER
def test_tracks_above_a_tunnel_are_not_on_its_road(rule: Rule) -> None:
    """The street goes under from x = 0 on: the track on the ground above it ends there."""
    under = Case(STREET, {1: ("w a", "lanes=2 width=7"), 2: ("a e", "lanes=2 width=7 tunnel=yes layer=-1")})
    track = thing(RoadsideKind.TRAM_TRACK, [(-50.0, 1.5), (50.0, 1.5)], rule)
    found = placed(world_of(under, rule, network=with_things(track)))
    portal = s_of(STREET["a"][0])
    assert len(found) == 2
    for item in found:
        assert item.repeat is not None
        assert item.repeat.s == pytest.approx(s_of(-50.0), abs=NEAR)
        assert portal - 5.0 < item.repeat.s + item.repeat.length <= portal + 1e-6


def test_tracks_beside_the_carriageway_are_left_out() -> None:
    track = thing(RoadsideKind.TRAM_TRACK, [(-50.0, 6.0), (50.0, 6.0)])
    assert placed(world_of(ROAD, network=with_things(track))) == ()


@EITHER
def test_streets_with_tracks_have_them_in_their_inner_lanes(rule: Rule) -> None:
    world = world_of(Case(STREET, {1: ("w a e", "lanes=2 width=7 embedded_rails=tram")}), rule)
    found = placed(world)
    assert sorted(round(item.t, 4) for item in found) == [-2.4675, -1.0325, 1.0325, 2.4675]
    assert {item.osm_id for item in found} == {"way/1"}
    assert all(
        item.repeat is not None and item.repeat.length == pytest.approx(world.lanes.length(item.road))
        for item in found
    )
