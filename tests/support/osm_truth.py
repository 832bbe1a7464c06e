"""What an OSM file says about car roads, read apart from the product, to hold its output against."""

from __future__ import annotations

import gzip
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from lxml import etree
from pyproj import Transformer
from scipy.spatial import cKDTree
from xodr_file import CAR_LANES, FloatArray, XodrFile

CAR_HIGHWAYS = frozenset(
    f"{name}{link}" for name in ("motorway", "trunk", "primary", "secondary", "tertiary") for link in ("", "_link")
) | {"unclassified", "residential", "living_street"}
CLOSED = frozenset({"no", "private", "agricultural", "forestry", "delivery", "permit"})


@dataclass(frozen=True)
class OsmWay:
    """A road that cars must find in the output."""

    id: int
    node_ids: tuple[int, ...]
    xy: FloatArray


@dataclass(frozen=True)
class OsmTruth:
    """The car roads of an area in the local frame of a georeference."""

    ways: dict[int, OsmWay]
    bounds_deg: tuple[float, float, float, float]

    def before(self, way_id: int, node_id: int, distance: float) -> tuple[float, float, float]:
        """Return x, y and heading on a way, `distance` before it comes to a node (or near its start, if shorter)."""
        return self._near(way_id, node_id, distance, coming=True)

    def after(self, way_id: int, node_id: int, distance: float) -> tuple[float, float, float]:
        """Return x, y and heading on a way, `distance` after it leaves a node (or near its end, if shorter)."""
        return self._near(way_id, node_id, distance, coming=False)

    def _near(self, way_id: int, node_id: int, distance: float, coming: bool) -> tuple[float, float, float]:
        way = self.ways[way_id]
        ends = (way.node_ids[0], way.node_ids[-1])
        if node_id not in ends or ends[0] == ends[1]:
            raise ValueError(f"way {way_id} does not start or end at node {node_id}")
        xy = way.xy if node_id == ends[0] else way.xy[::-1]
        run = np.r_[0.0, np.cumsum(np.hypot(*np.diff(xy, axis=0).T))]
        at = min(distance, 0.9 * float(run[-1]))
        k = int(np.searchsorted(run, at, side="right")) - 1
        step = xy[k + 1] - xy[k]
        x, y = xy[k] + step * (at - run[k]) / (run[k + 1] - run[k])
        away = math.atan2(step[1], step[0])
        return float(x), float(y), away + math.pi if coming else away


def read_osm(path: Path, georeference: str) -> OsmTruth:
    """Read the car roads of a gzipped or plain OSM XML file."""
    document = path.read_bytes()
    root = etree.fromstring(gzip.decompress(document) if path.suffix == ".gz" else document)
    places = {int(e.attrib["id"]): (float(e.attrib["lon"]), float(e.attrib["lat"])) for e in root.iter("node")}
    to_local = Transformer.from_crs("EPSG:4326", georeference, always_xy=True)
    ways, lon_lat = {}, []
    for element in root.iter("way"):
        tags = {str(e.attrib["k"]): str(e.attrib["v"]) for e in element.iter("tag")}
        node_ids = [int(e.attrib["ref"]) for e in element.iter("nd")]
        node_ids = [n for k, n in enumerate(node_ids) if n in places and (k == 0 or n != node_ids[k - 1])]
        if _for_cars(tags) and len(node_ids) > 1:
            degrees = np.array([places[n] for n in node_ids])
            lon_lat.append(degrees)
            xy = np.column_stack(to_local.transform(degrees[:, 0], degrees[:, 1]))
            way_id = int(element.attrib["id"])
            ways[way_id] = OsmWay(way_id, tuple(node_ids), xy)
    everything = np.concatenate(lon_lat)
    west, south, east, north = (float(v) for v in (*everything.min(0), *everything.max(0)))
    return OsmTruth(ways, (west, south, east, north))


def _for_cars(tags: dict[str, str]) -> bool:
    if tags.get("area") == "yes":
        return False
    for key in ("motorcar", "motor_vehicle", "vehicle", "access"):
        if key in tags:
            if tags[key] in CLOSED:
                return False
            break
    highway = tags.get("highway")
    return highway in CAR_HIGHWAYS or (highway == "service" and tags.get("service", "alley") == "alley")


def distances_to_roads(osm: OsmTruth, network: XodrFile, step: float = 2.0) -> tuple[FloatArray, list[str]]:
    """Return how far the OSM lines, seen each `step`, are outside of the car lanes, m, and the way of each figure."""
    places, names = [], []
    for way in osm.ways.values():
        run = np.r_[0.0, np.cumsum(np.hypot(*np.diff(way.xy, axis=0).T))]
        at = np.linspace(0.0, run[-1], max(2, int(run[-1] / step) + 1))
        places.append(np.column_stack([np.interp(at, run, way.xy[:, 0]), np.interp(at, run, way.xy[:, 1])]))
        names += [f"way {way.id}"] * len(at)
    points = np.concatenate(places)
    x, y, hdg, low, high = _carriageways(network)
    _, near = cKDTree(np.column_stack([x, y])).query(points, k=min(32, len(x)))
    near = np.asarray(near).reshape(len(points), -1)
    dx, dy = points[:, :1] - x[near], points[:, 1:] - y[near]
    along = dx * np.cos(hdg[near]) + dy * np.sin(hdg[near])
    t = dy * np.cos(hdg[near]) - dx * np.sin(hdg[near])
    aside = np.maximum(np.maximum(low[near] - t, t - high[near]), 0.0)
    return np.hypot(aside, np.maximum(np.abs(along) - 0.5, 0.0)).min(1), names


def _carriageways(network: XodrFile) -> tuple[FloatArray, ...]:
    """Sample reference lines each metre: x, y, heading, and t of the right and left edge of all car lanes."""
    columns: list[list[FloatArray]] = [[], [], [], [], []]
    for road in network.roads.values():
        for section in road.sections:
            cars = [i for i, lane in section.lanes.items() if lane.type in CAR_LANES]
            if not cars:
                continue
            s = np.linspace(section.s, section.end, max(2, math.ceil(section.end - section.s) + 1))
            edges = np.array([t for i in cars for t in section.edges(i, s)]) + road.lane_offset.value(s)
            for column, values in zip(columns, (*road.pose(s), edges.min(0), edges.max(0)), strict=True):
                column.append(values)
    return tuple(np.concatenate(column) for column in columns)
