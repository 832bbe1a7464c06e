from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from osm2xodr.errors import InputError
from osm2xodr.model import Surface
from osm2xodr.surface import FlatSurface, SurfaceOptions


def test_flat_surface() -> None:
    surface: Surface = FlatSurface()
    z, measured = surface.heights(np.array([1.0, 2.0]), np.array([3.0, 4.0]))
    assert (z.tolist(), measured.tolist()) == ([0.0, 0.0], [True, True])
    assert (surface.cell_size, surface.sigma) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"method": "kriging"}, "choose one of nearest, bilinear"),
        ({"polynomial_order": 6}, "choose 2 to 5"),
        ({"sigma": 0.0}, "not above 0"),
        ({"sigma": float("nan")}, "not above 0"),
    ],
)
def test_options_out_of_range(options: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        SurfaceOptions(**options)
