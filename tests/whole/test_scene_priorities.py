"""Who goes first at the junctions of real places."""

from __future__ import annotations

import pytest
from lxml import etree
from scene_files import SCENES, Conversion, Conversions, Scene, scene_named


def figures(conversion: Conversion) -> dict[str, float]:
    statistics = conversion.report["statistics"]
    assert isinstance(statistics, dict)
    further: dict[str, float] = statistics["further"]
    return further


@pytest.mark.parametrize("scene", SCENES, ids=str)
def test_pairs_are_of_connecting_roads_that_come_from_different_roads(scene: Scene, conversions: Conversions) -> None:
    conversion = conversions.of(scene)
    number = 0
    for junction in etree.parse(str(conversion.path)).iterfind("junction"):
        incoming = {item.get("connectingRoad"): item.get("incomingRoad") for item in junction.iterfind("connection")}
        pairs = [(item.get("high"), item.get("low")) for item in junction.iterfind("priority")]
        assert len(set(pairs)) == len(pairs)
        assert not {(low, high) for high, low in pairs} & set(pairs)
        for high, low in pairs:
            assert incoming[high] != incoming[low]
        number += len(pairs)
    assert number == figures(conversion)["priorities"] > 0


# What a person counts on the map: entries of roundabouts, stop and give-way signs before junctions, crossings where
# all have to stop, junctions with signals.
COUNTED = {
    "montlake_roundabout": {"roundabout_entries": 5, "signs_followed": 0, "all_way_stops": 0},
    "andorra_ordino": {"signs_followed": 3, "all_way_stops": 0, "junctions_with_signals": 0},
    # A third all-way stop is at the edge of the area, where one arm alone is left.
    "i5_exit_ramp": {"all_way_stops": 2, "signs_followed": 1, "roundabout_entries": 0},
    "fremantle_placement": {"signs_followed": 1, "junctions_with_signals": 1},
}


@pytest.mark.parametrize("name", COUNTED)
def test_what_is_counted(name: str, conversions: Conversions) -> None:
    found = figures(conversions.of(scene_named(name)))
    assert {key: found[key] for key in COUNTED[name]} == COUNTED[name]
