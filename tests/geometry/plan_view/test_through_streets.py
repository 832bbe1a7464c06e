"""Which streets go on in each other through intersections."""

from __future__ import annotations

import numpy as np
from street_cases import Case

from osm2xodr.curves import lengths, pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.plan_view.street_smoothing import StreetChains, chain_streets
from osm2xodr.geometry.plan_view.streets import FittedStreets, fit_streets

_CROSS = {"a": (-100.0, 0.0), "m": (0.0, 0.0), "b": (100.0, 8.0), "c": (0.0, -100.0), "d": (4.0, 100.0)}


def _chains(case: Case) -> tuple[StreetChains, FittedStreets, list[set[int]]]:
    """Return the chains, the streets, and the ways of each chain."""
    network = case.stages().network
    fitted = fit_streets(network, Diagnostics())
    chains = chain_streets(network, fitted.plan_view, np.ones(len(network.streets), bool))
    ways = [
        {network.streets[k].pieces[0][1].osm_way_id for k in chains.street[first:last].tolist()}
        for first, last in zip(chains.first[:-1].tolist(), chains.first[1:].tolist(), strict=True)
    ]
    return chains, fitted, ways


def test_at_a_crossing_both_streets_go_on_straight() -> None:
    _, _, ways = _chains(Case(_CROSS, {1: ("a m", ""), 2: ("m b", ""), 3: ("c m", ""), 4: ("m d", "")}))
    assert sorted(map(sorted, ways)) == [[1, 2], [3, 4]]


def test_a_street_that_ends_at_another_goes_on_in_none() -> None:
    _, _, ways = _chains(Case(_CROSS, {1: ("a m", ""), 2: ("m b", ""), 3: ("c m", "")}))
    assert sorted(map(sorted, ways)) == [[1, 2], [3]]


def test_of_two_branches_that_of_the_same_name_goes_on() -> None:
    """It bends more than the other one, by less than what names outweigh."""
    nodes = {"a": (-100.0, 0.0), "m": (0.0, 0.0), "b": (100.0, 15.0), "c": (100.0, -12.0)}
    _, _, ways = _chains(Case(nodes, {1: ("a m", "name=A"), 2: ("m b", "name=A"), 3: ("m c", "name=C")}))
    assert {1, 2} in ways


def test_of_two_branches_alike_none_goes_on() -> None:
    """Else it would matter which one comes first, or on which side traffic drives."""
    nodes = {"a": (-100.0, 0.0), "m": (0.0, 0.0), "b": (100.0, 15.0), "c": (100.0, -15.0)}
    _, _, ways = _chains(Case(nodes, {1: ("a m", ""), 2: ("m b", ""), 3: ("m c", "")}))
    assert sorted(map(sorted, ways)) == [[1], [2], [3]]


def test_streets_of_one_way_go_on_in_those_that_lead_on() -> None:
    """Neither in a street of both directions nor in one that comes the other way."""
    nodes = {"a": (-100.0, 0.0), "m": (0.0, 0.0), "b": (100.0, 0.0), "c": (0.0, 100.0)}
    both = {1: ("a m", "oneway=yes"), 2: ("m b", ""), 3: ("c m", "")}
    assert {1, 2} not in _chains(Case(nodes, both))[2]
    against = {1: ("a m", "oneway=yes"), 2: ("b m", "oneway=yes"), 3: ("m c", "")}
    assert {1, 2} not in _chains(Case(nodes, against))[2]
    on = {1: ("a m", "oneway=yes"), 2: ("m b", "oneway=yes"), 3: ("c m", "")}
    assert {1, 2} in _chains(Case(nodes, on))[2]


def test_the_curve_of_a_chain_leads_from_end_to_end() -> None:
    """Whichever way its streets are drawn."""
    case = Case(_CROSS, {1: ("m a", ""), 2: ("m b", ""), 3: ("c m", "")})
    chains, fitted, ways = _chains(case)
    plan = chains.curves(fitted.plan_view)
    row = np.array([ways.index({1, 2})])
    inner = chains.first[row[0]] + 1
    place = chains.place_of(fitted.plan_view)[[inner]]
    (x0, x1, x2), (y0, y1, y2), _ = pose(plan, np.repeat(row, 3), np.concatenate([[0.0], place, lengths(plan)[row]]))
    found = sorted([(float(x0 - x1), float(y0 - y1)), (float(x2 - x1), float(y2 - y1))])
    assert np.allclose(found, [(-100.0, 0.0), (100.0, 8.0)], atol=0.01)


def test_a_circle_of_streets_is_a_chain_too() -> None:
    """Streets that turn little from each to the next, about a block."""
    nodes = {f"n{k}": (100.0 * np.cos(k * np.pi / 4), 100.0 * np.sin(k * np.pi / 4)) for k in range(8)}
    nodes |= {f"m{k}": (150.0 * np.cos(k * np.pi / 4), 150.0 * np.sin(k * np.pi / 4)) for k in range(8)}
    corners = [np.pi / 4 * (k + np.array([0.0, 1 / 3, 2 / 3, 1.0])) for k in range(8)]
    ways = {}
    for k, angles in enumerate(corners):
        for j, angle in enumerate(angles[1:-1].tolist()):
            nodes[f"p{k}{j}"] = (100.0 * np.cos(angle), 100.0 * np.sin(angle))
        ways[k + 1] = (f"n{k} p{k}0 p{k}1 n{(k + 1) % 8}", "")
        ways[k + 11] = (f"n{k} m{k}", "")
    chains, _, found = _chains(Case(nodes, ways))
    assert set(range(1, 9)) in found
    assert sorted(chains.street.tolist()) == list(range(16))
