"""Real places, converted by the command line and measured with a reader of our own."""

from __future__ import annotations

import numpy as np
import pytest
import rasterio
from osm_truth import distances_to_roads
from scene_files import SCENES, Conversion, Conversions, Scene
from xodr_measure import (
    Figure,
    above,
    broken_references,
    length_errors,
    links_to_another_kind,
    narrowest_widths,
    profile_jumps,
    record_gaps,
    record_kinks,
    section_gaps,
    sections_past_the_end,
    shortest_records,
    steepest_grades,
    step_figures,
)

ROUNDING = 1e-9
MICRON = 1e-6
# Arcs that turn by less than 1e-4 rad are written as their chords, or readers with single precision misplace them.
CHORD = 1e-4
MILLIMETRE = 1e-3
LANE_GRADE_STEP = 0.0046
STEEPEST = 0.35
# How far bridges and tunnels may lie outside of the heights of the terrain.
STRUCTURES = 15.0


@pytest.fixture(scope="module", params=SCENES, ids=str)
def scene(request: pytest.FixtureRequest) -> Scene:
    found: Scene = request.param
    return found


@pytest.fixture(scope="module")
def converted(scene: Scene, conversions: Conversions) -> Conversion:
    return conversions.of(scene)


def test_every_reference_resolves(converted: Conversion) -> None:
    assert len(converted.network.roads) > 10
    assert len(converted.network.junctions) > 0
    assert broken_references(converted.network) == []


def test_lengths_and_stations_are_true(converted: Conversion) -> None:
    assert above(length_errors(converted.network), MICRON) == []
    assert sections_past_the_end(converted.network) == []
    assert min(f.value for f in shortest_records(converted.network)) > MILLIMETRE


def test_reference_lines_have_no_gap_and_no_kink(converted: Conversion) -> None:
    gaps = record_gaps(converted.network)
    assert len(gaps) > 30
    assert above(gaps, MICRON) == []
    assert above(record_kinks(converted.network), CHORD) == []


def test_heights_are_smooth_along_each_road(converted: Conversion) -> None:
    heights, grades = profile_jumps(converted.network)
    assert above(heights, MICRON) == []
    assert above(grades, MICRON) == []
    assert above(steepest_grades(converted.network), STEEPEST) == []


def test_roads_are_as_high_as_the_terrain_is(converted: Conversion) -> None:
    z = np.concatenate([road.elevation.value(np.array([0.0])) for road in converted.network.roads.values()])
    with rasterio.open(converted.scene.dem) as dem:
        terrain = dem.read(1, masked=True)
    assert terrain.min() - STRUCTURES <= z.min() < z.max() <= terrain.max() + STRUCTURES


def test_lanes_are_continuous_along_each_road(converted: Conversion) -> None:
    assert above(section_gaps(converted.network), MILLIMETRE) == []
    assert above([Figure(-f.value, f.where) for f in narrowest_widths(converted.network)], ROUNDING) == []


def test_lanes_meet_at_every_lane_link(converted: Conversion) -> None:
    figures = step_figures(converted.network)
    assert len(figures.centre) > 30
    assert above(figures.centre, MILLIMETRE) == []
    assert above(figures.edge, MILLIMETRE) == []
    assert above(figures.heading, MILLIMETRE) == []


def test_lanes_for_cars_lead_to_lanes_for_cars(converted: Conversion) -> None:
    assert links_to_another_kind(converted.network) == []


def test_heights_meet_at_every_lane_link(converted: Conversion) -> None:
    figures = step_figures(converted.network)
    assert above(figures.height, MILLIMETRE) == []
    # Of reference lines: where a road ends in a bend, the lane inside it is steeper, and so is its connecting road.
    assert above(figures.grade, LANE_GRADE_STEP) == []


def test_every_car_road_of_osm_is_carried(converted: Conversion) -> None:
    distance, way = distances_to_roads(converted.osm, converted.network)
    missed = sorted({name for d, name in zip(distance, way, strict=True) if d > 0.5})
    assert (distance <= 0.5).mean() >= 0.99, missed


def test_same_input_same_bytes_by_any_number_of_processes_on_any_processor(
    scene: Scene, conversions: Conversions
) -> None:
    once = conversions.of(scene).path.read_bytes()
    assert conversions.of(scene, jobs=3).path.read_bytes() == once
