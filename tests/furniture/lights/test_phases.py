"""Which lights are green together: at junctions drawn by hand, and never two that conflict."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from junction_cases import CASES
from light_cases import Lit, lit, with_tags
from light_file import read_lights
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Furniture, Rule
from osm2xodr.xodrWriter import WriteOptions, write_xodr

EITHER = pytest.mark.parametrize("rule", list(Rule))
SIGNALS = "highway=traffic_signals"
_LANES = "lanes=5 lanes:forward=3 lanes:backward=2 turn:lanes:forward=left|through|right"
X = CASES["x"].case
POCKETS = Case(X.nodes, {1: ("w o", _LANES), 2: ("e o", _LANES), 3: ("s o", _LANES), 4: ("n o", _LANES)})
CROSSINGS = {
    "x": with_tags(X, o=SIGNALS),
    "t": with_tags(CASES["t"].case, o=SIGNALS),
    "pockets": with_tags(CASES["pockets"].case, o=SIGNALS),
    "pockets_everywhere": with_tags(POCKETS, o=SIGNALS),
    "unmarked_lanes": with_tags(CASES["unmarked_lanes"].case, o=SIGNALS),
    "dual_cross": with_tags(CASES["dual_cross"].case, a=SIGNALS),
    "dual_t": with_tags(CASES["dual_t"].case, a=SIGNALS, b=SIGNALS),
    "slip_lane": with_tags(CASES["slip_lane"].case, o=SIGNALS),
    "star": with_tags(CASES["star"].case, o=SIGNALS),
    "two_lanes_turn_left": with_tags(CASES["two_lanes_turn_left"].case, o=SIGNALS),
    "y_merge": with_tags(CASES["y_merge"].case, o=SIGNALS),
    "fork": with_tags(CASES["fork"].case, o=SIGNALS),
}


def mirrored(text: str) -> str:
    """Return turns as left-hand traffic names them; of several the left one is named first."""
    words = [{"left": "right", "right": "left"}.get(word, word) for word in text.split(" and ")]
    return " and ".join(sorted(words, key=["left", "through", "right"].index))


@EITHER
@pytest.mark.parametrize(
    ("name", "expected"),
    [
        # Each arm's traffic may turn left over the opposite one's.
        (
            "x",
            [f"{way} left and through and right" for way in (1, 2, 3, 4)],
        ),
        ("t", ["1 through and right", "2 left and through", "3 left and right"]),
        # Both ways straight on, then both turns to the left; the same across.
        (
            "pockets_everywhere",
            [
                *("1 left,2 left", "1 through,1 right,2 through,2 right"),
                *("3 left,4 left", "3 through,3 right,4 through,4 right"),
            ],
        ),
        # One arm has lanes apart, but all others cross each of them.
        (
            "pockets",
            ["1 left,1 through,1 right", *(f"{way} left and through and right" for way in (2, 3, 4))],
        ),
        ("dual_cross", [f"{way} left and through,{way} through and right" for way in (1, 4, 7, 10)]),
        ("slip_lane", ["2 left and through", "5 through", "6 left and right"]),
    ],
)
def test_groups(name: str, expected: list[str], rule: Rule) -> None:
    found = lit(CROSSINGS[name], rule)
    groups = [{(int(item.split()[0]), " ".join(item.split()[1:])) for item in text.split(",")} for text in expected]
    if rule is Rule.LEFT_HAND:
        groups = [{(way, mirrored(turns)) for way, turns in group} for group in groups]
    made = found.phases()
    assert sorted(map(sorted, made)) == sorted(map(sorted, groups))
    junction = found.world.road_map.junctions
    assert [item.sequence for item in found.lights.controllers] == list(range(len(groups)))
    assert len({item.junction for item in found.lights.controllers}) == 1
    assert found.lights.controllers[0].junction in {item.id for item in junction}
    assert found.lights.controllers[0].name == f"junction {found.lights.controllers[0].junction}, phase 1"


def written(found: Lit, folder: Path) -> Path:
    """Write a network with its lights."""
    lights = found.lights
    furniture = Furniture(tuple(lights.signals), tuple(lights.references), tuple(lights.controllers))
    path = folder / "lights.xodr"
    with path.open("wb") as stream:
        write_xodr(
            replace(found.world.road_map, furniture=furniture), stream, WriteOptions(name="lights"), Diagnostics()
        )
    return path


@EITHER
@pytest.mark.parametrize("name", CROSSINGS)
def test_no_two_ways_of_a_group_conflict(name: str, rule: Rule, tmp_path: Path) -> None:
    found = lit(CROSSINGS[name], rule)
    lights = read_lights(written(found, tmp_path))
    assert lights.conflicts_within_groups() == []
    assert sum(map(len, lights.governed.values())) >= len(lights.governed) > 0
    # As many as there are arms that cross: never all in one.
    assert len(lights.groups) > 1


def test_the_check_itself_finds_conflicts(tmp_path: Path) -> None:
    found = lit(CROSSINGS["x"])
    first = found.lights.controllers[0]
    everything = replace(first, signals=tuple(sorted(item.id for item in found.lights.signals)))
    joined = replace(found, lights=replace(found.lights, controllers=[everything]))
    lights = read_lights(written(joined, tmp_path))
    # 54 pairs of ways come from different arms. Of those these do not meet: 6 of two turns to the right, 8 of one and
    # who goes straight on, 8 of one and a turn to the left, 2 straight on both, 2 of opposite turns to the left.
    assert len(lights.conflicts_within_groups()) == 54 - 26
