from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import CoverageError
from osm2xodr.surface import SurfaceOptions, judge_coverage

PLACES = (np.array([11.5, 11.6]), np.array([49.9, 50.0]))


def judged(coverage: float, options: SurfaceOptions) -> list[str]:
    diagnostics = Diagnostics()
    judge_coverage([Path("a.tif")], options, coverage, 1234.0, PLACES, diagnostics)
    assert [item.code for item in diagnostics] == ["dem-gap"]
    return [item.message for item in diagnostics]


def test_the_message_says_how_much_and_where() -> None:
    said = "11.5000 to 11.6000 E, 49.9000 to 50.0000 N) have no measured height; it was filled in."
    assert judged(0.97, SurfaceOptions()) == [f"a.tif: 3 % of the roads (1.2 km, {said}"]
    assert judged(0.996, SurfaceOptions()) == [f"a.tif: 0.4 % of the roads (1.2 km, {said}"]
    assert judged(0.004, SurfaceOptions(allow_partial=True)) == [f"a.tif: 99.60 % of the roads (1.2 km, {said}"]


def test_less_than_half_is_too_little() -> None:
    assert judged(0.5, SurfaceOptions())
    with pytest.raises(CoverageError, match=r"a.tif: only 49 % of the roads .* --allow-partial"):
        judged(0.49, SurfaceOptions())
    assert judged(0.19, SurfaceOptions(allow_partial=True))


def test_the_share_asked_for_is_demanded() -> None:
    assert judged(0.19, SurfaceOptions(coverage_least=0.15))
    wanted = r"only 19 % of .* and --fail-below-coverage asks for 25 %; give elevation"
    with pytest.raises(CoverageError, match=wanted):
        judged(0.19, SurfaceOptions(coverage_least=0.25))
    with pytest.raises(CoverageError, match=r"only 99.99 % of .* asks for 100 %"):
        judged(0.9999, SurfaceOptions(coverage_least=1.0))


def test_nothing_is_said_where_all_is_measured() -> None:
    diagnostics, none = Diagnostics(), (np.zeros(0), np.zeros(0))
    judge_coverage([Path("a.tif")], SurfaceOptions(coverage_least=1.0), 1.0, 0.0, none, diagnostics)
    assert list(diagnostics) == []
