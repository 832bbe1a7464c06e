"""Lanes of streets side by side: narrow enough to fit, but never narrower than a car drives."""

from __future__ import annotations

import math

import numpy as np
import pytest
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.parallel_carriageways import narrow_parallel_streets
from osm2xodr.geometry.plan_view.streets import fit_streets

# Headings along a bend, rad.
_BEND = np.deg2rad(np.arange(-80.0, 81.0, 10.0)).tolist()


def share_kept(case: Case) -> tuple[float, list[str]]:
    """Return the share of its width that the first street keeps, and what was reported."""
    network = case.stages().network
    fitted, diagnostics = fit_streets(network, Diagnostics()), Diagnostics()
    narrowed = narrow_parallel_streets(network, fitted, diagnostics)
    before, after = (item.pieces[0][0][2] for item in (fitted, narrowed))
    share = (after.left_edge - after.right_edge) / (before.left_edge - before.right_edge)
    return share, [item.code for item in diagnostics]


# Two streets of 6 m; 0.2 m is left between them.
@pytest.mark.parametrize(
    ("apart", "share"),
    [
        (6.3, 1.0),
        (5.6, 0.9),
        (5.0, 0.8),
        (4.4, defaults.NARROWEST_SHARE),
        (3.4, defaults.NARROWEST_SHARE),
        (3.1, 1.0),
        (1.0, 1.0),
    ],
)
def test_both_streets_fit(apart: float, share: float) -> None:
    nodes = {"a": (0.0, 0.0), "b": (200.0, 0.0), "c": (0.0, apart), "d": (200.0, apart)}
    kept, reported = share_kept(Case(nodes, {1: ("a b", "width=6"), 2: ("c d", "width=6")}))
    assert kept == pytest.approx(share, abs=0.011)
    assert reported == ([] if share == 1.0 else ["lanes-narrowed"] * 2)


@pytest.mark.parametrize(
    ("tags", "width", "said"),
    [
        # 70 % of 2.75 m
        ("highway=residential lanes=2 width=5.5", 1.92, False),
        ("highway=service lanes=2 width=5", defaults.NARROWEST_LANE, True),
        ("highway=service lanes=2 width=3.6", defaults.NARROWEST_LANE, True),
        ("highway=service lanes=2 width:lanes:forward=1.7 width:lanes:backward=1.7", 1.7, True),
    ],
)
def test_lanes_for_cars_stay_wide_enough_for_cars(tags: str, width: float, said: bool) -> None:
    nodes = {"a": (0.0, 0.0), "b": (200.0, 0.0), "c": (0.0, 3.4), "d": (200.0, 3.4)}
    network = Case(nodes, {1: ("a b", tags), 2: ("c d", tags)}).stages().network
    diagnostics = Diagnostics()
    found = narrow_parallel_streets(network, fit_streets(network, Diagnostics()), diagnostics)
    assert [lane.width for lane in found.pieces[0][0][1].lanes_ltr] == [pytest.approx(width, abs=0.01)] * 2
    assert [f"below {defaults.NARROWEST_LANE:g} m" in item.message for item in diagnostics] == [said] * 2


@pytest.mark.parametrize(("highway", "narrowed"), [("residential", True), ("motorway_link", False)])
def test_streets_that_part_slowly_are_arms_only_as_far_as_a_junction_reaches(highway: str, narrowed: bool) -> None:
    """Both begin at one node, are 4.6 m apart after 30 m and stay so up to 95 m."""
    nodes = {"o": (0.0, 0.0), "a": (95.0, 0.0), "b": (30.0, 4.6), "c": (95.0, 4.6), "w": (-50.0, 0.0)}
    tags = f"highway={highway} width=5.5 oneway=no"
    kept, reported = share_kept(Case(nodes, {1: ("o a", tags), 2: ("o b c", tags), 3: ("w o", tags)}))
    assert (kept < 1.0) is narrowed
    assert reported == (["lanes-narrowed"] * 2 if narrowed else [])


@pytest.mark.parametrize(("apart", "share"), [(6.3, 1.0), (5.0, 0.8), (2.0, 1.0)])
def test_a_street_in_a_bend_fits_beside_the_one_that_it_touches(apart: float, share: float) -> None:
    """A bend of 15 m in radius comes nearest between places of which none is abreast and parallel."""
    bend = {f"p{k}": (103.0 + 15.0 * math.sin(a), apart + 15.0 * (1.0 - math.cos(a))) for k, a in enumerate(_BEND)}
    nodes = {"a": (0.0, 0.0), "b": (200.0, 0.0), "c": (30.0, 90.0), **bend, "d": (180.0, 90.0)}
    ways = {1: ("a b", "width=6"), 2: (" ".join(["c", *bend, "d"]), "width=6")}
    kept, reported = share_kept(Case(nodes, ways))
    assert kept == pytest.approx(share, abs=0.03)
    assert reported == ([] if share == 1.0 else ["lanes-narrowed"] * 2)
