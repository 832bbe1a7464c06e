"""Streets that go on straight through intersections: their curves become smooth as one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.curves import chain_curves, chosen_curves, lengths, pose, reverse_curves, runs, sum_before, wrapped
from osm2xodr.model import BoolArray, Direction, FloatArray, IntArray, PlanView, StreetNetwork

# A street goes on in another if it bends by less there, rad (30 degrees), from and to the places that lie this far
# from the intersection, m. Choices.
_LEAST_CORNER: Final = 0.52
_LEAD: Final = 10.0
# So much bend, rad, outweighs that names or classes differ. A choice.
_OTHER_ROAD: Final = 0.2
# Branches whose bends differ by less are alike, rad (1 degree). A choice.
_ALIKE: Final = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class StreetChains:
    """Rows of streets that go on in each other."""

    first: IntArray  # (chains + 1,) Index of each chain's first street; the last entry is the number of streets
    # (streets of all chains,) Chain after chain
    street: IntArray  # Its id
    back: BoolArray  # Whether the chain runs against it

    def curves(self, plan: PlanView) -> PlanView:
        """Return the curves of chains, by those of streets."""
        return chain_curves(reverse_curves(chosen_curves(plan, self.street), self.back, wrap=False), self.first)

    def place_of(self, plan: PlanView) -> FloatArray:
        """Return how far along its chain each street begins, (streets of all chains,), m."""
        return sum_before(lengths(plan, self.street), self.first)


def chain_streets(network: StreetNetwork, plan: PlanView, which: BoolArray, *, chained: bool = True) -> StreetChains:
    """Return the chains that streets form, of those of `which`, (streets,), alone; else each is one of its own."""
    partner = _partners(network, plan, which) if chained else np.full(2 * len(which), -1, np.int64)
    street: list[int] = []
    first: list[int] = []
    used = ~which
    # From loose ends first; what is left are circles, which begin anywhere.
    ends = np.flatnonzero(np.repeat(which, 2))
    for end in [*ends[partner[ends] < 0].tolist(), *ends[(partner[ends] >= 0) & (ends % 2 == 0)].tolist()]:
        if used[end // 2]:
            continue
        first.append(len(street))
        here = end
        while here >= 0 and not used[here // 2]:
            used[here // 2] = True
            street.append(here)
            here = int(partner[here ^ 1])
    number = np.array(street, np.int64)
    return StreetChains(np.array([*first, len(street)], np.int64), number // 2, number % 2 == 1)


def _partners(network: StreetNetwork, plan: PlanView, which: BoolArray) -> IntArray:
    """Return for each street end that which it goes on in, -1 if it does in none, (ends,).

    Both bend least, of all at their intersection, where they go on in each other.
    """
    streets = network.streets
    end = np.arange(2 * len(streets))
    partner = np.full(len(end), -1, np.int64)
    node = np.array([number for street in streets for number in (street.start, street.end)], np.int64)
    chosen = np.flatnonzero(np.repeat(which, 2) & (node >= 0))
    if not len(chosen):
        return partner
    attributes = [street.attributes_at_end(k) for street in streets for k in (0, 1)]
    roads: dict[tuple[str, str], int] = {}
    road = np.array([roads.setdefault((item.road, item.highway), len(roads)) for item in attributes])
    ways: list[frozenset[Direction]] = []
    for k, item in enumerate(attributes):
        ways.append(ways[-1] if k and item is attributes[k - 1] else item.car_directions())
    along = np.array([Direction.BACKWARD not in item for item in ways], bool)
    against = np.array([Direction.FORWARD not in item for item in ways], bool)
    one_way = along | against
    enters = np.where(end % 2 == 1, ~against, ~along)
    hdg = _headings(plan, end)
    # All pairs of ends at an intersection.
    order = chosen[np.argsort(node[chosen], kind="stable")]
    group = np.flatnonzero(np.diff(node[order], prepend=-1))
    size = np.diff(np.append(group, len(order)))
    one = np.repeat(order, np.repeat(size, size))
    other = order[runs(np.repeat(group, size), np.repeat(size, size))]
    bend = np.abs(wrapped(hdg[one] + np.pi - hdg[other]))
    fits = (bend < _LEAST_CORNER) & (one // 2 != other // 2) & (one_way[one] == one_way[other])
    fits &= ~one_way[one] | (enters[one] != enters[other])
    one, other, cost = one[fits], other[fits], (bend + _OTHER_ROAD * (road[one] != road[other]))[fits]
    ranked = np.lexsort((other, cost, one))
    first = np.diff(one[ranked], prepend=-1) != 0
    # Of two branches that are alike none is the street itself.
    rival = np.append(~first[1:] & (np.diff(cost[ranked]) < _ALIKE), False)
    best = ranked[first & ~rival]
    partner[one[best]] = other[best]
    mutual = partner[partner] == end
    return np.where((partner >= 0) & mutual, partner, -1)


def _headings(plan: PlanView, end: IntArray) -> FloatArray:
    """Return the direction from street ends to places a little along their streets, (n,), rad."""
    length = lengths(plan)[end // 2]
    away = np.minimum(_LEAD, length / 2)
    at_end = end % 2 == 1
    x0, y0, _ = pose(plan, end // 2, np.where(at_end, length, 0.0))
    x1, y1, _ = pose(plan, end // 2, np.where(at_end, length - away, away))
    return np.asarray(np.arctan2(y1 - y0, x1 - x0))
