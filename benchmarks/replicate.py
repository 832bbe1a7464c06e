"""Make a large area out of a small one: copies side by side, each with ids of its own, and their elevation model.

Copies do not touch, so that the network grows by their number and nothing else.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import osmium
import rasterio
from osmium.osm import mutable
from rasterio.transform import Affine

# Between copies, degrees: wider than any road, and than a cell of the elevation models that are in use.
_MARGIN_DEG = 0.004


@dataclass(frozen=True)
class Area:
    """An OSM file and perhaps its elevation model."""

    name: str
    osm: Path
    dem: Path | None = None


def count_nodes(path: Path) -> int:
    """Count the nodes of an OSM file."""
    return sum(1 for _ in osmium.FileProcessor(str(path), osmium.osm.NODE))


def replicate(area: Area, copies: int, folder: Path) -> Area:
    """Write `copies` copies of an area into `folder`, as .osm.pbf, .osm and .tif.

    Nodes that no way refers to, and those out of the extent of the roads, are copied as well: readers have to pass
    over them, as in any extract.
    """
    name = f"{area.name}_x{copies}"
    nodes, ways, relations = _elements(area.osm)
    west, south, east, north = _extent(nodes, ways)
    columns = math.ceil(math.sqrt(copies))
    rows = math.ceil(copies / columns)
    width, height = east - west + _MARGIN_DEG, north - south + _MARGIN_DEG
    dem = None
    if area.dem is not None:
        dem = folder / f"{name}.tif"
        width, height = _tile_dem(area.dem, (west, south, east, north), rows, columns, dem)
    targets = [folder / f"{name}.osm.pbf", folder / f"{name}.osm"]
    step = 1 + max(item.id for group in (nodes, ways, relations) for item in group)
    writers = [osmium.SimpleWriter(str(target)) for target in targets]
    places = [(k * step, (k % columns) * width, (k // columns) * height) for k in range(copies)]
    for writer in writers:
        for shift, dx, dy in places:
            for node in nodes:
                lon, lat = node.location
                writer.add_node(mutable.Node(node, id=node.id + shift, location=(lon + dx, lat + dy)))
        for shift, _, _ in places:
            for way in ways:
                writer.add_way(mutable.Way(way, id=way.id + shift, nodes=[ref + shift for ref in way.nodes]))
        for shift, _, _ in places:
            for item in relations:
                members = [(kind, ref + shift, role) for kind, ref, role in item.members]
                writer.add_relation(mutable.Relation(item, id=item.id + shift, members=members))
        writer.close()
    return Area(name, targets[0], dem)


def _elements(path: Path) -> tuple[list[Any], list[Any], list[Any]]:
    nodes: list[Any] = []
    ways: list[Any] = []
    relations: list[Any] = []
    item: Any
    for item in osmium.FileProcessor(str(path)):
        tags = {tag.k: tag.v for tag in item.tags}
        if item.is_node():
            place = (item.location.lon, item.location.lat)
            nodes.append(mutable.Node(id=item.id, version=1, location=place, tags=tags))
        elif item.is_way():
            refs = [node.ref for node in item.nodes]
            ways.append(mutable.Way(id=item.id, version=1, nodes=refs, tags=tags))
        elif item.is_relation():
            members = [(member.type, member.ref, member.role) for member in item.members]
            relations.append(mutable.Relation(id=item.id, version=1, members=members, tags=tags))
    return nodes, ways, relations


def _extent(nodes: list[Any], ways: list[Any]) -> tuple[float, float, float, float]:
    """Return west, south, east, north of the nodes of streets."""
    used = {ref for way in ways if "highway" in way.tags for ref in way.nodes}
    lon, lat = np.array([node.location for node in nodes if node.id in used]).T
    return float(lon.min()), float(lat.min()), float(lon.max()), float(lat.max())


def _tile_dem(
    source: Path, bounds: tuple[float, float, float, float], rows: int, columns: int, target: Path
) -> tuple[float, float]:
    """Repeat the part of an elevation model below the streets and return the size of one copy, degrees."""
    with rasterio.open(source) as dem:
        if not dem.crs.is_geographic:
            raise SystemExit(f"{source}: replication needs an elevation model in degrees")
        west, south, east, north = bounds
        cell_x, cell_y = dem.res
        x0, y0 = dem.bounds.left, dem.bounds.top
        # A cell more on every side keeps copies apart; beyond the model its outermost heights go on.
        cols = np.arange(math.floor((west - x0) / cell_x) - 1, math.ceil((east - x0) / cell_x) + 1)
        rows_read = np.arange(math.floor((y0 - north) / cell_y) - 1, math.ceil((y0 - south) / cell_y) + 1)
        band = dem.read(1)
        heights = band[np.ix_(np.clip(rows_read, 0, band.shape[0] - 1), np.clip(cols, 0, band.shape[1] - 1))]
        corner = x0 + float(cols[0]) * cell_x, y0 - float(rows_read[0]) * cell_y
        profile = dem.profile
    height, width = heights.shape
    tiled = np.tile(heights, (rows, columns))
    profile.update(
        driver="GTiff",
        height=tiled.shape[0],
        width=tiled.shape[1],
        transform=Affine(cell_x, 0.0, corner[0], 0.0, -cell_y, corner[1] + (rows - 1) * height * cell_y),
    )
    with rasterio.open(target, "w", **profile) as out:
        out.write(tiled, 1)
    return width * cell_x, height * cell_y
