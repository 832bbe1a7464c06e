from __future__ import annotations

import logging
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
from affine import Affine
from dem_factory import (
    BAVARIA,
    OREGON,
    around,
    centres,
    in_crs,
    read,
    scatter,
    write_raster,
)

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.errors import InputError, Osm2xodrError

UTM = "EPSG:32632"


def good(path: Path, value: float = 100.0, **profile: Any) -> Path:
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    return write_raster(path, np.full((rows, cols), value, np.float32), transform, UTM, **profile)


def missing(folder: Path) -> Path:
    return folder / "missing.tif"


def directory(folder: Path) -> Path:
    (folder / "folder.tif").mkdir()
    return folder / "folder.tif"


def text(folder: Path) -> Path:
    path = folder / "text.tif"
    path.write_text("this is no raster\n")
    return path


def empty(folder: Path) -> Path:
    path = folder / "empty.tif"
    path.touch()
    return path


def archive(folder: Path) -> Path:
    path = folder / "dem.tif.zip"
    path.write_bytes(b"PK\x03\x04" + bytes(100))
    return path


def badly_named_tile(folder: Path) -> Path:
    path = folder / "tile.hgt"
    path.write_bytes(np.zeros((1201, 1201), ">i2").tobytes())
    return path


def short_tile(folder: Path) -> Path:
    path = folder / "N49E011.hgt"
    path.write_bytes(bytes(1000))
    return path


def without_crs(folder: Path) -> Path:
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    return write_raster(folder / "a.tif", np.ones((rows, cols), np.float32), transform, None)


def without_place(folder: Path) -> Path:
    return write_raster(folder / "a.tif", np.ones((50, 50), np.float32), None, UTM)


def of_nowhere(folder: Path) -> Path:
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    crs = 'LOCAL_CS["site",UNIT["metre",1],AXIS["x",EAST],AXIS["y",NORTH]]'
    return write_raster(folder / "a.tif", np.ones((rows, cols), np.float32), transform, crs)


def of_mars(folder: Path) -> Path:
    datum = 'DATUM["D",SPHEROID["Mars",3396190,169.89]],PRIMEM["Reference",0]'
    crs = f'GEOGCS["Mars",{datum},UNIT["degree",0.0174532925]]'
    transform, rows, cols = around(BAVARIA, "EPSG:4326", 2e-4)
    return write_raster(folder / "a.tif", np.ones((rows, cols), np.float32), transform, crs)


def colours(folder: Path) -> Path:
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    return write_raster(folder / "a.tif", np.ones((3, rows, cols), np.uint8), transform, UTM, photometric="RGB")


def four_byte_bands(folder: Path) -> Path:
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    return write_raster(
        folder / "a.tif", np.ones((4, rows, cols), np.uint8), transform, UTM, photometric="MINISBLACK"
    )


def picture(folder: Path) -> Path:
    return write_raster(folder / "a.png", np.ones((3, 40, 40), np.uint8), None, None, driver="PNG")


def complex_numbers(folder: Path) -> Path:
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    return write_raster(folder / "a.tif", np.ones((rows, cols), np.complex64), transform, UTM)


def of_no_size(folder: Path) -> Path:
    path = folder / "a.tif"
    return write_raster(path, np.ones((9, 9), np.float32), Affine(1e-300, 0, 7e5, 0, -1e-5, 5e6), UTM)


def off_the_earth(folder: Path) -> Path:
    path = folder / "a.tif"
    return write_raster(path, np.ones((9, 9), np.float32), Affine(20, 0, 1e300, 0, -20, 5e6), UTM)


def scaled_to_nothing(folder: Path) -> Path:
    return good(folder / "a.tif", scale=float("nan"))


def cut_short(folder: Path) -> Path:
    path = folder / "cut.tif"
    transform, rows, cols = around(BAVARIA, UTM, 5.0)
    noise = np.random.default_rng(1).normal(0, 1, (rows, cols)).astype(np.float32)
    write_raster(path, noise, transform, UTM, compress="deflate", tiled=True, blockxsize=128, blockysize=128)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    return path


def cut_to_the_header(folder: Path) -> Path:
    path = good(folder / "cut.tif")
    path.write_bytes(path.read_bytes()[:60])
    return path


def damaged(folder: Path) -> Path:
    path = folder / "damaged.tif"
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    noise = np.random.default_rng(1).normal(0, 1, (rows, cols)).astype(np.float32)
    write_raster(path, noise, transform, UTM, compress="deflate")
    whole = bytearray(path.read_bytes())
    whole[2000:20000] = b"\x55" * 18000
    path.write_bytes(bytes(whole))
    return path


def virtual_without_source(folder: Path) -> Path:
    path = folder / "a.vrt"
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    path.write_text(
        f'<VRTDataset rasterXSize="{cols}" rasterYSize="{rows}"><SRS>{UTM}</SRS>'
        f"<GeoTransform>{transform.c}, 20, 0, {transform.f}, 0, -20</GeoTransform>"
        '<VRTRasterBand dataType="Float32" band="1"><SimpleSource><SourceFilename relativeToVRT="1">gone.tif'
        "</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>"
    )
    return path


BAD_FILES = [
    (missing, "there is no such elevation model"),
    (directory, "an elevation model is one file"),
    (text, "not a raster that can be read"),
    (empty, "not a raster that can be read"),
    (archive, "the archive is damaged or cut short; get it whole"),
    (badly_named_tile, "name it after its south-west corner"),
    (short_tile, "or get it whole"),
    (without_crs, "no coordinate reference system; name it with --dem-crs"),
    (without_place, "does not say where it lies"),
    (of_no_size, "does not say where it lies"),
    (off_the_earth, "does not say where it lies"),
    (of_nowhere, "is not one on Earth; assign the right one"),
    (of_mars, "is not one on Earth; assign the right one"),
    (colours, "a picture in colours"),
    (four_byte_bands, "a picture in colours"),
    (picture, "a picture in colours"),
    (complex_numbers, "complex numbers"),
    (scaled_to_nothing, "are not valid for heights"),
    (cut_short, "damaged or cut short"),
    (cut_to_the_header, "not a raster that can be read"),
    (damaged, "damaged or cut short"),
    (virtual_without_source, "refers to a file that is missing or damaged"),
]


@pytest.mark.parametrize(("make", "words"), [pytest.param(*case, id=case[0].__name__) for case in BAD_FILES])
def test_bad_files_are_refused_in_one_sentence(
    tmp_path: Path, make: Any, words: str, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    path = make(tmp_path)
    caplog.clear()
    capfd.readouterr()
    with pytest.raises(InputError, match=re.escape(words)) as caught:
        read(path, BAVARIA, *scatter())
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    assert ";" in message
    # GDAL says nothing by itself, and the chain of causes holds nothing of it that could be printed.
    assert capfd.readouterr() == ("", "")
    assert caplog.records == []
    assert caught.value.__suppress_context__ or caught.value.__context__ is None


@pytest.mark.parametrize(
    "name",
    [
        "/vsicurl/https://example.org/dem.tif",
        "/vsis3/bucket/dem.tif",
        "/vsizip/dem.zip/dem.tif",
        "https://example.org/dem.tif",
        "s3://bucket/dem.tif",
    ],
)
def test_network_paths_are_refused(name: str) -> None:
    with pytest.raises(InputError, match="read from local files only; download it first"):
        read(Path(name), BAVARIA, *scatter())


def test_unreadable_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = good(tmp_path / "a.tif")

    def denied(*_: Any, **__: Any) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", denied)
    with pytest.raises(InputError, match=r"cannot be opened \(Permission denied\); check its permissions"):
        read(path, BAVARIA, *scatter())


def test_names_that_look_odd_but_are_local(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("vsidem.tif", "a b é.tif", "x;y.tif", "noending"):
        good(Path(name), 77.0)
        surface, _ = read(Path(name), BAVARIA, *scatter())
        assert surface.heights(*scatter())[0] == pytest.approx(77.0)


def test_rasterio_is_loaded_only_for_a_raster() -> None:
    code = "import osm2xodr.surface, sys; raise SystemExit('rasterio' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_logging_is_left_as_it_was(tmp_path: Path) -> None:
    logger = logging.getLogger("rasterio")
    logger.setLevel(logging.INFO)
    with pytest.raises(Osm2xodrError):
        read(text(tmp_path), BAVARIA, *scatter())
    assert logger.level == logging.INFO
    logger.setLevel(logging.NOTSET)


def kinds(diagnostics: Diagnostics) -> list[str]:
    return [item.code for item in diagnostics]


def test_pixel_is_point(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    px, _ = centres(transform, rows, cols)
    heights = 0.1 * (px - px.mean())
    area = write_raster(tmp_path / "area.tif", heights, transform, "EPSG:32632")
    point = write_raster(tmp_path / "point.tif", heights, transform, "EPSG:32632", tags={"AREA_OR_POINT": "Point"})
    with rasterio.open(area) as a, rasterio.open(point) as b:
        assert a.tags()["AREA_OR_POINT"] != b.tags()["AREA_OR_POINT"]
    # The two files state other tie points for the same cells; the heights are where they are.
    assert area.read_bytes() != point.read_bytes()
    x, y = scatter()
    z_area, z_point = (read(path, BAVARIA, x, y)[0].heights(x, y)[0] for path in (area, point))
    assert np.array_equal(z_area, z_point)
    expected = 0.1 * (in_crs(BAVARIA, "EPSG:32632", x, y)[0] - px.mean())
    assert np.abs(z_point - expected).max() < 1e-5


@pytest.mark.parametrize(
    ("units", "crs", "factor"),
    [
        ("ft", "EPSG:32632", 0.3048),
        ("US survey foot", "EPSG:32632", 1200 / 3937),
        ("m", "EPSG:32632", 1.0),
        ("cm", "EPSG:32632", 0.01),
        (None, "EPSG:25832+5783", 1.0),
        (None, "EPSG:26910+6360", 1200 / 3937),
        (None, "EPSG:26910+8228", 0.3048),
        ("m", "EPSG:26910+8228", 1.0),
    ],
)
def test_units(tmp_path: Path, units: str | None, crs: str, factor: float) -> None:
    frame = OREGON if "26910" in crs else BAVARIA
    transform, rows, cols = around(frame, crs.split("+")[0], 20.0)
    path = write_raster(tmp_path / "a.tif", np.full((rows, cols), 1234.5), transform, crs, units=units)
    surface, diagnostics = read(path, frame, *scatter())
    z, _ = surface.heights(*scatter())
    assert np.abs(z - 1234.5 * factor).max() < 1e-6
    assert kinds(diagnostics) == []


def test_units_that_are_guessed(tmp_path: Path) -> None:
    transform, rows, cols = around(OREGON, "EPSG:2269", 50.0)
    cells = np.full((rows, cols), 100.0)
    feet = write_raster(tmp_path / "feet.tif", cells, transform, "EPSG:2269")
    surface, diagnostics = read(feet, OREGON, *scatter())
    assert surface.heights(*scatter())[0] == pytest.approx(100.0)
    assert [(item.kind, item.code) for item in diagnostics] == [(Kind.GUESSED, "dem-unit")]
    cubits = write_raster(tmp_path / "cubits.tif", cells, transform, "EPSG:2269", units="cubit")
    _, diagnostics = read(cubits, OREGON, *scatter())
    assert [item.message for item in diagnostics] == [
        f"{cubits}: the unit of heights 'cubit' is not known; they were taken as metres."
    ]


@pytest.mark.parametrize("dtype", ["uint8", "int16", "uint16", "int32", "float32", "float64"])
def test_scale_offset_and_every_type_of_cells(tmp_path: Path, dtype: str) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.broadcast_to(np.arange(cols) % 200, (rows, cols)).astype(dtype)
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632", scale=0.5, offset=-100.0)
    x, y = scatter()
    surface, diagnostics = read(path, BAVARIA, x, y, method="nearest")
    col = (in_crs(BAVARIA, "EPSG:32632", x, y)[0] - transform.c) / 20.0
    assert np.array_equal(surface.heights(x, y)[0], np.floor(col) % 200 * 0.5 - 100.0)
    assert surface.dems[0].dtype == dtype
    assert kinds(diagnostics) == []


@pytest.mark.parametrize("value", [-32768, -9999])
def test_undeclared_sentinels_are_voids(tmp_path: Path, value: int) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.full((rows, cols), 321, np.int16)
    cells[:, 40:44] = value
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632")
    surface, diagnostics = read(path, BAVARIA, *scatter())
    z, measured = surface.heights(*scatter())
    assert z == pytest.approx(321.0)
    assert 0.01 < np.mean(~measured) < 0.1
    assert [(item.kind, item.code) for item in diagnostics] == [(Kind.REPAIRED, "dem-sentinel")]
    assert next(iter(diagnostics)).message == (
        f"{path}: {4 * rows} cells hold values that are not heights ({value}) and that the file does not declare as "
        "nodata; they were taken for voids."
    )


@pytest.mark.parametrize("value", [3.4028235e38, -3.4028235e38, 1e20, 12345.0, np.inf, np.nan])
def test_impossible_heights_are_voids(tmp_path: Path, value: float) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.full((rows, cols), 321, np.float32)
    cells[40:44] = value
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632", nodata=-32768)
    surface, diagnostics = read(path, BAVARIA, *scatter())
    z, measured = surface.heights(*scatter())
    assert z == pytest.approx(321.0)
    assert 0.01 < np.mean(~measured) < 0.1
    assert ("dem-sentinel" in kinds(diagnostics)) == np.isfinite(value)


def test_real_heights_are_no_sentinels(tmp_path: Path) -> None:
    # 9999 ft are a pass in Colorado, -410 m the shore of the Dead Sea, -9999 mm the ground of a polder.
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    for value, profile, expected in (
        (9999, {"units": "ft"}, 9999 * 0.3048),
        (-410, {}, -410.0),
        (-9999, {"scale": 0.001}, -9.999),
    ):
        path = write_raster(
            tmp_path / "a.tif", np.full((rows, cols), value, np.int32), transform, "EPSG:32632", **profile
        )
        surface, diagnostics = read(path, BAVARIA, *scatter())
        assert surface.heights(*scatter())[0] == pytest.approx(expected)
        assert kinds(diagnostics) == []


def test_mask_band_and_alpha(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.full((2, rows, cols), 100, np.uint16)
    cells[1] = 65535
    cells[1, :, :30] = 0
    path = tmp_path / "alpha.tif"
    write_raster(path, cells, transform, "EPSG:32632", photometric="MINISBLACK", alpha="YES")
    x, y = scatter()
    surface, diagnostics = read(path, BAVARIA, x, y)
    col = (in_crs(BAVARIA, "EPSG:32632", x, y)[0] - transform.c) / 20.0
    assert np.array_equal(surface.heights(x, y)[1], col >= 30.5)
    assert kinds(diagnostics) == []


def test_first_of_several_bands(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.stack([np.full((rows, cols), 11.0), np.full((rows, cols), 99.0)]).astype(np.float32)
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632")
    surface, diagnostics = read(path, BAVARIA, *scatter())
    assert surface.heights(*scatter())[0] == pytest.approx(11.0)
    assert kinds(diagnostics) == ["dem-bands"]


def test_hgt_and_virtual_raster(tmp_path: Path) -> None:
    row, col = np.mgrid[0:1201, 0:1201]
    cells = (200 + col // 4 + row // 8).astype(np.int16)
    cells[600, 600] = -32768
    hgt = tmp_path / "N49E011.hgt"
    hgt.write_bytes(cells.astype(">i2").tobytes())
    x, y = scatter(half=5000.0)
    lon, lat = in_crs(BAVARIA, 4326, x, y)
    # Tiles hold the heights at the whole three arc seconds from corner to corner.
    at_row, at_col = np.floor((50 - lat) * 1200 + 0.5), np.floor((lon - 11) * 1200 + 0.5)
    expected = 200 + at_col // 4 + at_row // 8
    hole = (at_row == 600) & (at_col == 600)
    surface, _ = read(hgt, BAVARIA, x, y, method="nearest")
    z, measured = surface.heights(x, y)
    assert surface.dems[0].driver == "SRTMHGT"
    assert np.array_equal(measured, ~hole)
    assert np.array_equal(z[measured], expected[measured])
    vrt = tmp_path / "all.vrt"
    vrt.write_text(
        '<VRTDataset rasterXSize="1201" rasterYSize="1201"><SRS>EPSG:4326</SRS>'
        f"<GeoTransform>{11 - 1 / 2400!r}, {1 / 1200!r}, 0, {50 + 1 / 2400!r}, 0, {-1 / 1200!r}</GeoTransform>"
        '<VRTRasterBand dataType="Int16" band="1"><NoDataValue>-32768</NoDataValue><SimpleSource>'
        '<SourceFilename relativeToVRT="1">N49E011.hgt</SourceFilename><SourceBand>1</SourceBand>'
        "</SimpleSource></VRTRasterBand></VRTDataset>"
    )
    virtual, _ = read(vrt, BAVARIA, x, y, method="nearest")
    assert virtual.dems[0].driver == "VRT"
    assert np.array_equal(virtual.heights(x, y)[0], z)
