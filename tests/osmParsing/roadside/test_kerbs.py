"""Kerbs along a straight street of 200 m from west to east; its middle is node 2."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest
from osm_builder import Area, about

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import Corrections, StreetAttributes, WayCorrection
from osm2xodr.osmParsing import ParseOptions, parse_ways_option

STREET = {1: (0.0, 0.0), 2: (100.0, 0.0), 3: (200.0, 0.0)}
OWN = "highway=residential"
KERB = "barrier=kerb"

Line = tuple[Sequence[tuple[float, float]], str]


def along(y: float, tags: str = KERB, start: float = 0.0, end: float = 200.0) -> Line:
    return [(start, y), (end, y)], tags


def area(south: float, north: float, tags: str = "area:highway=residential") -> Line:
    return [(0.0, south), (200.0, south), (200.0, north), (0.0, north), (0.0, south)], tags


def read(
    folder: Path,
    *lines: Line,
    own: str = OWN,
    refs: Sequence[int] = (1, 2, 3),
    more: Mapping[int, tuple[Sequence[int], str]] | None = None,
    nodes: Mapping[int, tuple[float, float]] = STREET,
    options: ParseOptions | None = None,
) -> tuple[StreetAttributes, Diagnostics]:
    """Return what is read of the first piece of the street, seen along its way, and the diagnostics."""
    places, ways = dict(nodes), {20: (refs, own), **(more or {})}
    for number, (points, tags) in enumerate(lines):
        first = 1000 * (number + 1)
        closed = points[0] == points[-1]
        ids = [first + k for k in range(len(points) - closed)]
        places |= dict(zip(ids, points, strict=False))
        ways[100 + number] = (ids + ids[:1] if closed else ids), tags
    network, diagnostics = Area(places, ways).parse(folder, options)
    pieces = [piece for street in network.streets for _, piece in street.pieces if piece.osm_way_id == 20]
    assert len({(piece.lanes_ltr, abs(piece.middle_offset)) for piece in pieces}) == 1
    assert not pieces[0].reversed
    return pieces[0], diagnostics


def edges(piece: StreetAttributes) -> tuple[float, float]:
    """Return t of the left and right edge of the lanes."""
    half = sum(lane.width for lane in piece.lanes_ltr) / 2.0
    return round(piece.middle_offset + half, 3), round(piece.middle_offset - half, 3)


def test_kerbs_along_both_sides_are_the_edges(tmp_path: Path) -> None:
    piece, diagnostics = read(tmp_path, along(3.5), along(-2.7))
    assert edges(piece) == (3.5, -2.7)
    assert [lane.width for lane in piece.lanes_ltr] == pytest.approx([3.1, 3.1])
    (told,) = about(diagnostics, "kerbs")
    assert (told.kind, told.osm_id) == (Kind.NOTE, "way/20")
    assert told.message.startswith("6.2 m ")
    assert not about(diagnostics, "lane-width")


@pytest.mark.parametrize("tags", ["kerb=raised", "kerb=lowered", "barrier=kerb kerb=flush"])
def test_kerbs_have_either_tag(tmp_path: Path, tags: str) -> None:
    assert edges(read(tmp_path, along(3.5, tags), along(-2.7, tags))[0]) == (3.5, -2.7)


@pytest.mark.parametrize("tags", ["barrier=fence", "kerb=no", "highway=footway kerb=raised"])
def test_other_lines_are_no_kerbs(tmp_path: Path, tags: str) -> None:
    assert edges(read(tmp_path, along(3.5, tags), along(-2.7, tags))[0]) == (3.0, -3.0)


def test_the_area_of_a_carriageway_has_its_edges(tmp_path: Path) -> None:
    assert edges(read(tmp_path, area(-2.7, 3.5))[0]) == (3.5, -2.7)
    assert edges(read(tmp_path, area(-2.7, 3.5, "area:highway=footway"))[0]) == (3.0, -3.0)


def test_a_way_drawn_backwards_has_the_same_edges(tmp_path: Path) -> None:
    assert edges(read(tmp_path, along(3.5), along(-2.7), refs=(3, 2, 1))[0]) == (2.7, -3.5)


def test_lines_lie_in_the_middle_where_kerbs_are_hardly_aside(tmp_path: Path) -> None:
    assert edges(read(tmp_path, along(3.5), along(-3.3))[0]) == (3.4, -3.4)


def test_one_kerb_moves_the_edge_at_its_side(tmp_path: Path) -> None:
    piece, diagnostics = read(tmp_path, along(4.0))
    assert edges(piece) == (4.0, -3.0)
    assert "along its left" in about(diagnostics, "kerbs")[0].message
    # Of a width that is tagged it tells the place.
    assert edges(read(tmp_path, along(-2.5), own=f"{OWN} width=6.0")[0]) == (3.5, -2.5)


def test_cars_park_between_the_kerbs(tmp_path: Path) -> None:
    piece, _ = read(
        tmp_path, along(4.1), along(-4.9), own=f"{OWN} parking:right=lane parking:right:orientation=parallel"
    )
    # 9.0 m less 2.0 m of parking on the right.
    assert edges(piece) == (4.1, -2.9)


def test_kerbs_beside_a_part_of_the_way_are_enough_if_it_is_a_fifth(tmp_path: Path) -> None:
    assert edges(read(tmp_path, along(3.5, end=60.0), along(-2.7, end=60.0))[0]) == (3.5, -2.7)
    assert edges(read(tmp_path, along(3.5, end=30.0), along(-2.7, end=30.0))[0]) == (3.0, -3.0)


def test_kerbs_that_wander_tell_nothing(tmp_path: Path) -> None:
    step = [(0.0, 3.5), (100.0, 3.5), (101.0, 8.0), (200.0, 8.0)], KERB
    assert edges(read(tmp_path, step, along(-2.7), own=f"{OWN} width=6")[0]) == (3.3, -2.7)


def test_kerbs_too_far_apart_for_the_lanes_are_reported(tmp_path: Path) -> None:
    piece, diagnostics = read(tmp_path, along(8.0), along(-8.0))
    assert edges(piece) == (3.0, -3.0)
    (told,) = about(diagnostics, "kerbs")
    assert told.kind is Kind.DROPPED


def test_an_island_that_the_line_leads_through_does_not_matter(tmp_path: Path) -> None:
    island = [(95.0, -1.0), (105.0, -1.0), (105.0, 1.0), (95.0, 1.0), (95.0, -1.0)], KERB
    assert edges(read(tmp_path, along(3.5), along(-3.5), island)[0]) == (3.5, -3.5)


def test_a_kerb_beyond_another_street_is_not_this_ones(tmp_path: Path) -> None:
    nodes = {**STREET, 4: (0.0, 7.0), 5: (200.0, 7.0)}
    two = {21: ([4, 5], OWN)}
    assert edges(read(tmp_path, along(10.5), along(-2.5), nodes=nodes, more=two)[0]) == (3.0, -2.5)
    # Of the other street it is.
    network, _ = Area(
        {**nodes, 6: (0.0, 10.5), 7: (200.0, 10.5)}, {20: ([1, 2, 3], OWN), 21: ([4, 5], OWN), 30: ([6, 7], KERB)}
    ).parse(tmp_path)
    (other,) = [piece for street in network.streets for _, piece in street.pieces if piece.osm_way_id == 21]
    assert edges(other) == (3.5, -3.0)


def test_kerbs_on_another_layer_are_not_looked_at(tmp_path: Path) -> None:
    above = f"{OWN} bridge=yes layer=1"
    assert edges(read(tmp_path, along(3.5), along(-2.7), own=above)[0]) == (3.0, -3.0)
    on_it = f"{KERB} layer=1"
    assert edges(read(tmp_path, along(3.5, on_it), along(-2.7, on_it), own=above)[0]) == (3.5, -2.7)


def test_corners_of_junctions_do_not_count(tmp_path: Path) -> None:
    # Side streets at node 2; kerbs leave for their corners 10 m before and behind it.
    nodes = {**STREET, 4: (100.0, 50.0), 5: (100.0, -50.0)}
    sides = {21: ([5, 2], OWN), 22: ([2, 4], OWN)}
    kerbs = [along(y, start=start, end=end) for y in (3.5, -2.7) for start, end in ((0.0, 90.0), (110.0, 200.0))]
    corner = [(90.0, 3.5), (100.0, 5.5), (110.0, 3.5)], KERB
    assert edges(read(tmp_path, *kerbs, corner, nodes=nodes, more=sides)[0]) == (3.5, -2.7)


@pytest.mark.parametrize(("length", "expected"), [(30.0, (3.0, -3.0)), (60.0, (3.5, -2.7))])
def test_a_way_between_two_junctions_needs_room_for_its_kerbs(
    tmp_path: Path, length: float, expected: tuple[float, float]
) -> None:
    nodes = {1: (0.0, 0.0), 2: (length / 2, 0.0), 3: (length, 0.0)}
    nodes |= {4: (0.0, 60.0), 5: (0.0, -60.0), 6: (length, 60.0), 7: (length, -60.0)}
    sides = {21: ([5, 1], OWN), 22: ([1, 4], OWN), 23: ([7, 3], OWN), 24: ([3, 6], OWN)}
    kerbs = along(3.5, end=length), along(-2.7, end=length)
    assert edges(read(tmp_path, *kerbs, nodes=nodes, more=sides)[0]) == expected


def test_kerbs_beside_aisles_of_car_parks_stand_behind_the_bays(tmp_path: Path) -> None:
    aisle = "highway=service service=parking_aisle lanes=2 width=6"
    options = ParseOptions(parse_ways_option("all"), default_speeds=False, guessed_sidewalks=False)
    assert edges(read(tmp_path, along(5.0), along(-5.0), own=aisle, options=options)[0]) == (3.0, -3.0)


def test_a_width_that_a_user_corrects_stays(tmp_path: Path) -> None:
    corrections = Corrections(ways={20: WayCorrection(width=7.0)})
    options = ParseOptions(default_speeds=False, guessed_sidewalks=False, corrections=corrections)
    assert edges(read(tmp_path, along(4.5), along(-4.5), options=options)[0]) == (3.5, -3.5)


def test_widths_are_the_same_without_furniture(tmp_path: Path) -> None:
    for furniture in (True, False):
        options = ParseOptions(default_speeds=False, furniture=furniture)
        assert edges(read(tmp_path, along(3.5), area(-2.7, 3.5), along(-2.7), options=options)[0]) == (3.5, -2.7)


def test_kerbs_that_hardly_differ_from_way_to_way_become_the_same(tmp_path: Path) -> None:
    nodes = {**STREET, 4: (400.0, 0.0)}
    # The second way runs against the first; widths of 6.2 and 6.6 m, as long as each other.
    kerbs = {101: ([11, 12], KERB), 102: ([13, 14], KERB), 103: ([15, 16], KERB)}
    places = {
        11: (0.0, -3.0),
        12: (400.0, -3.0),
        13: (0.0, 3.2),
        14: (200.0, 3.2),
        15: (200.0, 3.6),
        16: (400.0, 3.6),
    }
    for name, expected in (("name=A", (3.4, -3.0)), ("", (3.1, -3.1))):
        ways = {20: ([1, 2, 3], f"{OWN} {name}"), 21: ([4, 3], f"{OWN} {name} surface=sett"), **kerbs}
        network, _ = Area({**nodes, **places}, ways).parse(tmp_path)
        first = next(piece for street in network.streets for _, piece in street.pieces if piece.osm_way_id == 20)
        assert sum(expected) == pytest.approx(0.4 if name else 0.0)
        assert edges(first) == expected
