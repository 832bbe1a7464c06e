"""Files that are made to do harm: each is refused in one sentence, or read, in bounded time and memory."""

from __future__ import annotations

import bz2
import gzip
import http.server
import resource
import threading
import time
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

import bombs
import numpy as np
import pytest
import rasterio
from rasterio import Affine
from rasterio.windows import Window
from refusals import refusal, run
from small_area import write_area, write_dem

from osm2xodr.cli import main


@pytest.fixture
def area(tmp_path: Path) -> Path:
    return write_area(tmp_path)


@pytest.fixture
def out(tmp_path: Path) -> Path:
    (tmp_path / "out").mkdir()
    return tmp_path / "out" / "map.xodr"


# ---------------------------------------------------------------- OSM


@pytest.mark.parametrize("pack", [gzip.open, bz2.open, None])
@pytest.mark.parametrize(
    ("make", "words"),
    [
        (bombs.spaces, "1 MB of text without any markup"),
        (bombs.zeros, "1 MB of text without any markup"),
        (bombs.one_value, "1 MB of text without any markup"),
        (bombs.one_way, "an element of over 16 MB"),
        (bombs.prolog, "is no OSM data or incomplete"),
    ],
)
def test_little_that_becomes_much(
    make: Callable[[int], Iterator[bytes]],
    words: str,
    pack: Callable[..., BinaryIO] | None,
    tmp_path: Path,
    out: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    path = tmp_path / "bomb.osm.gz"
    with pack(path, "wb", 1) if pack else path.open("wb") as stream:
        for chunk in make(20):
            stream.write(chunk)
    began = time.monotonic()
    assert main(["convert", str(path), "-o", str(out)]) == 1
    assert time.monotonic() - began < 20.0
    assert words in refusal(1, capsys.readouterr().err)


@pytest.mark.parametrize(("what", "content"), list(bombs.pbf_files().items()))
def test_sizes_that_are_lies(
    what: str, content: bytes, tmp_path: Path, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "lie.osm.pbf"
    path.write_bytes(content)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert main(["convert", str(path), "-o", str(out)]) == 1
    assert "cannot be read as OSM data" in refusal(1, capsys.readouterr().err)
    # pbf allows blobs of 32 MB.
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 150_000


@pytest.mark.parametrize("what", ["nodes", "tags", "ways"])
def test_few_bytes_of_pbf_that_become_gigabytes(what: str, tmp_path: Path, out: Path) -> None:
    path = tmp_path / "claims.osm.pbf"
    path.write_bytes(bombs.pbf_that_claims_much(what))
    assert path.stat().st_size < 100_000
    status, error, megabytes = run("convert", path, "-o", out, "-q")
    assert "far more elements and text than map data of its size" in refusal(status, error)
    assert megabytes < 400.0


# ---------------------------------------------------------------- elevation models


def test_a_raster_of_billions_of_cells_is_read_where_it_is_needed(area: Path, tmp_path: Path, out: Path) -> None:
    dem = tmp_path / "large.tif"
    cell = 1e-5
    with rasterio.open(
        dem, "w", driver="GTiff", width=200_000, height=200_000, count=1, dtype="float32", crs="EPSG:4326",
        transform=Affine(cell, 0.0, 1.572 - 1.0, 0.0, -cell, 42.55 + 1.0), SPARSE_OK=True, BIGTIFF="YES", tiled=True,
    ) as dataset:  # fmt: skip
        dataset.write(np.full((1, 1024, 1024), 1200.0, "float32"), window=Window(99_488, 99_488, 1024, 1024))
    status, error, megabytes = run("convert", area, "--dem", dem, "-o", out, "-q")
    assert (status, error) == (0, "")
    assert megabytes < 600.0
    assert b'<elevation s="0" a="1200"' in out.read_bytes()


@pytest.mark.parametrize("virtual", [False, True])
def test_blocks_that_cannot_be_unpacked(
    virtual: bool, area: Path, tmp_path: Path, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file of half a kB whose cells are one block of 14 GB."""
    size, cell = 60_000, 1e-5
    transform = Affine(cell, 0.0, 1.272, 0.0, -cell, 42.85)
    path = bombs.sparse_raster(tmp_path / "block.tif", size, transform, blockysize=size, compress="deflate")
    assert path.stat().st_size < 1000
    if virtual:
        path = tmp_path / "block.vrt"
        path.write_text(
            f'<VRTDataset rasterXSize="{size}" rasterYSize="{size}"><SRS>EPSG:4326</SRS>'
            f"<GeoTransform>1.272, {cell}, 0, 42.85, 0, -{cell}</GeoTransform>"
            '<VRTRasterBand dataType="Float32" band="1"><SimpleSource><SourceFilename relativeToVRT="1">block.tif'
            "</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>"
        )
    assert main(["convert", str(area), "--dem", str(path), "-o", str(out)]) == 1
    assert "block.tif: the raster's cells are packed in blocks of 14,400 MB" in capsys.readouterr().err


def test_cells_of_less_than_a_millimetre(
    area: Path, tmp_path: Path, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    transform = Affine(5e-9, 0.0, 1.57, 0.0, -5e-9, 42.5515)
    path = bombs.sparse_raster(
        tmp_path / "fine.tif", 300_000, transform, tiled=True, blockxsize=8192, blockysize=8192
    )
    assert main(["convert", str(area), "--dem", str(path), "-o", str(out)]) == 1
    assert "more than can be read; resample it with gdalwarp -tr" in refusal(1, capsys.readouterr().err)


@pytest.mark.parametrize(
    "transform",
    [
        Affine(float("nan"), 0.0, 1.0, 0.0, float("nan"), 1.0),
        Affine(float("inf"), 0.0, 1.0, 0.0, float("-inf"), 1.0),
        Affine(1e-300, 0.0, 1.565, 0.0, -1e-300, 42.5),
        Affine(1e300, 0.0, 1.565, 0.0, -1e300, 42.5),
        Affine(1.0, 1.0, 1.565, 1.0, 1.0, 42.5),
        Affine(90.0, 0.0, -1000.0, 0.0, -90.0, 1000.0),
    ],
)
def test_places_that_are_nowhere(
    transform: Affine, area: Path, tmp_path: Path, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "dem.tif"
    with rasterio.open(
        path, "w", driver="GTiff", width=60, height=40, count=1, dtype="float32", crs="EPSG:4326", transform=transform
    ) as dataset:
        dataset.write(np.full((1, 40, 60), 1000.0, "float32"))
    assert main(["convert", str(area), "--dem", str(path), "-o", str(out)]) == 1
    assert "does not say where it lies" in refusal(1, capsys.readouterr().err)


# ---------------------------------------------------------------- nothing is fetched


@pytest.fixture
def server() -> Iterator[tuple[str, list[str]]]:
    """Address of a server of this machine, and what it was asked for."""
    asked: list[str] = []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked.append(self.path)
            self.send_error(404)

        do_HEAD = do_GET  # noqa: N815

        def log_message(self, *_: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as listening:
        thread = threading.Thread(target=listening.serve_forever, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{listening.server_address[1]}", asked
        listening.shutdown()
        thread.join()


def test_neither_files_beside_a_raster_nor_the_environment_reach_the_network(
    server: tuple[str, list[str]], area: Path, tmp_path: Path, out: Path
) -> None:
    address, asked = server
    dem = write_dem(tmp_path)
    expected = out.with_name("expected.xodr")
    assert run("convert", area, "--dem", dem, "-o", expected, "-q", "--name", "map")[:2] == (0, "")
    elsewhere = f"/vsicurl/{address}/dem.tif"
    environment = {
        "GDAL_CONFIG_FILE": str(area),
        "GDAL_DATA": address,
        "GDAL_DRIVER_PATH": str(tmp_path),
        "PROJ_DATA": str(tmp_path),
        "PROJ_LIB": str(tmp_path),
        "PROJ_NETWORK": "ON",
        "PROJ_NETWORK_ENDPOINT": address,
        "CPL_VSIL_CURL_ALLOWED_EXTENSIONS": "tif",
        "GDAL_VRT_ENABLE_PYTHON": "YES",
        "GDAL_DISABLE_READDIR_ON_OPEN": "EMPTY_DIR",
        "GDAL_GEOREF_SOURCES": "PAM,INTERNAL",
        "GDAL_SKIP": "GTiff",
        "GTIFF_POINT_GEO_IGNORE": "YES",
        "OSM_CONFIG_FILE": elsewhere,
        "PYTHONHASHSEED": "7",
    }
    assert run("convert", area, "--dem", dem, "-o", out, "-q", "--name", "map", **environment)[:2] == (0, "")
    assert out.read_bytes() == expected.read_bytes()
    # A datum whose grid PROJ would have to fetch.
    grid = ["--vertical-datum", "ellipsoid", "--dem-vertical-datum", "EPSG:3855"]
    run("convert", area, "--dem", dem, "-o", tmp_path / "grid.xodr", "-q", *grid, **environment)
    overviews = f'<Metadata domain="OVERVIEWS"><MDI key="OVERVIEW_FILE">{address}/dem.tif</MDI></Metadata>'
    source = f"<SimpleSource><SourceFilename>{address}/dem.tif</SourceFilename></SimpleSource>"
    band = f'<VRTRasterBand dataType="Byte" band="1">{source}</VRTRasterBand>'
    virtual = f'<VRTDataset rasterXSize="9" rasterYSize="9">{band}</VRTDataset>'
    for beside, text in ((".aux.xml", f"<PAMDataset>{overviews}</PAMDataset>"), (".msk", virtual), (".ovr", virtual)):
        path = Path(f"{dem}{beside}")
        path.write_text(text)
        refused = run("convert", area, "--dem", dem, "-o", out, "-q", "--overwrite", **environment)
        assert str(dem) in refusal(*refused[:2])
        path.unlink()
    with zipfile.ZipFile(tmp_path / "dem.zip", "w") as archive:
        archive.writestr("dem.tif", virtual)
    refused = run("convert", area, "--dem", tmp_path / "dem.zip", "-o", out, "-q", "--overwrite")
    assert "is not a raster" in refusal(*refused[:2])
    assert asked == []
    assert out.read_bytes() == expected.read_bytes()


# ---------------------------------------------------------------- OpenDRIVE

LAUGHS = "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefgh", "bcdefghi", strict=True))
XODR = '<OpenDRIVE><header revMajor="1" revMinor="7" name="{}"/></OpenDRIVE>'


@pytest.mark.parametrize(
    "text",
    [
        f'<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa">{LAUGHS}]>' + XODR.format("&i;"),
        '<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>' + XODR.format("&a;"),
        '<!DOCTYPE x SYSTEM "ADDRESS/x.dtd">' + XODR.format(""),
        '<!DOCTYPE x [<!ENTITY % a SYSTEM "ADDRESS/y.dtd"> %a;]>' + XODR.format(""),
    ],
)
@pytest.mark.parametrize(
    "command",
    [
        ["check"],
        ["report", "-o", "OUT.html"],
        ["locate", "--x", "0", "--y", "0"],
        ["export", "-o", "OUT.geojson"],
        ["render", "-o", "OUT.svg"],
    ],
)
def test_entities_in_road_networks(
    text: str, command: list[str], server: tuple[str, list[str]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    address, asked = server
    path = tmp_path / "map.xodr"
    path.write_text(text.replace("ADDRESS", address))
    words = [word.replace("OUT", str(tmp_path / "out")) for word in command]
    began = time.monotonic()
    status = main([words[0], str(path), *words[1:]])
    printed = capsys.readouterr()
    assert status == 1
    assert time.monotonic() - began < 20.0
    assert "root:" not in printed.out + printed.err
    assert "internal error" not in printed.err
    assert sorted(item.name for item in tmp_path.iterdir()) == ["map.xodr"]
    assert asked == []
