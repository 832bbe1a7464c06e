"""The traffic lights of an OpenDRIVE file, and the signal nodes of OSM, read apart from the product."""

from __future__ import annotations

import gzip
from collections import defaultdict
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
from lxml import etree
from osm_truth import CAR_HIGHWAYS
from pyproj import Transformer
from scipy.spatial import cKDTree
from xodr_file import FloatArray, XodrFile, read_xodr

Path_ = tuple[str, int]
"""(connecting road, lane)."""


@dataclass(frozen=True)
class LightFile:
    """Lights for cars.

    Parameters
    ----------
    network
        The file.
    governed
        The lanes of connecting roads that refer to each light, by its id.
    groups
        (junction, ids of the lights) of each controller for cars in a junction.
    places
        x, y of all lights, those for people too, m.
    """

    network: XodrFile
    governed: dict[str, list[Path_]]
    groups: list[tuple[str, list[str]]]
    places: FloatArray

    def middle(self, path: Path_) -> FloatArray:
        """Return points of the middle of a lane each half metre, (n, 2), m."""
        road = self.network.roads[path[0]]
        assert len(road.sections) == 1
        s = np.linspace(0.0, road.length, max(2, int(road.length / 0.5) + 2))
        return road.lane_middle(0, path[1], s)[:, :2]

    def conflicts_within_groups(self) -> list[tuple[str, Path_, Path_]]:
        """Return the pairs of lanes from different roads that one controller makes green, and that touch or merge."""
        found = []
        for junction, lights in self.groups:
            paths = sorted({path for light in lights for path in self.governed[light]})
            points = {path: self.middle(path) for path in paths}
            for one, other in combinations(paths, 2):
                if self.entry(one) == self.entry(other):
                    continue
                near = np.min(cKDTree(points[one]).query(points[other])[0]) < 1.0
                if near or self.exit(one) == self.exit(other):
                    found.append((junction, one, other))
        return found

    def entry(self, path: Path_) -> tuple[str, str | None]:
        """Return the road end that a lane comes from."""
        link = self.network.roads[path[0]].predecessor
        assert link is not None
        return link.element_id, link.contact_point

    def exit(self, path: Path_) -> tuple[str, str | None, tuple[int, ...]]:
        """Return the lane that a lane leads to."""
        road = self.network.roads[path[0]]
        assert road.successor is not None
        successors = road.sections[-1].lanes[path[1]].successors
        return road.successor.element_id, road.successor.contact_point, successors


def read_lights(path: Path) -> LightFile:
    """Read the lights of a file."""
    root = etree.parse(str(path)).getroot()
    cars = {item.get("id"): item for item in root.iter("signal") if item.get("type") == "1000001"}
    governed: dict[str, list[Path_]] = defaultdict(list)
    for road in root.findall("road"):
        for item in road.iter("signalReference"):
            for lane in lanes_of(item, road):
                governed[item.get("id", "")].append((road.get("id", ""), lane))
    members = {
        item.get("id"): [control.get("signalId", "") for control in item.findall("control")]
        for item in root.findall("controller")
    }
    groups = []
    for junction in root.findall("junction"):
        for item in junction.findall("controller"):
            lights = [light for light in members[item.get("id")] if light in cars]
            if lights:
                groups.append((junction.get("id", ""), lights))
    network = read_xodr(path)
    places = []
    for road in root.findall("road"):
        for item in road.iter("signal"):
            if item.get("dynamic") == "yes":
                s, t = (np.array([float(item.get(key, "nan"))]) for key in "st")
                places.append(network.roads[road.get("id", "")].points(s, t)[0, :2])
    return LightFile(network, dict(governed), groups, np.array(places).reshape(-1, 2))


def lanes_of(reference: etree._Element, road: etree._Element) -> list[int]:
    """Return the lanes that a reference is for: those that it names, or else all lanes for cars."""
    ranges = [(int(item.get("fromLane", "")), int(item.get("toLane", ""))) for item in reference.findall("validity")]
    if ranges:
        return [lane for first, last in ranges for lane in range(first, last + 1)]
    section = road.find("lanes/laneSection")
    assert section is not None
    return [
        int(item.get("id", "")) for item in section.iter("lane") if item.get("type") in ("driving", "bus", "taxi")
    ]


def signal_nodes(osm: Path, georeference: str) -> dict[int, tuple[float, float]]:
    """Return x, y of the nodes of car roads that OSM gives lights: signals, and crossings that have them, m."""
    document = osm.read_bytes()
    root = etree.fromstring(gzip.decompress(document) if osm.suffix == ".gz" else document)
    on_roads = set()
    for way in root.iter("way"):
        tags = {item.get("k"): item.get("v") for item in way.iter("tag")}
        if tags.get("highway") in CAR_HIGHWAYS:
            on_roads |= {item.get("ref") for item in way.iter("nd")}
    to_local = Transformer.from_crs("EPSG:4326", georeference, always_xy=True)
    found = {}
    for node in root.iter("node"):
        tags = {item.get("k"): item.get("v") for item in node.iter("tag")}
        lights = tags.get("highway") == "traffic_signals" or tags.get("crossing") == "traffic_signals"
        if (lights or tags.get("crossing:signals") == "yes") and node.get("id") in on_roads:
            x, y = to_local.transform(float(node.get("lon", "nan")), float(node.get("lat", "nan")))
            found[int(node.get("id", ""))] = (float(x), float(y))
    return found
