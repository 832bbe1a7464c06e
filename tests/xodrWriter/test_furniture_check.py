"""Furniture that no stage should make is refused, not written."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
from sample_road_maps import crossing, furnished_crossing

from osm2xodr.errors import OutputError
from osm2xodr.model import Furniture, ObjectRepeat, RoadMap, RoadObject, RoadStructure
from osm2xodr.xodrWriter.check import check_road_map

FURNITURE = furnished_crossing().furniture


def test_sound_furniture_passes() -> None:
    assert len(check_road_map(furnished_crossing())) == 4
    assert len(check_road_map(crossing())) == 4


def signal_of_no_road() -> Furniture:
    return replace(FURNITURE, signals=(replace(FURNITURE.signals[0], road=77), *FURNITURE.signals[1:]))


def signal_behind_the_end() -> Furniture:
    return replace(FURNITURE, signals=(replace(FURNITURE.signals[0], s=100.1), *FURNITURE.signals[1:]))


def reference_before_the_start() -> Furniture:
    return replace(FURNITURE, references=(replace(FURNITURE.references[0], s=-1.0),))


def repeat_behind_the_end() -> Furniture:
    fence = ObjectRepeat(10.0, 95.0, 0.0, 5.0, 5.0, 0.1, 1.0)
    return Furniture(objects=(RoadObject(1, 1, "barrier", "", "", 10.0, 5.0, repeat=fence, osm_id="way/9"),))


def bridge_behind_the_end() -> Furniture:
    return Furniture(structures=(RoadStructure(1, 1, 50.0, 51.0, "bridge", "steel"),))


def tunnel_with_the_id_of_a_signal() -> Furniture:
    return replace(FURNITURE, structures=(RoadStructure(1, 1, 50.0, 10.0, "tunnel", "standard"),))


def object_nowhere() -> Furniture:
    return Furniture(objects=(RoadObject(1, 1, "tree", "", "", 10.0, math.nan),))


def corner_nowhere() -> Furniture:
    square = ((0.0, 0.0, 0.0, 0.0), (1.0, 0.0, math.inf, 0.0), (1.0, 1.0, 0.0, 0.0))
    return Furniture(objects=(RoadObject(1, 1, "patch", "", "", 10.0, 0.0, outline=square),))


def id_of_a_signal_and_an_object() -> Furniture:
    return replace(FURNITURE, objects=(replace(FURNITURE.objects[0], id=1),))


def id_of_two_controllers() -> Furniture:
    return replace(FURNITURE, controllers=(FURNITURE.controllers[0],) * 2)


def reference_to_nothing() -> Furniture:
    return replace(FURNITURE, references=(replace(FURNITURE.references[0], signal=77),))


def controller_of_nothing() -> Furniture:
    return replace(FURNITURE, controllers=(replace(FURNITURE.controllers[0], signals=()),))


def controller_of_an_object() -> Furniture:
    return replace(FURNITURE, controllers=(replace(FURNITURE.controllers[0], signals=(4,)),))


def controller_of_no_junction() -> Furniture:
    return replace(FURNITURE, controllers=(replace(FURNITURE.controllers[0], junction=1),))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (signal_of_no_road, r"signal 1 \(node/42\) stands on road 77, which is not there"),
        (signal_behind_the_end, r"signal 1 \(node/42\) does not stand within the 100\.000 m of road 1: s 100\.100"),
        (reference_before_the_start, r"a reference to signal 1 does not stand within the 10\.000 m of road 3"),
        (repeat_behind_the_end, r"object 1 \(way/9\) does not stand within the 100\.000 m of road 1"),
        (bridge_behind_the_end, r"bridge 1 does not stand within the 100\.000 m of road 1: s 50\.000"),
        (object_nowhere, "object 1 has a number that is not finite"),
        (corner_nowhere, "object 1 has a number that is not finite"),
        (id_of_a_signal_and_an_object, "signals, objects, bridges and tunnels need ids of their own above 0"),
        (tunnel_with_the_id_of_a_signal, "signals, objects, bridges and tunnels need ids of their own above 0"),
        (id_of_two_controllers, "controllers need ids of their own above 0"),
        (reference_to_nothing, "road 3 refers to signal 77, which is not there"),
        (controller_of_nothing, "controller 1 has no signal"),
        (controller_of_an_object, "controller 1 names signal 4, which is not there"),
        (controller_of_no_junction, "controller 1 names junction 1, which is not there"),
    ],
)
def test_defects_are_refused(make: Callable[[], Furniture], message: str) -> None:
    road_map: RoadMap = replace(furnished_crossing(), furniture=make())
    with pytest.raises(OutputError, match=message + ".*this is a defect of osm2xodr"):
        check_road_map(road_map)
