from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st
from osm_builder import Area, about

from osm2xodr.model import Direction, LaneType, MarginSpec, Rule, StreetNetwork
from osm2xodr.osmParsing import ParseOptions

# The streets are 5.5 m wide. Its edges are 2.75 m from its middle.
STREET = {1: (0.0, 0.0), 2: (60.0, 0.0), 3: (120.0, 0.0), 4: (200.0, 0.0)}
BOTH = Direction.BOTH


def verge(width: float, height: float = 0.12) -> MarginSpec:
    return MarginSpec(LaneType.BORDER, width, BOTH, height)


def walk(width: float = 2.0, height: float = 0.12) -> MarginSpec:
    return MarginSpec(LaneType.SIDEWALK, width, BOTH, height)


def margins(network: StreetNetwork) -> list[tuple[list[MarginSpec], list[MarginSpec]]]:
    """Return what lies left and right of each piece, streets seen along ascending node ids, in that order."""
    out = []
    for street in network.streets:
        along = street.node_ids[0] < street.node_ids[-1]
        ends = [*(at for at, _ in street.pieces[1:]), len(street.points) - 1]
        for (at, piece), end in zip(street.pieces, ends, strict=True):
            sides = [list(piece.margin_left), list(piece.margin_right)]
            if not along:
                sides = [[turned(strip) for strip in side] for side in reversed(sides)]
            out.append((int(min(street.node_ids[at], street.node_ids[end])), sides[0], sides[1]))
    return [(left, right) for _, left, right in sorted(out, key=lambda item: item[0])]


def turned(strip: MarginSpec) -> MarginSpec:
    return MarginSpec(strip.type, strip.width, Direction(-strip.direction), strip.height)


def beside(
    folder: Path,
    footways: Sequence[tuple[float, str]],
    street: str = "",
    turn: Sequence[bool] = (False, False),
    rule: Rule | None = None,
    span: tuple[float, float] = (0.0, 200.0),
) -> list[tuple[list[MarginSpec], list[MarginSpec]]]:
    """Return the margins of a straight street with ways beside it, (y, tags) each."""
    nodes = dict(STREET)
    street_tags = street if "highway=" in street else f"highway=residential width=5.5 {street}"
    ways = {20: (list(STREET)[:: -1 if turn[0] else 1], street_tags)}
    for number, (y, tags) in enumerate(footways):
        a, b = 100 + 2 * number, 101 + 2 * number
        nodes[a], nodes[b] = (span[0], y), (span[1], y)
        ways[30 + number] = ([b, a] if turn[1] else [a, b], tags)
    network, _ = Area(nodes, ways).parse(folder, ParseOptions(rule=rule, guessed_sidewalks=False))
    return margins(network)


SIDEWALK = "highway=footway footway=sidewalk"


@pytest.mark.parametrize("rule", [Rule.RIGHT_HAND, Rule.LEFT_HAND])
@pytest.mark.parametrize("turn", [(False, False), (True, False), (False, True), (True, True)])
def test_both_sides(tmp_path: Path, turn: tuple[bool, bool], rule: Rule) -> None:
    found = beside(tmp_path, [(6.05, SIDEWALK), (-4.0, f"{SIDEWALK} width=2.5")], turn=turn, rule=rule)
    assert found == [([verge(2.3), walk()], [walk(2.5)])]


@pytest.mark.parametrize(
    ("y", "tags", "street", "expected"),
    [
        (6.05, "highway=footway", "", [verge(2.3), walk()]),
        (6.05, "highway=path foot=designated bicycle=designated", "", [verge(2.3), walk()]),
        (10.55, SIDEWALK, "", [verge(6.8), walk()]),
        (10.9, SIDEWALK, "", []),
        (8.55, "highway=footway", "", [verge(4.8), walk()]),
        (8.9, "highway=footway", "", []),
        (4.05, "highway=footway", "", [walk()]),
        (4.15, "highway=footway", "", [verge(0.4), walk()]),
        (1.5, "highway=footway", "", [walk()]),
        (1.0, "highway=footway", "", []),
        (6.05, "highway=footway width=9", "", [verge(2.3), walk()]),
        (6.05, "highway=footway est_width=3", "", [verge(1.8), walk(3.0)]),
        (6.05, "highway=footway footway=crossing", "", []),
        (6.05, "highway=steps", "", []),
        (6.05, "highway=path", "", []),
        (6.05, SIDEWALK, "kerb=flush", [verge(2.3, 0.0), walk(2.0, 0.0)]),
        (6.05, SIDEWALK, "sidewalk=separate", [verge(2.3), walk()]),
        (6.05, SIDEWALK, "sidewalk=no", []),
        (6.05, SIDEWALK, "sidewalk:left=no", []),
        (6.05, SIDEWALK, "sidewalk=right", []),
        (6.05, SIDEWALK, "sidewalk:right=no", [verge(2.3), walk()]),
        (5.05, SIDEWALK, "sidewalk=no", [verge(1.3), walk()]),
        (6.05, "highway=footway", "highway=motorway", []),
        (6.05, "highway=footway", "highway=service oneway=yes width=2.5", []),
        (6.05, SIDEWALK, "highway=service oneway=yes width=2.5", [verge(3.8), walk()]),
        (4.55, "highway=footway", "highway=service oneway=yes width=2.5", [verge(2.3), walk()]),
    ],
)
def test_distances_widths_and_tags(
    tmp_path: Path, y: float, tags: str, street: str, expected: list[MarginSpec]
) -> None:
    for turn in ((False, False), (False, True)):
        ((left, _),) = beside(tmp_path, [(y, tags)], street, turn)
        assert left == expected


def test_sides_of_tags_turn_with_the_way(tmp_path: Path) -> None:
    assert beside(tmp_path, [(6.05, SIDEWALK)], "sidewalk:left=no", (True, False)) == [([verge(2.3), walk()], [])]
    assert beside(tmp_path, [(6.05, SIDEWALK)], "sidewalk:right=no", (True, False)) == [([], [])]


def test_a_sidewalk_from_tags_stays(tmp_path: Path) -> None:
    plain = beside(tmp_path, [], "sidewalk=both sidewalk:both:width=3")
    assert plain == [([walk(3.0)], [walk(3.0)])]
    assert beside(tmp_path, [(6.05, SIDEWALK), (-8.0, SIDEWALK)], "sidewalk=both sidewalk:both:width=3") == plain


def test_cycleways_and_footways_in_the_order_of_their_distance(tmp_path: Path) -> None:
    track = MarginSpec(LaneType.BIKING, 2.0, Direction.FORWARD, 0.12)
    against = MarginSpec(LaneType.BIKING, 2.0, Direction.BACKWARD, 0.12)
    both_ways = MarginSpec(LaneType.BIKING, 2.5, BOTH, 0.12)
    cycleway = "highway=cycleway oneway=yes"
    ways = [(4.85, cycleway), (7.85, "highway=footway")]
    assert beside(tmp_path, ways) == [([verge(1.1), track, verge(1.0), walk()], [])]
    assert beside(tmp_path, ways, turn=(True, False)) == [([verge(1.1), track, verge(1.0), walk()], [])]
    assert beside(tmp_path, ways, turn=(False, True)) == [([verge(1.1), against, verge(1.0), walk()], [])]
    ways = [(4.85, "highway=footway"), (7.85, "highway=cycleway")]
    assert beside(tmp_path, ways) == [([verge(1.1), walk(), verge(0.8), both_ways], [])]
    # One that people may walk on is a sidewalk.
    assert beside(tmp_path, [(4.85, "highway=cycleway foot=designated")]) == [([verge(1.1), walk()], [])]


@pytest.mark.parametrize(
    ("street", "footway", "attached"),
    [
        ("", "layer=1", False),
        ("", "bridge=yes layer=1", False),
        ("", "tunnel=yes", False),
        ("bridge=yes", "", False),
        ("tunnel=yes layer=-1", "", False),
        ("bridge=yes", "bridge=yes layer=1", True),
        ("tunnel=yes layer=-2", "tunnel=yes layer=-2", True),
        ("layer=0", "layer=0", True),
    ],
)
def test_levels(tmp_path: Path, street: str, footway: str, attached: bool) -> None:
    found = beside(tmp_path, [(6.05, f"highway=footway {footway}")], street)
    assert found == [([verge(2.3), walk()] if attached else [], [])]


def test_a_footway_below_a_bridge_goes_to_the_street_beside_it(tmp_path: Path) -> None:
    nodes = {**STREET, 5: (0.0, 5.0), 6: (200.0, 5.0), 7: (0.0, 6.05), 8: (200.0, 6.05)}
    ways = {
        20: (list(STREET), "highway=residential width=5.5"),
        21: ([5, 6], "highway=residential width=5.5 bridge=yes"),
        30: ([7, 8], "highway=footway"),
    }
    network, _ = Area(nodes, ways).parse(tmp_path)
    assert margins(network) == [([verge(2.3), walk()], []), ([], [])]


@pytest.mark.parametrize(("y", "expected"), [(5.8, (True, False)), (6.2, (False, True))])
def test_the_nearest_of_two_carriageways_takes_it(tmp_path: Path, y: float, expected: tuple[bool, bool]) -> None:
    nodes = {**STREET, 5: (0.0, 12.0), 6: (200.0, 12.0), 7: (0.0, y), 8: (200.0, y)}
    ways = {
        20: (list(STREET), "highway=residential width=5.5"),
        21: ([5, 6], "highway=residential width=5.5"),
        30: ([7, 8], "highway=footway"),
    }
    network, _ = Area(nodes, ways).parse(tmp_path)
    (lower_left, lower_right), (upper_left, upper_right) = margins(network)
    assert (bool(lower_left), bool(upper_right)) == expected
    assert lower_right == upper_left == []


def test_the_nearest_edge_counts_not_the_nearest_line(tmp_path: Path) -> None:
    # 2 m from their edge, and 3.7 m from that of a street whose line is nearer.
    nodes = {**STREET, 5: (0.0, 15.0), 6: (200.0, 15.0), 7: (0.0, 8.55), 8: (200.0, 8.55)}
    ways = {
        20: (list(STREET), "highway=secondary lanes=4 width=13"),
        21: ([5, 6], "highway=residential width=5.5"),
        30: ([7, 8], "highway=footway"),
    }
    network, _ = Area(nodes, ways).parse(tmp_path)
    assert margins(network) == [([verge(1.1), walk()], []), ([], [])]


def test_ways_that_do_not_run_along(tmp_path: Path) -> None:
    nodes = {**STREET, 7: (100.0, 3.0), 8: (100.0, 50.0), 9: (0.0, 3.0), 10: (40.0, 19.5)}
    ways = {
        20: (list(STREET), "highway=residential width=5.5"),
        30: ([7, 8], "highway=footway"),
        31: ([9, 10], SIDEWALK),
    }
    network, _ = Area(nodes, ways).parse(tmp_path)
    assert margins(network) == [([], [])]


def test_streets_are_cut_where_footways_end(tmp_path: Path) -> None:
    # From the start to 123 m; a node of the street is at 120 m.
    found = beside(tmp_path, [(6.05, SIDEWALK)], span=(0.0, 123.0))
    assert found == [([verge(2.3), walk()], []), ([], [])]
    # No node is near 90 m, but most of the street is covered up to 125 m; 65 m are too little of 200 m.
    assert beside(tmp_path, [(6.05, SIDEWALK)], span=(0.0, 92.0)) == [([], [])]
    # Too short a rest.
    assert beside(tmp_path, [(6.05, SIDEWALK)], span=(0.0, 180.0)) == [([verge(2.3), walk()], [])]


def test_cut_pieces_keep_their_ways_attributes(tmp_path: Path) -> None:
    nodes = {**STREET, 7: (0.0, 6.05), 8: (120.0, 6.05)}
    ways = {20: (list(STREET), "highway=residential width=5.5 name=A"), 30: ([7, 8], SIDEWALK)}
    network, _ = Area(nodes, ways).parse(tmp_path)
    (street,) = network.streets
    assert [(at, piece.osm_way_id, piece.name) for at, piece in street.pieces] == [(0, 20, "A"), (2, 20, "A")]


def chain(folder: Path, tags: Sequence[str], parts: Sequence[tuple[float, float, float]]) -> list[list[MarginSpec]]:
    """Return what is left of a street of ways of 40 m each, with footways (x from, x to, y)."""
    nodes = {number: (40.0 * number, 0.0) for number in range(1, len(tags) + 2)}
    ways = {20 + k: ([k + 1, k + 2], f"highway=residential width=5.5 {words}") for k, words in enumerate(tags)}
    for number, (start, end, y) in enumerate(parts):
        nodes[100 + 2 * number], nodes[101 + 2 * number] = (40.0 + start, y), (40.0 + end, y)
        ways[50 + number] = ([100 + 2 * number, 101 + 2 * number], SIDEWALK)
    network, _ = Area(nodes, ways).parse(folder)
    return [left for left, _ in margins(network)]


def test_distances_that_hardly_differ_along_a_street_are_one(tmp_path: Path) -> None:
    found = chain(tmp_path, ["name=A", "name=B", "name=C"], [(0, 40, 6.1), (40, 80, 6.4), (80, 120, 8.15)])
    assert found == [[verge(2.5), walk()], [verge(2.5), walk()], [verge(4.4), walk()]]


def test_short_gaps_are_closed(tmp_path: Path) -> None:
    nodes = {1: (0.0, 0.0), 2: (80.0, 0.0), 3: (95.0, 0.0), 4: (200.0, 0.0)}
    for number, x in enumerate((0.0, 79.0, 96.0, 200.0)):
        nodes[10 + number] = (x, 6.05)
    ways = {
        20: ([1, 2], "highway=residential width=5.5 name=A"),
        21: ([2, 3], "highway=residential width=5.5 name=B"),
        22: ([3, 4], "highway=residential width=5.5 name=C"),
        30: ([10, 11], SIDEWALK),
        31: ([12, 13], SIDEWALK),
    }
    network, _ = Area(nodes, ways).parse(tmp_path)
    assert margins(network) == [([verge(2.3), walk()], [])] * 3
    ways[21] = ([2, 3], "highway=residential width=5.5 name=B sidewalk=no")
    network, _ = Area(nodes, ways).parse(tmp_path)
    assert [bool(left) for left, _ in margins(network)] == [True, False, True]
    ways[21] = ([2, 3], "highway=residential width=5.5 name=B bridge=yes")
    network, _ = Area(nodes, ways).parse(tmp_path)
    assert [bool(left) for left, _ in margins(network)] == [True, True, True]


def test_a_few_metres_are_no_sidewalk(tmp_path: Path) -> None:
    nodes = {1: (0.0, 0.0), 2: (9.0, 0.0), 5: (0.0, 6.05), 6: (9.0, 6.05)}
    ways = {20: ([1, 2], "highway=residential width=5.5"), 30: ([5, 6], SIDEWALK)}
    network, _ = Area(nodes, ways).parse(tmp_path)
    assert margins(network) == [([], [])]


def test_what_was_done_is_said_once(tmp_path: Path) -> None:
    nodes = {**STREET, 5: (0.0, 6.05), 6: (200.0, 6.05), 7: (50.0, 12.0), 8: (50.0, 112.0)}
    ways = {
        20: (list(STREET), "highway=residential width=5.5"),
        30: ([5, 6], SIDEWALK),
        31: ([7, 8], "highway=footway"),
    }
    _, diagnostics = Area(nodes, ways).parse(tmp_path)
    (note,) = about(diagnostics, "separate-sidewalk")
    assert note.message == (
        "0.2 of 0.3 km of footways and cycleways mapped beside streets run along them and become sidewalks and "
        "bicycle tracks there (of 1 street)"
    )


@st.composite
def areas(draw: st.DrawFn) -> tuple[list[tuple[float, float]], list[tuple[float, int, int, str]], list[bool]]:
    """Draw a bent street's nodes, footways beside it (distance, first and last node, tags) and which ways to turn."""
    turns = draw(st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=6))
    places = [(0.0, 0.0)]
    for index, turn in enumerate(turns):
        x, y = places[-1]
        places.append((x + 45.0 + index, y + 45.0 * turn))
    footways = []
    for _ in range(draw(st.integers(1, 4))):
        first = draw(st.integers(0, len(places) - 2))
        last = draw(st.integers(first + 1, len(places) - 1))
        distance = draw(st.floats(3.5, 9.0)) * draw(st.sampled_from([-1.0, 1.0]))
        tags = draw(st.sampled_from([SIDEWALK, "highway=cycleway oneway=yes", "highway=footway width=3"]))
        footways.append((distance, first, last, tags))
    flips = draw(st.lists(st.booleans(), min_size=10, max_size=10))
    return places, footways, flips


@settings(max_examples=30, deadline=None)
@given(areas())
def test_turning_ways_round_changes_nothing(
    drawn: tuple[list[tuple[float, float]], list[tuple[float, int, int, str]], list[bool]],
) -> None:
    places, footways, flips = drawn
    nodes = {number + 1: place for number, place in enumerate(places)}
    ways: dict[int, tuple[list[int], str]] = {}
    for number in range(len(places) - 1):
        ways[20 + number] = ([number + 1, number + 2], f"highway=residential width=5.5 name=N{number // 2}")
    for number, (distance, first, last, tags) in enumerate(footways):
        ids = []
        for index in range(first, last + 1):
            nodes[100 + 10 * number + index] = (places[index][0], places[index][1] + distance)
            ids.append(100 + 10 * number + index)
        ways[50 + number] = (ids, tags)
    turned_ways = {
        number: (refs[::-1], tags.replace("oneway=yes", "oneway=-1")) if flip else (refs, tags)
        for (number, (refs, tags)), flip in zip(ways.items(), flips, strict=False)
    }
    turned_ways = {**ways, **turned_ways}
    with tempfile.TemporaryDirectory() as folder:
        one, _ = Area(nodes, ways).parse(Path(folder))
        other, _ = Area(nodes, turned_ways).parse(Path(folder))
    assert margins(one) == margins(other)
