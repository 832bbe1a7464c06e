"""Signs and signals of OSM that stand before a street's end: highway=stop, give_way and traffic_signals on nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Final

import numpy as np

from osm2xodr import defaults
from osm2xodr.model import Direction, Street, StreetNetwork


class Sign(str, Enum):
    """What regulates the traffic that comes to a street's end, in OSM's words."""

    STOP = "stop"
    GIVE_WAY = "give_way"
    SIGNALS = "traffic_signals"


_SIGNS: Final = frozenset(sign.value for sign in Sign)
# Signals that are not those of a junction (OSM wiki, Key:traffic_signals).
_OTHER_SIGNALS: Final = frozenset({"pedestrian_crossing", "tunnel", "ramp_meter", "level_crossing", "blinker"})
_ALL_WAY: Final = frozenset({"all", "4-way", "4way"})
_ALONG: Final = {"forward": True, "backward": False}


@dataclass(frozen=True, slots=True)
class Signs:
    """Signs of a street network.

    Parameters
    ----------
    before_end
        The sign that holds for who comes to a street end (2 x street, plus 1 for its end).
    all_way
        Those of the street ends where all arms have to stop.
    nodes
        Signs on the nodes where streets meet, by OSM node id; they name no arm.
    all_way_nodes
        Those of them where all arms have to stop.
    """

    before_end: Mapping[int, Sign]
    all_way: frozenset[int]
    nodes: Mapping[int, Sign]
    all_way_nodes: frozenset[int]


def sign_of(tags: Mapping[str, str]) -> Sign | None:
    """Return the sign that a node's tags speak of; None for signals that are not a junction's."""
    value = tags.get("highway", "")
    if value not in _SIGNS:
        return None
    if value == Sign.SIGNALS.value and tags.get("traffic_signals") in _OTHER_SIGNALS:
        return None
    return Sign(value)


def read_signs(network: StreetNetwork) -> Signs:
    """Find the signs of all street ends.

    A sign inside a street is meant for the end that ``direction`` names, else for the only end that traffic comes
    to, else for the nearer one, as long as that is within `SIGN_REACH`. Of several the one nearest to the end counts.
    """
    signed = {node: sign for node, tags in network.node_tags.items() if (sign := sign_of(tags)) is not None}
    all_way = {node for node in signed if network.node_tags[node].get("stop") in _ALL_WAY}
    meeting = {node.osm_node_id for node in network.intersections}
    before: dict[int, tuple[float, Sign, int]] = {}
    for street, place in _on_streets(network, signed.keys() - meeting):
        node = int(street.node_ids[place])
        distance = _distances(street, place)
        for end in _meant(street, place, network.node_tags[node], distance):
            if distance[end] <= defaults.SIGN_REACH:
                key = 2 * street.id + end
                before[key] = min(before.get(key, (np.inf, Sign.STOP, 0)), (distance[end], signed[node], node))
    at_nodes = {node: sign for node, sign in signed.items() if node in meeting}
    return Signs(
        before_end={end: sign for end, (_, sign, _) in sorted(before.items())},
        all_way=frozenset(end for end, (_, _, node) in before.items() if node in all_way),
        nodes=at_nodes,
        all_way_nodes=frozenset(all_way & at_nodes.keys()),
    )


def _on_streets(network: StreetNetwork, nodes: set[int]) -> list[tuple[Street, int]]:
    """Return (street, index of the node) of every place where one of the nodes lies inside a street."""
    wanted = np.array(sorted(nodes), np.int64)
    if not len(wanted):
        return []
    start = np.concatenate([[0], np.cumsum([len(street.node_ids) for street in network.streets])])
    every = np.concatenate([street.node_ids for street in network.streets])
    rows = np.flatnonzero(np.isin(every, wanted))
    owner = np.searchsorted(start, rows, side="right") - 1
    return [
        (network.streets[street], row - int(start[street]))
        for street, row in zip(owner.tolist(), rows.tolist(), strict=True)
    ]


def _distances(street: Street, place: int) -> tuple[float, float]:
    """Return how far a node is from the street's start and end along it, m."""
    step = np.hypot(*np.diff(street.points, axis=0).T)
    return float(step[:place].sum()), float(step[place:].sum())


def _meant(street: Street, place: int, tags: Mapping[str, str], distance: tuple[float, float]) -> tuple[int, ...]:
    """Return the ends (0 start, 1 end) that a sign inside a street is meant for."""
    attributes = next(item for first, item in reversed(street.pieces) if first <= place)
    text = tags.get("traffic_signals:direction") or tags.get("direction", "")
    if text == "both":
        return 0, 1
    if text in _ALONG:
        return (int(_ALONG[text] != attributes.reversed),)
    runs = attributes.car_directions()
    if Direction.BOTH not in runs and len(runs) == 1:
        return (int(Direction.FORWARD in runs),)
    return (int(distance[1] < distance[0]),)
