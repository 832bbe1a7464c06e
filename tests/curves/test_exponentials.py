"""Exponentials, logarithms and roots with digits of their own."""

from __future__ import annotations

import math

import numpy as np

from osm2xodr.curves import cube_root, exp, log, power
from osm2xodr.model import FloatArray

RNG = np.random.default_rng(8)


def units_off(found: FloatArray, expected: list[float]) -> float:
    """Return by how many units in the last place numbers differ at most."""
    return float((np.abs(found - expected) / np.spacing(np.abs(expected))).max())


def test_exponentials_and_logarithms_are_those_of_the_c_library_but_for_the_last_digit() -> None:
    x = np.concatenate([RNG.uniform(-700.0, 700.0, 3000), RNG.uniform(-3.0, 3.0, 3000), RNG.normal(0.0, 1e-6, 300)])
    assert units_off(exp(x), list(map(math.exp, x.tolist()))) <= 1.0
    y = np.concatenate([10.0 ** RNG.uniform(-300.0, 300.0, 3000), 1.0 + RNG.normal(0.0, 1e-3, 3000)])
    assert units_off(log(y), list(map(math.log, y.tolist()))) <= 1.0


def test_roots_and_powers() -> None:
    assert cube_root([0.0, 1.0, 27.0, 1e-9]).tolist() == [0.0, 1.0, 3.0, 1e-3]
    assert np.abs(power([2.0, 9.0, 10.0], [10.0, 0.5, -2.0]) / [1024.0, 3.0, 0.01] - 1.0).max() < 1e-15


def test_the_ends() -> None:
    assert exp([0.0, 1000.0, -1000.0, -np.inf]).tolist() == [1.0, np.inf, 0.0, 0.0]
    assert log([1.0, 0.0]).tolist() == [0.0, -np.inf]
    assert np.isnan(log([-1.0])).all()
    assert np.isnan(exp([np.nan])).all()


def test_the_bits_are_the_same_everywhere() -> None:
    x = np.array([0.1, 2.5, 31.7])
    assert [float(value).hex() for value in (*exp(x), *log(x), *cube_root(x))] == [
        "0x1.1aec7b35a00d4p+0",
        "0x1.85d6fd931e0bbp+3",
        "0x1.a99f867326b67p+45",
        "-0x1.26bb1bbb55515p+1",
        "0x1.d5240f0e0e078p-1",
        "0x1.ba6895c281a23p+1",
        "0x1.db4c7760bcff3p-2",
        "0x1.5b7209557b0eep+0",
        "0x1.9519cb5a323a6p+1",
    ]
