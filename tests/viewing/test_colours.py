"""Ramps and round numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from osm2xodr.viewing import colours
from osm2xodr.viewing.colours import Ramp, nice_step, rgb, round_range


def lightness(stops: tuple[str, ...]) -> list[float]:
    """Return CIE lightness of colours (sRGB, D65)."""
    out = []
    for stop in stops:
        linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in np.array(rgb(stop)) / 255.0]
        y = float(np.dot(linear, (0.2126, 0.7152, 0.0722)))
        out.append(116.0 * y ** (1 / 3) - 16.0 if y > 0.008856 else 903.3 * y)
    return out


def test_ramps_mix_between_their_stops() -> None:
    ramp = Ramp(("#000000", "#ff0000", "#ffff00"), 0.0, 10.0, "m")
    found = ramp.colours(np.array([-5.0, 0.0, 2.5, 5.0, 7.5, 99.0])).tolist()
    assert found == [[0, 0, 0], [0, 0, 0], [128, 0, 0], [255, 0, 0], [255, 128, 0], [255, 255, 0]]
    assert ramp.colours(np.array([math.nan])).tolist() == [list(rgb(colours.UNKNOWN_COLOUR))]


@pytest.mark.parametrize("stops", [colours.CIVIDIS, colours.VIRIDIS])
def test_ramps_keep_their_order_in_grey(stops: tuple[str, ...]) -> None:
    assert np.diff(lightness(stops)).min() > 1.0


def test_steepness_darkens_and_errors_darken_to_both_sides() -> None:
    steep = lightness(colours.STEEPNESS)
    assert np.diff(steep[2:]).max() < -5.0
    error = lightness(colours.ERROR)
    assert np.diff(error[:4]).min() > 5.0
    assert np.diff(error[3:]).max() < -5.0


def test_ranges_are_round() -> None:
    assert round_range(3.2, 178.0, 10.0) == (0.0, 180.0)
    assert round_range(850.0, 2419.0, 10.0) == (800.0, 2600.0)
    assert round_range(5.0, 5.0, 10.0) == (0.0, 10.0)
    assert round_range(math.nan, math.nan, 4.0) == (0.0, 4.0)
    assert [nice_step(width) for width in (0.9, 1.0, 4.9, 5.0, 37.0)] == [0.5, 1.0, 2.0, 5.0, 20.0]
