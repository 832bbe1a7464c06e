from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import rasterio

from osm2xodr.viewing.picture.png import as_png


def test_png_is_read_back_as_it_was(tmp_path: Path) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (17, 23, 3), np.uint8)
    path = tmp_path / "a.png"
    path.write_bytes(as_png(pixels))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)
        with rasterio.open(path) as dataset:
            assert np.array_equal(dataset.read(), pixels.transpose(2, 0, 1))
    assert as_png(pixels) == as_png(pixels)
