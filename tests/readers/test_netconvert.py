"""SUMO's netconvert imports the files."""

from __future__ import annotations

import pytest
from lane_graph import LaneGraph
from real_readers import SumoNet, sumo_net
from scene_files import SCENES, Conversion, Conversions, Scene

# netconvert leaves lanes out where they are narrower than 1.8 m, and cuts edges back to junctions of its own shape:
# by 6 % in Fremantle, where five junctions lie within 80 m.
LANE_KM_TOLERANCE = 0.075


@pytest.fixture(scope="module", params=SCENES, ids=str)
def imported(
    request: pytest.FixtureRequest, conversions: Conversions, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Conversion, SumoNet]:
    scene: Scene = request.param
    conversion = conversions.of(scene)
    return conversion, sumo_net(conversion.path, tmp_path_factory.mktemp("sumo"))


def test_it_writes_a_net_without_errors(imported: tuple[Conversion, SumoNet]) -> None:
    _, net = imported
    assert net.errors == []
    assert net.exit_status == 0


def test_the_net_has_our_lanes(imported: tuple[Conversion, SumoNet]) -> None:
    conversion, net = imported
    network = conversion.network
    ours = (
        sum(m for (road, _, _), m in LaneGraph(network).length.items() if not network.roads[road].connecting) / 1000
    )
    assert net.edges > 0
    assert net.lane_km == pytest.approx(ours, rel=LANE_KM_TOLERANCE)
