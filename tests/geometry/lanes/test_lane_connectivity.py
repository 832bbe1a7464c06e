"""What connectivity relations say about the lanes of paths over ways, and which of them are told as unheeded."""

from __future__ import annotations

import pytest
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import build_roads
from osm2xodr.geometry.lanes.lane_connectivity import Connectivity, StatedLanes
from osm2xodr.model import Direction, LaneConnectivity, LaneSpec, LaneType
from osm2xodr.surface import FlatSurface

Lanes = tuple[tuple[int, int, bool], ...]
_AHEAD: Lanes = ((1, 1, False), (2, 2, False))


def _relation(
    number: int, one: int, via: int | tuple[int, ...], other: int, lanes: Lanes = _AHEAD
) -> LaneConnectivity:
    node, ways = (via, ()) if isinstance(via, int) else (None, via)
    return LaneConnectivity(number, one, node, ways, other, lanes)


@pytest.mark.parametrize(
    ("relations", "ways", "nodes", "expected"),
    [
        ([_relation(1, 10, 7, 11)], [10, 11], [7], StatedLanes(_AHEAD, (1,))),
        ([_relation(1, 10, 7, 11)], [10, 11], [8], None),
        ([_relation(1, 10, 7, 11)], [11, 10], [7], None),
        ([_relation(1, 10, 7, 11)], [10], [], None),
        ([_relation(1, 10, (12, 13), 11)], [10, 12, 13, 11], [7, 8, 9], StatedLanes(_AHEAD, (1,))),
        ([_relation(1, 10, (12,), 11)], [10, 12, 13, 11], [7, 8, 9], None),
        ([_relation(1, 10, 7, 12)], [10, 12, 11], [7, 8], None),
        (
            [
                _relation(1, 10, 7, 12, ((1, 1, False), (2, 2, False), (2, 3, True))),
                _relation(2, 12, 8, 11, ((1, 2, False), (3, 3, False), (3, 4, True))),
            ],
            [10, 12, 11],
            [7, 8],
            StatedLanes(((1, 2, False), (2, 3, True), (2, 4, True)), (1, 2)),
        ),
    ],
)
def test_what_is_said_of_a_path(
    relations: list[LaneConnectivity], ways: list[int], nodes: list[int], expected: StatedLanes | None
) -> None:
    assert Connectivity.of(relations).along(ways, nodes) == expected


def test_what_is_said_of_a_border_in_either_direction() -> None:
    known = Connectivity.of([_relation(1, 10, 7, 11), _relation(2, 11, 7, 10, ((1, 1, False),))])
    found = known.at_border(10, 11)
    assert {direction: stated.relations for direction, stated in found.items()} == {
        Direction.FORWARD: (1,),
        Direction.BACKWARD: (2,),
    }
    assert known.at_border(10, 12) == {}
    assert not Connectivity.of([])


def test_cycle_lanes_are_not_counted_and_lanes_must_be_there() -> None:
    car, cycle, bus = (
        LaneSpec(kind, Direction.FORWARD, 3.0) for kind in (LaneType.DRIVING, LaneType.BIKING, LaneType.BUS)
    )
    stated = StatedLanes(_AHEAD, (1,))
    assert stated.between((car, cycle, bus), (cycle, car, car)) == ((0, 1), (2, 2))
    assert stated.between((car, cycle), (car, car)) is None
    assert stated.between((car, car), (car,)) is None


_CROSS = {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "s": (0.0, -80.0), "m": (-40.0, 0.0)}


@pytest.mark.parametrize(
    ("relation", "told"),
    [
        ((1, "o", 2, "1:1|2:2", 2, 2), []),
        ((1, "o", 2, "1:1|2:3", 2, 2), ["relation/9001"]),
        ((1, "o", 3, "2:1", 2, 1), []),
        ((2, "o", 3, "3:1", 3, 1), ["relation/9001"]),
        ((4, "m", 1, "1:1|2:2", 2, 2), []),
        ((4, "m", 1, "1:1|2:3", 2, 3), ["relation/9001"]),
    ],
)
def test_relations_that_decide_nothing_are_told(
    relation: tuple[int, str, int, str, int, int], told: list[str]
) -> None:
    ways = {1: ("m o", "lanes=4"), 2: ("o e", "lanes=4"), 3: ("s o", ""), 4: ("w m", "lanes=3 lanes:forward=2")}
    stages = Case(_CROSS, ways, connectivity=(relation,)).stages()
    diagnostics = Diagnostics()
    build_roads(stages.network, FlatSurface(), diagnostics)
    assert [item.osm_id for item in diagnostics if item.code == "connectivity"] == told
