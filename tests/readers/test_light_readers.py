"""What CARLA and SUMO make of the traffic lights of real places."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from light_file import read_lights
from real_readers import carla_answers, sumo_net
from scene_files import Conversions, scene_named

# CARLA moves traffic lights this far towards those who see them, m (`MapBuilder.cpp`).
_FORWARD = 0.25


@pytest.mark.parametrize("name", ["i5_exit_ramp", "fremantle_placement"])
def test_carla_finds_all_lights_in_place(name: str, conversions: Conversions) -> None:
    path = conversions.of(scene_named(name)).path
    lights = read_lights(path)
    found = [item for item in carla_answers(path)["landmarks"] if item["type"] == "1000001"]
    # Each on its approach, and once more on each connecting road that it governs.
    assert {item["id"] for item in found} >= set(lights.governed)
    connecting = [item for item in found if lights.network.roads[str(item["road"])].connecting]
    assert len(connecting) == sum(map(len, lights.governed.values())) > 8
    assert all(item["light"] for item in found)
    for item in found:
        assert np.hypot(*(lights.places - item["place"][:2]).T).min() == pytest.approx(_FORWARD, abs=0.02)


def test_netconvert_makes_each_signalled_junction_one_with_lights(conversions: Conversions, tmp_path: Path) -> None:
    path = conversions.of(scene_named("i5_exit_ramp")).path
    lights = read_lights(path)
    net = sumo_net(path, tmp_path)
    junctions = {junction for junction, _ in lights.groups}
    assert junctions
    assert junctions <= set(net.lights)
    for junction in junctions:
        governed = {
            lane
            for name, group in lights.groups
            if name == junction
            for light in group
            for lane in lights.governed[light]
        }
        assert net.lights[junction] >= len(governed) > 2
