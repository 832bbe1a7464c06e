"""Heights that are coded as colours."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyproj
import pyproj.network
import pytest
from affine import Affine
from dem_factory import BAVARIA, around, centres, in_crs, read, scatter, to_local, write_raster
from pyproj import CRS

from osm2xodr.diagnostics import Kind
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray
from osm2xodr.projection import make_frame
from osm2xodr.surface import DEM_ENCODINGS, SurfaceOptions
from osm2xodr.surface.grids.crs import ENCODINGS, heights_of, horizontal_crs, metres_per, parse_datum, vertical_unit

UTM = "EPSG:32632"

BELGIUM = make_frame(50.8, 4.5)
SOCHI = make_frame(44.8, 37.5)


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


def level(path: Path, crs: str, heights: str = "", **profile: object) -> Path:
    """Write ground at 100 units in Belgium."""
    transform, rows, cols = around(BELGIUM, crs, 20.0)
    return write_raster(path, np.full((rows, cols), 100.0), transform, crs + heights, **profile)


@pytest.fixture
def made_geoid(tmp_path: Path) -> Iterator[None]:
    """Give PROJ a geoid of our own under the name of EGM96's grid: 40 m at 50 N, 4 E, 2 m up north and 1.5 m east."""
    folder = tmp_path / "proj"
    folder.mkdir()
    lat, lon = np.arange(51.5, 49.9, -0.25), np.arange(3.5, 6.1, 0.25)
    grid = np.add.outer(2.0 * (lat - 50.0), 40.0 + 1.5 * (lon - 4.0)).astype(np.float32)
    write_raster(
        folder / "us_nga_egm96_15.tif", grid, Affine(0.25, 0, 3.375, 0, -0.25, 51.625), "EPSG:4979",
        tags={"TYPE": "VERTICAL_OFFSET_GEOGRAPHIC_TO_VERTICAL", "AREA_OR_POINT": "Point"},
    )  # fmt: skip
    before = pyproj.datadir.get_data_dir()
    pyproj.datadir.append_data_dir(str(folder))
    yield
    pyproj.datadir.set_data_dir(before)


def test_ellipsoidal_heights_from_a_geoid(tmp_path: Path, made_geoid: None) -> None:
    x, y = scatter()
    lon, lat = in_crs(BELGIUM, 4326, x, y)
    expected = 100.0 + 40.0 + 2.0 * (lat - 50.0) + 1.5 * (lon - 4.0)
    plain = level(tmp_path / "plain.tif", "EPSG:32631")
    surface, diagnostics = read(plain, BELGIUM, x, y, vertical_datum="ellipsoid", dem_vertical_datum="EPSG:5773")
    assert np.abs(surface.heights(x, y)[0] - expected).max() < 1e-4
    said = [item for item in diagnostics if item.code == "vertical-datum"]
    assert [item.kind for item in said] == [Kind.NOTE]
    assert "from EGM96 height (EPSG:5773) to heights above the ellipsoid of WGS 84" in said[0].message
    assert "changed them by 42.29 to 42.41 m" in said[0].message
    # The file's own datum does as well, and so does the way back.
    own = level(tmp_path / "own.tif", "EPSG:32631", "+5773")
    surface, _ = read(own, BELGIUM, x, y, vertical_datum="EPSG:4979")
    assert np.abs(surface.heights(x, y)[0] - expected).max() < 1e-4
    surface, _ = read(plain, BELGIUM, x, y, vertical_datum="EPSG:5773", dem_vertical_datum="ellipsoid")
    assert np.abs(surface.heights(x, y)[0] - (200.0 - expected)).max() < 1e-4


def test_models_in_two_datums_meet_without_a_step(tmp_path: Path, made_geoid: None) -> None:
    transform, rows, cols = around(BELGIUM, "EPSG:32631", 20.0)
    sea = write_raster(tmp_path / "sea.tif", np.full((rows, cols // 2), 100.0), transform, "EPSG:32631+5773")
    transform, rows, cols = around(BELGIUM, "EPSG:4326", 1 / 3600)
    lon, lat = centres(transform, rows, cols)
    above = 100.0 + 40.0 + 2.0 * (lat - 50.0) + 1.5 * (lon - 4.0)
    ellipsoid = write_raster(tmp_path / "ellipsoid.tif", above, transform, "EPSG:4979")
    x, y = np.linspace(-900.0, 900.0, 1000), np.zeros(1000)
    apart, diagnostics = read([sea, ellipsoid], BELGIUM, x, y)
    assert np.ptp(apart.heights(x, y)[0]) > 42.0
    assert "dem-datums" in [item.code for item in diagnostics]
    together, _ = read([sea, ellipsoid], BELGIUM, x, y, vertical_datum="EPSG:5773")
    assert np.abs(together.heights(x, y)[0] - 100.0).max() < 1e-3


def test_transformations_without_a_grid(tmp_path: Path) -> None:
    x, y = scatter()
    # EPSG's Ostend height to EVRF2000 height: -2.311 m and a slope of a few hundredths of an arc second.
    path = level(tmp_path / "a.tif", "EPSG:3812", "+5710")
    surface, _ = read(path, BELGIUM, x, y, vertical_datum="EPSG:5730")
    assert np.abs(surface.heights(x, y)[0] - (100.0 - 2.311)).max() < 2e-3
    # Baltic 1977 height to Black Sea height: 0.4 m, from feet too.
    transform, rows, cols = around(SOCHI, "EPSG:32637", 20.0)
    feet = write_raster(tmp_path / "b.tif", np.full((rows, cols), 100.0), transform, "EPSG:32637", units="ft")
    surface, _ = read(feet, SOCHI, x, y, vertical_datum="EPSG:5735", dem_vertical_datum="EPSG:5705")
    assert np.abs(surface.heights(x, y)[0] - (30.48 + 0.4)).max() < 1e-6


def test_voids_stay_voids(tmp_path: Path, made_geoid: None) -> None:
    transform, rows, cols = around(BELGIUM, "EPSG:32631", 20.0)
    cells = np.full((rows, cols), 100.0, np.float32)
    cells[30:40, 30:40] = np.nan
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32631+5773")
    surface, _ = read(path, BELGIUM, *scatter(), vertical_datum="ellipsoid")
    assert surface.dems[0].voids == 100
    assert surface.heights(*scatter())[0] == pytest.approx(142.35, abs=0.1)


@pytest.mark.parametrize(
    ("source", "target", "grid"),
    [
        ("EPSG:5773", "EPSG:3855", "us_nga_egm96_15.tif"),
        ("EPSG:3855", "ellipsoid", "us_nga_egm08_25.tif"),
        ("EPSG:5710", "ellipsoid", "be_ign_hBG18.tif"),
    ],
)
def test_a_grid_that_is_absent_is_an_error(tmp_path: Path, source: str, target: str, grid: str) -> None:
    path = level(tmp_path / "a.tif", "EPSG:31370")
    with pytest.raises(InputError) as caught:
        read(path, BELGIUM, *scatter(), vertical_datum=target, dem_vertical_datum=source)
    message = str(caught.value)
    assert message.startswith(f"{path}: heights cannot be converted from ")
    assert grid in message
    assert f"pyproj sync --file {grid}" in message
    assert message.count("\n") == 0


def test_a_grid_that_does_not_reach_is_an_error(tmp_path: Path, made_geoid: None) -> None:
    transform, rows, cols = around(SOCHI, "EPSG:32637", 20.0)
    path = write_raster(tmp_path / "a.tif", np.full((rows, cols), 100.0), transform, "EPSG:32637")
    with pytest.raises(InputError, match="heights cannot be converted from EGM96 height"):
        read(path, SOCHI, *scatter(), vertical_datum="ellipsoid", dem_vertical_datum="EPSG:5773")


def test_no_transformation_at_all(tmp_path: Path) -> None:
    path = level(tmp_path / "a.tif", "EPSG:31370")
    with pytest.raises(InputError, match="PROJ knows no transformation that is valid there"):
        read(path, BELGIUM, *scatter(), vertical_datum="EPSG:5706", dem_vertical_datum="EPSG:5705")


def test_the_network_is_left_as_it_was(tmp_path: Path) -> None:
    network: Any = pyproj.network
    network.set_network_enabled(True)
    try:
        with pytest.raises(InputError):
            read(
                level(tmp_path / "a.tif", "EPSG:31370"), BELGIUM, *scatter(),
                vertical_datum="EPSG:3855", dem_vertical_datum="EPSG:5773",
            )  # fmt: skip
        assert network.is_network_enabled()
    finally:
        network.set_network_enabled(False)


def test_a_model_without_datum(tmp_path: Path) -> None:
    path = level(tmp_path / "a.tif", "EPSG:31370")
    with pytest.raises(InputError, match=r"does not say to which datum .* --dem-vertical-datum"):
        read(path, BELGIUM, *scatter(), vertical_datum="EPSG:5730")


def test_several_datums_are_said(tmp_path: Path) -> None:
    one = level(tmp_path / "a.tif", "EPSG:31370", "+5710")
    two = level(tmp_path / "b.tif", "EPSG:32631", "+5773")
    _, diagnostics = read([one, two], BELGIUM, *scatter())
    said = [item.message for item in diagnostics if item.code == "dem-datums"]
    assert len(said) == 1
    assert said[0] == (
        f"{one}, {two}: heights refer to several datums (EGM96 height, Ostend height) and were taken as they are; "
        "--vertical-datum converts them to one."
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sea level", "is not known"),
        ("EPSG:4326", "has no heights"),
        ("EPSG:32632", "has no heights"),
        ("", "not kn"),
    ],
)
def test_what_is_no_datum(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        parse_datum(text)


def test_datums() -> None:
    assert parse_datum(" Ellipsoid ") == pyproj.CRS("EPSG:4979")
    assert parse_datum("EPSG:4326+3855") == pyproj.CRS("EPSG:3855")
    assert heights_of(pyproj.CRS("EPSG:7415")) == pyproj.CRS("EPSG:5709")
    assert heights_of(pyproj.CRS("EPSG:4937")) == pyproj.CRS("EPSG:4937")
    assert heights_of(pyproj.CRS("EPSG:32632")) is None


def test_a_source_alone_is_of_no_use() -> None:
    with pytest.raises(InputError, match="give --vertical-datum too"):
        SurfaceOptions(dem_vertical_datum="EPSG:5773")


@pytest.mark.parametrize(
    ("name", "metres"),
    [
        ("m", 1.0),
        ("Metre", 1.0),
        (" meters ", 1.0),
        ("[m]", 1.0),
        ("ft", 0.3048),
        ("Feet", 0.3048),
        ("US survey foot", 0.3048006096012192),
        ("us-ft", 0.3048006096012192),
        ("US_survey_foot", 0.3048006096012192),
        ("cm", 0.01),
        ("mm", 0.001),
        ("dm", 0.1),
        ("furlong", None),
        ("", None),
    ],
)
def test_names_of_units(name: str, metres: float | None) -> None:
    assert metres_per(name) == metres


@pytest.mark.parametrize(
    ("crs", "expected"),
    [
        ("EPSG:4326", None),
        ("EPSG:32632", None),
        ("EPSG:4979", ("metre", 1.0)),
        ("EPSG:7415", ("metre", 1.0)),
        ("EPSG:2263+6360", ("US survey foot", 0.30480060960121924)),
        ("EPSG:26910+8228", ("foot", 0.3048)),
    ],
)
def test_unit_of_a_crs(crs: str, expected: tuple[str, float] | None) -> None:
    assert vertical_unit(CRS.from_user_input(crs)) == expected


@pytest.mark.parametrize(
    ("crs", "plain"),
    [
        ("EPSG:4979", "EPSG:4326"),
        ("EPSG:7415", "EPSG:28992"),
        ("EPSG:2263+6360", "EPSG:2263"),
        ("EPSG:32632", "EPSG:32632"),
    ],
)
def test_crs_without_heights(crs: str, plain: str) -> None:
    assert horizontal_crs(CRS.from_user_input(crs)) == CRS.from_user_input(plain)
