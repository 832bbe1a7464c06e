"""How cars of scenarios go: within limits, slower in bends, stopping for red and at the end."""

from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.starting.motion import Light, Path, plan_motion


def straight(length: float, limit: float) -> Path:
    """Return a straight path, a place each metre."""
    at = np.arange(0.0, length + 0.5)
    places = np.column_stack([at, 0.0 * at, 0.0 * at])
    return Path((0,), np.zeros(len(at), np.int64), at, places, 0.0 * at, at, np.full(len(at), limit))


def bend(radius: float) -> Path:
    """Return 50 m straight on, a quarter of a circle to the left, and 50 m straight on."""
    arc = 0.5 * np.pi * radius
    at = np.arange(0.0, 100.0 + arc)
    turned = np.clip((at - 50.0) / radius, 0.0, 0.5 * np.pi)
    step = np.column_stack([np.cos(turned), np.sin(turned), 0.0 * at])
    return Path((0,), np.zeros(len(at), np.int64), at, np.cumsum(step, axis=0), turned, at, np.full(len(at), 20.0))


def at_place(path: Path, light: tuple[Light, ...], distance: float, delay: float = 0.0) -> tuple[float, float]:
    """Return when a car gets to a distance, s, and its speed there, m/s."""
    motion = plan_motion(path, light, delay)
    times = np.arange(0.0, 120.0, 0.01)
    far = motion.distance(times)
    k = int(np.searchsorted(far, distance))
    return float(times[k]), float((far[k + 1] - far[k - 1]) / 0.02)


def test_it_goes_at_the_limit_and_stops_before_the_end() -> None:
    path = straight(300.0, 15.0)
    motion = plan_motion(path, ())
    assert motion.speed.max() == 15.0
    assert float(motion.distance(np.array([1e3]))[0]) == pytest.approx(292.0, abs=0.5)
    # It stops from 15 m/s by 2 m/s2, for which it takes 7.5 s and 56 m, and goes the rest at 15 m/s.
    standing = float(motion.time[np.flatnonzero(motion.speed == 0.0)[0]])
    assert standing == pytest.approx((292.0 - 56.25) / 15.0 + 7.5, abs=0.2)


def test_bends_are_taken_by_two_metres_per_second_squared() -> None:
    _, speed = at_place(bend(12.5), (), 50.0 + 10.0)
    assert speed == pytest.approx(5.0, abs=0.2)


def test_red_lights_are_waited_for() -> None:
    path = straight(300.0, 10.0)
    red = Light(100.0, lambda time: time >= 30.0, lambda time: max(time, 30.0))
    arrival, _ = at_place(path, (red,), 99.5)
    assert arrival < 15.0
    # A second after it turns green it sets out by 1.5 m/s2: 20 m take 5.2 s.
    after, _ = at_place(path, (red,), 120.0)
    assert after == pytest.approx(31.0 + np.sqrt(2 * 20.0 / 1.5), abs=0.3)
    green = Light(100.0, lambda time: True, lambda time: time)
    assert at_place(path, (green,), 120.0)[0] == pytest.approx(12.0, abs=0.1)


def test_it_sets_out_after_a_delay() -> None:
    arrival, _ = at_place(straight(300.0, 10.0), (), 12.0, delay=20.0)
    assert arrival == pytest.approx(20.0 + np.sqrt(2 * 12.0 / 1.5), abs=0.1)


def test_entries_give_the_same_distances() -> None:
    motion = plan_motion(bend(12.5), (Light(120.0, lambda time: time > 40.0, lambda time: 40.0),))
    entries = np.array(motion.entries)
    when = np.cumsum(entries[:, 0])
    assert len(entries) < 80
    times = np.arange(0.0, when[-1], 0.01)
    gone = np.cumsum(np.interp(times, when, entries[:, 1])) * 0.01
    assert np.abs(gone - motion.distance(times)).max() < 0.5
