from __future__ import annotations

import re

import numpy as np

from osm2xodr.viewing.colours import rgb
from osm2xodr.viewing.surface_report import (
    bars,
    block_extremes,
    block_means,
    error_map,
    error_ramp,
    image,
    land_ramp,
    relief,
    scale_bar,
)


def test_blocks() -> None:
    z = np.array([[1.0, 2.0, -9.0, 4.0, 99.0], [3.0, np.nan, 5.0, 6.0, 99.0]])
    assert block_means(z, 2).tolist() == [[2.0, 1.5]]
    assert block_extremes(z, 2).tolist() == [[3.0, -9.0]]
    assert np.isnan(block_means(np.full((2, 2), np.nan), 2)).all()
    assert np.isnan(block_extremes(np.full((2, 2), np.nan), 2)).all()


def test_colours_of_errors() -> None:
    error = np.repeat(np.repeat([[-2.0, -1.0, 0.0, 1.0, 2.0, 5.0, np.nan]], 2, 0), 2, 1)
    colours = error_map(error, error_ramp(2.0))[0].tolist()
    assert colours[:5] == [list(rgb(stop)) for stop in error_ramp(2.0).stops]
    assert colours[5] == colours[4]
    assert colours[6] not in colours[:6]
    # Cells that were not predicted are not seen between those that were.
    mesh = np.full((8, 8), 1.0)
    mesh[::2, ::2] = np.nan
    assert np.unique(error_map(mesh, error_ramp(2.0)).reshape(-1, 3), axis=0).tolist() == [
        list(rgb(error_ramp(2.0).stops[3]))
    ]


def test_relief_is_lit_from_the_north_west() -> None:
    row, col = np.mgrid[:40, :60].astype(np.float64)
    # A hill in the middle: its western and northern sides are brighter than the eastern and southern ones.
    hill = 100 - np.maximum(np.abs(col - 30), np.abs(row - 20))
    sum_of = relief(hill, (10.0, 10.0), land_ramp(0.0, 100.0)).astype(int).sum(axis=2)
    assert sum_of[20, 20] > sum_of[20, 40] + 50
    assert sum_of[10, 30] > sum_of[30, 30] + 50
    level = relief(np.full((10, 10), 50.0), (10.0, 10.0), land_ramp(0.0, 100.0))
    assert np.unique(level.reshape(-1, 3), axis=0).tolist() == [list(rgb(land_ramp(0.0, 100.0).stops[2]))]


def test_large_grids_become_small_pictures() -> None:
    z = np.zeros((1000, 2000))
    assert relief(z, (1.0, 1.0), land_ramp(-1.0, 1.0)).shape == (200, 400, 3)
    assert error_map(z, error_ramp(1.0)).shape == (200, 400, 3)
    assert 'width="460" height="230"' in image(relief(z, (1.0, 1.0), land_ramp(-1.0, 1.0)), (1.0, 1.0), "x")


def test_bars_are_as_long_as_their_values() -> None:
    text = bars(["a", "b"], [2.0, 0.5], "m")
    assert re.findall(r'<rect class="bar"[^>]* width="([\d.]+)"', text) == ["240.0", "60.0"]
    assert "2 m" in text
    assert "0.5 m" in text
    assert 'width="1.0"' in bars(["a"], [0.0], "m")


def test_scale_bar() -> None:
    text = scale_bar(land_ramp(100.0, 300.0))
    assert re.findall(r">([\d.]+)</text>", text) == ["100", "200", "300"]
    assert text.count("<stop") == len(land_ramp(100.0, 300.0).stops)
