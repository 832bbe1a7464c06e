"""What holds for every network: random ones, through the whole pipeline."""

from __future__ import annotations

import io
import random
import re
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st
from random_networks import RandomNetwork, random_network
from real_readers import schema_errors
from road_measures import assert_lanes_meet, assert_sound
from xodr_file import read_xodr
from xodr_measure import above, broken_references, record_gaps, record_kinks, section_gaps, step_figures

from osm2xodr.conventions import PLANS, SPIRALS
from osm2xodr.curves.plan_views import lengths
from osm2xodr.curves.records import pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.geometry import RoadOptions
from osm2xodr.model import RoadMap
from osm2xodr.osmParsing import ParseOptions, parse_osm
from osm2xodr.pipeline import PipelineOptions, convert
from osm2xodr.projection import to_local
from osm2xodr.xodrWriter import WriteOptions, write_xodr

SEEDS = st.integers(0, 2**32 - 1)
# Ends of roads of two conversions that are the same place, m.
NEAR = 0.02
# With spirals, roads lie this near: rounding decides which of two spirals that do equally well ends first.
NEAR_WITH_SPIRALS = 0.15
# Where junctions are so far apart that each stands for itself. Nearer ones may be joined in another order, and at
# places that lie even for two choices one of them has to be taken.
ROOMY = (40.0, 70.0, 120.0)


def converted(
    network: RandomNetwork, text: str, folder: Path, plan: str = PLANS[0]
) -> tuple[RoadMap, bytes, Diagnostics]:
    area = folder / "area.osm"
    area.write_text(text, encoding="utf-8")
    found = Diagnostics()
    options = PipelineOptions(area, parse=ParseOptions(rule=network.rule), roads=RoadOptions(plan=plan))
    road_map = convert(options, found).road_map
    stream = io.BytesIO()
    write_xodr(road_map, stream, WriteOptions(version="1.7"), found)
    return road_map, stream.getvalue(), found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("properties")


@given(SEEDS)
@example(seed=500068)
@example(seed=300010)
@settings(max_examples=12)
def test_every_network_is_sound(folder: Path, seed: int) -> None:
    network = random_network(seed)
    road_map, data, _ = converted(network, network.osm(), folder)
    assert_sound(road_map)
    path = folder / "out.xodr"
    path.write_bytes(data)
    assert schema_errors(path, "1.7") == []
    read = read_xodr(path)
    assert broken_references(read) == []
    assert above(record_gaps(read), 1e-3) == []
    assert above(record_kinks(read), 1e-3) == []
    assert above(section_gaps(read), 1e-3) == []
    steps = step_figures(read)
    assert above(steps.centre, 0.01) == []
    assert above(steps.edge, 0.02) == []
    assert above(steps.heading, 0.01) == []
    assert above(steps.height, 0.01) == []


@pytest.mark.parametrize("seed", [500226, 500355, 800106])
def test_lanes_meet_between_arms_that_lie_on_each_other(folder: Path, seed: int) -> None:
    network = random_network(seed)
    assert_lanes_meet(converted(network, network.osm(), folder)[0])


@given(SEEDS)
@settings(max_examples=12)
def test_the_order_of_elements_changes_nothing(folder: Path, seed: int) -> None:
    network = random_network(seed)
    _, once, found = converted(network, network.osm(), folder)
    _, again, _ = converted(network, network.osm(), folder)
    assert once == again
    _, other, found_then = converted(network, network.osm(random.Random(seed)), folder)
    assert once == other
    assert list(found) == list(found_then)


@given(SEEDS)
@example(seed=266)
@settings(max_examples=12)
def test_no_way_vanishes(folder: Path, seed: int) -> None:
    network = random_network(seed)
    road_map, _, found = converted(network, network.osm(), folder)
    streets = parse_osm(folder / "area.osm", ParseOptions(rule=network.rule), Diagnostics()).streets
    named = {item.osm_id for item in found}
    with_road = {way for road in road_map.roads for way in road.osm_way_ids}
    in_junction = {node for junction in road_map.junctions for node in junction.osm_node_ids}
    for street in streets:
        # A street without a road lies within a junction that somebody drives through, or is named.
        within = {int(street.node_ids[0]), int(street.node_ids[-1])} <= in_junction
        ways = {attributes.osm_way_id for _, attributes in street.pieces}
        assert within or {way for way in ways - with_road if f"way/{way}" not in named} == set()
    kept = {attributes.osm_way_id for street in streets for _, attributes in street.pieces}
    assert {way for way in network.ways if way not in kept and f"way/{way}" not in named} == set()


# Whether the floor beside a way through a junction is raised depends on areas, at whose limits rounding decides.
FLOOR = {"border": "floor", "shoulder": "floor"}
# What a road is whichever way it runs: lanes by type, both ends; outside junctions also its middle and its length.
Signature = tuple[bool, tuple[tuple[str, int], ...], tuple[float, ...]]


def signatures(road_map: RoadMap, place: tuple[float, float], mirror: bool = False) -> list[Signature]:
    """Return the signatures of all roads; x counts from the place's meridian, to the west if mirrored."""
    length = lengths(road_map.plan_view)
    curve = np.repeat(np.arange(len(length)), 3)
    x, y, _ = pose(road_map.plan_view, curve, (length[:, None] * np.array([0.0, 0.5, 1.0])).ravel())
    # The frame's origin is rounded, and so is not the mirror image of the other's.
    lat, lon = place
    nearest = road_map.frame.lon_0_deg + (lon - road_map.frame.lon_0_deg + 180.0) % 360.0 - 180.0
    meridian = to_local(road_map.frame, np.array([nearest, nearest]), np.array([lat, lat]))[0][0]
    x = meridian - x if mirror else x - meridian
    out = []
    for k, road in enumerate(road_map.roads):
        types = [lane.type.value for part in road.lane_sections for lane in part.lanes if lane.id]
        lanes = Counter(types if road.junction is None else [FLOOR.get(kind, kind) for kind in types])
        ends = sorted([(float(x[3 * k]), float(y[3 * k])), (float(x[3 * k + 2]), float(y[3 * k + 2]))])
        figures: tuple[float, ...] = (*ends[0], *ends[1])
        if road.junction is None:
            figures = (*figures, float(x[3 * k + 1]), float(y[3 * k + 1]), float(length[k]))
        out.append((road.junction is not None, tuple(sorted(lanes.items())), figures))
    return out


def differences(one: list[Signature], other: list[Signature], near: float = NEAR) -> list[str]:
    """Return what only one of two road maps has."""
    left = list(other)
    out = []
    for item in one:
        found = next(
            (
                k
                for k, candidate in enumerate(left)
                if candidate[:2] == item[:2]
                and max(abs(a - b) for a, b in zip(candidate[2], item[2], strict=True)) < near
            ),
            None,
        )
        if found is None:
            out.append(f"only the first: {item}")
        else:
            del left[found]
    return out + [f"only the second: {item}" for item in left]


@given(SEEDS)
@example(seed=64693)
@settings(max_examples=12)
def test_the_direction_that_ways_are_drawn_in_changes_nothing(folder: Path, seed: int) -> None:
    network = random_network(seed, ROOMY)
    dice = random.Random(seed)
    other = network.turned(frozenset(way for way in network.ways if dice.random() < 0.5))
    for plan, near in (("arcs", NEAR), (SPIRALS, NEAR_WITH_SPIRALS)):
        one_map, _, _ = converted(network, network.osm(), folder, plan)
        other_map, _, _ = converted(other, other.osm(), folder, plan)
        found = differences(signatures(one_map, network.place), signatures(other_map, network.place), near)
        assert found == []


@given(SEEDS)
@settings(max_examples=12)
def test_a_mirrored_network_is_the_mirrored_road_map(folder: Path, seed: int) -> None:
    network = random_network(seed, ROOMY)
    one_map, _, _ = converted(network, network.osm(), folder)
    mirrored = network.mirrored()
    other_map, _, _ = converted(mirrored, mirrored.osm(), folder)
    assert differences(signatures(one_map, network.place), signatures(other_map, network.place, mirror=True)) == []


@pytest.mark.parametrize("latitude", [84.5, -85.0, 89.99, -90.0, 90.0])
def test_poles_are_refused(latitude: float, tmp_path: Path) -> None:
    nodes = "".join(f'<node id="{k}" lat="{latitude}" lon="{0.001 * k:.3f}"/>' for k in (0, 1))
    way = '<way id="7"><nd ref="0"/><nd ref="1"/><tag k="highway" v="tertiary"/></way>'
    area = tmp_path / "pole.osm"
    area.write_text(f'<osm version="0.6">{nodes}{way}</osm>', encoding="utf-8")
    with pytest.raises(InputError, match=re.escape(f"reaches to latitude {latitude:.2f}")) as refused:
        convert(PipelineOptions(area), Diagnostics())
    assert "choose an area off the poles" in str(refused.value)
