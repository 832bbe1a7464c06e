from __future__ import annotations

from pathlib import Path

import pytest
from osm_builder import Area, about

import osm2xodr
from osm2xodr.model import LaneType, MarginSpec, Rule
from osm2xodr.osmParsing import ParseOptions

SHOULDER = MarginSpec(LaneType.SHOULDER, 2.5)
ROW = {1: (0.0, 0.0), 2: (400.0, 0.0), 3: (700.0, 0.0), 4: (900.0, 0.0)}
MOTORWAY = "highway=motorway oneway=yes maxspeed=120"


def shoulders(
    folder: Path, ways: dict[int, tuple[list[int], str]], rule: Rule | None = None
) -> dict[int, list[bool]]:
    """Return whether ways have the guessed shoulder left and right, seen along the way, and nothing else."""
    network, diagnostics = Area(ROW, ways).parse(folder, ParseOptions(rule=rule, guessed_sidewalks=False))
    found = {}
    for street in network.streets:
        for _, piece in street.pieces:
            margins = [piece.margin_left, piece.margin_right]
            sides = [margin == (SHOULDER,) for margin in (margins[::-1] if piece.reversed else margins)]
            found[piece.osm_way_id] = sides
    guessed = [item.osm_id for item in about(diagnostics, "shoulder") if "as motorways have them" in item.message]
    assert guessed == [f"way/{way}" for way in sorted(found) if any(found[way])]
    return found


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        (f"{MOTORWAY} lanes=2", [False, True]),
        (f"{MOTORWAY} lanes=3 turn:lanes=through|through|through", [False, True]),
        (f"{MOTORWAY} lanes=3 turn:lanes=none|none|none", [False, True]),
        (f"{MOTORWAY} lanes=3 turn:lanes=through|through|slight_right", [False, False]),
        (f"{MOTORWAY} lanes=3 turn:lanes=none|none|merge_to_left", [False, False]),
        (f"{MOTORWAY} lanes=3 turn:lanes=slight_left|through|through", [False, True]),
        (f"{MOTORWAY} lanes=2 bridge=yes layer=1", [False, True]),
        (f"{MOTORWAY} lanes=2 tunnel=yes layer=-1", [False, False]),
        (f"{MOTORWAY} lanes=2 shoulder=no", [False, False]),
        (f"{MOTORWAY} lanes=2 shoulder:right=no", [False, False]),
        ("highway=motorway oneway=-1 lanes=2", [True, False]),
        ("highway=motorway oneway=no lanes=2", [False, False]),
        ("highway=motorway_link oneway=yes lanes=1", [False, False]),
        ("highway=trunk oneway=yes lanes=2", [False, False]),
    ],
)
def test_tags_decide(tmp_path: Path, tags: str, expected: list[bool]) -> None:
    assert shoulders(tmp_path, {20: ([1, 2], tags)}) == {20: expected}


def test_it_is_on_the_near_side(tmp_path: Path) -> None:
    assert shoulders(tmp_path, {20: ([1, 2], f"{MOTORWAY} lanes=2")}, Rule.LEFT_HAND) == {20: [True, False]}


@pytest.mark.parametrize(
    ("length", "lanes", "expected"),
    [
        # As many lanes before the piece that tells of the exit: the near one is that exit lane.
        (300.0, 3, [False, False]),
        (300.0, 2, [False, True]),
        # Nobody weaves so long.
        (1100.0, 3, [False, True]),
    ],
)
def test_lanes_are_auxiliary_from_where_they_begin(
    tmp_path: Path, length: float, lanes: int, expected: list[bool]
) -> None:
    nodes = {1: (0.0, 0.0), 2: (400.0, 0.0), 3: (400.0 + length, 0.0), 4: (600.0 + length, 0.0)}
    before, exit_ = f"{MOTORWAY} lanes={lanes}", f"{MOTORWAY} lanes=3 turn:lanes=none|none|slight_right"
    for turned in (False, True):
        # The way's nodes against traffic change nothing.
        ways = {20: [2, 3], 30: [3, 4]}
        tags = {20: before, 30: exit_}
        if turned:
            ways = {way: refs[::-1] for way, refs in ways.items()}
            tags = {20: before.replace("=yes", "=-1"), 30: exit_.replace("=yes", "=-1")}
        area = Area(nodes, {way: (refs, tags[way]) for way, refs in ways.items()})
        network, _ = area.parse(tmp_path, ParseOptions(rule=Rule.RIGHT_HAND))
        (piece,) = (piece for street in network.streets for _, piece in street.pieces if piece.osm_way_id == 20)
        margins = [piece.margin_left, piece.margin_right]
        along = [margin == (SHOULDER,) for margin in (margins[::-1] if piece.reversed else margins)]
        assert along == (expected[::-1] if turned else expected)


@pytest.mark.parametrize("left_out", [False, True])
def test_an_option_leaves_them_out(tmp_path: Path, left_out: bool) -> None:
    path = Area(ROW, {20: ([1, 2], f"{MOTORWAY} lanes=2")}).write(tmp_path)
    output = tmp_path / "area.xodr"
    osm2xodr.convert(path, output=output, no_guessed_shoulders=left_out)
    assert ('type="shoulder"' in output.read_text(encoding="utf-8")) is not left_out
