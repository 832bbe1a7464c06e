from __future__ import annotations

import logging
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from affine import Affine
from dem_factory import BAVARIA, around, read, scatter, write_raster

from osm2xodr.errors import CoverageError, InputError, Osm2xodrError

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
    (archive, "unpack it first"),
    (badly_named_tile, "name it after its south-west corner"),
    (short_tile, "or get it whole"),
    (without_crs, "no coordinate reference system; assign the right one"),
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


def test_a_model_elsewhere(tmp_path: Path) -> None:
    path = good(tmp_path / "a.tif")
    x, y = scatter()
    words = (
        f"{path}: the elevation model covers 11.4852 to 11.5148 E, 49.4903 to 49.5097 N but the roads lie at "
        "11.6255 to 11.6503 E, 49.4918 to 49.5079 N; give one that covers the roads"
    )
    with pytest.raises(CoverageError) as caught:
        read(path, BAVARIA, x + 10000.0, y)
    numbers = re.findall(r"\d+\.\d{4}", str(caught.value))
    assert [float(n) for n in numbers] == pytest.approx(
        [float(n) for n in re.findall(r"\d+\.\d{4}", words)], abs=2e-3
    )
    assert re.sub(r"\d", "", str(caught.value).split(": ", 1)[1]) == re.sub(r"\d", "", words.split(": ", 1)[1])


def test_a_model_on_the_other_side_of_the_earth(tmp_path: Path) -> None:
    path = write_raster(
        tmp_path / "a.tif", np.ones((60, 60), np.float32), Affine(1.0, 0, -179.0, 0, -1.0, -10.0), "EPSG:4326"
    )
    with pytest.raises(CoverageError, match=r"covers -179.0000 to -119.0000 E, -70.0000 to -10.0000 N but the roads"):
        read(path, BAVARIA, *scatter())


def test_a_model_without_heights_at_the_roads(tmp_path: Path) -> None:
    path = good(tmp_path / "a.tif", value=-9999.0, nodata=-9999.0)
    with pytest.raises(CoverageError, match="all cells around the roads are nodata; give an elevation model"):
        read(path, BAVARIA, *scatter())
    with pytest.raises(CoverageError, match="all cells around the roads are nodata; give an elevation model"):
        read(path, BAVARIA, *scatter(), allow_partial=True)


def test_less_than_half(tmp_path: Path) -> None:
    path = good(tmp_path / "a.tif")
    x = np.linspace(-900.0, 9100.0, 1001)
    with pytest.raises(CoverageError, match=r"only 19 % of the roads .* --allow-partial"):
        read(path, BAVARIA, x, 0 * x)
    surface, diagnostics = read(path, BAVARIA, x, 0 * x, allow_partial=True)
    assert 0.18 < surface.coverage < 0.2
    assert [item.message for item in diagnostics] == [
        f"{path}: 81 % of the roads have no measured height; it was filled in."
    ]


def test_nothing_measured_is_too_little_even_if_partial_is_allowed(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    cells = np.full((rows, cols), np.nan, np.float32)
    cells[:10] = 5.0
    path = write_raster(tmp_path / "a.tif", cells, transform, UTM)
    x, y = scatter(half=740.0)
    with pytest.raises(CoverageError, match="no road has a measured height"):
        read(path, BAVARIA, x, y, allow_partial=True)


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
