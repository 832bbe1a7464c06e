"""The scenario for esmini: valid, on lanes that lead to each other, within limits, with lights that are minded."""

from __future__ import annotations

from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lane_graph import LaneGraph, LaneKey
from lxml import etree
from real_readers import need
from scene_files import SAMPLES, scene_named
from xodr_file import XodrFile, read_xodr

import osm2xodr
from osm2xodr import Started
from osm2xodr.model import FloatArray

(SAMPLE,) = SAMPLES
SCENES = (SAMPLE, scene_named("fremantle_placement"), scene_named("i5_exit_ramp"))
# How long it is watched, s.
SECONDS = 90.0


class Scenario:
    """A scenario, read from its file, and the road network that it is on."""

    def __init__(self, started: Started) -> None:
        self.started = started
        self.root: Any = etree.parse(str(started.folder / "start.xosc")).getroot()
        self.network: XodrFile = read_xodr(started.folder / "map.xodr")
        self.graph = LaneGraph(self.network)
        self.names = [str(item.get("name")) for item in self.root.iter("ScenarioObject")]

    def route(self, name: str) -> list[tuple[LaneKey, float]]:
        """Return the lanes of the waypoints of a car, each with s."""
        places = self.root.findall(f".//Private[@entityRef='{name}']//Route//LanePosition")
        out = []
        for place in places:
            road, s = self.network.roads[place.get("roadId")], float(place.get("s"))
            section = max(k for k, item in enumerate(road.sections) if item.s <= s)
            out.append(((road.id, section, int(place.get("laneId"))), s))
        return out

    def speeds(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Return times, s, and speeds, m/s, of the profile of a car."""
        rows = self.root.findall(f".//ManeuverGroup[@name='{name}Drive']//SpeedProfileEntry")
        pairs = np.array([(float(row.get("time")), float(row.get("speed"))) for row in rows])
        return np.cumsum(pairs[:, 0]), pairs[:, 1]

    def lanes(self, name: str) -> list[LaneKey]:
        """Return all lanes that a car drives on: those of the waypoints, and those between on the same roads."""
        keys = [key for key, _ in self.route(name)]
        out = keys[:1]
        for key in keys[1:]:
            while key not in self.graph.next[out[-1]]:
                (ahead,) = [item for item in self.graph.next[out[-1]] if item[0] in (out[-1][0], key[0])]
                out.append(ahead)
            out.append(key)
        return out

    def points(self, name: str) -> FloatArray:
        """Return where a car drives, x, y, one point for 0.2 m of reference line, (n, 2), m."""
        first, last = self.route(name)[0], self.route(name)[-1]
        parts = []
        lanes = self.lanes(name)
        for k, key in enumerate(lanes):
            road, section = self.network.roads[key[0]], self.network.roads[key[0]].sections[key[1]]
            low, high = section.s, section.end
            forward = road.forward(key[2])
            if k == 0:
                low, high = (first[1], high) if forward else (low, first[1])
            if k == len(lanes) - 1:
                low, high = (low, last[1]) if forward else (last[1], high)
            s = np.linspace(low, high, max(int((high - low) / 0.2), 2))
            parts.append(road.lane_middle(key[1], key[2], s if forward else s[::-1])[:, :2])
        return np.concatenate(parts)

    def places(self, name: str, times: FloatArray) -> FloatArray:
        """Return where a car is at times, x, y, (n, 2), m: that far along its lanes as its speeds make."""
        points = self.points(name)
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        when, speed = self.speeds(name)
        fine = np.arange(0.0, SECONDS + 0.01, 0.01)
        gone = np.cumsum(np.interp(fine, when, speed)) * 0.01
        far = np.interp(times, fine, gone)
        assert far[-1] < along[-1]
        return np.column_stack([np.interp(far, along, points[:, k]) for k in (0, 1)])


@pytest.fixture(scope="module", params=SCENES, ids=str)
def scenario(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    folder = tmp_path_factory.mktemp("start") / "esmini"
    return Scenario(osm2xodr.start("esmini", request.param.osm, folder, request.param.dem))


def test_it_is_valid_by_its_schema(scenario: Scenario) -> None:
    need("qc_openscenario", "the ASAM checker of scenarios (asam-qc-openscenarioxml)")
    import qc_openscenario

    path = Path(qc_openscenario.__file__).parent / "schema" / "1.2.0" / "OpenSCENARIO.xsd"
    schema = etree.XMLSchema(etree.parse(str(path)))
    schema.assertValid(scenario.root.getroottree())
    head = scenario.root.find("FileHeader")
    assert (head.get("revMajor"), head.get("revMinor")) == ("1", "2")
    assert "© OpenStreetMap contributors" in head.get("description")


def test_the_road_network_is_beside_it(scenario: Scenario) -> None:
    name = scenario.root.find("RoadNetwork/LogicFile").get("filepath")
    assert scenario.started.folder / name in scenario.started.files
    assert f"--osc {scenario.started.folder}/start.xosc" in scenario.started.command


def test_an_ego_and_five_others_are_on_lanes_that_lead_to_each_other(scenario: Scenario) -> None:
    assert scenario.names == ["Ego", "Car1", "Car2", "Car3", "Car4", "Car5"]
    for name in scenario.names:
        route = scenario.route(name)
        assert len(route) > 1
        for key, s in route:
            road = scenario.network.roads[key[0]]
            assert road.sections[key[1]].lanes[key[2]].type == "driving"
            # esmini says an error of waypoints beyond their roads.
            assert 0.0 < s < road.length
        # Of several on the same road esmini drops all but the last.
        assert all(one[0] != other[0] for (one, _), (other, _) in pairwise(route))
        # This finds no way where waypoints do not lead to each other.
        assert len(scenario.lanes(name)) >= len(route)


def test_no_way_through_a_junction_is_left_to_esmini(scenario: Scenario) -> None:
    """It looks for ways from road to road, whatever the lane: of several to the same road it takes any."""
    for name in scenario.names:
        for (one, _), (other, _) in pairwise(scenario.route(name)):
            between = {key[0] for key in scenario.lanes(name)} - {one[0], other[0]}
            assert not {key[0] for key in scenario.graph.next[one]} & between


def test_cars_keep_to_limits_and_are_slow_in_bends(scenario: Scenario) -> None:
    units = {"km/h": 1 / 3.6, "mph": 0.44704}
    written = etree.parse(str(scenario.started.folder / "map.xodr")).getroot().iterfind(".//lane/speed")
    most = max(float(item.get("max", "")) * units[item.get("unit", "")] for item in written)
    for name in scenario.names:
        when, speed = scenario.speeds(name)
        assert speed.max() <= most + 0.05
        change = np.diff(speed) / np.maximum(np.diff(when), 1e-3)
        # But where rounding to milliseconds makes much of a little.
        assert change[np.diff(when) > 0.05].max(initial=0.0) < 1.7
        assert change[np.diff(when) > 0.05].min(initial=0.0) > -2.3
        assert speed[-1] == 0.0
    ego = np.interp(np.arange(0.0, SECONDS, 0.1), *scenario.speeds("Ego"))
    assert ego.sum() * 0.1 > 250.0


def test_cars_never_meet(scenario: Scenario) -> None:
    times = np.arange(0.0, SECONDS, 0.1)
    places = {name: scenario.places(name, times) for name in scenario.names}
    for one, other in combinations(scenario.names, 2):
        assert np.hypot(*(places[one] - places[other]).T).min() > 6.0, (one, other)


def test_lights_change_by_their_programme_and_nobody_passes_red(tmp_path: Path) -> None:
    scene = scene_named("fremantle_placement")
    found = Scenario(osm2xodr.start("esmini", scene.osm, tmp_path / "esmini", scene.dem))
    (programme,) = found.started.conversion.road_map.furniture.programmes
    approaches = {link.road for link in programme.links}
    signals = found.started.conversion.road_map.furniture.signals
    lights = {item.id for item in signals if item.type == "1000001" and item.road in approaches}
    first = {item.get("name"): item.get("state") for item in found.root.findall(".//Init//TrafficSignalStateAction")}
    assert set(first) == {str(name) for name in lights}
    assert set(first.values()) == {"on;off;off", "off;off;on"}
    events = found.root.findall(f".//ManeuverGroup[@name='Lights{programme.junction}']//Event")
    times = [float(event.find(".//SimulationTimeCondition").get("value")) for event in events]
    ends = np.cumsum([phase.duration for phase in programme.phases]).tolist()
    assert times == [end for end in ends if end < SECONDS]
    passed = 0
    for name in found.names:
        lanes, route = found.lanes(name), found.points(name)
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(route, axis=0).T))])
        for before, key in pairwise(lanes):
            links = [
                k
                for k, link in enumerate(programme.links)
                if str(link.connecting_road) == key[0] and link.lane == before[2]
            ]
            if not links:
                continue
            road = found.network.roads[key[0]]
            begin = road.lane_middle(key[1], key[2], np.array([0.0 if road.forward(key[2]) else road.length]))[0, :2]
            far = along[np.hypot(*(route - begin).T).argmin()]
            when, speed = found.speeds(name)
            fine = np.arange(0.0, SECONDS, 0.01)
            gone = np.cumsum(np.interp(fine, when, speed)) * 0.01
            # With its front on the line: 3.65 m before the middle of its rear axle.
            at = int(np.searchsorted(gone, far - 3.65))
            if at < len(fine):
                passed += 1
                phase = int(np.searchsorted(ends, fine[at] % ends[-1], side="right"))
                assert programme.phases[phase].state[links[0]] in "Gg", (name, fine[at])
    assert passed >= 3


def test_the_same_input_gives_the_same_bytes(tmp_path: Path) -> None:
    scene = scene_named("fremantle_placement")
    one, other = (osm2xodr.start("esmini", scene.osm, tmp_path / name, scene.dem) for name in ("one", "other"))
    for path in one.files:
        assert path.read_bytes() == (other.folder / path.name).read_bytes()


def test_networks_that_take_minutes_to_load_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("osm2xodr.starting.esmini._MANY_ROADS", 100)
    scene = scene_named("fremantle_placement")
    started = osm2xodr.start("esmini", scene.osm, tmp_path / "esmini", scene.dem)
    roads = etree.parse(str(started.folder / "map.xodr")).getroot().findall("road")
    assert started.notes[-1].startswith(f"esmini takes minutes to load {len(roads)} roads; convert less")
