"""The local frame is that of PROJ, and what depends on PROJ's settings not on those of the program around it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pyproj import Transformer, network

from osm2xodr.projection import WGS84, frame_of_proj, make_frame, offline, to_geographic, to_local


def test_proj_stays_off_the_network_and_gets_its_setting_back() -> None:
    # Not all versions of pyproj have types for these two.
    switch: Any = network
    for before in (True, False):
        switch.set_network_enabled(before)
        with offline():
            assert not switch.is_network_enabled()
        assert switch.is_network_enabled() is before


@pytest.mark.parametrize("origin", [(42.55, 1.53), (-33.2, 179.9), (0.0, 0.0), (71.2, -8.0)])
def test_the_local_frame_is_projs_transverse_mercator(origin: tuple[float, float]) -> None:
    rng = np.random.default_rng(4)
    frame = make_frame(*origin)
    lat, lon = (middle + rng.uniform(-5.0, 5.0, 2000) for middle in origin)
    x, y = to_local(frame, lon, lat)
    expected = Transformer.from_crs(WGS84, frame.proj, always_xy=True)
    assert np.abs(np.subtract((x, y), expected.transform(lon, lat))).max() < 1e-8
    back = to_geographic(frame, x, y)
    around = np.subtract(back, expected.transform(x, y, direction="INVERSE"))
    around[0] -= 360.0 * np.round(around[0] / 360.0)
    assert np.abs(around).max() < 1e-13
    assert np.isinf(to_local(frame, [origin[1] + 90.0], [0.0])).all()


def test_a_local_frame_is_known_by_its_words() -> None:
    frame = make_frame(-42.559831, 1.57225)
    assert frame_of_proj(frame.proj) == frame
    for other in ("EPSG:25832", frame.proj.replace("+k=1", "+k=0.9996"), frame.proj + " +no_defs"):
        assert frame_of_proj(other) is None


def test_the_bits_of_places_are_the_same_everywhere() -> None:
    frame = make_frame(42.55, 1.53)
    x, y = to_local(frame, [1.5, 1.6124], [42.5, 42.6123])
    assert [float(value).hex() for value in (*x, *y)] == [
        "-0x1.343f0d3937d57p+11",
        "0x1.a6910ba5cf377p+12",
        "-0x1.5b1bcfe198000p+12",
        "0x1.b0bdc65720c00p+12",
    ]
