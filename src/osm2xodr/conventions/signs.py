"""The numbers that countries give their traffic signs (keys of ``sign_codes.json``), and signs before street ends.

These are highway=stop, give_way and traffic_signals on nodes.
"""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr.conventions import countries
from osm2xodr.curves import cosine, hypot, sine, starts
from osm2xodr.defaults import SIGN_REACH, SIGNALLED_CROSSING_REACH
from osm2xodr.model import Direction, Facing, Light, Sign, Street, StreetNetwork
from osm2xodr.system import record

# The country whose numbers are written unless a reader wants those of the country where the sign stands.
COMMON: Final = "DE"
NO_SUBTYPE: Final = "-1"
_VALUE: Final = r"(\d+(?:[.,]\d+)?)"
# VzKat before 2017: 274-53 is a limit of 30 km/h.
_OLD_GERMAN_SPEEDS: Final = range(51, 60)

# Least share of a junction's entries with a signal for a signalled junction; a choice.
_SIGNALLED_SHARE: Final = 0.5
# Signs that look within 20 degrees, by their sine, of across a street are for neither of its directions; a choice.
_ACROSS_SINE: Final = 0.34


@record
class SignCode:
    """Type, subtype and country as OpenDRIVE wants them."""

    type: str
    subtype: str
    country: str


@record
class _Catalogue:
    """The signs of a country."""

    templates: Mapping[str, str]  # Codes by meaning; ``{}`` stands for the value on the sign, ``{tens}`` for a tenth
    meanings: Mapping[str, str]  # Meanings by code, of codes without a value
    valued: tuple[tuple[re.Pattern[str], str, float], ...]  # (pattern of a code with a value, meaning, factor)
    supplementary: re.Pattern[str] | None  # Codes of plates that add to the sign above them


_EMPTY: Final = _Catalogue({}, {}, (), None)


@cache
def _catalogues() -> Mapping[str, _Catalogue]:
    text = Path(__file__).with_name("sign_codes.json").read_text(encoding="utf-8")
    return {country: _catalogue(item) for country, item in json.loads(text)["countries"].items()}


def _catalogue(item: Mapping[str, Mapping[str, str]]) -> _Catalogue:
    templates = item["codes"]
    meanings: dict[str, str] = {}
    valued: list[tuple[re.Pattern[str], str, float]] = []
    for meaning, template in templates.items():
        if "{" not in template:
            meanings[_plain(template)] = meaning
            continue
        before, after = re.split(r"\{.*\}", template)
        factor = 10.0 if "{tens}" in template else 1.0
        valued.append((re.compile(re.escape(_plain(before)) + _VALUE + re.escape(after)), meaning, factor))
        if not after:
            meanings[_plain(before.removesuffix("-"))] = meaning
    meanings.update({_plain(code): meaning for code, meaning in item.get("also", {}).items()})
    pattern = str(item.get("supplementary", ""))
    return _Catalogue(templates, meanings, tuple(valued), re.compile(pattern) if pattern else None)


def _plain(code: str) -> str:
    """Normalise the spelling of a code: ``A01``, ``A-1`` and ``a1`` are the same."""
    return re.sub(r"^([A-Z]+)[ -]?0*(?=\d)", r"\1", code.strip().upper())


@cache
def sign_meanings() -> frozenset[str]:
    """Return all meanings of signs."""
    return frozenset(meaning for item in _catalogues().values() for meaning in item.templates)


def sign_meaning(country: str, code: str) -> tuple[str, float | None]:
    """Return the meaning of a country's code, empty where it is not known, and the value that the code contains.

    `country` is ISO 3166-1 alpha-2; `code` has neither the country nor a value in brackets.
    """
    catalogue, plain = _catalogues().get(country, _EMPTY), _plain(code)
    if plain in catalogue.meanings:
        return catalogue.meanings[plain], None
    for pattern, meaning, factor in catalogue.valued:
        found = pattern.fullmatch(plain)
        if found:
            return meaning, _value_shown(country, float(found[1].replace(",", ".")), factor)
    # An unknown number behind the hyphen is a variant of the same sign, such as its mirror image.
    return catalogue.meanings.get(re.sub(r"(?<=\d)-\d+$", "", plain), ""), None


def _value_shown(country: str, number: float, factor: float) -> float:
    if country == "DE" and number in _OLD_GERMAN_SPEEDS:
        return (number - 50.0) * 10.0
    # Codes with tens are also found with the whole number.
    return number * factor if number * factor <= 200.0 else number


def is_supplementary(country: str, code: str) -> bool:
    """Return whether a country's code is that of a plate that only adds to the sign above it."""
    pattern = _catalogues().get(country, _EMPTY).supplementary
    return pattern is not None and pattern.fullmatch(code.strip().upper()) is not None


def sign_code(
    meaning: str, value: float | None, country: str, *, own_codes: bool, value_in_subtype: bool
) -> SignCode | None:
    """Return the code to write for a sign with a meaning and a number on it; None where the meaning has none.

    `country` is where it stands, empty where that is not known. `own_codes` prefers its own numbers to the common
    ones; `value_in_subtype` makes the value on the sign the subtype of common numbers.
    """
    own = own_codes and meaning in _catalogues().get(country, _EMPTY).templates
    owner = country if own else COMMON
    template = _catalogues()[owner].templates.get(meaning)
    if template is None:
        return None
    if "{" in template:
        return _with_value(template, value, owner, in_subtype=value_in_subtype or own_codes)
    kind, _, variant = template.partition("-") if owner == COMMON else (template, "", "")
    return SignCode(kind, variant or NO_SUBTYPE, owner)


def _with_value(template: str, value: float | None, country: str, *, in_subtype: bool) -> SignCode:
    before, after = re.split(r"\{.*\}", template)
    kind = before.removesuffix("-")
    if value is None:
        return SignCode(kind, NO_SUBTYPE, country)
    number = f"{value / 10.0 if '{tens}' in template else value:g}"
    if after:
        return SignCode(f"{before}{number}{after}", NO_SUBTYPE, country)
    # esmini finds a sign with a value and the subtype -1 under no name.
    return SignCode(kind, number if in_subtype else "", country)


@record
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
