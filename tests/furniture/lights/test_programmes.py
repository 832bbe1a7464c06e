"""Signal programmes: who is green together, who yields within the green, and for how long."""

from __future__ import annotations

import pytest
from junction_cases import CASES
from light_cases import ARMS, SIGNALS, Lit, lit, with_tags
from street_cases import Case

from osm2xodr.furniture.lights.heads import turn_of
from osm2xodr.model import Rule, SignalProgramme

EITHER = pytest.mark.parametrize("rule", list(Rule))
MIRRORED = {"left": "right", "right": "left", "through": "through"}


def programme(case: Case, rule: Rule) -> tuple[Lit, SignalProgramme]:
    found = lit(case, rule, target="sumo")
    (made,) = found.lights.programmes
    return found, made


def shown(found: Lit, made: SignalProgramme, state: str) -> str:
    """Return what each way shows to its turns, as right-hand traffic names them, such as ``1 left g right G``."""
    roads = {road.id: road.osm_way_ids[0] for road in found.world.road_map.roads if road.osm_way_ids}
    turns = {item.connecting_road: turn_of(item) for approach in found.approaches for item in approach.movements}
    swap = MIRRORED if found.world.road_map.rule is Rule.LEFT_HAND else {}
    ways: dict[int, dict[str, str]] = {}
    for link, letter in zip(made.links, state, strict=True):
        turn = turns[link.connecting_road]
        ways.setdefault(roads[link.road], {})[swap.get(turn, turn)] = letter
    green = {way: letters for way, letters in ways.items() if set(letters.values()) != {"r"}}
    return "; ".join(f"{way} {' '.join(f'{k} {v}' for k, v in sorted(green[way].items()))}" for way in sorted(green))


@EITHER
@pytest.mark.parametrize(
    ("case", "stages"),
    [
        # Arms that face each other are green together, and turns across oncoming traffic yield to it.
        (
            with_tags(CASES["x"].case, o=SIGNALS),
            [
                "1 left g right G through G; 2 left g right G through G",
                "3 left g right G through G; 4 left g right G through G",
            ],
        ),
        (
            with_tags(CASES["t"].case, o=SIGNALS),
            ["1 right G through G; 2 left g through G", "3 left G right G"],
        ),
        # Arms without a light of their own have none to wait for, and yield.
        (
            with_tags(ARMS, o=SIGNALS, si="highway=give_way", ni="highway=give_way"),
            [
                (
                    "1 left g right G through G; 2 left g right G through G; 3 left o right o through o; "
                    "4 left o right o through o"
                ),
                "3 left o right o through o; 4 left o right o through o",
            ],
        ),
    ],
)
def test_stages(case: Case, stages: list[str], rule: Rule) -> None:
    found, made = programme(case, rule)
    states = [item.state for item in made.phases if "y" not in item.state]
    said = [shown(found, made, state) for state in states]
    assert [text for text in dict.fromkeys(said) if text] == stages


@EITHER
def test_yellow_and_red_lie_between_stages(rule: Rule) -> None:
    _, made = programme(with_tags(CASES["x"].case, o=SIGNALS), rule)
    assert len(made.links) == 12
    assert [item.duration for item in made.phases] == [41.0, 3.0, 1.0] * 2
    assert [item.range for item in made.phases] == [(5.0, 50.0), None, None] * 2
    for k, item in enumerate(made.phases):
        then = made.phases[(k + 1) % len(made.phases)].state
        assert all(
            pair in ("rr", "rG", "rg", "Gy", "gy", "yr") for pair in map("".join, zip(item.state, then, strict=True))
        )


def test_cars_that_only_people_stop_have_most_of_the_cycle() -> None:
    case = with_tags(ARMS, o=SIGNALS, si="highway=give_way", ni="highway=give_way")
    _, made = programme(case, Rule.RIGHT_HAND)
    assert made.detector_range == 0.0
    assert [(item.duration, item.range) for item in made.phases] == [
        (75.0, None),
        (3.0, None),
        (1.0, None),
        (11.0, None),
    ]


def test_heads_that_meet_nobody_are_green_as_well() -> None:
    """The turn lane to the right of the side street waits for nobody while the main road turns left into that."""
    _, made = programme(with_tags(CASES["pockets"].case, o=SIGNALS), Rule.RIGHT_HAND)
    assert made.detector_range == 50.0
    assert len({item.state for item in made.phases}) > 4
    for item in made.phases:
        greens = [link for link, letter in zip(made.links, item.state, strict=True) if letter == "G"]
        exits = [(link.exit_road, link.exit_lane) for link in greens]
        assert len(exits) == len(set(exits)), "two ways that go first lead to one lane"


@pytest.mark.parametrize(
    ("target", "count"), [("generic", 0), ("carla", 0), ("roadrunner", 0), ("sumo", 1), ("esmini", 1)]
)
def test_programmes_are_for_sumo_and_scenarios_of_esmini(target: str, count: int) -> None:
    assert len(lit(with_tags(CASES["x"].case, o=SIGNALS), target=target).lights.programmes) == count
