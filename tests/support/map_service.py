"""What a server of the Overpass API and one of elevation models would answer, for a map and terrain of ours."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import numpy.typing as npt
import rasterio
from rasterio import Affine
from web_server import Reply, Request, WebServer

ROOT = Path(__file__).parents[2]
SAMPLE = ROOT / "data" / "samples" / "andorra_ordino"
ORDINO = (1.56, 42.55, 1.59, 42.565)
OSM_BASE = "2026-11-20T10:00:00Z"
GLO_30 = "/Copernicus_DSM_COG_10_{ns}_00_{ew}_00_DEM.tif"
_META = f'<note>The data included in this document is from OSM.</note>\n<meta osm_base="{OSM_BASE}"/>'
_HEAD = f'<?xml version="1.0" encoding="UTF-8"?>\n<osm version="0.6" generator="a double">\n{_META}\n'


class Overpass:
    """Answers the queries of `osm2xodr.fetching.queries` from a file, as far as they differ in their box."""

    def __init__(self, path: Path = SAMPLE / "area.osm") -> None:
        self.root = ElementTree.parse(path).getroot()
        self.places = {
            node.get("id", ""): (float(node.get("lon", "")), float(node.get("lat", "")))
            for node in self.root.iter("node")
        }
        self.boxes: list[tuple[float, float, float, float]] = []  # Those that were asked for, and given whole
        self.counted: list[tuple[float, float, float, float]] = []

    def __call__(self, request: Request) -> Reply:
        query = request.query["data"]
        found = re.search(r"\(([-\d.]+),([-\d.]+),([-\d.]+),([-\d.]+)\)", query)
        assert found is not None
        south, west, north, east = map(float, found.groups())
        box = west, south, east, north
        items = self.within(box)
        if query.endswith("out count;"):
            self.counted.append(box)
            count = sum(item.tag == "way" for item in items)
            return Reply(answer(f'<count id="0"><tag k="total" v="{count}"/></count>'))
        self.boxes.append(box)
        return Reply(answer("".join(ElementTree.tostring(item, "unicode") for item in items)))

    def within(self, box: tuple[float, float, float, float]) -> list[ElementTree.Element]:
        """Return ways with a node in a box, all of their nodes, and the relations about them."""
        west, south, east, north = box
        inside = {key for key, (x, y) in self.places.items() if west <= x <= east and south <= y <= north}
        ways = [
            way
            for way in self.root.iter("way")
            if inside & {node.get("ref") for node in way.iter("nd")}
            and any(tag.get("k") == "highway" for tag in way.iter("tag"))
        ]
        names = {way.get("id") for way in ways}
        refs = {node.get("ref") for way in ways for node in way.iter("nd")}
        nodes = [node for node in self.root.iter("node") if node.get("id") in refs]
        rules = [item for item in self.root.iter("relation") if names & {part.get("ref") for part in item}]
        return [*nodes, *ways, *rules]


def answer(content: str) -> bytes:
    """Return an answer of the Overpass API."""
    return f"{_HEAD}{content}\n</osm>\n".encode()


def height(lon: Any, lat: Any) -> npt.NDArray[np.float32]:
    """Return the heights of the terrain at places, degrees."""
    out: npt.NDArray[np.float32] = (1300.0 + 800.0 * (lon - 1.575) + 500.0 * (lat - 42.56)).astype(np.float32)
    return out


def tile_of(west: int, south: int, size: int = 1200, columns: int | None = None) -> bytes:
    """Return a tile as Copernicus has them, of a degree, its corner half a cell off; cells of 3 arc seconds."""
    across = columns or size
    step_x, step_y = 1.0 / across, 1.0 / size
    transform = Affine(step_x, 0.0, west - 0.5 * step_x, 0.0, -step_y, south + 1.0 + 0.5 * step_y)
    lon, lat = west + np.arange(across) * step_x, south + 1.0 - np.arange(size) * step_y
    cells = height(lon[None, :], lat[:, None])
    with rasterio.MemoryFile() as memory:
        with memory.open(
            driver="GTiff", width=across, height=size, count=1, dtype="float32", crs="EPSG:4326", transform=transform,
            tiled=True, blockxsize=256, blockysize=256, compress="deflate",
        ) as dataset:  # fmt: skip
            dataset.write(cells, 1)
        return bytes(memory.getbuffer())


def tile_path(west: int, south: int) -> str:
    """Return where a tile is."""
    ns, ew = f"{'S' if south < 0 else 'N'}{abs(south):02}", f"{'W' if west < 0 else 'E'}{abs(west):03}"
    return GLO_30.format(ns=ns, ew=ew)


def template(server: WebServer) -> str:
    """Return the address of tiles with placeholders."""
    return server.url + GLO_30.format(ns="{NS}{lat:02}", ew="{EW}{lon:03}")
