"""What tests of the page share."""

from __future__ import annotations

import base64
import gzip
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import rasterio
from rasterio import Affine

from osm2xodr.model import FloatArray
from osm2xodr.opendrive.space import frame_of
from osm2xodr.opendrive.tables import OpenDrive

TERTIARY = '<tag k="highway" v="tertiary"/><tag k="name" v="Hauptstraße"/>'


def info_of(page: bytes) -> dict[str, Any]:
    """Return the page's document."""
    found = re.search(rb'id="info-data">([^<]*)<', page)
    assert found is not None
    info: dict[str, Any] = json.loads(gzip.decompress(base64.b64decode(found.group(1))))
    return info


def write_plane(folder: Path, file: OpenDrive) -> Path:
    """Write an elevation model that is a plane over a file's x and y: 8 + 0.05 x."""
    return write_ground(folder, file, lambda x, y: 8.0 + 0.05 * x + 0.0 * y)


def write_ground(folder: Path, file: OpenDrive, height: Callable[[FloatArray, FloatArray], FloatArray]) -> Path:
    """Write an elevation model whose heights (m) are a function of a file's x and y, in cells of 5 m."""
    frame, _ = frame_of(file.header)
    assert frame is not None
    path = folder / "plane.tif"
    x, y = np.meshgrid(np.arange(-297.5, 500.0, 5.0), np.arange(397.5, -400.0, -5.0))
    z = height(x, y).astype(np.float32)
    shape = {"width": x.shape[1], "height": 160, "count": 1, "dtype": "float32", "crs": frame.crs.to_wkt()}
    with rasterio.open(path, "w", driver="GTiff", transform=Affine(5, 0, -300, 0, -5, 400), **shape) as dataset:
        dataset.write(z, 1)
    return path
