"""Banded systems of linear equations."""

from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.geometry.plan_view.banded import solve_banded


@pytest.mark.parametrize("size", [1, 2, 3, 60])
def test_the_solution_fulfils_the_system(size: int) -> None:
    rng = np.random.default_rng(size)
    root = np.tril(np.triu(rng.normal(0.0, 1.0, (size, size)), -3)) + 3.0 * np.eye(size)
    system, wanted = root @ root.T, rng.normal(0.0, 1.0, size)
    bands = np.stack(
        [np.pad(np.diag(system, -k), (0, min(k, size))) if k < size else np.zeros(size) for k in range(4)]
    )
    before = bands.copy()
    assert solve_banded(bands, system @ wanted) == pytest.approx(wanted, rel=1e-9)
    assert (bands == before).all()


def test_nothing_to_solve() -> None:
    assert solve_banded(np.zeros((4, 0)), np.zeros(0)).shape == (0,)
