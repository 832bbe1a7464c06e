from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from border_cases import EAST, FIRST, WEST, halves_of
from sample_road_maps import furnished_crossing

from osm2xodr.diagnostics import Diagnostic, Diagnostics, Kind
from osm2xodr.geometry.tile_edges.own_area import keep_own_area
from osm2xodr.model import (
    Furniture,
    ObjectRepeat,
    RoadMap,
    RoadObject,
    RoadStructure,
    Signal,
    SignalLink,
    SignalPhase,
    SignalProgramme,
)

# Lines through road 1 (from x = 0 to 100), of which one lies between the junction's light at 98 and the junction.
AMID, AT_LIGHT = 30.0, 99.5


def split(road_map: RoadMap, x: float, own: int, diagnostics: Diagnostics | None = None) -> RoadMap:
    return keep_own_area(halves_of(road_map, x, own), diagnostics or Diagnostics())


def about(value: float) -> Any:
    """Return what equals a number but for rounding, fit for the fields of a record."""
    return pytest.approx(value)


def cut_at(road_map: RoadMap) -> float:
    assert road_map.border_ends is not None
    return road_map.border_ends[0].x


def by_place(furniture: Furniture) -> list[tuple[str, int, float]]:
    things: list[Signal | RoadObject] = [*furniture.signals, *furniture.objects]
    return [(item.osm_id or item.type, item.road, round(item.s, 6)) for item in things]


def test_all_stands_on_the_piece_where_it_stood() -> None:
    west, east = split(furnished_crossing(), AMID, WEST), split(furnished_crossing(), AMID, EAST)
    cut = cut_at(west)
    assert by_place(west.furniture) == [("274", 1000, 20.0)]
    assert by_place(east.furniture) == [
        ("node/42", 50_000, round(98.0 - cut, 6)),
        ("1000001", 50_001, 2.0),
        ("roadSurface", 50_000, round(40.0 - cut, 6)),
        ("node/43", 50_000, round(80.0 - cut, 6)),
        ("roadMark", 50_000, round(95.0 - cut, 6)),
        ("node/44", 50_001, 0.0),
        ("barrier", 50_001, 10.0),
    ]
    assert replace(west.furniture.signals[0], id=3, road=1) == furnished_crossing().furniture.signals[1]


def test_controllers_keep_the_junctions_that_are_left() -> None:
    road_map = furnished_crossing()
    first, *others = road_map.furniture.controllers
    assert first.junction is not None
    shared = replace(first, junction=first.junction - 1, further_junctions=(first.junction,))
    furniture = replace(road_map.furniture, controllers=(shared, *others))
    (east, *_) = split(replace(road_map, furniture=furniture), AMID, EAST).furniture.controllers
    (alone, *_) = split(road_map, AMID, EAST).furniture.controllers
    assert (east.junction, east.further_junctions) == (alone.junction, ())


def test_ids_begin_with_the_first_of_the_area() -> None:
    west, east = (split(furnished_crossing(), AMID, own).furniture for own in (WEST, EAST))
    assert [item.id for item in west.signals] == [1000]
    # In the order of their ids before: 1 and 2 of signals, 4 to 8 of objects.
    assert sorted([item.id for item in east.signals] + [item.id for item in east.objects]) == list(
        range(50_000, 50_007)
    )
    assert [item.id for item in east.signals] == [50_000, 50_001]
    assert [item.id for item in east.objects] == [50_004, 50_002, 50_003, 50_005, 50_006]


def test_controllers_keep_what_is_left_for_them() -> None:
    west, east = (split(furnished_crossing(), AMID, own).furniture for own in (WEST, EAST))
    assert [(item.id, item.name, item.signals, item.junction) for item in west.controllers] == [
        (1000, "alone", (1000,), None)
    ]
    assert [(item.id, item.name, item.signals, item.junction) for item in east.controllers] == [
        (50_000, "along", (50_000, 50_001), 50_004)
    ]
    assert [(item.signal, item.road) for item in east.references] == [(50_000, 50_002), (50_001, 50_003)]
    assert [item.validity for item in east.references] == [((-1, -1),), ()]


def test_signal_programmes_follow_their_junction() -> None:
    whole = furnished_crossing()
    (junction,) = whole.junctions
    connection = junction.connections[0]
    through = next(road for road in whole.roads if road.id == connection.connecting_road)
    assert through.successor is not None
    link = SignalLink(through.id, connection.incoming_road, True, -1, through.successor.id, True, -1)
    programme = SignalProgramme(junction.id, (link,), (SignalPhase("G", 75.0),))
    whole = replace(whole, furniture=replace(whole.furniture, programmes=(programme,)))
    west, east = (split(whole, AMID, own) for own in (WEST, EAST))
    assert west.furniture.programmes == ()
    (kept,) = east.furniture.programmes
    assert kept.junction == east.junctions[0].id
    there = east.junctions[0].connections[0]
    found = next(road for road in east.roads if road.id == there.connecting_road)
    assert found.successor is not None
    assert kept.phases == programme.phases
    assert kept.links == (
        replace(link, connecting_road=found.id, road=there.incoming_road, exit_road=found.successor.id),
    )


def near_lights(road_map: RoadMap, own: int) -> RoadMap:
    """Return a road map whose road 1 is cut between the junction and the light before it."""
    whole = halves_of(road_map, AMID, own)
    assert whole.borders is not None
    piece_s = whole.borders.piece_s.copy()
    piece_s[1] = AT_LIGHT
    return replace(whole, borders=replace(whole.borders, piece_s=piece_s))


def test_a_light_beyond_the_border_is_put_where_it_is_referred_to() -> None:
    told = Diagnostics()
    east = keep_own_area(near_lights(furnished_crossing(), EAST), told).furniture
    before = furnished_crossing().furniture.signals[0]
    assert [(item.road, item.osm_id) for item in east.signals] == [(50_001, ""), (50_002, "node/42")]
    assert east.signals[1] == replace(before, id=50_000, road=50_002, s=0.0, t=-4.5, validity=((-1, -1),))
    assert [(item.signal, item.road) for item in east.references] == [(50_001, 50_003)]
    assert east.controllers[0].signals == (50_000, 50_001)
    assert list(told) == [
        Diagnostic(
            Kind.REPAIRED,
            "border-signal",
            "node/42",
            "it stands on a road of a neighbouring area and is moved to where the junction of this area begins",
        )
    ]


def test_a_light_of_a_junction_beyond_the_border_belongs_to_none() -> None:
    west = keep_own_area(near_lights(furnished_crossing(), WEST), Diagnostics()).furniture
    assert [(item.signals, item.junction) for item in west.controllers] == [((1000,), None), ((1001,), None)]
    assert west.references == ()
    assert [item.type for item in west.signals] == ["274", "1000001"]


def with_object(thing: RoadObject) -> RoadMap:
    whole = furnished_crossing()
    return replace(whole, furniture=Furniture(objects=(thing,), statistics={"objects": 1.0}))


def test_a_barrier_is_cut_in_two() -> None:
    repeat = ObjectRepeat(10.0, 60.0, 0.0, 4.0, 7.0, 0.3, 0.8)
    rail = RoadObject(9, 1, "barrier", "guardRail", "", 10.0, 4.0, length=60.0, width=0.3, height=0.8, repeat=repeat)
    west, east = (split(with_object(rail), AMID, own) for own in (WEST, EAST))
    cut = cut_at(west)
    t = 4.0 + 3.0 * (cut - 10.0) / 60.0
    assert west.furniture.objects == (
        replace(
            rail,
            id=1000,
            road=1000,
            length=about(cut - 10.0),
            repeat=replace(repeat, length=about(cut - 10.0), t_end=about(t)),
        ),
    )
    assert east.furniture.objects == (
        replace(
            rail,
            id=50_000,
            road=50_000,
            s=0.0,
            t=about(t),
            length=about(70.0 - cut),
            repeat=replace(repeat, s=0.0, length=about(70.0 - cut), t_start=about(t)),
        ),
    )
    assert west.furniture.statistics == {"objects": 1.0}


def copies(thing: RoadObject, begin: float) -> list[tuple[float, float]]:
    """Return s on the whole road and t of the copies of an object, whose road begins at a place on it."""
    repeat = thing.repeat
    assert repeat is not None
    count = int(repeat.length / repeat.distance + 1e-9) + 1
    slope = (repeat.t_end - repeat.t_start) / repeat.length if repeat.length else 0.0
    return [
        (begin + repeat.s + k * repeat.distance, repeat.t_start + slope * k * repeat.distance) for k in range(count)
    ]


@pytest.mark.parametrize("distance", [1.5, 2.0, 7.0, 20.0, 60.0, 100.0])
@pytest.mark.parametrize("first", [0.0, 10.0, 29.0, 40.0])
def test_each_copy_stands_on_one_piece(first: float, distance: float) -> None:
    repeat = ObjectRepeat(first, 60.0, distance, 4.0, 7.0, 0.3, 0.8)
    bollards = RoadObject(9, 1, "pole", "bollard", "", first, 4.0, radius=0.15, height=0.8, repeat=repeat)
    west, east = (split(with_object(bollards), AMID, own) for own in (WEST, EAST))
    cut = cut_at(west)
    found = [copies(item, 0.0) for item in west.furniture.objects]
    found += [copies(item, cut) for item in east.furniture.objects]
    expected = copies(bollards, 0.0)
    assert sorted(item for part in found for item in part) == pytest.approx(
        [pytest.approx(item, abs=1e-9) for item in expected]
    )
    assert all(s < cut for item in west.furniture.objects for s, _ in copies(item, 0.0))
    assert all(item.s >= 0.0 for item in east.furniture.objects)


def test_copies_where_the_border_is_stand_behind_it() -> None:
    repeat = ObjectRepeat(10.0, 60.0, 10.0, 4.0, 4.0, 0.3, 0.8)
    bollards = RoadObject(9, 1, "pole", "bollard", "", 10.0, 4.0, radius=0.15, height=0.8, repeat=repeat)
    for own, first in ((WEST, 10.0), (EAST, 0.0)):
        whole = halves_of(with_object(bollards), AMID, own)
        assert whole.borders is not None
        piece_s = whole.borders.piece_s.copy()
        piece_s[1] = 40.0
        half = keep_own_area(replace(whole, borders=replace(whole.borders, piece_s=piece_s)), Diagnostics())
        found = [s for item in half.furniture.objects for s, _ in copies(item, 0.0)]
        assert found == pytest.approx([first, first + 10.0, first + 20.0] + ([30.0] if own == EAST else []))
        assert half.furniture.objects[0].id == FIRST[own]


def test_a_bridge_is_cut_in_two_and_one_beyond_the_border_is_gone() -> None:
    bridge = RoadStructure(9, 1, 10.0, 60.0, "bridge", "steel", "Long one", osm_way_ids=(5, 6))
    tunnel = RoadStructure(10, 1, 80.0, 20.0, "tunnel", "standard", lighting=1.0)
    furniture = Furniture(structures=(bridge, tunnel))
    west, east = (split(replace(furnished_crossing(), furniture=furniture), AMID, own) for own in (WEST, EAST))
    cut = cut_at(west)
    assert west.furniture.structures == (replace(bridge, id=1000, road=1000, length=about(cut - 10.0)),)
    assert east.furniture.structures == (
        replace(bridge, id=50_000, road=50_000, s=0.0, length=about(70.0 - cut)),
        replace(tunnel, id=50_001, road=50_000, s=about(80.0 - cut)),
    )
