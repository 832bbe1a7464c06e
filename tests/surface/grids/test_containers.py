"""Elevation models in zip archives and in text files."""

from __future__ import annotations

import os
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
import rasterio
from dem_factory import BAVARIA, around, read, scatter, write_raster
from pyproj import CRS

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.projection import make_frame
from osm2xodr.surface import SurfaceOptions, expand, read_surface
from osm2xodr.surface.grids import rasters_in
from osm2xodr.surface.grids.containers import is_virtual, virtual_sources

FRAME = make_frame(49.95, 11.58)
X = np.linspace(-300.0, 300.0, 21)

TRANSFORM, ROWS, COLS = around(BAVARIA, "EPSG:32632", 20.0)


def heights(path: Path, **options: str) -> list[float]:
    surface = read_surface((path,), FRAME, X, X, SurfaceOptions(**options), Diagnostics())  # type: ignore[arg-type]
    return [float(z) for z in surface.heights(X, X)[0]]


def slope(folder: Path, name: str = "tile.tif", **profile: object) -> Path:
    transform, rows, cols = around(FRAME, CRS.from_epsg(25832), 10.0)
    cells = np.add.outer(np.arange(rows), 2.0 * np.arange(cols)).astype(np.float32) / 10.0
    return write_raster(folder / name, cells, transform, CRS.from_epsg(25832), **profile)


def packed(archive: Path, **members: Path) -> Path:
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as stream:
        for name, path in members.items():
            stream.write(path, f"a folder/{name}{path.suffix}")
    return archive


@pytest.mark.parametrize("name", ["dem.zip", "a b {c}.ZIP"])
def test_archives_stand_for_their_rasters(name: str, tmp_path: Path) -> None:
    tile = slope(tmp_path)
    readme = tmp_path / "readme.txt"
    readme.write_text("heights", encoding="utf-8")
    archive = packed(tmp_path / name, tile=tile, readme=readme)
    assert rasters_in(archive) == [archive / "a folder/tile.tif"]
    assert heights(archive) == heights(tile)
    # One raster of an archive can be named.
    assert heights(archive / "a folder/tile.tif") == heights(tile)


def test_files_that_are_no_archives_stay(tmp_path: Path) -> None:
    tile = slope(tmp_path)
    assert rasters_in(tile) == [tile]
    assert rasters_in(tmp_path / "none.zip") == [tmp_path / "none.zip"]


def test_bad_archives_are_refused(tmp_path: Path) -> None:
    readme = tmp_path / "readme.txt"
    readme.write_text("heights", encoding="utf-8")
    damaged = tmp_path / "damaged.zip"
    damaged.write_bytes(b"PK\3\4 and no more")
    with pytest.raises(InputError, match=r"damaged\.zip: the archive is damaged or cut short; get it whole"):
        heights(damaged)
    with pytest.raises(InputError, match=r"empty\.zip: there is no elevation model in the archive \(\.tif, "):
        heights(packed(tmp_path / "empty.zip", readme=readme))
    wrong = tmp_path / "wrong.tif"
    wrong.write_text("no raster", encoding="utf-8")
    with pytest.raises(InputError, match=r"wrong\.tif: the file is not a raster that can be read"):
        heights(packed(tmp_path / "wrong.zip", wrong=wrong))
    with pytest.raises(InputError, match=r"none\.tif: the file is not a raster that can be read"):
        heights(packed(tmp_path / "good.zip", tile=slope(tmp_path)) / "none.tif")


def test_virtual_rasters_in_archives_are_not_read(tmp_path: Path) -> None:
    """What they refer to could be anywhere."""
    virtual = tmp_path / "tile.vrt"
    virtual.write_text("<VRTDataset rasterXSize='1' rasterYSize='1'/>", encoding="utf-8")
    with pytest.raises(InputError, match="there is no elevation model in the archive"):
        heights(packed(tmp_path / "virtual.zip", tile=virtual))


def test_text_and_imagine_files_are_read(tmp_path: Path) -> None:
    tile = slope(tmp_path)
    image = slope(tmp_path, "tile.img", driver="HFA")
    assert heights(image) == pytest.approx(heights(tile))
    text = tmp_path / "text" / "tile.asc"
    text.parent.mkdir()
    with rasterio.open(tile) as dataset:
        cells, corner = dataset.read(1), dataset.transform
    rows = [" ".join(f"{value:.2f}" for value in row) for row in cells]
    south = corner.f + corner.e * len(cells)
    head = [f"ncols {cells.shape[1]}", f"nrows {cells.shape[0]}", f"xllcorner {corner.c}", f"yllcorner {south}"]
    text.write_text("\n".join([*head, f"cellsize {corner.a}", *rows]) + "\n", encoding="ascii")
    with pytest.raises(InputError, match=r"no coordinate reference system; name it with --dem-crs"):
        heights(text)
    assert heights(text, dem_crs="EPSG:25832") == pytest.approx(heights(tile), abs=0.01)
    feet = heights(text, dem_crs="EPSG:25832", dem_unit="us-ft")
    assert feet == pytest.approx([1200.0 / 3937.0 * z for z in heights(tile)], abs=0.01)
    # What the file says counts.
    assert heights(tile, dem_crs="EPSG:4326") == heights(tile)


def test_folders_and_patterns_are_files(tmp_path: Path) -> None:
    for name in ("b.tif", "a.ASC", "c.zip", "notes.txt", "d.img", "e.vrt"):
        (tmp_path / name).touch()
    assert [path.name for path in expand([tmp_path])] == ["a.ASC", "b.tif", "c.zip", "d.img", "e.vrt"]
    assert [path.name for path in expand([tmp_path / "*.tif", tmp_path])][:2] == ["b.tif", "a.ASC"]
    with pytest.raises(InputError, match=r"no file is called like .*\.hgt; check the pattern"):
        expand([f"{tmp_path}/*.hgt"])


@pytest.mark.parametrize("beside", ["tile.prj", "tile.TFW", "tile.tif.msk", "tile.tif.aux.xml", "tile.aux"])
def test_pipes_beside_a_raster_are_not_waited_for(beside: str, tmp_path: Path) -> None:
    tile = slope(tmp_path)
    os.mkfifo(tmp_path / beside)
    with pytest.raises(InputError, match=rf"{beside}, which is read with it, is no regular file; remove it"):
        heights(tile)


def test_masks_beside_a_raster_hold(tmp_path: Path) -> None:
    tile = slope(tmp_path)
    with rasterio.Env(GDAL_TIFF_INTERNAL_MASK="NO"), rasterio.open(tile, "r+") as dataset:
        mask = np.ones(dataset.shape, bool)
        mask[:, : dataset.width // 2] = False
        dataset.write_mask(mask)
    surface = read_surface((tile,), FRAME, X, X, SurfaceOptions(), Diagnostics())
    assert surface.dems[0].voids > 0
    with zipfile.ZipFile(tmp_path / "dem.zip", "w") as archive:
        for path in (tile, tmp_path / "tile.tif.msk"):
            archive.write(path, path.name)
    packed = read_surface((tmp_path / "dem.zip",), FRAME, X, X, SurfaceOptions(), Diagnostics())
    assert packed.dems[0].voids == surface.dems[0].voids


def test_grids_of_text_are_whole_before_gdal_reads_them(tmp_path: Path) -> None:
    # GDAL never ends where what is packed breaks off in the middle of a grid of text.
    grid = tmp_path / "grid.asc"
    head = "ncols 40\nnrows 40\nxllcorner 11.5\nyllcorner 49.5\ncellsize 0.001\n"
    grid.write_text(head + "\n".join(" ".join(str((i * j) % 97) for i in range(40)) for j in range(40)), "ascii")
    archive = packed(tmp_path / "grid.zip", grid=grid)
    assert [path.name for path in rasters_in(archive)] == ["grid.asc"]
    data = bytearray(archive.read_bytes())
    data[400:408] = bytes(8)
    archive.write_bytes(data)
    for path in (archive, archive / "a folder/grid.asc"):
        with pytest.raises(InputError, match=r"grid\.zip: the archive is damaged or cut short; get it whole"):
            rasters_in(path)


def virtual(path: Path, source: str, *, relative: int = 1, tag: str = "SourceFilename", more: str = "") -> Path:
    path.write_text(
        f'<VRTDataset rasterXSize="{COLS}" rasterYSize="{ROWS}"><SRS>EPSG:32632</SRS>'
        f"<GeoTransform>{TRANSFORM.c!r}, 20, 0, {TRANSFORM.f!r}, 0, -20</GeoTransform>"
        f'<VRTRasterBand dataType="Float32" band="1"><SimpleSource><{tag} relativeToVRT="{relative}">{source}</{tag}>'
        f"<SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>{more}</VRTDataset>"
    )
    return path


def source(folder: Path, value: float = 42.0) -> Path:
    return write_raster(folder / "dem.tif", np.full((ROWS, COLS), value, np.float32), TRANSFORM, "EPSG:32632")


@pytest.mark.parametrize("name", ["a.vrt", "a.tif"])
def test_local_sources_are_read(tmp_path: Path, name: str) -> None:
    source(tmp_path)
    (tmp_path / "deeper").mkdir()
    write_raster(tmp_path / "deeper" / "dem.tif", np.full((ROWS, COLS), 43.0, np.float32), TRANSFORM, "EPSG:32632")
    for path, expected in (
        (virtual(tmp_path / f"relative-{name}", "dem.tif"), 42.0),
        (virtual(tmp_path / f"absolute-{name}", str(tmp_path / "deeper" / "dem.tif"), relative=0), 43.0),
        (virtual(tmp_path / f"nested-{name}", f"relative-{name}"), 42.0),
        (virtual(tmp_path / f"below-{name}", "deeper/../dem.tif"), 42.0),
    ):
        assert is_virtual(path)
        surface, _ = read(path, BAVARIA, *scatter())
        assert surface.dems[0].driver == "VRT"
        assert surface.heights(*scatter())[0] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("name", "tag"),
    [
        ("/vsicurl/https://example.org/dem.tif", "SourceFilename"),
        ("/vsizip/dem.zip/dem.tif", "sourcefilename"),
        ("https://example.org/dem.tif", "SourceDataset"),
        ("NETCDF:/vsicurl/https://example.org/dem.nc:z", "SourceFilename"),
        ("WMS:https://example.org/?layers=dem", "SourceFilename"),
        ("NETCDF:dem.nc:z", "SourceFilename"),
        ("&lt;GDAL_WMS&gt;&lt;/GDAL_WMS&gt;", "SourceFilename"),
        ("/vsis3/bucket/dem.tif", "Anything"),
    ],
)
def test_what_is_not_a_local_file_is_refused(tmp_path: Path, name: str, tag: str) -> None:
    path = virtual(tmp_path / "a.vrt", name, tag=tag, relative=0)
    with pytest.raises(InputError, match="only local rasters are read; download it first"):
        read(path, BAVARIA, *scatter())


def test_references_in_nested_files_and_attributes_are_refused(tmp_path: Path) -> None:
    source(tmp_path)
    inner = virtual(tmp_path / "inner.vrt", "/vsicurl/https://example.org/dem.tif", relative=0)
    with pytest.raises(InputError, match=re.escape(f"{inner}: the virtual raster refers to '/vsicurl/")):
        read(virtual(tmp_path / "outer.vrt", "inner.vrt"), BAVARIA, *scatter())
    attribute = virtual(
        tmp_path / "a.vrt", "dem.tif", more='<OverviewList source="/vsicurl/http://example.org/x.ovr"/>'
    )
    with pytest.raises(InputError, match="only local rasters"):
        read(attribute, BAVARIA, *scatter())


def test_a_source_that_describes_a_service_is_refused(tmp_path: Path) -> None:
    (tmp_path / "service.xml").write_text("<GDAL_WMS><Service name='WMS'/></GDAL_WMS>")
    with pytest.raises(InputError, match=r"service.xml', but only local rasters"):
        read(virtual(tmp_path / "a.vrt", "service.xml"), BAVARIA, *scatter())
    with pytest.raises(InputError, match="not a raster that can be read"):
        read(tmp_path / "service.xml", BAVARIA, *scatter())


def test_entities_and_broken_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.vrt"
    path.write_text('<!DOCTYPE x [<!ENTITY a "dem.tif">]><VRTDataset>&a;</VRTDataset>')
    with pytest.raises(InputError, match="document type or entities, which are not read; remove them"):
        read(path, BAVARIA, *scatter())
    path.write_text("<VRTDataset><SRS></VRTDataset>")
    with pytest.raises(InputError, match=r"not well-formed XML .*; make it anew with gdalbuildvrt"):
        read(path, BAVARIA, *scatter())


def test_files_that_refer_to_themselves_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="more than 8 deep"):
        read(virtual(tmp_path / "a.vrt", "a.vrt"), BAVARIA, *scatter())


def test_what_gdal_would_read_in_another_way_is_refused(tmp_path: Path) -> None:
    """It takes attributes for elements, and reads on in what other parsers pass over."""
    source(tmp_path)
    text = virtual(tmp_path / "a.vrt", "dem.tif").read_text()
    other = "<SimpleSource><SourceFilename>/dev/zero</SourceFilename></SimpleSource>"
    for name, changed in {
        "attribute": text.replace("<SimpleSource>", '<SimpleSource SourceFilename="/dev/zero">'),
        "namespace": text.replace("<SourceFilename", '<SourceFilename xmlns="x"').replace("dem.tif", "/dev/zero"),
        "crs": text.replace("<SRS>EPSG:32632", "<SRS>/dev/zero"),
        "option": text.replace(
            "<SourceBand>", '<OpenOptions><OOI key="ROOT_PATH">/dev</OOI></OpenOptions><SourceBand>'
        ),
    }.items():
        path = tmp_path / f"{name}.vrt"
        path.write_text(changed)
        with pytest.raises(InputError, match="only local rasters are read"):
            read(path, BAVARIA, *scatter())
    for name, passed in {"comment": f"<!--> {other} -->", "instruction": f"<?x ?><?y {other}?>"}.items():
        path = tmp_path / f"{name}.vrt"
        path.write_text(text.replace("</SimpleSource>", f"</SimpleSource>{passed}"))
        assert read(path, BAVARIA, *scatter())[0].heights(*scatter())[0] == pytest.approx(42.0)
    deep = tmp_path / "deep.vrt"
    deep.write_text(text.replace("<SRS>", "<a>" * 100 + "</a>" * 100 + "<SRS>"))
    with pytest.raises(InputError, match="too deep within each other"):
        read(deep, BAVARIA, *scatter())


def test_sources_are_regular_files_and_their_number_is_bounded(tmp_path: Path) -> None:
    source(tmp_path)
    os.mkfifo(tmp_path / "pipe.tif")
    for name in ("pipe.tif", "."):
        with pytest.raises(InputError, match="only local rasters are read"):
            read(virtual(tmp_path / "a.vrt", name), BAVARIA, *scatter())
    inner = virtual(tmp_path / "6.vrt", "dem.tif")
    for level in range(5, 0, -1):
        outer = virtual(tmp_path / f"{level}.vrt", inner.name)
        text = outer.read_text()
        begin, end = text.index("<SimpleSource>"), text.index("</VRTRasterBand>")
        outer.write_text(text[:begin] + 10 * text[begin:end] + text[end:])
        inner = outer
    assert virtual_sources(tmp_path / "3.vrt") == [tmp_path / name for name in ("dem.tif", "6.vrt", "5.vrt", "4.vrt")]
    with pytest.raises(InputError, match="refers to rasters more than 100,000 times"):
        virtual_sources(tmp_path / "1.vrt")
