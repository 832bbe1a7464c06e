"""Streets that become part of a junction though some room is left on them."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import cosine, repeated, sine, slope_of, unique_counts, wrapped
from osm2xodr.defaults import LEAST_TURN_BACK
from osm2xodr.geometry.defaults import SHORTEST_STREET_BETWEEN_JUNCTIONS
from osm2xodr.geometry.junctions import defaults
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import BoolArray, FloatArray, IntArray, StreetNetwork

# Streets shorter than this, m, that a turn restriction runs over (via way) become part of a junction. A choice.
_RESTRICTED_STREET: Final = 30.0
# Streets across a median, from one carriageway to the other of the same road, are shorter than this, m; the
# carriageways run opposite ways within the angle of this cosine, and square to the street within that of this sine
# (37 degrees). Choices.
_MEDIAN_CROSSING: Final = 40.0
_CARRIAGEWAYS_COSINE: Final = 0.8
# What a crossing for people needs of a street, m: 3 m (R-FGÜ 2001), and half a metre on either side.
_CROSSING_ROOM: Final = 4.0
# Ways over a street onto an arm beyond it may cut the corner between by this much, m: half of a carriageway of two
# lanes, and 1.5 m more. A choice.
_MOST_CORNER_CUT: Final = 4.5


def streets_without_room(
    network: StreetNetwork,
    ends: StreetEnds,
    between: BoolArray,
    left: FloatArray,
    wished: FloatArray,
    group: IntArray,
) -> BoolArray:
    """Say which streets leave no room for a car, and would do no harm as part of a junction, (streets,).

    `between` says which of them lie between two junctions, `left` what these leave of them, (streets,), m; `wished`
    is what rounded corners would take, (ends,), m, `group` the junction of each node.

    Roundabouts keep their rings apart from the junctions around them, and crossings for people their place on a
    street. A street stays if another one joins the same junctions, which would lead back to where it begins, and if
    ways over it would leave the streets at corners.
    """
    ringed = np.isin(ends.node, ends.node[ends.roundabout])
    short = between & (left < SHORTEST_STREET_BETWEEN_JUNCTIONS) & ~ringed[0::2] & ~ringed[1::2]
    pair = np.sort(group[ends.node.reshape(-1, 2)[between]], 1) @ np.array([len(group), 1])
    number, count = unique_counts(pair)
    short[between] &= count[np.searchsorted(number, pair)] == 1
    found = np.flatnonzero(short & ~((left >= _CROSSING_ROOM) & _crossed(network)))
    short[:] = False
    short[found[_corner_cut(ends, found, wished) < _MOST_CORNER_CUT]] = True
    return short


def _crossed(network: StreetNetwork) -> BoolArray:
    """Say on which streets, apart from their ends, people cross, (streets,)."""
    nodes = {crossing.node for crossing in network.node_facts.crossings}
    inner = [street.node_ids[1:-1] for street in network.streets]
    street = repeated([len(ids) for ids in inner])
    found = np.isin(np.concatenate(inner), np.array(sorted(nodes), np.int64))
    return np.bincount(street[found], minlength=len(inner)) > 0


def _corner_cut(ends: StreetEnds, street: IntArray, wished: FloatArray) -> FloatArray:
    """Return by how much ways over streets would cut the corners at their nodes if these were one junction, (n,), m.

    An arc whose tangents are as long as the shorter one of the street and the arm that turns off passes the corner at
    this distance.
    """
    at: dict[int, list[int]] = {}
    for end in np.flatnonzero(np.isin(ends.node, ends.node[[2 * street, 2 * street + 1]])).tolist():
        at.setdefault(int(ends.node[end]), []).append(end)
    pairs = [
        (number, end, arm)
        for number, k in enumerate(street.tolist())
        for end in (2 * k, 2 * k + 1)
        for arm in at[int(ends.node[end])]
        if arm != end
    ]
    number, end, arm = np.array(pairs, np.int64).reshape(-1, 3).T
    turn = np.abs(wrapped(ends.hdg[arm] - ends.hdg[end] - np.pi))
    driven = (ends.enters[end] & ends.leaves[arm]) | (ends.enters[arm] & ends.leaves[end])
    tangent = np.minimum(wished[arm], ends.length[end] + defaults.KERB_TANGENT_MAX)
    out = np.zeros(len(street))
    np.maximum.at(out, number, np.where(driven & (turn < LEAST_TURN_BACK), tangent * slope_of(turn / 4), 0.0))
    return out


def between_carriageways(network: StreetNetwork, ends: StreetEnds) -> BoolArray:
    """Say which streets lead across a median, from a one-way carriageway to the opposite one, (streets,)."""
    out = np.zeros(len(network.streets), bool)
    at: dict[int, list[tuple[float, str]]] = {}
    one_way = ends.enters != ends.leaves
    flow = np.where(ends.leaves, ends.hdg, ends.hdg + np.pi)
    for end in np.flatnonzero(one_way & (ends.node >= 0) & ~ends.roundabout).tolist():
        road = network.streets[end // 2].attributes_at_end(end).road
        at.setdefault(int(ends.node[end]), []).append((float(flow[end]), road))
    short = (ends.length[0::2] < _MEDIAN_CROSSING) & (ends.node[0::2] >= 0) & (ends.node[1::2] >= 0)
    # A ring does not cross the two halves of a roundabout's arm.
    short &= ~(ends.roundabout[0::2] & ends.roundabout[1::2])
    for street in np.flatnonzero(short).tolist():
        across = float(ends.hdg[2 * street])
        out[street] = any(
            name == other
            and cosine(one - two) < -_CARRIAGEWAYS_COSINE
            and abs(sine(one - across)) > _CARRIAGEWAYS_COSINE
            for one, name in at.get(int(ends.node[2 * street]), ())
            for two, other in at.get(int(ends.node[2 * street + 1]), ())
        )
    return out


def restricted(network: StreetNetwork, ends: StreetEnds) -> BoolArray:
    """Say which streets a turn restriction runs over, (streets,): lane links can state it only inside a junction."""
    via = {way for item in network.restrictions for way in item.via_ways}
    over = [via.issuperset(attributes.osm_way_id for _, attributes in street.pieces) for street in network.streets]
    return np.array(over, bool) & (ends.length[0::2] < _RESTRICTED_STREET)
