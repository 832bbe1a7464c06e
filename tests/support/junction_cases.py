"""Junctions made by hand, drawn for right-hand traffic, and the lane links that each must have."""

from __future__ import annotations

import math
from typing import NamedTuple

from street_cases import Case, Link, written_links

_CROSS = {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "s": (0.0, -80.0), "n": (0.0, 80.0)}
_CROSS_WAYS = {1: ("w o", ""), 2: ("o e", ""), 3: ("s o", ""), 4: ("o n", "")}
_FROM_WEST = "1:-1>2:-1,3:1,4:-1 "
_FROM_OTHERS = "2:1>1:1,3:1,4:-1 3:-1>1:1,2:-1,4:-1 4:1>1:1,2:-1,3:1"


class Expected(NamedTuple):
    """A case, its number of junctions, and its links through them."""

    case: Case
    junctions: int
    links: set[Link]


def _ring(radius: float, count: int) -> dict[str, tuple[float, float]]:
    """Return nodes r0, r1 … on a circle, counter-clockwise from the east."""
    angles = [2 * math.pi * k / count for k in range(count)]
    return {f"r{k}": (radius * math.cos(a), radius * math.sin(a)) for k, a in enumerate(angles)}


def _roundabout(radius: float, per_quarter: int, tags: str) -> Case:
    """Return a ring of ways 11 to 14 with the two-way streets 1 to 4 at its east, north, west and south."""
    count = 4 * per_quarter
    nodes = _ring(radius, count)
    nodes |= {"e": (100.0, 0.0), "n": (0.0, 100.0), "w": (-100.0, 0.0), "s": (0.0, -100.0)}
    ways = {k + 1: (f"{name} r{k * per_quarter}", "") for k, name in enumerate("enws")}
    for k in range(4):
        listed = " ".join(f"r{(k * per_quarter + i) % count}" for i in range(per_quarter + 1))
        ways[11 + k] = (listed, f"junction=roundabout {tags}")
    return Case(nodes, ways)


def dual_cross(half: float) -> Case:
    """Return two dual carriageways that cross in four nodes; ways 1, 4, 7, 10 lead in, 3, 6, 9, 12 out."""
    nodes = {"a": (-half, -half), "b": (half, -half), "c": (half, half), "d": (-half, half)}
    nodes |= {"w": (-100.0, -half), "w2": (-100.0, half), "e": (100.0, -half), "e2": (100.0, half)}
    nodes |= {"s": (half, -100.0), "s2": (-half, -100.0), "n": (half, 100.0), "n2": (-half, 100.0)}
    rows = ("w a", "a b", "b e", "e2 c", "c d", "d w2", "s b", "b c", "c n", "n2 d", "d a", "a s2")
    tags = "highway=primary oneway=yes lanes=2"
    back = ((1, "2 8 5", 6), (4, "5 11 2", 3), (7, "8 5 11", 12), (10, "11 2 8", 9))
    rules = tuple(("no_u_turn", one, via, other) for one, via, other in back)
    return Case(nodes, {k + 1: (row, tags) for k, row in enumerate(rows)}, rules)


_DUAL_LINKS = (
    "1:-1>3:-1,9:-1 1:-2>3:-2,12:-2 4:-1>6:-1,12:-1 4:-2>6:-2,9:-2 "
    "7:-1>9:-1,6:-1 7:-2>9:-2,3:-2 10:-1>12:-1,3:-1 10:-2>12:-2,6:-2"
)


def _merge(lanes_after: int) -> Case:
    angle = math.radians(10.0)
    nodes = {"w": (-300.0, 0.0), "o": (0.0, 0.0), "e": (300.0, 0.0)}
    nodes["r"] = (-200.0 * math.cos(angle), -200.0 * math.sin(angle))
    return Case(
        nodes,
        {
            1: ("w o", "highway=motorway lanes=2"),
            2: ("r o", "highway=motorway_link lanes=1"),
            3: ("o e", f"highway=motorway lanes={lanes_after}"),
        },
    )


def _split(lanes_before: int) -> Case:
    angle = math.radians(10.0)
    nodes = {"w": (-300.0, 0.0), "o": (0.0, 0.0), "e": (300.0, 0.0)}
    nodes["r"] = (200.0 * math.cos(angle), -200.0 * math.sin(angle))
    return Case(
        nodes,
        {
            1: ("w o", f"highway=motorway lanes={lanes_before}"),
            2: ("o e", "highway=motorway lanes=2"),
            3: ("o r", "highway=motorway_link lanes=1"),
        },
    )


def _slip(reach: float, *, restricted: bool) -> Case:
    """Return a T whose right turn from the west has a slip road, way 4."""
    nodes = {"w": (-120.0, 0.0), "a": (-reach, 0.0), "o": (0.0, 0.0), "e": (120.0, 0.0)}
    nodes |= {"b": (0.0, -reach), "s": (0.0, -120.0), "m": (-0.3 * reach, -0.3 * reach)}
    ways = {
        1: ("w a", ""),
        2: ("o e", ""),
        3: ("b s", ""),
        4: ("a m b", "highway=tertiary_link oneway=yes"),
        5: ("a o", ""),
        6: ("o b", ""),
    }
    rules = (("no_right_turn", 5, "o", 6), ("no_u_turn", 5, "a", 4), ("no_u_turn", 4, "b", 6))
    return Case(nodes, ways, rules if restricted else ())


def _star() -> Expected:
    nodes = {"o": (0.0, 0.0)}
    for k in range(6):
        angle = math.radians(60 * k + 10)
        nodes[f"p{k}"] = (100 * math.cos(angle), 100 * math.sin(angle))
    # Every street leads away from the centre: one comes in on lane 1 and leaves on lane -1.
    links = {(one, 1, other, -1) for one in range(1, 7) for other in range(1, 7) if one != other}
    return Expected(Case(nodes, {k + 1: (f"o p{k}", "") for k in range(6)}), 1, links)


def _ring_links(entry: str, through: tuple[str, ...], leave: str) -> str:
    """Write the links of a roundabout: `entry` lane of the ring, lanes that go on, lane that leaves."""
    words = []
    for k in range(4):
        arm, before, after = k + 1, 11 + (k + 3) % 4, 11 + k
        words.append(f"{arm}:-1>{after}:{entry}")
        words += [f"{before}:{lane}>{after}:{lane}" for lane in through]
        words.append(f"{before}:{leave}>{arm}:1")
    return " ".join(words)


_OFFSET_T = Case(
    {**_CROSS, "a": (-4.0, 0.0), "b": (4.0, 0.0), "s": (-4.0, -80.0), "n": (4.0, 80.0)},
    {1: ("w a", ""), 2: ("b e", ""), 3: ("s a", ""), 4: ("b n", ""), 5: ("a b", "")},
)
_CROSS_CASE = Case(_CROSS, _CROSS_WAYS)
_LOOP = {"w": (-80.0, 0.0), "o": (0.0, 0.0), "a": (30.0, -25.0), "b": (60.0, 0.0), "c": (30.0, 25.0)}
_FORK = {"w": (-100.0, 0.0), "o": (0.0, 0.0), "a": (40.0, -6.0), "b": (40.0, 6.0), "e": (140.0, -6.0)}
_FORK |= {"e2": (140.0, 6.0)}
_FORK_WAYS = {1: ("w o", ""), 2: ("o a e", "oneway=yes"), 3: ("e2 b o", "oneway=yes")}


def _lanes(tags: str) -> Case:
    """Return a crossing whose street from the west comes with other tags."""
    return Case(_CROSS, {**_CROSS_WAYS, 1: ("w o", tags)})


def _dual_t() -> Case:
    """Return a dual carriageway, ways 1 and 2 east and 3 and 4 west, that street 5 joins over the median, way 6."""
    nodes = {"w": (-100.0, -6.0), "w2": (-100.0, 6.0), "e": (100.0, -6.0), "e2": (100.0, 6.0)}
    nodes |= {"a": (0.0, -6.0), "b": (0.0, 6.0), "n": (0.0, 90.0)}
    tags = "oneway=yes lanes=2 highway=primary"
    rows = {1: "w a", 2: "a e", 3: "e2 b", 4: "b w2"}
    return Case(nodes, {k: (row, tags) for k, row in rows.items()} | {5: ("n b", ""), 6: ("b a", "")})


def _auxiliary() -> Case:
    """Return a motorway with an auxiliary lane from a ramp that joins, way 2, to one that leaves, way 5."""
    dx, dy = 200.0 * math.cos(math.radians(10.0)), 200.0 * math.sin(math.radians(10.0))
    nodes = {"w": (-300.0, 0.0), "a": (0.0, 0.0), "b": (400.0, 0.0), "e": (700.0, 0.0)}
    nodes |= {"r": (-dx, -dy), "q": (400.0 + dx, -dy)}
    ways = {
        1: ("w a", "highway=motorway lanes=2"),
        2: ("r a", "highway=motorway_link lanes=1"),
        3: ("a b", "highway=motorway lanes=3 turn:lanes=through|through|slight_right"),
        4: ("b e", "highway=motorway lanes=2"),
        5: ("b q", "highway=motorway_link lanes=1"),
    }
    return Case(nodes, ways)


def _bypass() -> Case:
    """Return a roundabout that way 7 passes by from the street in the west, 3 and 5, to the south, 4 and 6."""
    ring = _roundabout(22.0, 4, "")
    nodes = {**ring.nodes, "p": (-60.0, 0.0), "q": (0.0, -60.0), "m": (-32.0, -32.0)}
    ways = {**ring.ways, 3: ("w p", ""), 5: ("p r8", ""), 4: ("s q", ""), 6: ("q r12", "")}
    rules = (("no_right_turn", 5, "p", 7), ("no_left_turn", 7, "q", 6))
    return Case(nodes, {**ways, 7: ("p m q", "highway=tertiary_link oneway=yes")}, rules)


_THREE = "lanes=4 lanes:forward=3 lanes:backward=1"
_BUS = "lanes=3 lanes:forward=2 lanes:backward=1 bus:lanes:forward=yes|designated vehicle:lanes:forward=yes|no"
_CENTRE = "lanes=3 lanes:forward=1 lanes:backward=1 lanes:both_ways=1 turn:lanes:both_ways=left"
_LANES_NAMED = Case(
    _CROSS, {**_CROSS_WAYS, 1: ("w o", _THREE), 2: ("o e", _THREE)}, connectivity=((1, "o", 2, "1:1|2:2,(3)", 3, 3),)
)
_OFFSET_WIDE = Case(
    _OFFSET_T.nodes,
    {1: ("w a", _THREE), 2: ("b e", _THREE), 3: ("s a", ""), 4: ("b n", ""), 5: ("a b", _THREE)},
)
_CUL_DE_SAC = {"w": (-80.0, 0.0), "o": (0.0, 0.0)}

CASES: dict[str, Expected] = {
    "t": Expected(
        Case(_CROSS, {1: ("w o", ""), 2: ("o e", ""), 3: ("s o", "")}),
        1,
        written_links("1:-1>2:-1,3:1 2:1>1:1,3:1 3:-1>1:1,2:-1"),
    ),
    "x": Expected(_CROSS_CASE, 1, written_links(_FROM_WEST + _FROM_OTHERS)),
    "offset_t": Expected(_OFFSET_T, 1, written_links(_FROM_WEST + _FROM_OTHERS)),
    "dual_cross": Expected(dual_cross(5.0), 1, written_links(_DUAL_LINKS)),
    "dual_cross_far_apart": Expected(
        Case(dual_cross(15.0).nodes, dual_cross(15.0).ways),
        4,
        written_links(
            "1:-1>2:-1 1:-2>2:-2,12:-2 2:-1>3:-1,8:-1 2:-2>3:-2 4:-1>5:-1 4:-2>5:-2,9:-2 5:-1>6:-1,11:-1 5:-2>6:-2 "
            "7:-1>8:-1 7:-2>8:-2,3:-2 8:-1>9:-1,5:-1 8:-2>9:-2 "
            "10:-1>11:-1 10:-2>11:-2,6:-2 11:-1>12:-1,2:-1 11:-2>12:-2"
        ),
    ),
    "slip_lane": Expected(
        _slip(45.0, restricted=True),
        3,
        written_links("1:-1>5:-1,4:-1 5:1>1:1 5:-1>2:-1 2:1>5:1,6:-1 6:1>5:1,2:-1 6:-1>3:-1 4:-1>3:-1 3:1>6:1"),
    ),
    "slip_lane_short": Expected(
        _slip(12.0, restricted=True), 1, written_links("1:-1>2:-1,3:-1 2:1>1:1,3:-1 3:1>1:1,2:-1")
    ),
    "y_merge": Expected(_merge(2), 1, written_links("1:-1>3:-1 1:-2>3:-2 2:-1>3:-2")),
    "y_merge_added_lane": Expected(_merge(3), 1, written_links("1:-1>3:-1 1:-2>3:-2 2:-1>3:-3")),
    "y_split": Expected(_split(2), 1, written_links("1:-1>2:-1 1:-2>2:-2,3:-1")),
    "y_split_dropped_lane": Expected(_split(3), 1, written_links("1:-1>2:-1 1:-2>2:-2 1:-3>3:-1")),
    "mini_roundabout": Expected(
        Case(_CROSS, _CROSS_WAYS, node_tags={"o": "highway=mini_roundabout"}),
        1,
        written_links(_FROM_WEST + _FROM_OTHERS),
    ),
    "roundabout": Expected(_roundabout(18.0, 4, ""), 4, written_links(_ring_links("-1", ("-1",), "-1"))),
    "roundabout_few_nodes": Expected(_roundabout(14.0, 1, ""), 4, written_links(_ring_links("-1", ("-1",), "-1"))),
    "roundabout_two_lanes": Expected(
        _roundabout(22.0, 4, "lanes=2"), 4, written_links(_ring_links("-2", ("-1", "-2"), "-2"))
    ),
    "only_straight_on": Expected(
        Case(_CROSS, _CROSS_WAYS, (("only_straight_on", 1, "o", 2),)), 1, written_links("1:-1>2:-1 " + _FROM_OTHERS)
    ),
    "no_left_turn": Expected(
        Case(_CROSS, _CROSS_WAYS, (("no_left_turn", 1, "o", 4),)), 1, written_links("1:-1>2:-1,3:1 " + _FROM_OTHERS)
    ),
    "no_left_turn_via_way": Expected(
        Case(_OFFSET_T.nodes, _OFFSET_T.ways, (("no_left_turn", 3, "5", 4),)),
        1,
        written_links(_FROM_WEST + _FROM_OTHERS) - {(3, -1, 4, -1)},
    ),
    "fork": Expected(Case(_FORK, _FORK_WAYS), 1, written_links("1:-1>2:-1 3:-1>1:1,2:-1")),
    "no_u_turn": Expected(
        Case(_FORK, _FORK_WAYS, (("no_u_turn", 3, "o", 2),)), 1, written_links("1:-1>2:-1 3:-1>1:1")
    ),
    "lollipop": Expected(
        Case(_LOOP, {1: ("w o", ""), 2: ("o a b c o", "")}),
        1,
        written_links("1:-1>2:-1,2:1 2:-1>1:1,2:-1 2:1>1:1,2:1"),
    ),
    "closed_loop_road": Expected(
        Case(_LOOP, {1: ("w o", ""), 2: ("o a b c o", "oneway=yes")}), 1, written_links("1:-1>2:-1 2:-1>1:1,2:-1")
    ),
    "isolated_ring": Expected(
        Case(
            _ring(30.0, 12) | {"w": (-80.0, 60.0), "e": (80.0, 60.0)},
            {1: (" ".join([f"r{k}" for k in range(12)] + ["r0"]), ""), 2: ("w e", "")},
        ),
        0,
        set(),
    ),
    "roads_meeting_twice": Expected(
        Case(
            {"w": (-80.0, 0.0), "a": (0.0, 0.0), "b": (70.0, 0.0), "e": (150.0, 0.0), "m": (35.0, 40.0)},
            {1: ("w a", ""), 2: ("a b", ""), 3: ("a m b", ""), 4: ("b e", "")},
        ),
        2,
        written_links("1:-1>2:-1,3:-1 2:1>1:1,3:-1 3:1>1:1,2:-1 2:-1>4:-1,3:1 3:-1>4:-1,2:1 4:1>2:1,3:1"),
    ),
    "star": _star(),
    "bridge": Expected(Case(_CROSS, {1: ("w e", ""), 2: ("s n", "bridge=yes layer=1")}), 0, set()),
    "pockets": Expected(
        _lanes("lanes=4 lanes:forward=3 lanes:backward=1 turn:lanes:forward=left|through|right"),
        1,
        written_links("1:-1>4:-1 1:-2>2:-1 1:-3>3:1 " + _FROM_OTHERS),
    ),
    "shared_pocket": Expected(
        _lanes("lanes=3 lanes:forward=2 lanes:backward=1 turn:lanes:forward=left;through|right"),
        1,
        written_links("1:-1>4:-1,2:-1 1:-2>3:1 " + _FROM_OTHERS),
    ),
    "unmarked_lanes": Expected(
        Case(_CROSS, {**_CROSS_WAYS, 1: ("w o", "lanes=4"), 2: ("o e", "lanes=4")}),
        1,
        written_links("1:-1>4:-1,2:-1 1:-2>2:-2,3:1 2:1>1:1,3:1 2:2>1:2,4:-1 3:-1>1:1,2:-2,4:-1 4:1>1:2,2:-1,3:1"),
    ),
    "bus_lane": Expected(
        Case(_CROSS, {**_CROSS_WAYS, 1: ("w o", _BUS), 2: ("o e", _BUS)}),
        1,
        written_links(_FROM_WEST + _FROM_OTHERS + " 1:-2>2:-2"),
    ),
    "bus_lane_ends": Expected(_lanes(_BUS), 1, written_links(_FROM_WEST + _FROM_OTHERS + " 1:-2>2:-1")),
    "centre_lane": Expected(
        Case(_CROSS, {**_CROSS_WAYS, 1: ("w o", _CENTRE), 2: ("o e", _CENTRE)}),
        1,
        written_links("1:-1>2:-1 2:-1>1:-1 1:-2>2:-2,3:1,4:-1 2:1>1:1,3:1,4:-1 3:-1>1:1,2:-2,4:-1 4:1>1:1,2:-2,3:1"),
    ),
    "turning_circle": Expected(
        Case(_CUL_DE_SAC, {1: ("w o", "")}, node_tags={"o": "highway=turning_circle"}), 1, written_links("1:-1>1:1")
    ),
    "turning_loop_of_four_lanes": Expected(
        Case(_CUL_DE_SAC, {1: ("w o", "lanes=4")}, node_tags={"o": "highway=turning_loop diameter=30"}),
        1,
        written_links("1:-1>1:1 1:-2>1:2"),
    ),
    "dead_end": Expected(Case(_CUL_DE_SAC, {1: ("w o", "")}), 0, set()),
    "dual_cross_apart": Expected(
        Case(dual_cross(7.0).nodes, dual_cross(7.0).ways, dual_cross(7.0).restrictions),
        1,
        written_links(_DUAL_LINKS),
    ),
    "dual_t": Expected(
        _dual_t(),
        1,
        written_links("1:-1>2:-1,4:-1,5:1 1:-2>2:-2 3:-1>2:-1,4:-1 3:-2>4:-2,5:1 5:-1>2:-1,4:-2"),
    ),
    "roundabout_with_bypass": Expected(
        _bypass(),
        6,
        written_links(
            "1:-1>11:-1 2:-1>12:-1 3:-1>5:-1,7:-1 4:-1>6:-1 5:-1>13:-1 5:1>3:1 6:-1>14:-1 6:1>4:1 7:-1>4:1 "
            "11:-1>2:1,12:-1 12:-1>5:1,13:-1 13:-1>6:1,14:-1 14:-1>1:1,11:-1"
        ),
    ),
    "auxiliary_lane": Expected(
        _auxiliary(), 2, written_links("1:-1>3:-1 1:-2>3:-2 2:-1>3:-3 3:-1>4:-1 3:-2>4:-2 3:-3>5:-1")
    ),
    "service_road_onto_primary": Expected(
        Case(
            _CROSS,
            {
                1: ("w o", "highway=primary lanes=4"),
                2: ("o e", "highway=primary lanes=4"),
                3: ("s o", "highway=service"),
            },
        ),
        1,
        written_links("1:-1>2:-1 1:-2>2:-2,3:1 2:1>1:1,3:1 2:2>1:2 3:-1>1:1,2:-2"),
    ),
    "two_lanes_turn_left": Expected(
        Case(
            _CROSS,
            {
                **_CROSS_WAYS,
                1: ("w o", f"{_THREE} turn:lanes:forward=left|left|through;right"),
                4: ("o n", "lanes=4"),
            },
        ),
        1,
        written_links(
            "1:-1>4:-1 1:-2>4:-2 1:-3>2:-1,3:1 2:1>1:1,3:1,4:-2 3:-1>1:1,2:-1,4:-1 4:1>2:-1,3:1 4:2>1:1,3:1"
        ),
    ),
    "connectivity": Expected(
        _LANES_NAMED,
        1,
        written_links("1:-1>2:-1,4:-1 1:-2>2:-2,2:-3 1:-3>3:1 2:1>1:1,3:1,4:-1 3:-1>1:1,2:-3,4:-1 4:1>1:1,2:-1,3:1"),
    ),
    "connectivity_via_way": Expected(
        Case(_OFFSET_WIDE.nodes, _OFFSET_WIDE.ways, connectivity=((1, "5", 2, "1:1|2:2,3", 3, 3),)),
        1,
        written_links("1:-1>2:-1,4:-1 1:-2>2:-2,2:-3 1:-3>3:1 2:1>1:1,3:1,4:-1 3:-1>1:1,2:-3,4:-1 4:1>1:1,2:-1,3:1"),
    ),
    "connectivity_in_two_steps": Expected(
        Case(
            _OFFSET_WIDE.nodes,
            _OFFSET_WIDE.ways,
            connectivity=((1, "a", 5, "1:1|2:2|3:3", 3, 3), (5, "b", 2, "1:2|2:2|3:3", 3, 3)),
        ),
        1,
        written_links("1:-1>2:-2,4:-1 1:-2>2:-2 1:-3>2:-3,3:1 2:1>1:1,3:1,4:-1 3:-1>1:1,2:-3,4:-1 4:1>1:1,2:-1,3:1"),
    ),
}
