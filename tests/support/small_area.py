"""An area of a few streets, made by hand: an OSM file and elevation models for it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import rasterio
from rasterio import Affine

# A village street from west to east, about 330 m, and a lane that leaves it to the north after half of it.
OSM = """<?xml version="1.0" encoding="UTF-8"?>
<osm version="0.6" generator="by hand">
 <node id="1" lat="42.5500" lon="1.5700"/>
 <node id="2" lat="42.5500" lon="1.5720"/>
 <node id="3" lat="42.5500" lon="1.5740"/>
 <node id="4" lat="42.5515" lon="1.5720"/>
 <way id="10">
  <nd ref="1"/><nd ref="2"/><nd ref="3"/>
  <tag k="highway" v="tertiary"/><tag k="name" v="Carrer Major"/><tag k="lanes" v="2"/><tag k="maxspeed" v="50"/>
 </way>
 <way id="11">
  <nd ref="2"/><nd ref="4"/>
  <tag k="highway" v="residential"/>
 </way>
</osm>
"""


def write_area(folder: Path, text: str = OSM, name: str = "village.osm") -> Path:
    """Write the OSM file and return its path."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def write_dem(
    folder: Path,
    name: str = "dem.tif",
    *,
    west: float = 1.565,
    north: float = 42.556,
    columns: int = 60,
    crs: str | None = "EPSG:4326",
    void: bool = False,
) -> Path:
    """Write a GeoTIFF of cells of 1 second of arc that rises by 1 m per cell to the east from 1000 m on.

    It covers the whole area unless it is placed elsewhere or made of fewer columns (1 second is 0.00028 degrees).
    """
    cell = 1.0 / 3600.0
    heights = np.tile(np.arange(1000.0, 1000.0 + columns), (40, 1)).astype(np.float32)
    if void:
        heights[:] = -9999.0
    path = folder / name
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        width=columns,
        height=40,
        count=1,
        dtype="float32",
        crs=crs,
        transform=Affine(cell, 0.0, west, 0.0, -cell, north),
        nodata=-9999.0,
    ) as dataset:
        dataset.write(heights, 1)
    return path


def street_grid(count: int) -> str:
    """Return a town of streets that cross every 100 m, which takes some 10 s and 500 MB for 90 of them each way."""
    lines = ["<osm version='0.6'>"]
    for row in range(count):
        for column in range(count):
            place = f"lat='{48 + row * 9e-4:.6f}' lon='{11 + column * 1.34e-3:.6f}'"
            lines.append(f"<node id='{row * count + column + 1}' {place}/>")
    for k in range(count):
        for number, nodes in ((k, range(k * count, (k + 1) * count)), (count + k, range(k, count * count, count))):
            refs = "".join(f"<nd ref='{node + 1}'/>" for node in nodes)
            lines.append(f"<way id='{number + 1}'>{refs}<tag k='highway' v='residential'/></way>")
    return "\n".join([*lines, "</osm>"])
