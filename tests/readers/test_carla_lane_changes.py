"""CARLA's route planner lets drivers leave lanes as the tags say, on both sides of the road."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from real_readers import carla_answers
from street_cases import Case

from osm2xodr.conventions.targets import TARGETS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Rule
from osm2xodr.xodrWriter import WriteOptions, write_xodr

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
LANES = "lanes=6 lanes:forward=3 lanes:backward=3"
FORWARD = "change:lanes:forward=only_right|only_right|no"
BACKWARD = "change:lanes:backward=no|only_left|only_left"
STREET = Case(
    {"w": (-150.0, 0.0), "e": (150.0, 0.0)},
    {1: ("w e", f"highway=primary {LANES} divider=solid_line {FORWARD} {BACKWARD}")},
)
# Of each lane, from the centre outwards as in the drawing: whether one may leave it to the left and to the right.
ALONG = [(False, True), (False, True), (False, False)]
AGAINST = [(False, False), (True, False), (True, False)]


def allowed(case: Case, rule: Rule, target: str, folder: Path) -> dict[int, list[bool]]:
    """Return what CARLA says of each lane: whether one may leave it to the left and to the right."""
    drawn = case if rule is Rule.RIGHT_HAND else case.mirrored()
    stream = io.BytesIO()
    write_xodr(drawn.build(rule), stream, WriteOptions(target=TARGETS[target]), Diagnostics())
    path = folder / "lanes.xodr"
    path.write_bytes(stream.getvalue())
    return {key[2]: found for key, found in carla_answers(path)["changes"]}


@EITHER
def test_marks_that_one_side_may_cross(rule: Rule, tmp_path: Path) -> None:
    found = allowed(STREET, rule, "carla", tmp_path)
    sign = 1 if rule is Rule.RIGHT_HAND else -1
    for half, lanes in ((-sign, ALONG), (sign, AGAINST)):
        for number, (left, right) in enumerate(lanes, start=1):
            # Drawn for right-hand traffic: left-hand traffic mirrors it.
            assert tuple(found[half * number]) == ((left, right) if sign > 0 else (right, left))


@EITHER
def test_as_the_standard_says_it_lanes_below_0_are_taken_the_wrong_way_round(rule: Rule, tmp_path: Path) -> None:
    found = allowed(STREET, rule, "generic", tmp_path)
    right_way = allowed(STREET, rule, "carla", tmp_path)
    assert [found[lane] for lane in (1, 2, 3)] == [right_way[lane] for lane in (1, 2, 3)]
    assert [found[lane] for lane in (-1, -2)] != [right_way[lane] for lane in (-1, -2)]


@EITHER
@pytest.mark.parametrize("way", ["forward", "backward"])
def test_nobody_crosses_a_centre_line_that_is_solid_on_one_side(way: str, rule: Rule, tmp_path: Path) -> None:
    tags = (
        f"highway=primary lanes=2 overtaking:{way}=no overtaking:{'backward' if way == 'forward' else 'forward'}=yes"
    )
    case = Case(STREET.nodes, {1: ("w e", tags)})
    assert allowed(case, rule, "carla", tmp_path) == {1: [False, False], -1: [False, False]}
