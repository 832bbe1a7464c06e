"""Signs and signals before street ends: highway=stop, give_way and traffic_signals on nodes.

Crossings with lights count as signals of the junction at which they lie.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.conventions import countries
from osm2xodr.curves import (
    cosine,
    hypot,
    sine,
    starts,
)
from osm2xodr.defaults import SIGN_REACH, SIGNALLED_CROSSING_REACH
from osm2xodr.model import Direction, Facing, Light, Sign, Street, StreetNetwork

# Least share of a junction's entries with a signal for a signalled junction; a choice.
_SIGNALLED_SHARE: Final = 0.5
# Signs that look within 20 degrees, by their sine, of across a street are for neither of its directions; a choice.
_ACROSS_SINE: Final = 0.34


@dataclass(frozen=True, slots=True)
class Signs:
    """Signs of a street network. Street ends are numbered 2 x street, plus 1 for its end."""

    before_end: Mapping[int, Sign]  # The sign for traffic to a street end (2 x street, plus 1 for its end)
    all_way: frozenset[int]  # The street ends where all arms have to stop
    nodes: Mapping[int, Sign]  # Signs on the nodes where streets meet, by OSM node id; they name no arm
    all_way_nodes: frozenset[int]  # The nodes of these where all arms have to stop
    ends_of: Mapping[int, tuple[int, ...]]  # The street ends that the sign on a node inside a street is meant for

    def signalled(self, nodes: Collection[int], entries: Sequence[int]) -> bool:
        """Return whether a junction has signals: on its nodes, or before enough of its entries (street ends)."""
        if any(self.nodes.get(node) is Sign.SIGNALS for node in nodes):
            return True
        count = sum(self.before_end.get(end) is Sign.SIGNALS for end in entries)
        return count > 0 and count >= _SIGNALLED_SHARE * len(entries)


def priority_rank(highway: str) -> int:
    """Return the rank of a road by its class in OSM among the roads that it meets, see `PRIORITY_RANK`."""
    if highway.endswith("_link"):
        return countries.PRIORITY_RANK_LINK
    return countries.PRIORITY_RANK.get(highway, countries.PRIORITY_RANK_OTHER)


def ranks_at_junction(highways: Iterable[str]) -> list[int]:
    """Return the ranks of the arms of a junction by their classes in OSM.

    Ramps rank above streets in general where none of these runs on.
    """
    ranks = [priority_rank(highway) for highway in highways]
    if ranks.count(countries.PRIORITY_RANK_OTHER) > 1:
        return ranks
    link, above = countries.PRIORITY_RANK_LINK, countries.PRIORITY_RANK_LINK_ABOVE
    return [above if rank == link else rank for rank in ranks]


def read_signs(network: StreetNetwork) -> Signs:
    """Find the signs of all street ends.

    A sign inside a street is meant for the end that ``direction`` names, else for the only end to which traffic
    comes, else for the end whose traffic it faces, else for the nearer end; within `SIGN_REACH`. Of several the one
    nearest to the end counts. Lights of a crossing are meant for the nearer end, within `SIGNALLED_CROSSING_REACH`,
    if traffic comes to it.
    """
    controls = network.node_facts.controls
    signed = {node: sign for node, control in controls.items() if (sign := control.sign) is not None}
    all_way = {node for node in signed if controls[node].all_way}
    meeting = {node.osm_node_id for node in network.intersections}
    before: dict[int, tuple[bool, float, Sign, int]] = {}
    ends_of: dict[int, list[int]] = defaultdict(list)
    for street, place in places_on_streets(network.streets, signed.keys() - meeting):
        node = int(street.node_ids[place])
        distance = _distances(street, place)
        crossing = controls[node].light is Light.CROSSING
        reach = SIGNALLED_CROSSING_REACH if crossing else SIGN_REACH
        for end in _meant(street, place, controls[node].facing, distance, crossing):
            if distance[end] <= reach:
                key = 2 * street.id + end
                ends_of[node].append(key)
                # Signs of the junction itself go before lights of a crossing.
                found = (crossing, distance[end], signed[node], node)
                before[key] = min(before.get(key, found), found)
    # Lights of a crossing on a node where streets meet belong to one of the arms.
    at_nodes = {
        node: sign for node, sign in signed.items() if node in meeting and controls[node].light is not Light.CROSSING
    }
    return Signs(
        before_end={end: sign for end, (_, _, sign, _) in sorted(before.items())},
        all_way=frozenset(end for end, (_, _, _, node) in before.items() if node in all_way),
        nodes=at_nodes,
        all_way_nodes=frozenset(all_way & at_nodes.keys()),
        ends_of={node: tuple(ends) for node, ends in sorted(ends_of.items())},
    )


def places_on_streets(streets: Sequence[Street], nodes: Iterable[int]) -> list[tuple[Street, int]]:
    """Return (street, index of the node) of every place of nodes on streets, by OSM id, in the order of streets."""
    wanted = np.array(sorted(set(nodes)), np.int64)
    if not len(wanted):
        return []
    start = starts([len(street.node_ids) for street in streets])
    every = np.concatenate([street.node_ids for street in streets])
    rows = np.flatnonzero(np.isin(every, wanted))
    owner = np.searchsorted(start, rows, side="right") - 1
    return [
        (streets[street], row - int(start[street])) for street, row in zip(owner.tolist(), rows.tolist(), strict=True)
    ]


def _distances(street: Street, place: int) -> tuple[float, float]:
    """Return the distances of a node from the street's start and end along it, m."""
    step = hypot(*np.diff(street.points, axis=0).T)
    return float(step[:place].sum()), float(step[place:].sum())


def _meant(
    street: Street, place: int, facing: Facing, distance: tuple[float, float], crossing: bool
) -> tuple[int, ...]:
    """Return the ends (0 start, 1 end) that a sign inside a street applies to."""
    attributes = street.attributes_at(place)
    runs = attributes.car_directions()
    nearer = int(distance[1] < distance[0])
    if crossing:
        towards = Direction.FORWARD if nearer else Direction.BACKWARD
        return (nearer,) if towards in runs or Direction.BOTH in runs else ()
    if facing.both:
        return 0, 1
    if facing.along is not None:
        return (int(facing.along != attributes.reversed),)
    if Direction.BOTH not in runs and len(runs) == 1:
        return (int(Direction.FORWARD in runs),)
    faced = _faced(street, place, facing.azimuth_deg)
    return (nearer,) if faced is None else (faced,)


def _faced(street: Street, place: int, azimuth_deg: float | None) -> int | None:
    """Return the end (0 start, 1 end) that traffic comes to which sees a sign that looks in a direction.

    None where the direction is not known, or the sign looks across the street.
    """
    if azimuth_deg is None:
        return None
    step = street.points[min(place + 1, len(street.points) - 1)] - street.points[max(place - 1, 0)]
    angle = np.deg2rad(azimuth_deg)
    against = float(step[0] * sine(angle) + step[1] * cosine(angle))
    return None if abs(against) < _ACROSS_SINE * float(hypot(*step)) else int(against < 0.0)


def meant_ends(street: Street, place: int, facing: Facing) -> tuple[int, ...]:
    """Return the ends (0 start, 1 end) of a street that a stop or give-way sign on a node, by its index, is for."""
    return _meant(street, place, facing, _distances(street, place), crossing=False)
