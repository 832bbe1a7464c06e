"""A straight street of three ways from west to east, with cars parked along the first and the last."""

from __future__ import annotations

from pathlib import Path

import pytest
from osm_builder import Area, about

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import LaneType, MarginSpec, StreetAttributes
from osm2xodr.osmParsing.defaults import PARKING_PAUSE_MAX
from osm2xodr.osmParsing.tags import turned_round

STREET = "highway=residential name=A oneway=no"
PARKED = "parking:both=lane parking:both:orientation=parallel"
NOBODY = "parking:both=no"
FREE = (MarginSpec(LaneType.RESTRICTED, 2.0),)


def read(folder: Path, *tags: str, pause: float = 30.0, turned: bool = False) -> tuple[StreetAttributes, Diagnostics]:
    """Return the second way, as seen from west to east, and the diagnostics."""
    nodes = {1: (0.0, 0.0), 2: (100.0, 0.0), 3: (100.0 + pause, 0.0), 4: (200.0 + pause, 0.0)}
    refs = [[1, 2], [3, 2] if turned else [2, 3], [3, 4]]
    ways = {10 + k: (refs[k], f"{STREET} {item}") for k, item in enumerate(tags)}
    network, diagnostics = Area(nodes, ways).parse(folder, None)
    (street, piece), *_ = [(s, item) for s in network.streets for _, item in s.pieces if item.osm_way_id == 11]
    return piece if street.points[0, 0] < street.points[-1, 0] else turned_round(piece), diagnostics


def room(piece: StreetAttributes) -> tuple[float, float]:
    """Return the room left and right that nobody parks in, m."""
    left, right = (
        sum(strip.width for strip in strips if strip.type is LaneType.RESTRICTED)
        for strips in (piece.margin_left, piece.margin_right)
    )
    return left, right


def widths(piece: StreetAttributes) -> list[float]:
    return [lane.width for lane in piece.lanes_ltr]


def test_lanes_run_straight_on_past_a_pause(tmp_path: Path) -> None:
    """8 m between the kerbs, 2 of them parked on along each: lanes of 2 m, also where nobody parks."""
    piece, diagnostics = read(tmp_path, f"width=8 {PARKED}", f"width=8 {NOBODY}", f"width=8 {PARKED}")
    assert (widths(piece), piece.middle_offset) == ([2.0, 2.0], 0.0)
    assert (piece.margin_left[:1], piece.margin_right[:1]) == (FREE, FREE)
    words = "parking pauses: 2 m on the left and 2 m on the right stay free, so that the kerb runs straight on"
    told = [(item.kind, item.osm_id) for item in about(diagnostics, "parking") if item.message == words]
    assert told == [(Kind.NOTE, "way/11")]


@pytest.mark.parametrize(
    ("before", "here", "after", "found"),
    [
        (PARKED, NOBODY, PARKED, (2.0, 2.0)),
        (PARKED, "", PARKED, (2.0, 2.0)),
        # Before a junction.
        (PARKED, NOBODY, NOBODY, (0.0, 0.0)),
        ("parking:right=lane", NOBODY, "parking:right=lane", (0.0, 2.0)),
        ("parking:left=lane", "parking:right=lane", "parking:both=lane", (2.0, 0.0)),
        ("parking:both=half_on_kerb", NOBODY, "parking:both=lane", (1.0, 1.0)),
        # Bays have kerbs of their own.
        ("parking:both=street_side", NOBODY, "parking:both=street_side", (0.0, 0.0)),
        ("parking:both=on_kerb", NOBODY, "parking:both=on_kerb", (0.0, 0.0)),
        # Other lanes take the room.
        (PARKED, f"{NOBODY} lanes=3", PARKED, (0.0, 0.0)),
        (PARKED, f"{NOBODY} cycleway:both=lane", PARKED, (0.0, 0.0)),
        (PARKED, f"{NOBODY} turn:lanes:forward=left|right", PARKED, (0.0, 0.0)),
        (f"{PARKED} cycleway:both=lane", f"{NOBODY} cycleway:both=lane", PARKED, (0.0, 0.0)),
        # So do kerbs that step forward.
        (f"{PARKED} width=9", f"{NOBODY} width=6", f"{PARKED} width=9", (0.0, 0.0)),
        (f"{PARKED} width=9", f"{NOBODY} width=8.5", f"{PARKED} width=9", (2.0, 2.0)),
        # Another street.
        (PARKED, f"{NOBODY} name=B", PARKED, (0.0, 0.0)),
    ],
)
def test_which_pauses_leave_room(
    tmp_path: Path, before: str, here: str, after: str, found: tuple[float, float]
) -> None:
    assert room(read(tmp_path, before, here, after)[0]) == found


@pytest.mark.parametrize(("pause", "found"), [(PARKING_PAUSE_MAX - 0.1, 2.0), (PARKING_PAUSE_MAX + 0.1, 0.0)])
def test_only_short_pauses_leave_room(tmp_path: Path, pause: float, found: float) -> None:
    assert room(read(tmp_path, PARKED, NOBODY, PARKED, pause=pause)[0]) == (found, found)


def test_a_pause_at_the_end_of_a_street_leaves_room(tmp_path: Path) -> None:
    assert room(read(tmp_path, PARKED, NOBODY)[0]) == (2.0, 2.0)


def test_the_direction_of_the_way_does_not_matter(tmp_path: Path) -> None:
    tags = "parking:right=lane", NOBODY, "parking:right=lane"
    assert [room(read(tmp_path, *tags, turned=turned)[0]) for turned in (False, True)] == [(0.0, 2.0)] * 2
