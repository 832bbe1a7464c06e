"""Heights that are coded as colours."""

from pathlib import Path

import numpy as np
import pytest
from dem_factory import BAVARIA, around, centres, read, scatter, to_local, write_raster

from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray
from osm2xodr.surface import DEM_ENCODINGS
from osm2xodr.surface.grids.labels import ENCODINGS

UTM = "EPSG:32632"


def coded(folder: Path, name: str, alpha: bool = False) -> tuple[Path, FloatArray]:
    """Write the plane 500 + x / 10 as a picture; return it and its heights."""
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    x, _ = to_local(BAVARIA, UTM, *(part.ravel() for part in np.broadcast_arrays(*centres(transform, rows, cols))))
    z = 500.0 + x.reshape(rows, cols) / 10.0
    step, lowest = ENCODINGS[name]
    code = np.round((z - lowest) / step).astype(np.int64)
    bands = [code >> 16, code >> 8 & 255, code & 255, *([np.full_like(code, 255)] if alpha else [])]
    return write_raster(folder / "dem.tif", np.array(bands, np.uint8), transform, UTM), z


@pytest.mark.parametrize("alpha", [False, True])
@pytest.mark.parametrize("name", ENCODINGS)
def test_colours_become_heights(tmp_path: Path, name: str, alpha: bool) -> None:
    path, _ = coded(tmp_path, name, alpha)
    x, y = scatter(half=800.0)
    surface, diagnostics = read(path, BAVARIA, x, y, dem_encoding=name)
    z, measured = surface.heights(x, y)
    assert measured.all()
    # Half a step of the encoding.
    assert np.abs(z - (500.0 + x / 10.0)).max() < 0.06
    assert [item.code for item in diagnostics if item.code == "dem-bands"] == []


@pytest.mark.parametrize("name", ENCODINGS)
def test_pictures_that_may_code_heights_say_how(tmp_path: Path, name: str) -> None:
    path, _ = coded(tmp_path, name)
    with pytest.raises(InputError, match=rf"seem to code heights as Terrain-RGB .*--dem-encoding {name}$"):
        read(path, BAVARIA, *scatter(half=800.0))


def test_black_is_no_height(tmp_path: Path) -> None:
    path, z = coded(tmp_path, "mapbox")
    transform, _, cols = around(BAVARIA, UTM, 20.0)
    code = np.round((z + 10000.0) / 0.1).astype(np.int64)
    code[:, : cols // 2] = 0
    write_raster(path, np.array([code >> 16, code >> 8 & 255, code & 255], np.uint8), transform, UTM)
    x = np.array([-500.0, 500.0])
    assert read(path, BAVARIA, x, 0.0 * x, dem_encoding="mapbox")[0].heights(x, 0.0 * x)[1].tolist() == [False, True]


def test_names_are_those_that_options_have() -> None:
    assert tuple(ENCODINGS) == DEM_ENCODINGS


def test_a_band_that_is_the_same_everywhere_is_reported(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    first = np.full((rows, cols), 7.0, np.float32)
    second = np.linspace(400, 500, rows * cols, dtype=np.float32).reshape(rows, cols)
    path = write_raster(tmp_path / "dem.tif", np.array([first, second]), transform, UTM)
    _, diagnostics = read(path, BAVARIA, *scatter(half=800.0))
    (found,) = [item.message for item in diagnostics if item.code == "dem-constant"]
    assert "is 7 m everywhere around the roads, and band 2 goes from 4" in found
    write_raster(path, np.array([second, first]), transform, UTM)
    _, diagnostics = read(path, BAVARIA, *scatter(half=800.0))
    assert "dem-constant" not in [item.code for item in diagnostics]
