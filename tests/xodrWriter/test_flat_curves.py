"""Arcs and spirals that are too flat for readers to compute with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from osm2xodr.curves import pose
from osm2xodr.model import PlanView
from osm2xodr.xodrWriter.flat_curves import LARGEST_RADIUS, without_flat_curves


def one_arc(length: float, radius: float, rate: float = 0.0) -> PlanView:
    """A curve of one record that starts at (3, 4)."""
    values = [np.array([value]) for value in (0.0, 3.0, 4.0, 0.5, length, 1.0 / radius, rate)]
    return PlanView(np.array([0, 1]), *values)


@pytest.mark.parametrize(
    ("radius", "length", "count"),
    [
        (32e6, 130.0, 1),
        (-1e6, 70.0, 1),
        # 74.8 m of such an arc lie within 0.7 mm of a line.
        (1e6, 100.0, 2),
        (-300e3, 150.0, 4),
        (200.1e3, 160.0, 5),
    ],
)
def test_flat_arcs_become_lines_along_them(radius: float, length: float, count: int) -> None:
    plan = one_arc(length, radius)
    found = without_flat_curves(plan)
    assert found.start.tolist() == [0, count]
    assert found.curvature.tolist() == [0.0] * count
    assert found.length.tolist() == pytest.approx([length / count] * count, abs=1e-12)
    assert found.s == pytest.approx(np.arange(count) * length / count, abs=1e-12)
    s = np.linspace(0.0, length, 33)
    (x, y, hdg), (x0, y0, hdg0) = (pose(item, np.zeros(33, int), s) for item in (found, plan))
    off = np.hypot(x - x0, y - y0)
    assert 0.1e-3 * (abs(radius) < 1e7) < off.max() < 1e-3
    assert off[0] < 1e-9
    assert off[-1] < 1e-6
    assert np.abs(hdg - hdg0).max() < 1e-4
    assert np.rad2deg(np.abs(np.diff(found.hdg))).max(initial=0.0) < 0.01


def test_other_records_stay() -> None:
    for plan in (
        one_arc(50.0, 0.99 * LARGEST_RADIUS),
        one_arc(12.0, 1e6, 1e-6),
        one_arc(50.0, 5e5, 1e-6),
        one_arc(50.0, np.inf),
    ):
        assert without_flat_curves(plan) is plan


def test_neighbours_of_flat_arcs_stay() -> None:
    values = [[0.0, 50.0, 150.0], [0.0, 50.0, 150.0], [0.0] * 3, [0.0] * 3, [50.0, 100.0, 20.0], [0.0, 1e-6, 0.01]]
    plan = PlanView(np.array([0, 1, 3]), *(np.array(item) for item in values))
    found = without_flat_curves(plan)
    assert found.start.tolist() == [0, 1, 4]
    assert found.curvature.tolist() == [0.0, 0.0, 0.0, 0.01]
    assert found.hdg.tolist() == pytest.approx([0.0, 25e-6, 75e-6, 0.0], abs=1e-12)


# What esmini and libOpenDRIVE take for 0, 1/m.
SMALL = 1e-6


def as_read(plan: PlanView) -> PlanView:
    """The records as esmini 3.6 reads them: spirals that hardly bend are lines or arcs, others may begin straight."""
    change = plan.rate * plan.length
    curvature = np.where((plan.rate != 0.0) & (np.abs(plan.curvature) < SMALL), 0.0, plan.curvature)
    return replace(plan, curvature=curvature, rate=np.where(np.abs(change) < SMALL, 0.0, plan.rate))


@pytest.mark.parametrize(
    ("length", "start", "end"),
    [
        # A road of Portland.
        (783.55, 3.44e-7, -1.59e-7),
        (400.0, 0.004, 0.004 + 9e-7),
        (300.0, 8e-7, 2e-3),
        (300.0, -8e-7, 2e-3),
        (900.0, -9e-7, 1.5e-6),
        (20.0, 9e-7, 0.04),
        (3000.0, 0.0, 9e-7),
        # Hardly more than a line.
        (250.0, 2e-8, 3e-8),
    ],
)
def test_readers_meet_the_places_of_flat_spirals(length: float, start: float, end: float) -> None:
    plan = one_arc(length, np.inf, (end - start) / length)
    plan = replace(plan, curvature=np.array([start]))
    found = without_flat_curves(plan)
    s = np.linspace(0.0, length, 41)
    zero = np.zeros(41, int)
    x0, y0, hdg0 = pose(plan, zero, s)
    wrong = pose(as_read(plan), zero, s)
    assert np.hypot(wrong[0] - x0, wrong[1] - y0).max() > 1.2e-4
    for read in (found, as_read(found)):
        x, y, hdg = pose(read, zero, s)
        off = np.hypot(x - x0, y - y0)
        assert off.max() < 1.2e-3
        assert off[-1] < 2e-5
        # The last line of a flat arc has the heading of its middle.
        assert abs(hdg[-1] - hdg0[-1]) < 1e-4
    # Records begin where those before them end.
    joints = np.arange(1, len(found.s))
    x, y, hdg = pose(found, np.zeros(len(joints), int), found.s[joints] - 1e-9)
    assert np.hypot(x - found.x[joints], y - found.y[joints]).max() < 2e-5
    assert found.length.sum() == pytest.approx(length, abs=1e-9)
    assert found.length.min() >= 0.24
    # ASAM's checker calls lines that go on in the same direction redundant.
    lines = (found.curvature == 0.0) & (found.rate == 0.0)
    assert np.abs(np.diff(found.hdg))[lines[1:] & lines[:-1]].min(initial=1.0) > 1e-6
