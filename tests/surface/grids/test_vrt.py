from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest
from dem_factory import BAVARIA, around, read, scatter, write_raster

from osm2xodr.errors import InputError
from osm2xodr.surface.grids.vrt import is_virtual, virtual_sources

TRANSFORM, ROWS, COLS = around(BAVARIA, "EPSG:32632", 20.0)


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
