"""GDAL as rasterio brings it."""

from __future__ import annotations

import _ctypes
from pathlib import Path
from types import SimpleNamespace

import pytest
import rasterio

from osm2xodr.errors import Osm2xodrError
from osm2xodr.system import raster_library


def test_gdal_is_found_beside_rasterio_where_a_module_gives_its_own_names_alone(tmp_path: Path) -> None:
    # As on Windows: a module without GDAL's names, and GDAL in a folder beside the package.
    installed = SimpleNamespace(
        __file__=str(tmp_path / "rasterio" / "__init__.py"), _env=SimpleNamespace(__file__=_ctypes.__file__)
    )
    with pytest.raises(Osm2xodrError, match=r"^GDAL is not found in this installation of rasterio, .* with pip$"):
        raster_library._library(installed)
    (tmp_path / "rasterio.libs").mkdir()
    (tmp_path / "rasterio.libs" / "gdal-1a2b.dll").symlink_to(rasterio._env.__file__)
    with rasterio.Env() as environment:
        assert raster_library._library(installed).GDALGetDriverCount() >= len(environment.drivers()) > 0
