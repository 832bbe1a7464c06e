"""Heights of roads from elevation models in files: seams, voids, and the time that large networks take."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
import rasterio
from affine import Affine
from elevation_helpers import Ground, Height, RoadSpec, Solved, make_problem, solve, straight

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import solve_profiles
from osm2xodr.model import FloatArray
from osm2xodr.projection import make_frame
from osm2xodr.surface import SurfaceOptions, read_surface

FRAME = make_frame(49.5, 11.5)
TIMES = 8


def raster(path: Path, height: Height, cell: float, box: tuple[float, float, float, float]) -> Path:
    """Write an elevation model of west, south, east, north in local coordinates."""
    west, south, east, north = box
    x, y = np.meshgrid(np.arange(west + cell / 2, east, cell), np.arange(north - cell / 2, south, -cell))
    z = np.asarray(height(x, y), np.float32)
    with rasterio.open(
        path, "w", driver="GTiff", height=z.shape[0], width=z.shape[1], count=1, dtype=z.dtype, crs=FRAME.proj,
        transform=Affine(cell, 0.0, west, 0.0, -cell, north), nodata=float("nan"),
    ) as dataset:  # fmt: skip
        dataset.write(z, 1)
    return path


def solve_on(paths: list[Path], roads: list[RoadSpec]) -> Solved:
    """Solve for roads on elevation models in files."""
    problem, diagnostics = make_problem(roads), Diagnostics()
    s = np.linspace(0.0, 1.0, 400)
    x = np.concatenate([road.x + s * road.length * np.cos(road.hdg) for road in roads])
    y = np.concatenate([road.y + s * road.length * np.sin(road.hdg) for road in roads])
    surface = read_surface(paths, FRAME, x, y, SurfaceOptions(), diagnostics)
    return Solved(problem, solve_profiles(problem, surface, diagnostics), diagnostics)


@pytest.mark.parametrize(("fine", "coarse"), [(2.0, 10.0), (10.0, 30.0)])
def test_seam_of_two_models_with_an_offset_is_a_gentle_ramp(tmp_path: Path, fine: float, coarse: float) -> None:
    paths = [
        raster(tmp_path / "fine.tif", lambda x, y: 400.0 + 0.02 * x, fine, (-1500.0, -600.0, 0.0, 600.0)),
        raster(tmp_path / "coarse.tif", lambda x, y: 403.0 + 0.02 * x, coarse, (-1500.0, -900.0, 1500.0, 900.0)),
    ]
    found = solve_on(paths, [straight((-900.0, 0.0), (900.0, 0.0))])
    s, x, _, z = found.along(0)
    own = z - 0.02 * x
    assert own[x < -200.0] == pytest.approx(400.0, abs=0.1)
    assert own[x > 200.0] == pytest.approx(403.0, abs=0.1)
    # 3 m over a ramp of 100 m, eased in and out.
    grade = found.grade(0, s) - 0.02
    assert grade.max() < 0.07
    assert grade.min() > -0.01
    assert np.abs(np.diff(grade)).max() < 2.5e-3


def test_void_is_bridged_by_what_lies_around_it(tmp_path: Path) -> None:
    def valley(x: FloatArray, y: FloatArray) -> FloatArray:
        return np.asarray(300.0 + 0.03 * y + 1e-4 * x**2)

    def with_hole(x: FloatArray, y: FloatArray) -> FloatArray:
        return np.where(np.hypot(x - 50.0, y) < 120.0, np.nan, valley(x, y))

    path = raster(tmp_path / "dem.tif", with_hole, 10.0, (-1000.0, -1000.0, 1000.0, 1000.0))
    found = solve_on([path], [straight((-600.0, 0.0), (600.0, 0.0)), straight((0.0, -400.0), (0.0, 400.0))])
    for road in range(2):
        s, x, y, z = found.along(road)
        assert z == pytest.approx(valley(x, y), abs=0.5)
        outside = np.hypot(x - 50.0, y) > 150.0
        assert z[outside] == pytest.approx(valley(x, y)[outside], abs=0.15)
        assert np.abs(np.diff(found.grade(road, s))).max() < 1e-3


def grid(size: int) -> tuple[list[RoadSpec], list[tuple[float, float]]]:
    """Return size² junctions 120 m apart and the roads between them."""
    nodes = [(120.0 * i, 120.0 * j) for i in range(size) for j in range(size)]
    roads = []
    for k, (x, y) in enumerate(nodes):
        if k // size < size - 1:
            roads.append(straight((x + 8.0, y), (x + 112.0, y), start=k, end=k + size))
        if k % size < size - 1:
            roads.append(straight((x, y + 8.0), (x, y + 112.0), start=k, end=k + 1))
    return roads, nodes


def test_time_grows_with_the_roads_and_no_faster() -> None:
    ground = Ground(lambda x, y: 20.0 * np.sin(x / 300.0) * np.cos(y / 250.0), cell_size=10.0, sigma=1.0)
    small, large = grid(13), grid(36)
    assert len(large[0]) / len(small[0]) == pytest.approx(TIMES, rel=0.02)

    def seconds(roads: list[RoadSpec], nodes: list[tuple[float, float]]) -> float:
        began = time.process_time()
        found = solve(roads, ground, nodes)
        spent = time.process_time() - began
        assert np.isfinite(found.solution.end_z).all()
        return spent

    seconds(*small)
    once = min(seconds(*small) for _ in range(2))
    assert min(seconds(*large) for _ in range(2)) <= 2.5 * TIMES * once
