"""OSM's signs and signals before the ends of streets: ``highway=stop``, ``give_way``, ``traffic_signals`` on nodes.

Crossings with lights count as signals of their junction.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final

import numpy as np

from osm2xodr.conventions import defaults
from osm2xodr.defaults import SIGN_REACH, SIGNALLED_CROSSING_REACH
from osm2xodr.model import Direction, Street, StreetNetwork

# Least share of a junction's entries with a signal for a signalled junction; a choice.
_SIGNALLED_SHARE: Final = 0.5


class Sign(str, Enum):
    """Regulation of the traffic that arrives at a street's end, in OSM's words."""

    STOP = "stop"
    GIVE_WAY = "give_way"
    SIGNALS = "traffic_signals"


class Light(str, Enum):
    """The purpose of lights on a node.

    ``ROAD`` lights are away from junctions and crossings (ramp meters, tunnels, fire stations), ``OTHER`` ones do not
    let cars go.
    """

    JUNCTION = "junction"
    CROSSING = "crossing"
    ROAD = "road"
    OTHER = "other"


_SIGNS: Final = frozenset(sign.value for sign in Sign)
# Signals that are not those of a junction (OSM wiki, Key:traffic_signals).
_SPECIAL_LIGHTS: Final = {
    **dict.fromkeys(("pedestrian_crossing", "crossing"), Light.CROSSING),
    **dict.fromkeys(("tunnel", "ramp_meter", "emergency", "bottleneck", "bridge"), Light.ROAD),
    **dict.fromkeys(("level_crossing", "blinker", "blink_mode", "no"), Light.OTHER),
}
_ALL_WAY: Final = frozenset({"all", "4-way", "4way"})
_ALONG: Final = {"forward": True, "backward": False}
_COMPASS: Final = re.compile(r"\d+(?:\.\d+)?")
# A sign that faces within 20 degrees of straight across the street tells no direction: the sine of that angle. A
# choice.
_FACING_MIN: Final = 0.34


@dataclass(frozen=True, slots=True)
class Signs:
    """Signs of a street network. Street ends are numbered 2 x street, plus 1 for its end."""

    before_end: Mapping[int, Sign]  # Signs for traffic that arrives at a street end
    all_way: frozenset[int]  # Street ends where all arms have to stop
    nodes: Mapping[int, Sign]  # Signs on nodes where streets meet, which name no arm, by OSM node id
    all_way_nodes: frozenset[int]  # Those of these nodes where all arms have to stop
    ends_of: Mapping[int, tuple[int, ...]]  # Street ends that the sign on a node inside a street applies to

    def signalled(self, nodes: Collection[int], entries: Sequence[int]) -> bool:
        """Whether a junction has signals: on its nodes (OSM ids), or before enough of its entries (street ends)."""
        if any(self.nodes.get(node) is Sign.SIGNALS for node in nodes):
            return True
        count = sum(self.before_end.get(end) is Sign.SIGNALS for end in entries)
        return count > 0 and count >= _SIGNALLED_SHARE * len(entries)


def light_of(tags: Mapping[str, str]) -> Light | None:
    """Return the purpose of a node's lights; None if it has none."""
    crossing = tags.get("crossing") == "traffic_signals" or tags.get("crossing:signals") == "yes"
    if tags.get("highway") == "traffic_signals":
        return _SPECIAL_LIGHTS.get(tags.get("traffic_signals", ""), Light.JUNCTION)
    return Light.CROSSING if crossing else None


def sign_of(tags: Mapping[str, str]) -> Sign | None:
    """Return the sign on a node by its tags; None without one, or for signals that are not a junction's."""
    value = tags.get("highway", "")
    if value in _SIGNS and value != Sign.SIGNALS.value:
        return Sign(value)
    return Sign.SIGNALS if light_of(tags) in (Light.JUNCTION, Light.CROSSING) else None


def stops_all(tags: Mapping[str, str]) -> bool:
    """Whether a stop sign, by the tags of its node, applies to all arms of its junction."""
    return tags.get("stop") in _ALL_WAY


def priority_rank(highway: str) -> int:
    """Return the rank of a road of a class of OSM (`PRIORITY_RANK`) among those that it meets."""
    if highway.endswith("_link"):
        return defaults.PRIORITY_RANK_LINK
    return defaults.PRIORITY_RANK.get(highway, defaults.PRIORITY_RANK_OTHER)


def read_signs(network: StreetNetwork) -> Signs:
    """Find the signs of all street ends.

    A sign inside a street applies to the end that ``direction`` names, else to the only end that traffic arrives at,
    else to the one whose traffic it faces, else to the nearer one, if that is within `SIGN_REACH`. Of several signs
    the one nearest to the end counts. Lights of a crossing apply to the nearer end if traffic arrives there and it is
    within `SIGNALLED_CROSSING_REACH`.
    """
    signed = {node: sign for node, tags in network.node_tags.items() if (sign := sign_of(tags)) is not None}
    all_way = {node for node in signed if stops_all(network.node_tags[node])}
    meeting = {node.osm_node_id for node in network.intersections}
    before: dict[int, tuple[bool, float, Sign, int]] = {}
    ends_of: dict[int, list[int]] = defaultdict(list)
    for street, place in _on_streets(network, signed.keys() - meeting):
        node = int(street.node_ids[place])
        tags = network.node_tags[node]
        distance = _distances(street, place)
        crossing = light_of(tags) is Light.CROSSING
        reach = SIGNALLED_CROSSING_REACH if crossing else SIGN_REACH
        for end in _ends_of_sign(street, place, tags, distance, crossing):
            if distance[end] <= reach:
                key = 2 * street.id + end
                ends_of[node].append(key)
                # A sign of the junction itself takes precedence over a crossing.
                found = (crossing, distance[end], signed[node], node)
                before[key] = min(before.get(key, found), found)
    # Lights of a crossing on a node where streets meet belong to one of the arms.
    at_nodes = {
        node: sign
        for node, sign in signed.items()
        if node in meeting and light_of(network.node_tags[node]) is not Light.CROSSING
    }
    return Signs(
        before_end={end: sign for end, (_, _, sign, _) in sorted(before.items())},
        all_way=frozenset(end for end, (_, _, _, node) in before.items() if node in all_way),
        nodes=at_nodes,
        all_way_nodes=frozenset(all_way & at_nodes.keys()),
        ends_of={node: tuple(ends) for node, ends in sorted(ends_of.items())},
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
    """Return the distances of a node from the street's start and end along it, m."""
    step = np.hypot(*np.diff(street.points, axis=0).T)
    return float(step[:place].sum()), float(step[place:].sum())


def _ends_of_sign(
    street: Street, place: int, tags: Mapping[str, str], distance: tuple[float, float], crossing: bool
) -> tuple[int, ...]:
    """Return the ends (0 start, 1 end) that a sign inside a street applies to."""
    attributes = street.attributes_at(place)
    runs = attributes.car_directions()
    nearer = int(distance[1] < distance[0])
    if crossing:
        towards = Direction.FORWARD if nearer else Direction.BACKWARD
        return (nearer,) if towards in runs or Direction.BOTH in runs else ()
    text = tags.get("traffic_signals:direction") or tags.get("direction", "")
    if text == "both":
        return 0, 1
    if text in _ALONG:
        return (int(_ALONG[text] != attributes.reversed),)
    if Direction.BOTH not in runs and len(runs) == 1:
        return (int(Direction.FORWARD in runs),)
    faced = _faced(street, place, text)
    return (nearer,) if faced is None else (faced,)


def _faced(street: Street, place: int, text: str) -> int | None:
    """Return the end at which the traffic arrives that a sign faces, given its direction in degrees from north.

    None if that is not a number, or the sign faces the side of the street.
    """
    if not _COMPASS.fullmatch(text):
        return None
    step = street.points[min(place + 1, len(street.points) - 1)] - street.points[max(place - 1, 0)]
    angle = np.deg2rad(float(text))
    against = float(step[0] * np.sin(angle) + step[1] * np.cos(angle))
    return None if abs(against) < _FACING_MIN * float(np.hypot(*step)) else int(against < 0.0)


def signed_ends(street: Street, place: int, tags: Mapping[str, str]) -> tuple[int, ...]:
    """Return the ends (0 start, 1 end) of a street that a stop or give-way sign on one of its nodes applies to.

    `place` is the index of the node in the street, `tags` are those of the node.
    """
    return _ends_of_sign(street, place, tags, _distances(street, place), crossing=False)


def signed_direction(tags: Mapping[str, str]) -> bool | None:
    """Whether a sign is for traffic along its way (False: against it); None if it may be for both."""
    return _ALONG.get(tags.get("traffic_signals:direction") or tags.get("direction", ""))
