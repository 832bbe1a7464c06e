"""What is recorded of a small scene: roads, lanes, heights, movements, furniture, in lines that a diff shows well."""

from __future__ import annotations

import string
from collections import Counter
from pathlib import Path

import numpy as np
import rasterio
from lxml import etree
from rasterio import Affine
from xodr_file import Road, XodrFile, read_xodr

# Cells of the made-up terrain, degrees (about 10 m), and how far it reaches beyond the nodes, degrees.
_CELL = 1e-4
_MARGIN = 0.004


def write_hills(osm: Path, path: Path) -> Path:
    """Write an elevation model of gentle hills around the nodes of an OSM file: the same for the same nodes."""
    nodes = etree.parse(str(osm)).getroot().iter("node")
    lat, lon = np.array([(float(node.attrib["lat"]), float(node.attrib["lon"])) for node in nodes]).T
    west, north = lon.min() - _MARGIN, lat.max() + _MARGIN
    columns, rows = (int((np.ptp(values) + 2 * _MARGIN) / _CELL) for values in (lon, lat))
    x, y = np.meshgrid(np.arange(columns) * 10.0, np.arange(rows) * -10.0)
    z = 300.0 + 0.03 * x + 0.02 * y + 8.0 * np.sin(x / 120.0) * np.cos(y / 90.0)
    shape = {"width": columns, "height": rows, "count": 1, "dtype": "float32", "crs": "EPSG:4326"}
    with rasterio.open(
        path, "w", driver="GTiff", transform=Affine(_CELL, 0.0, west, 0.0, -_CELL, north), **shape
    ) as out:
        out.write(z.astype(np.float32), 1)
    return path


def summary(path: Path) -> str:
    """Return what is recorded of a file, with lengths and heights to 1 cm, independent of ids and of order."""
    file = read_xodr(path)
    root = etree.parse(str(path)).getroot()
    names = _names(file, root)
    connecting = sum(road.connecting for road in file.roads.values())
    lines = [
        f"{len(file.roads) - connecting} roads, {connecting} connecting roads, {len(file.junctions)} junctions",
        *(f"{kind}: {count}" for kind, count in sorted(_furniture(root).items())),
    ]
    lines += sorted(_road(names[road.id], road) for road in file.roads.values() if not road.connecting)
    for movements in sorted(sorted(_movements(file, names, number)) for number in file.junctions):
        lines += ["junction", *(f"  {movement}" for movement in movements)]
    return "\n".join(lines) + "\n"


def _names(file: XodrFile, root: etree._Element) -> dict[str, str]:
    """Name plain roads by their OSM ways, with a letter where several have the same, from west to east."""
    ways = {
        str(road.attrib["id"]): "+".join(
            str(item.attrib["value"]) for item in road.findall("userData[@code='osm_way_ids']")
        )
        for road in root.findall("road")
    }
    x = {number: float(road.pose(np.array([road.length / 2]))[0][0]) for number, road in file.roads.items()}
    plain = sorted((number for number, road in file.roads.items() if not road.connecting), key=x.__getitem__)
    several = Counter(ways[number] for number in plain)
    seen = Counter[str]()
    names = {}
    for number in plain:
        way = ways[number]
        names[number] = f"way {way}" + (string.ascii_lowercase[seen[way]] if several[way] > 1 else "")
        seen[way] += 1
    return names


def _furniture(root: etree._Element) -> Counter[str]:
    found = Counter(f"signal {item.get('type')}" for item in root.iter("signal"))
    found.update(f"object {item.get('type')}" for item in root.iter("object"))
    found.update(f"mark {item.get('type')}" for item in root.iter("roadMark"))
    return found


def _road(name: str, road: Road) -> str:
    z = road.elevation.value(np.linspace(0.0, road.length, 3))
    parts = [f"{name}: {road.length:.2f} m", "z " + " ".join(f"{value:.2f}" for value in z)]
    for section in road.sections:
        middle = np.array([(section.s + section.end) / 2])
        lanes = sorted(section.lanes.values(), key=lambda lane: -lane.id)
        widths = {lane.id: float(lane.width.value(middle - section.s)[0]) for lane in lanes}
        text = [f"{lane.type} {widths[lane.id]:.2f}" for lane in lanes]
        left = sum(lane.id > 0 for lane in lanes)
        parts.append(f"{section.end - section.s:.2f} m [{', '.join(text[:left])} | {', '.join(text[left:])}]")
    return "; ".join(parts)


def _movements(file: XodrFile, names: dict[str, str], number: str) -> list[str]:
    """Return the ways of lanes through a junction, each with its length and its height in the middle."""
    out = []
    for connection in file.junctions[number].connections:
        road = file.roads[connection.connecting]
        beyond = road.successor if connection.contact_point == "start" else road.predecessor
        at_start = connection.contact_point != "start"
        z = float(road.elevation.value(np.array([road.length / 2]))[0])
        for entry, lane in connection.lane_links:
            section = road.section(at_start)
            ends = section.lanes[lane].predecessors if at_start else section.lanes[lane].successors
            exits = [f"{names[beyond.element_id]}:{k}" for k in ends] if beyond else ["nothing"]
            out += [f"{names[connection.incoming]}:{entry} -> {end}, {road.length:.2f} m, z {z:.2f}" for end in exits]
    return out
