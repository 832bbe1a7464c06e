"""What a server of the Overpass API and one of elevation models would answer, for a map and terrain of ours."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import numpy.typing as npt
import rasterio
from overpass_ql import Box, MapData, box_of
from rasterio import Affine
from web_server import Reply, Request, WebServer

from osm2xodr.fetching.overpass import area_query

ROOT = Path(__file__).parents[2]
SAMPLE = ROOT / "data" / "samples" / "andorra_ordino"
ORDINO = (1.56, 42.55, 1.59, 42.565)
OSM_BASE = "2026-11-20T10:00:00Z"
GLO_30 = "/Copernicus_DSM_COG_10_{ns}_00_{ew}_00_DEM.tif"
_META = f'<note>The data included in this document is from OSM.</note>\n<meta osm_base="{OSM_BASE}"/>'
_HEAD = f'<?xml version="1.0" encoding="UTF-8"?>\n<osm version="0.6" generator="a double">\n{_META}\n'


class Overpass:
    """Answers queries from a file."""

    def __init__(self, path: Path = SAMPLE / "area.osm") -> None:
        self.data = _data_of(path)
        self.boxes: list[Box] = []  # Those that were asked for, and given whole
        self.counted: list[Box] = []

    def __call__(self, request: Request) -> Reply:
        query = request.query["data"]
        (self.counted if query.endswith("out count;") else self.boxes).append(box_of(query))
        return Reply(answer(self.data.run(query)))

    def within(self, box: Box, *, surroundings: bool = True) -> list[ElementTree.Element]:
        """Return what there is in a box."""
        return list(ElementTree.fromstring(f"<osm>{self.data.run(area_query(box, surroundings=surroundings))}</osm>"))


_data_of = functools.cache(MapData)


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
