"""The traffic lights of real places, held against OSM."""

from __future__ import annotations

import numpy as np
import pytest
from light_file import LightFile, read_lights, signal_nodes
from scene_files import Conversion, Conversions, scene_named

SCENES = ("i5_exit_ramp", "fremantle_placement", "montlake_roundabout")


def lights_of(conversions: Conversions, name: str) -> tuple[Conversion, LightFile]:
    conversion = conversions.of(scene_named(name))
    return conversion, read_lights(conversion.path)


@pytest.mark.parametrize("name", SCENES)
def test_no_controller_lets_two_ways_that_conflict_go(name: str, conversions: Conversions) -> None:
    _, lights = lights_of(conversions, name)
    assert lights.conflicts_within_groups() == []


@pytest.mark.parametrize(("name", "nodes"), list(zip(SCENES, (8, 6, 0), strict=True)))
def test_each_signal_node_gives_lights_or_is_reported(name: str, nodes: int, conversions: Conversions) -> None:
    conversion, lights = lights_of(conversions, name)
    found = signal_nodes(conversion.scene.osm, lights.network.georeference)
    assert len(found) == nodes
    reported = {item["osm_id"] for item in conversion.report["diagnostics"] if item["code"] == "signal-left-out"}  # type: ignore[attr-defined]
    for node, place in found.items():
        # As far as a signal may stand before the junction that it is for.
        near = bool(len(lights.places)) and np.hypot(*(lights.places - place).T).min() < 50.0
        assert near or f"node/{node}" in reported
