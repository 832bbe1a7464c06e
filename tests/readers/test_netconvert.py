"""SUMO's netconvert imports the files."""

from __future__ import annotations

import pytest
from lane_graph import LaneGraph
from lxml import etree
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
    driving = sum(m for (road, _, _), m in LaneGraph(network).length.items() if not network.roads[road].connecting)
    # netconvert lets cars drive on lanes for parking, unless the file is written for it.
    parking = sum(
        section.end - section.s
        for road in network.roads.values()
        for section in road.sections
        for lane in section.lanes.values()
        if lane.type == "parking" and not road.connecting
    )
    ours = (driving + parking) / 1000
    assert net.edges > 0
    assert net.lane_km == pytest.approx(ours, rel=LANE_KM_TOLERANCE)


def test_junctions_with_controllers_have_lights(imported: tuple[Conversion, SumoNet]) -> None:
    conversion, net = imported
    root = etree.parse(str(conversion.path), etree.XMLParser(huge_tree=True)).getroot()
    signals = {item.get("id"): item.get("type") for item in root.iter("signal")}
    for_cars = {
        item.get("id")
        for item in root.iterfind("controller")
        if any(signals[control.get("signalId")] == "1000001" for control in item)
    }
    meant = {
        str(junction.get("id"))
        for junction in root.iterfind("junction")
        if for_cars & {item.get("id") for item in junction.iterfind("controller")}
    }
    # netconvert joins lights of junctions that lie close together.
    found = {name for light in net.lights for name in light.split("_") if name in meant}
    assert len(net.lights) >= min(len(meant), 1)
    assert found == meant
    assert all(count > 0 for count in net.lights.values())
