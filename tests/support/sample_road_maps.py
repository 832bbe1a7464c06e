"""Road maps made by hand, small enough to know every number of."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from osm2xodr.model import (
    Connection,
    Controller,
    Cubic,
    CubicProfile,
    Furniture,
    Junction,
    Lane,
    LaneSection,
    LaneType,
    LocalFrame,
    ObjectRepeat,
    PlanView,
    Road,
    RoadLink,
    RoadMap,
    RoadMark,
    RoadObject,
    RoadType,
    Rule,
    Signal,
    SignalReference,
)

FRAME = LocalFrame(
    "+proj=tmerc +lat_0=42.55000 +lon_0=1.57000 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +vunits=m +no_defs",
    42.55,
    1.57,
)
BROKEN = RoadMark("broken", "white", 0.12, "both")
SOLID = RoadMark("solid", "white", 0.12, "none")
WIDTH = (Cubic(0.0, 3.25),)


def plan_view(curves: list[list[tuple[float, ...]]]) -> PlanView:
    """Make a plan view of (s, x, y, hdg, length, curvature) per record, a list of records per curve."""
    table = np.array([record for curve in curves for record in curve], dtype=np.float64).reshape(-1, 6)
    start = np.cumsum([0, *map(len, curves)], dtype=np.int64)
    return PlanView(start, *(np.ascontiguousarray(column) for column in table.T))


def profile(curves: list[list[tuple[float, ...]]]) -> CubicProfile:
    """Make a profile of (s, a, b, c, d) per record, a list of records per curve."""
    records = [record for curve in curves for record in curve]
    table = np.array(records, dtype=np.float64).reshape(-1, 5)
    start = np.cumsum([0, *map(len, curves)], dtype=np.int64)
    return CubicProfile(start, *(np.ascontiguousarray(column) for column in table.T))


def lane(number: int, before: int | None = None, after: int | None = None, mark: RoadMark | None = SOLID) -> Lane:
    """Make a driving lane of 3.25 m."""
    return Lane(number, LaneType.DRIVING, WIDTH, before, after, mark)


def centre(mark: RoadMark | None = BROKEN) -> Lane:
    """Make a centre lane."""
    return Lane(0, LaneType.NONE, (), None, None, mark)


def crossing() -> RoadMap:
    """Make a street of 100 m, a junction of 10 m, a street of 80 m ending in a left arc of 90 degrees, all two-way.

    Road 1 runs east from (0, 0), road 2 from (110, 0); 3 and 4 are the connecting roads through junction 5, from 1 to
    2 and back. Heights rise by 2 % from 1000 m on.
    """
    radius = 20.0
    arc = 0.5 * math.pi * radius
    plan = plan_view(
        [
            [(0.0, 0.0, 0.0, 0.0, 100.0, 0.0)],
            [(0.0, 110.0, 0.0, 0.0, 80.0, 0.0), (80.0, 190.0, 0.0, 0.0, arc, 1.0 / radius)],
            [(0.0, 100.0, 0.0, 0.0, 10.0, 0.0)],
            [(0.0, 110.0, 0.0, math.pi, 10.0, 0.0)],
        ]
    )
    elevation = profile(
        [
            [(0.0, 1000.0, 0.02, 0.0, 0.0)],
            [(0.0, 1002.2, 0.02, 0.0, 0.0), (80.0, 1003.8, 0.02, -1e-4, 2e-7)],
            [(0.0, 1002.0, 0.02, 0.0, 0.0)],
            [(0.0, 1002.2, -0.02, 0.0, 0.0)],
        ]
    )
    turning = (Cubic(0.0, 0.0, 0.0, 0.0075, -0.00025), Cubic(20.0, 1.0))
    roads = (
        Road(
            1,
            'Carrer d\'"A & B" <Ç>\x01\ud800',
            None,
            None,
            RoadLink(to_junction=True, id=5),
            (RoadType(0.0, "town", 50.0 / 3.6), RoadType(60.0, "townExpressway", math.inf)),
            (
                LaneSection(0.0, (lane(1, None, 1), centre(), lane(-1, None, -1, BROKEN))),
                LaneSection(
                    60.0,
                    (
                        lane(1, 1, None),
                        centre(SOLID),
                        replace(lane(-1, -1, None, BROKEN), speed=30.0 * 0.44704),
                        Lane(-2, LaneType.BUS, turning, None, None, SOLID, speed=math.inf),
                    ),
                ),
            ),
            (111, 112),
        ),
        Road(
            2,
            "",
            None,
            RoadLink(to_junction=True, id=5),
            None,
            (RoadType(0.0, "rural", None),),
            (LaneSection(0.0, (lane(1), centre(), lane(-1))),),
            (113,),
        ),
        Road(
            3,
            "",
            5,
            RoadLink(to_junction=False, id=1, at_start=False),
            RoadLink(to_junction=False, id=2, at_start=True),
            (),
            (LaneSection(0.0, (centre(None), lane(-1, -1, -1, None))),),
            (),
        ),
        Road(
            4,
            "",
            5,
            RoadLink(to_junction=False, id=2, at_start=True),
            RoadLink(to_junction=False, id=1, at_start=False),
            (),
            (LaneSection(0.0, (centre(None), lane(-1, 1, 1, None))),),
            (),
        ),
    )
    junction = Junction(
        5,
        "",
        (Connection(0, 1, 3, ((-1, -1),)), Connection(1, 2, 4, ((1, -1),))),
        (99,),
        ((1, 2),),
    )
    return RoadMap(
        FRAME,
        Rule.RIGHT_HAND,
        roads,
        (junction,),
        plan,
        elevation,
        profile([[], [(0.0, 0.0, 0.0, 0.0, 0.0), (80.0, 0.0, 0.001, 0.0, 0.0)], [], []]),
        profile([[(0.0, 0.5, 0.0, 0.0, 0.0), (40.0, 0.5, 0.0, -1.5 / 60.0**2, 1.0 / 60.0**3)], [], [], []]),
        {"streets": 2.0},
    )


def straight_roads(count: int) -> RoadMap:
    """Make roads of 10 m side by side: road i starts at x = i and z = i / 8 and has i modulo 3 lane offsets."""
    section = LaneSection(0.0, (centre(), lane(-1)))
    return RoadMap(
        FRAME,
        Rule.RIGHT_HAND,
        tuple(Road(i + 1, str(i), None, None, None, (), (section,), (101 + i,)) for i in range(count)),
        (),
        plan_view([[(0.0, float(i), 0.0, 0.5, 10.0, 0.0)] for i in range(count)]),
        profile([[(0.0, i / 8, 0.0, 0.0, 0.0)] for i in range(count)]),
        profile([[] for _ in range(count)]),
        profile([[(float(k), 0.5, 0.0, 0.0, 0.0) for k in range(i % 3)] for i in range(count)]),
    )


def furnished_crossing() -> RoadMap:
    """Return `crossing` with one of everything that furniture has.

    Traffic lights 1 and 2 stand at the ends of roads 1 and 2 that lie at the junction and govern roads 3 and 4 too; a
    crosswalk lies on road 1 at s = 80, between its sidewalk and the other edge.
    """
    bare = crossing()
    sidewalk = Lane(-2, LaneType.SIDEWALK, (Cubic(0.0, 2.0),), road_mark=SOLID, height=0.12)
    first, second, third, fourth = bare.roads
    section = second.lane_sections[0]
    second = replace(
        second,
        lane_sections=(
            replace(section, lanes=(*section.lanes, sidewalk, replace(sidewalk, id=-3, type=LaneType.CURB))),
        ),
        guesses=("lanes-guessed", "width-guessed"),
    )
    lamp = ObjectRepeat(0.0, 60.0, 20.0, -5.0, -5.0, 0.3, 6.0)
    furniture = Furniture(
        signals=(
            Signal(
                1,
                1,
                98.0,
                -4.5,
                "light",
                "1000001",
                "-1",
                "OpenDRIVE",
                True,
                "+",
                2.2,
                1.0,
                0.3,
                validity=((-2, -1),),
                osm_id="node/42",
            ),
            Signal(
                3,
                1,
                20.0,
                -4.0,
                "limit",
                "274",
                "57",
                "DE",
                False,
                "+",
                2.0,
                0.6,
                0.6,
                h_offset=0.1,
                value=70.0,
                unit="km/h",
                text='"70" & <mehr>',
            ),
            Signal(2, 2, 2.0, 4.5, "", "1000001", "-1", "OpenDRIVE", True, "-", 2.2, 1.0, 0.3),
        ),
        references=(SignalReference(1, 3, 0.0, -4.5, "+", ((-1, -1),)), SignalReference(2, 4, 0.0, -4.5, "+")),
        controllers=(
            Controller(1, "along", (1, 2), 5, 0),
            Controller(2, "alone", (3,), None, 0, "pedestrian"),
        ),
        objects=(
            RoadObject(
                4,
                1,
                "crosswalk",
                "zebra",
                "",
                80.0,
                0.0,
                length=7.0,
                width=4.0,
                hdg=0.5 * math.pi,
                outline=((-3.5, 2.0, 0.0, 0.0), (3.5, 2.0, 0.0, 0.0), (3.5, -2.0, 0.0, 0.0), (-3.5, -2.0, 0.0, 0.0)),
                osm_id="node/43",
            ),
            RoadObject(
                5,
                1,
                "roadMark",
                "signalLines",
                "StopLine",
                95.0,
                -1.6,
                width=3.0,
                length=0.5,
                orientation="+",
                validity=((-1, -1),),
            ),
            RoadObject(6, 1, "roadSurface", "speedBump", "", 40.0, 0.0, width=6.0, length=1.0, height=0.1),
            RoadObject(7, 2, "streetLamp", "", "", 0.0, -5.0, height=6.0, radius=0.15, repeat=lamp, osm_id="node/44"),
            RoadObject(8, 2, "barrier", "guardRail", "", 10.0, 6.0, height=0.8, length=30.0, width=0.3),
        ),
    )
    return replace(bare, roads=(first, second, third, fourth), furniture=furniture)
