"""Stations and borders: they lie where the space of roads says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from viewed_file import viewed_file
from xodr_text import cubics, document, lane, read_text, road, section

from osm2xodr.opendrive.space import elevation, pose, surface_points
from osm2xodr.viewing.page.ground import station_lengths
from osm2xodr.viewing.strips import make_scene


def test_borders_of_a_street_run_from_left_to_right(tmp_path: Path) -> None:
    file = viewed_file(tmp_path)
    scene = make_scene(file, 0.03, 10.0)
    assert scene.strip_road.tolist() == [0, 1, 2]
    first = scene.border[: scene.border_start[1]].reshape(-1, 4)
    assert first[0].tolist() == [5.5, 3.5, 0.0, -3.5]
    # The right lane widens by 0.05 per metre from 60 m on.
    assert first[-1].tolist() == pytest.approx([5.5, 3.5, 0.0, -6.5])
    assert [file.lanes.id[row] for row in scene.lane[:3]] == [2, 1, -1]
    assert scene.s[0] == 0.0
    assert scene.s[scene.station_start[1] - 1] == 120.0


def test_places_are_those_of_road_space(tmp_path: Path) -> None:
    file = viewed_file(tmp_path)
    scene = make_scene(file, 0.03, 10.0)
    x, y, heading = pose(file, scene.station_road, scene.s)
    np.testing.assert_allclose(np.stack((scene.x, scene.y)), np.stack((x, y)), atol=1e-9)
    np.testing.assert_allclose(scene.heading, heading, atol=1e-12)
    np.testing.assert_allclose(scene.z, elevation(file, scene.station_road, scene.s), atol=1e-12)
    at = scene.border_station()
    wanted = surface_points(file, scene.station_road[at], scene.s[at], scene.border)
    np.testing.assert_allclose(np.stack(scene.border_places()), np.stack(wanted), atol=1e-9)


def test_chords_stay_close_to_the_bend(tmp_path: Path) -> None:
    scene = make_scene(viewed_file(tmp_path), 0.03, 10.0)
    rows = slice(int(scene.station_start[1]), int(scene.station_start[2]))
    step = np.diff(scene.s[rows])
    # Sagitta of a chord on a circle of 100 m, whose outer border lies at 103.5 m.
    assert np.max(step**2 / 8.0 / 100.0 * 1.035) <= 0.03 + 1e-9


def test_a_step_of_the_lane_offset_belongs_to_the_section_behind_it(tmp_path: Path) -> None:
    lanes = (
        cubics("laneOffset", (0, 0.0), (50, 2.0))
        + section(0.0, right=lane(-1, (0, 3.0)))
        + section(50.0, right=lane(-1, (0, 3.0)) + lane(-2, (0, 2.0), kind="biking"))
    )
    scene = make_scene(read_text(tmp_path, document(road("1", lanes=lanes))), 0.03, 10.0)
    assert scene.strip_borders.tolist() == [2, 3]
    assert scene.border[: scene.border_start[1]].reshape(-1, 2)[-1].tolist() == [0.0, -3.0]
    assert scene.border[scene.border_start[1] :].reshape(-1, 3)[0].tolist() == [2.0, -1.0, -3.0]
    assert scene.s[scene.station_start[1] - 1] == scene.s[scene.station_start[1]] == 50.0
    assert station_lengths(scene).sum() == pytest.approx(100.0)


def test_roads_that_cannot_be_drawn_are_left_out(tmp_path: Path) -> None:
    text = document(road("1", plan=""), road("2", lanes=""), road("3"))
    scene = make_scene(read_text(tmp_path, text), 0.03, 10.0)
    assert scene.strip_road.tolist() == [2]


def test_some_strips_alone_are_as_they_were(tmp_path: Path) -> None:
    scene = make_scene(viewed_file(tmp_path), 0.03, 10.0)
    order = np.array([2, 0])
    part = scene.only(order)
    assert part.strip_road.tolist() == scene.strip_road[order].tolist()
    x, y, _ = scene.border_places()
    own_x, own_y, _ = part.border_places()
    for k, strip in enumerate(order.tolist()):
        old = slice(int(scene.border_start[strip]), int(scene.border_start[strip + 1]))
        new = slice(int(part.border_start[k]), int(part.border_start[k + 1]))
        assert own_x[new].tolist() == x[old].tolist()
        assert own_y[new].tolist() == y[old].tolist()
        lanes = slice(int(scene.lane_start[strip]), int(scene.lane_start[strip + 1]))
        own = slice(int(part.lane_start[k]), int(part.lane_start[k + 1]))
        assert part.lane[own].tolist() == scene.lane[lanes].tolist()
    assert scene.only(np.arange(len(scene.strip_road))).border.tolist() == scene.border.tolist()
