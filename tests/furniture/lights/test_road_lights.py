"""Lights on roads apart from junctions."""

from __future__ import annotations

import math

import pytest
from light_cases import (
    ONE_WAY,
    ROAD,
    SIGNALS,
    crossing_at,
    lit,
    sides,
    with_tags,
)
from street_cases import Case

from osm2xodr.model import Rule

EITHER = pytest.mark.parametrize("rule", list(Rule))


@EITHER
def test_a_crossing_with_lights_apart_from_junctions(rule: Rule) -> None:
    case = with_tags(ROAD, b="highway=crossing crossing=traffic_signals")
    found = lit(case, rule, crossings=crossing_at(1, 100.0), target="roadrunner")
    mirror = sides(found)
    # Stop lines 1 m before the crossing of 4 m.
    assert [(item.orientation, item.s) for item in found.heads()] == [("+", 97.0), ("-", 103.0)]
    assert [found.at(item) for item in found.heads()] == pytest.approx(
        [complex(-3.0, -3.5 * mirror), complex(3.0, 3.5 * mirror)], abs=0.02
    )
    people = found.heads("1000002")
    assert [(item.s, item.t) for item in people] == [(100.0, 3.5), (100.0, -3.5)]
    # Who walks to the left sees the head at the left, as who drives along s sees one without a turn.
    assert [item.h_offset for item in people] == pytest.approx([math.pi / 2, -math.pi / 2])
    # Without a sidewalk they are for no lane: cars need not heed them.
    assert {item.validity for item in people} == {((0, 0),)}
    assert [(item.kind, item.junction, item.sequence, item.signals) for item in found.lights.controllers] == [
        ("traffic", None, 0, tuple(item.id for item in found.heads())),
        ("pedestrian", None, 1, tuple(item.id for item in people)),
    ]
    assert [(item.s, item.orientation, item.kind) for item in found.lights.stops] == [
        (97.0, "+", "traffic_signals"),
        (103.0, "-", "traffic_signals"),
    ]
    assert found.lights.section_breaks == ((found.heads()[0].road, 100.0),)


def test_nodes_about_one_crossing_are_one_installation() -> None:
    tags = {"a": f"{SIGNALS} traffic_signals:direction=forward", "b": "highway=crossing crossing=traffic_signals"}
    tags["c"] = f"{SIGNALS} traffic_signals:direction=backward"
    found = lit(with_tags(ROAD, **tags), crossings=crossing_at(1, 100.0), target="roadrunner")
    # The nodes say where the lines are: 20 m before the crossing, and 10 m.
    assert [(item.orientation, round(item.s, 2)) for item in found.heads()] == [("+", 80.0), ("-", 110.0)]
    assert [len(item.signals) for item in found.lights.controllers] == [2, 2]


@pytest.mark.parametrize("target", ["generic", "carla"])
def test_carla_switches_lights_apart_from_junctions_by_themselves(target: str) -> None:
    found = lit(with_tags(ROAD, b=SIGNALS), target=target)
    assert len(found.heads()) == 2
    assert found.lights.controllers == []


@pytest.mark.parametrize(
    ("case", "tags", "heads"),
    [
        (ROAD, SIGNALS, [("+", 99.0), ("-", 101.0)]),
        (ROAD, f"{SIGNALS} traffic_signals:direction=forward", [("+", 100.0)]),
        (ROAD, f"{SIGNALS} traffic_signals:direction=backward", [("-", 100.0)]),
        (ONE_WAY, SIGNALS, [("+", 99.0)]),
        (ONE_WAY, f"{SIGNALS} traffic_signals=ramp_meter direction=forward", [("+", 100.0)]),
        (ROAD, f"{SIGNALS} traffic_signals=emergency", [("+", 99.0), ("-", 101.0)]),
        (ROAD, "highway=crossing crossing:signals=yes", [("+", 97.0), ("-", 103.0)]),
        (ROAD, f"{SIGNALS} traffic_signals=pedestrian_crossing", [("+", 97.0), ("-", 103.0)]),
        (ROAD, "highway=crossing crossing=marked", []),
    ],
)
def test_lights_apart_from_junctions(case: Case, tags: str, heads: list[tuple[str, float]]) -> None:
    found = lit(with_tags(case, b=tags))
    assert [(item.orientation, round(item.s, 2)) for item in found.heads()] == heads
    assert not found.left_out
