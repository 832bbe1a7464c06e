from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
from dem_factory import BAVARIA, in_crs, read, scatter

from osm2xodr.surface.grids import raster_file as dem
from osm2xodr.surface.grids.grid import Cells


@pytest.fixture
def cells_read(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Count the cells that are asked of files."""
    counts: list[int] = []
    original = dem._metres

    def counted(source: Any, raw: Any, sentinels: dict[float, int]) -> Cells:
        counts.append(int(raw.size))
        return original(source, raw, sentinels)

    monkeypatch.setattr(dem, "_metres", counted)
    return counts


def tile(folder: Path, south: int, west: int) -> Path:
    """Write a tile of one arc second, 3601 x 3601 cells, whose height is 100 m for each degree north."""
    lat = south + 1.0 - np.arange(3601) / 3600.0
    rows = np.round(100.0 * lat).astype(">i2")
    path = folder / f"N{south:02d}E{west:03d}.hgt"
    path.write_bytes(np.broadcast_to(rows[:, None], (3601, 3601)).tobytes())
    return path


def test_a_whole_tile_costs_what_the_roads_need(tmp_path: Path, cells_read: list[int]) -> None:
    path = tile(tmp_path, 49, 11)
    x, y = scatter(half=1000.0)
    surface, _ = read(path, BAVARIA, x, y)
    lat = in_crs(BAVARIA, 4326, x, y)[1]
    assert np.abs(surface.heights(x, y)[0] - 100.0 * lat).max() < 0.51
    # 2 km are 65 rows and 100 columns, with 38 on either side; the type of model is told from 200 x 200 cells.
    assert 65 * 99 < surface.dems[0].cells <= (67 + 76) * (101 + 76)
    assert cells_read == [surface.dems[0].cells, 200 * 200]
    cells_read.clear()
    read(path, BAVARIA, x, y, dem_type="dsm")
    assert cells_read == [surface.dems[0].cells]


def test_a_country_of_tiles_costs_no_more(tmp_path: Path, cells_read: list[int]) -> None:
    tile(tmp_path, 49, 11)
    # 40 by 40 degrees of tiles, all but one absent from the disk, which GDAL must never try to open.
    sources = "".join(
        f'<SimpleSource><SourceFilename relativeToVRT="1">N{south:02d}E{west:03d}.hgt</SourceFilename><SourceBand>1'
        '</SourceBand><SourceProperties RasterXSize="3601" RasterYSize="3601" DataType="Int16"/>'
        '<SrcRect xOff="0" yOff="0" xSize="3601" ySize="3601"/>'
        f'<DstRect xOff="{(west - 0) * 3600}" yOff="{(69 - south) * 3600}" xSize="3601" ySize="3601"/></SimpleSource>'
        for south in range(30, 70)
        for west in range(40)
    )
    size = 40 * 3600 + 1
    vrt = tmp_path / "country.vrt"
    vrt.write_text(
        f'<VRTDataset rasterXSize="{size}" rasterYSize="{size}"><SRS>EPSG:4326</SRS><GeoTransform>{-1 / 7200!r}, '
        f"{1 / 3600!r}, 0, {70 + 1 / 7200!r}, 0, {-1 / 3600!r}</GeoTransform>"
        f'<VRTRasterBand dataType="Int16" band="1"><NoDataValue>-32768</NoDataValue>{sources}</VRTRasterBand>'
        "</VRTDataset>"
    )
    x, y = scatter(half=1000.0)
    began = time.perf_counter()
    surface, _ = read(vrt, BAVARIA, x, y)
    assert time.perf_counter() - began < 5.0
    lat = in_crs(BAVARIA, 4326, x, y)[1]
    assert np.abs(surface.heights(x, y)[0] - 100.0 * lat).max() < 0.51
    assert surface.dems[0].cells <= (67 + 76) * (101 + 76)
    assert cells_read == [surface.dems[0].cells, 200 * 200]
    with rasterio.open(vrt) as dataset:
        assert dataset.width * dataset.height > 2e10


def test_a_model_that_reaches_no_road_is_not_read(tmp_path: Path, cells_read: list[int]) -> None:
    here, away = tile(tmp_path, 49, 11), tile(tmp_path, 45, 7)
    surface, diagnostics = read([here, away], BAVARIA, *scatter(), dem_type="dtm")
    assert [item.cells for item in surface.dems] == [sum(cells_read), 0]
    assert "dem-unused" in [item.code for item in diagnostics]
