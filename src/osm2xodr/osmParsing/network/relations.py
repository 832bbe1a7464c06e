"""Relations about the way from one street to another: turn restrictions and lane connectivity.

Both kinds have from, via and to members (OSM wiki, Relation:restriction and Relation:connectivity). Relations that
cannot be used are reported and left out.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Final

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import LaneConnectivity, TurnRestriction
from osm2xodr.osmParsing.defaults import LANES_PLAUSIBLE_MAX
from osm2xodr.osmParsing.file import RawRelation, RawWay
from osm2xodr.system import record

# Keys that hold for cars, the most specific first; the users that ``except`` may name; types of relations.
_CAR_KEYS: Final = ("restriction:motorcar", "restriction:motor_vehicle", "restriction:vehicle", "restriction")
_CARS: Final = frozenset({"motorcar", "motor_vehicle", "vehicle"})
_CAR_TYPES: Final = frozenset({"restriction", *(f"restriction:{user}" for user in _CARS)})
_TIMES: Final = ("day_on", "day_off", "hour_on", "hour_off")
_LANE: Final = re.compile(r"\d{1,3}", re.ASCII)
_OPTIONAL: Final = re.compile(r"\(([^()]*)\)")


def read_restrictions(
    relations: Sequence[RawRelation], ways: Sequence[RawWay], same_node: Mapping[int, int], diagnostics: Diagnostics
) -> tuple[TurnRestriction, ...]:
    """Read the turn restrictions that hold for cars at all times; others go to the diagnostics.

    Of `relations` of any type those are left out that need other ways than `ways`, which become streets. `same_node`
    has the ids of nodes that were joined with another, and the id of that one.
    """
    carried = {way.id: way for way in ways}
    found: list[TurnRestriction] = []
    for relation in relations:
        value = _restriction_for_cars(relation, diagnostics)
        if value is None:
            continue
        members = _find_members(relation, carried, same_node, only=value.startswith("only_"))
        if isinstance(members, str):
            diagnostics.dropped("restriction", f"relation/{relation.id}", f"{value} {members} and is not applied")
            continue
        found.append(
            TurnRestriction(
                osm_relation_id=relation.id,
                only=value.startswith("only_"),
                value=value,
                from_ways=members.from_ways,
                to_ways=members.to_ways,
                via_node=members.via_node,
                via_ways=members.via_ways,
            )
        )
    return tuple(found)


def forbids(restrictions: Sequence[TurnRestriction], from_way: int, to_way: int) -> bool:
    """Say whether restrictions via one node forbid to go on from one way to another there."""
    own = [item for item in restrictions if from_way in item.from_ways]
    orders = [item for item in own if item.only]
    ordered = not orders or any(to_way in item.to_ways for item in orders)
    return not ordered or any(to_way in item.to_ways for item in own if not item.only)


def read_connectivities(
    relations: Sequence[RawRelation], ways: Sequence[RawWay], same_node: Mapping[int, int], diagnostics: Diagnostics
) -> tuple[LaneConnectivity, ...]:
    """Read the relations that connect lanes; parameters as of `read_restrictions`."""
    carried = {way.id: way for way in ways}
    found: list[LaneConnectivity] = []
    for relation in relations:
        if relation.tags.get("type") != "connectivity":
            continue
        connectivity = _connectivity(relation, carried, same_node)
        if isinstance(connectivity, str):
            words = f"the connectivity {connectivity} and is not applied"
            diagnostics.dropped("connectivity", f"relation/{relation.id}", words)
        else:
            found.append(connectivity)
    return tuple(found)


@record
class _Members:
    """Members of a valid relation, as OSM ids; at least one from way."""

    from_ways: tuple[int, ...]
    via_node: int | None  # None where the via members are ways
    via_ways: tuple[int, ...]  # In the relation's order; empty with a via node
    to_ways: tuple[int, ...]  # At least one, unless `_find_members` was told otherwise


def _find_members(
    relation: RawRelation, carried: Mapping[int, RawWay], same_node: Mapping[int, int], *, only: bool = False
) -> _Members | str:
    """Return the members of a relation, or a few words on why it cannot be used.

    `only` says that it names the only way on. That may lie outside of the area or be left out: it closes all others
    just the same, if the from way ends there, so that there is no doubt who comes from it.
    """
    ways: dict[str, tuple[int, ...]] = {}
    missing: dict[str, bool] = {}
    for role in ("from", "via", "to"):
        members = [member.ref for member in relation.members if member.role == role and member.type == "way"]
        ways[role] = tuple(ref for ref in members if ref in carried)
        missing[role] = len(ways[role]) < len(members)
    nodes = [member.ref for member in relation.members if member.role == "via" and member.type == "node"]
    ending = all(nodes and nodes[0] in (carried[ref].refs[0], carried[ref].refs[-1]) for ref in ways["from"])
    no_to = not ways["to"] and not (only and missing["to"] and ending)
    if not ways["from"] or no_to or missing["via"]:
        return "needs ways that are absent or left out" if any(missing.values()) else "lacks a from or to member"
    if len(nodes) + (1 if ways["via"] else 0) != 1:
        return f"has {len(nodes) or 'no'} via nodes"
    if not nodes:
        return _Members(ways["from"], None, ways["via"], ways["to"])
    apart = [ref for ref in (*ways["from"], *ways["to"]) if nodes[0] not in carried[ref].refs]
    if apart:
        return f"is via a node that is not on way {apart[0]}"
    return _Members(ways["from"], same_node.get(nodes[0], nodes[0]), (), ways["to"])


def _restriction_for_cars(relation: RawRelation, diagnostics: Diagnostics) -> str | None:
    """Return the restriction that holds for cars at all times; None if there is none."""
    tags, osm_id = relation.tags, f"relation/{relation.id}"
    if tags.get("type") not in _CAR_TYPES:
        return None
    excepted = {user.strip() for user in tags.get("except", "").split(";")}
    value = next((tags[key] for key in _CAR_KEYS if key in tags), None)
    conditional = any(f"{key}:conditional" in tags for key in _CAR_KEYS) or any(key in tags for key in _TIMES)
    if excepted & _CARS or (value is None and not conditional):
        return None  # not about cars
    if conditional:
        diagnostics.note("restriction", osm_id, "holds at certain times only and is not applied")
        return None
    if value is None or not value.startswith(("no_", "only_")):
        diagnostics.dropped("restriction", osm_id, f"{value!r} is not a known restriction")
        return None
    return value


def _connectivity(
    relation: RawRelation, carried: Mapping[int, RawWay], same_node: Mapping[int, int]
) -> LaneConnectivity | str:
    """Return the connectivity of a relation, or a few words on why it cannot be used."""
    lanes = parse_connectivity(relation.tags.get("connectivity", ""))
    if isinstance(lanes, str):
        return lanes
    members = _find_members(relation, carried, same_node)
    if isinstance(members, str):
        return members
    if len(members.from_ways) != 1 or len(members.to_ways) != 1:
        return "has several from or to members"
    return LaneConnectivity(
        osm_relation_id=relation.id,
        from_way=members.from_ways[0],
        via_node=members.via_node,
        via_ways=members.via_ways,
        to_way=members.to_ways[0],
        lanes=lanes,
    )


def parse_connectivity(text: str) -> tuple[tuple[int, int, bool], ...] | str:
    """Read a value such as ``1:1|2:2,(3)``: lane of the from way, lanes of the to way, optional ones in brackets.

    Returns (from lane, to lane, whether optional) in ascending order, each once; a few words if it cannot be used.
    """
    found: dict[tuple[int, int], bool] = {}
    if not text.strip():
        return "names no lanes"
    # ``bw`` marks lanes against the direction of travel.
    what = "names lanes against the direction of travel" if "bw" in text else "is not understood"
    unusable = f"{text!r} {what}"
    for entry in text.split("|"):
        source, colon, targets = entry.partition(":")
        from_lane = _lane(source)
        if not colon or from_lane is None:
            return unusable
        # Brackets enclose one lane or several.
        optional = [part for group in _OPTIONAL.findall(targets) for part in group.split(",")]
        certain = [part for part in _OPTIONAL.sub("", targets).split(",") if part.strip()]
        if not optional and not certain:
            return unusable
        for parts, is_optional in ((optional, True), (certain, False)):
            for part in parts:
                to_lane = _lane(part)
                if to_lane is None:
                    return unusable
                found[from_lane, to_lane] = is_optional and found.get((from_lane, to_lane), True)
    return tuple((one, other, is_optional) for (one, other), is_optional in sorted(found.items()))


def _lane(text: str) -> int | None:
    """Read the number of a lane, from 1."""
    text = text.strip()
    number = int(text) if _LANE.fullmatch(text) else 0
    return number if 1 <= number <= LANES_PLAUSIBLE_MAX else None
