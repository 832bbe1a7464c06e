"""Sine, cosine and arctangent with digits of their own."""

from __future__ import annotations

import math

import numpy as np
import pytest

from osm2xodr.curves import arctan2, cosine, hypot, sine
from osm2xodr.model import FloatArray

RNG = np.random.default_rng(8)
ANGLES = np.concatenate(
    [
        RNG.uniform(-7.0, 7.0, 3000),
        RNG.uniform(-1.6e6, 1.6e6, 3000),
        RNG.normal(0.0, 1e-5, 300),
        np.arange(-40, 41) * np.pi / 4,
    ]
)


def units_off(found: FloatArray, expected: list[float]) -> float:
    """Return by how many units in the last place numbers differ at most."""
    return float((np.abs(found - expected) / np.spacing(np.abs(expected))).max())


def test_sines_and_cosines_are_those_of_the_c_library_but_for_the_last_digit() -> None:
    assert units_off(sine(ANGLES), [math.sin(angle) for angle in ANGLES.tolist()]) <= 1.0
    assert units_off(cosine(ANGLES), [math.cos(angle) for angle in ANGLES.tolist()]) <= 1.0


def test_arctangents_are_those_of_the_c_library_but_for_the_last_digits() -> None:
    y = np.concatenate([RNG.normal(0.0, 1.0, 4000), np.linspace(-1.0, 1.0, 2001), RNG.normal(0.0, 1e-9, 100)])
    x = np.concatenate([RNG.normal(0.0, 1.0, 4000), np.ones(2001), RNG.normal(0.0, 1.0, 100)])
    assert units_off(arctan2(y, x), list(map(math.atan2, y.tolist(), x.tolist()))) <= 2.0


def test_axes() -> None:
    assert sine([0.0, -0.5 * np.pi]).tolist() == [0.0, -1.0]
    assert cosine([0.0, np.pi]).tolist() == [1.0, -1.0]
    y, x = np.array([0.0, 1.0, 0.0, -1.0, 0.0, 1.0]), np.array([1.0, 0.0, -1.0, 0.0, 0.0, -1.0])
    assert (arctan2(y, x) / np.pi).tolist() == [0.0, 0.5, 1.0, -0.5, 0.0, 0.75]
    assert arctan2(-0.0, -1.0) == np.pi


def test_what_is_no_angle_has_none() -> None:
    assert np.isnan(sine([np.inf, -np.inf, np.nan])).all()
    assert np.isnan(cosine([np.inf, np.nan])).all()
    assert sine(1e9) == pytest.approx(math.sin(1e9), abs=1e-6)


def test_the_bits_are_the_same_everywhere() -> None:
    angles = np.array([0.1, 2.5, -1.2, 4.0, 1234.5])
    bits = [
        float(value).hex() for value in [*sine(angles), *cosine(angles), *arctan2(angles, 1.0), hypot(angles[0], 0.3)]
    ]
    assert bits == [
        "0x1.98eaecb8bcb2cp-4",
        "0x1.326af0dcfcab0p-1",
        "-0x1.dd343a21a55c4p-1",
        "-0x1.837b9dddc1eaep-1",
        "0x1.29c531dfd031bp-3",
        "0x1.fd712f9a817c1p-1",
        "-0x1.9a2f7ef858b7dp-1",
        "0x1.730de943b79d4p-2",
        "-0x1.4eaa606db24c1p-1",
        "-0x1.fa8f2ceb78372p-1",
        "0x1.983e282e2cc4dp-4",
        "0x1.30b6d796a4da8p+0",
        "-0x1.c08aae496efa6p-1",
        "0x1.5368c951e9cfcp+0",
        "0x1.91ea9efa2930ap+0",
        "0x1.43d136248490fp-2",
    ]


def test_shapes_are_kept() -> None:
    assert sine(np.zeros((2, 3))).shape == cosine(np.zeros((2, 3))).shape == (2, 3)
    assert arctan2(np.ones((2, 1)), np.ones(3)).shape == (2, 3)
    assert hypot([3.0, 6.0], [4.0, 8.0]).tolist() == [5.0, 10.0]
