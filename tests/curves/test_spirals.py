"""Spirals against Fresnel's integrals, and as records of curves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.special import fresnel, roots_legendre

from osm2xodr.curves import (
    arc_step,
    chain_curves,
    curvature_at,
    cut_curves,
    end_curvature,
    lengths,
    pose,
    project,
    record_turns,
    reverse_curves,
    smallest_radius,
    spirals_between,
)
from osm2xodr.model import FloatArray, PlanView

# Line of 20 m, spiral of 30 m to a radius of 25 m on the left, spiral of 40 m to one of 50 m on the right.
_CURVATURE = np.array([0.0, 0.0, 0.04])
_RATE = np.array([0.0, 0.04 / 30.0, -0.06 / 40.0])
_LENGTH = np.array([20.0, 30.0, 40.0])


def _road() -> PlanView:
    x, y, hdg = np.array([3.0, 0.0, 0.0]), np.array([4.0, 0.0, 0.0]), np.array([0.5, 0.0, 0.0])
    for k in range(2):
        u, v, turn = (float(a[0]) for a in _step(_CURVATURE[k], _RATE[k], _LENGTH[k]))
        x[k + 1] = x[k] + np.cos(hdg[k]) * u - np.sin(hdg[k]) * v
        y[k + 1] = y[k] + np.sin(hdg[k]) * u + np.cos(hdg[k]) * v
        hdg[k + 1] = hdg[k] + turn
    s = np.array([0.0, 20.0, 50.0])
    return PlanView(np.array([0, 3]), s, x, y, hdg, _LENGTH, _CURVATURE, _RATE)


def _step(curvature: float, rate: float, ds: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    return arc_step(np.array([curvature]), np.array([ds]), np.array([rate]))


@pytest.mark.parametrize("length", [1.0, 10.0, 60.0, 300.0])
def test_a_spiral_from_a_line_is_fresnels(length: float) -> None:
    """The last one turns by more than three full circles."""
    rate = 5e-4
    size = np.sqrt(np.pi / rate)
    sine, cosine = fresnel(length / size)
    u, v, turn = _step(0.0, rate, length)
    assert (u[0], v[0]) == pytest.approx((size * cosine, size * sine), abs=1e-9)
    assert turn[0] == pytest.approx(rate * length**2 / 2)


def test_places_on_spirals_are_reached_in_steps() -> None:
    plan, s = _road(), np.linspace(0.0, 90.0, 9001)
    x, y, hdg = pose(plan, np.zeros(len(s), np.int64), s)
    assert np.hypot(np.diff(x), np.diff(y)) == pytest.approx(0.01, abs=1e-7)
    ahead = np.arctan2(np.diff(y), np.diff(x))
    assert np.abs(ahead - (hdg[1:] + hdg[:-1]) / 2).max() < 1e-5
    bend = curvature_at(plan, np.zeros(len(s) - 1, np.int64), (s[1:] + s[:-1]) / 2)
    assert np.abs(np.diff(hdg) / 0.01 - bend).max() < 1e-9


def test_end_radius_and_turn() -> None:
    plan = _road()
    assert end_curvature(plan) == pytest.approx([0.0, 0.04, -0.02])
    assert smallest_radius(plan) == pytest.approx([25.0])
    assert record_turns(plan) == pytest.approx([0.0, 0.6, 0.4])


def test_backwards_a_spiral_is_the_same() -> None:
    plan, zeros = _road(), np.zeros(50, np.int64)
    back, s = reverse_curves(plan, np.array([True])), np.linspace(0.0, 90.0, 50)
    there, again = pose(plan, zeros, s), pose(back, zeros, 90.0 - s)
    assert np.abs(there[0] - again[0]).max() < 1e-9
    assert np.abs(there[1] - again[1]).max() < 1e-9
    assert curvature_at(back, zeros, 90.0 - s) == pytest.approx(-curvature_at(plan, zeros, s), abs=1e-9)


def test_parts_of_spirals_lie_on_them_and_chain_up_again() -> None:
    plan, cuts = _road(), np.array([0.0, 33.0, 41.0, 77.0, 90.0])
    parts = cut_curves(plan, cuts[:-1], cuts[1:], np.zeros(4, np.int64))
    assert lengths(parts) == pytest.approx(np.diff(cuts))
    whole, s = chain_curves(parts, np.array([0, 4])), np.linspace(0.0, 90.0, 50)
    zeros = np.zeros(50, np.int64)
    for one, other in zip(pose(plan, zeros, s), pose(whole, zeros, s), strict=True):
        assert np.abs(one - other).max() < 1e-9


@given(st.floats(0.5, 89.5), st.floats(-15.0, 15.0))
def test_points_beside_are_projected_to_where_they_are(s: float, t: float) -> None:
    """They lie nearer than the centres of the bends."""
    plan, one = _road(), np.zeros(1, np.int64)
    x, y, hdg = pose(plan, one, np.array([s]))
    found, aside, distance = project(plan, one, x - t * np.sin(hdg), y + t * np.cos(hdg))
    assert found[0] == pytest.approx(s, abs=1e-6)
    assert aside[0] == pytest.approx(t, abs=1e-9)
    assert distance[0] == pytest.approx(abs(t), abs=1e-9)


@given(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2))
def test_a_spiral_between_two_headings_ends_on_its_chord(before: float, after: float) -> None:
    a, b = np.array([before]), np.array([after])
    shape, length = spirals_between(a, b)
    u, v, turn = arc_step((b - a - shape) / length, length, 2 * shape / length**2)
    assert u[0] * np.cos(before) - v[0] * np.sin(before) == pytest.approx(1.0, abs=1e-9)
    assert u[0] * np.sin(before) + v[0] * np.cos(before) == pytest.approx(0.0, abs=1e-9)
    assert turn[0] == pytest.approx(after - before, abs=1e-12)


@given(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05), st.floats(0.1, 40.0))
def test_a_step_is_the_integral_of_its_direction(first: float, last: float, length: float) -> None:
    """They turn by up to 2 rad: in one piece and in two."""
    nodes, weights = roots_legendre(40)
    s = length * (nodes + 1.0) / 2.0
    heading = first * s + (last - first) / length * s**2 / 2.0
    u, v, turn = _step(first, (last - first) / length, length)
    assert u[0] == pytest.approx(length / 2.0 * float(weights @ np.cos(heading)), abs=2e-9)
    assert v[0] == pytest.approx(length / 2.0 * float(weights @ np.sin(heading)), abs=2e-9)
    assert turn[0] == pytest.approx((first + last) / 2.0 * length, abs=1e-12)
