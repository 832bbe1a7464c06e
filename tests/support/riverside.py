"""A street with buildings and water around it, some of them across the border of an area."""

from __future__ import annotations

from osm_builder import LAT_0, LAT_PER_METRE, LON_0, LON_PER_METRE, Area

# The area, m, and its corners, degrees: west, south, east, north.
SIDE = 300.0
BOX = (
    *(LON_0 - SIDE * LON_PER_METRE, LAT_0 - SIDE * LAT_PER_METRE),
    *(LON_0 + SIDE * LON_PER_METRE, LAT_0 + SIDE * LAT_PER_METRE),
)

# The street goes on to the east, beyond the area.
_ROADS = {1: ([1, 2], "highway=residential"), 2: ([2, 3], "highway=residential")}
_ROAD_NODES = {1: (-200.0, 0.0), 2: (200.0, 0.0), 3: (900.0, 0.0)}


def _square(first: int, x: float, y: float) -> dict[int, tuple[float, float]]:
    return {first: (x, y), first + 1: (x + 30.0, y), first + 2: (x + 30.0, y + 30.0), first + 3: (x, y + 30.0)}


RIVERSIDE = Area(
    {
        **_ROAD_NODES,
        **_square(11, 50.0, 30.0),
        **_square(21, 280.0, 6.0),
        **_square(31, 500.0, 30.0),
        # An outline of two ways, the second one beyond the area.
        41: (295.0, -20.0),
        42: (295.0, -40.0),
        43: (330.0, -8.0),
        44: (340.0, -8.0),
        # A river's shore, ever farther to the east.
        51: (-250.0, -100.0),
        52: (350.0, -100.0),
        53: (1250.0, -100.0),
        54: (1400.0, -100.0),
        55: (3000.0, -100.0),
        # A coast.
        61: (-250.0, 200.0),
        62: (250.0, 200.0),
    },
    {
        **_ROADS,
        10: ([11, 12, 13, 14, 11], "building=yes height=9"),
        20: ([21, 22, 23, 24, 21], "building:part=yes"),
        30: ([31, 32, 33, 34, 31], "building=house"),
        40: ([43, 41, 42, 44], ""),
        41: ([44, 43], "barrier=wall height=2"),
        50: ([51, 52], ""),
        51: ([52, 53], "waterway=river"),
        52: ([54, 55], ""),
        60: ([61, 62], "natural=coastline"),
        70: ([11, 13, 14, 11], "landuse=forest"),
        80: ([51, 61], "natural=water barrier=wall"),
    },
    {
        1: ([("way", 40, "outer"), ("way", 41, "outer")], "type=multipolygon building=yes"),
        2: ([("way", 50, "outer"), ("way", 51, "outer"), ("way", 52, "outer")], "type=multipolygon natural=water"),
        3: ([("way", 70, "outer")], "type=multipolygon landuse=forest"),
        4: ([("way", 10, "outer")], "type=boundary building=yes"),
    },
    # A corner of a building that lies beyond the area, beside the street that goes on.
    {22: "traffic_sign=DE:274-30 direction=90", 3: "highway=turning_circle"},
)
# What of it belongs to the area, without and with buildings and water: nodes, ways, relations.
ROADS_ALONE: tuple[list[int], ...] = ([1, 2, 3, 51, 61], [1, 2, 80], [])
WITH_SURROUNDINGS = (
    [1, 2, 3, *range(11, 15), *range(21, 25), *range(41, 45), 51, 52, 53, 61, 62],
    [1, 2, 10, 20, 40, 41, 50, 51, 60, 80],
    [1, 2],
)
