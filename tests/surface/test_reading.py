""" """

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from affine import Affine
from dem_factory import BAVARIA, around, moved, place, read, scatter, write_raster
from hypothesis import given, strategies as st
from pyproj import Transformer

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.errors import CoverageError, InputError
from osm2xodr.model import FloatArray, Street
from osm2xodr.surface import SurfaceOptions, judge_coverage, read_surface
from osm2xodr.surface.reading import points_along

PLACES = (np.array([11.5, 11.6]), np.array([49.9, 50.0]))


def street(points: list[tuple[float, float]]) -> Street:
    return Street(0, 0, 1, np.array(points, dtype=np.float64), np.arange(len(points)), ())


def test_points_are_evenly_spaced_around_corners() -> None:
    x, y = points_along([street([(0.0, 0.0), (30.0, 0.0), (30.0, 70.0)])], step=25.0)
    assert x == pytest.approx([0.0, 25.0, 30.0, 30.0, 30.0])
    assert y == pytest.approx([0.0, 0.0, 20.0, 45.0, 70.0])


def test_streets_do_not_run_into_each_other() -> None:
    streets = [street([(0.0, 0.0), (10.0, 0.0)]), street([(1000.0, 5.0), (1000.0, 65.0)])]
    x, y = points_along(streets, step=50.0)
    assert x == pytest.approx([0.0, 10.0, 1000.0, 1000.0, 1000.0])
    assert y == pytest.approx([0.0, 0.0, 5.0, 35.0, 65.0])


coordinate = st.floats(min_value=-1000.0, max_value=1000.0)


def lengths(points: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(*np.diff(points, axis=0).T), np.float64)


@given(st.lists(st.lists(st.tuples(coordinate, coordinate), min_size=2, max_size=6), min_size=1, max_size=5))
def test_each_street_is_covered_from_end_to_end(lines: list[list[tuple[float, float]]]) -> None:
    x, y = points_along([street(line) for line in lines], step=50.0)
    first = 0
    for line in lines:
        points = np.array(line)
        count = max(int(np.ceil(lengths(points).sum() / 50.0)), 1) + 1
        found = np.column_stack([x[first : first + count], y[first : first + count]])
        assert found[0] == pytest.approx(points[0], abs=1e-6)
        assert found[-1] == pytest.approx(points[-1], abs=1e-6)
        assert lengths(found).max() <= 50.0 + 1e-6
        first += count
    assert first == len(x)


def test_summary(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.full((rows, cols), 300, np.int16)
    cells[0, :3] = -1
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632", nodata=-1, units="ft")
    away = write_raster(tmp_path / "b.tif", cells, moved(transform, 0.0, 50000.0), "EPSG:32632")
    surface, diagnostics = read([path, away], BAVARIA, *scatter(half=990.0))
    used, unused = surface.dems
    assert (used.path, used.driver, used.crs, used.dtype, used.unit, used.nodata) == (
        path, "GTiff", "EPSG:32632", "int16", "ft", -1.0,
    )  # fmt: skip
    assert used.cell_size == pytest.approx(20.0, rel=1e-3)
    assert (used.cells, used.voids, used.share) == (rows * cols, 3, 1.0)
    lon, lat = Transformer.from_crs("EPSG:32632", 4326, always_xy=True).transform(
        *place(transform, np.array([0, cols, 0, cols]) - 0.5, np.array([0, 0, rows, rows]) - 0.5)
    )
    assert used.bounds_deg == pytest.approx((lon.min(), lat.min(), lon.max(), lat.max()), abs=1e-6)
    assert (unused.cells, unused.share) == (0, 0.0)
    assert [(item.kind, item.code) for item in diagnostics] == [(Kind.NOTE, "dem-unused")]


def test_nothing_to_read() -> None:
    nowhere: FloatArray = np.zeros(0)
    with pytest.raises(InputError, match="name at least one file"):
        read_surface([], BAVARIA, np.zeros(1), np.zeros(1), SurfaceOptions(), Diagnostics())
    with pytest.raises(InputError, match="no roads"):
        read_surface([Path("a.tif")], BAVARIA, nowhere, nowhere, SurfaceOptions(), Diagnostics())


def test_same_input_same_surface(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.random.default_rng(5).normal(100, 3, (rows, cols)).astype(np.float32)
    cells[20:40, 30:50] = np.nan
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632")
    x, y = scatter()
    first, second = (read(path, BAVARIA, x, y)[0].heights(x, y)[0] for _ in range(2))
    assert first.tobytes() == second.tobytes()


UTM = "EPSG:32632"


def good(path: Path, value: float = 100.0, **profile: Any) -> Path:
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    return write_raster(path, np.full((rows, cols), value, np.float32), transform, UTM, **profile)


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


def test_nothing_measured_is_too_little_even_if_partial_is_allowed(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    cells = np.full((rows, cols), np.nan, np.float32)
    cells[:10] = 5.0
    path = write_raster(tmp_path / "a.tif", cells, transform, UTM)
    x, y = scatter(half=740.0)
    with pytest.raises(CoverageError, match="no road has a measured height"):
        read(path, BAVARIA, x, y, allow_partial=True)


def test_a_model_of_zeros_is_reported_and_others_are_not(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    for height, codes in ((0.0, ["dem-level"]), (1.0, [])):
        path = write_raster(tmp_path / "a.tif", np.full((rows, cols), height, np.float32), transform, "EPSG:32632")
        _, diagnostics = read([path], BAVARIA, *scatter(half=900.0))
        assert [item.code for item in diagnostics] == codes
        path.unlink()


def judged(coverage: float, options: SurfaceOptions) -> list[str]:
    diagnostics = Diagnostics()
    judge_coverage([Path("a.tif")], options, coverage, 1234.0, PLACES, diagnostics)
    assert [item.code for item in diagnostics] == ["dem-gap"]
    return [item.message for item in diagnostics]


def test_the_message_says_how_much_and_where() -> None:
    said = "11.5000 to 11.6000 E, 49.9000 to 50.0000 N) have no measured height; it was filled in."
    assert judged(0.97, SurfaceOptions()) == [f"a.tif: 3 % of the roads (1.2 km, {said}"]
    assert judged(0.996, SurfaceOptions()) == [f"a.tif: 0.4 % of the roads (1.2 km, {said}"]
    assert judged(0.004, SurfaceOptions(allow_partial=True)) == [f"a.tif: 99.60 % of the roads (1.2 km, {said}"]


def test_less_than_half_is_too_little() -> None:
    assert judged(0.5, SurfaceOptions())
    with pytest.raises(CoverageError, match=r"a.tif: only 49 % of the roads .* --allow-partial"):
        judged(0.49, SurfaceOptions())
    assert judged(0.19, SurfaceOptions(allow_partial=True))


def test_the_share_asked_for_is_demanded() -> None:
    assert judged(0.19, SurfaceOptions(coverage_least=0.15))
    wanted = r"only 19 % of .* and --fail-below-coverage asks for 25 %; give elevation"
    with pytest.raises(CoverageError, match=wanted):
        judged(0.19, SurfaceOptions(coverage_least=0.25))
    with pytest.raises(CoverageError, match=r"only 99.99 % of .* asks for 100 %"):
        judged(0.9999, SurfaceOptions(coverage_least=1.0))


def test_nothing_is_said_where_all_is_measured() -> None:
    diagnostics, none = Diagnostics(), (np.zeros(0), np.zeros(0))
    judge_coverage([Path("a.tif")], SurfaceOptions(coverage_least=1.0), 1.0, 0.0, none, diagnostics)
    assert list(diagnostics) == []
