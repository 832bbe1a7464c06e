"""Who takes part in a relation about what one may do from one way to another: from, via and to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from osm2xodr.osmParsing.file import RawRelation, RawWay


@dataclass(frozen=True, slots=True)
class RelationMembers:
    """Members of a relation that holds together."""

    # from_ways, to_ways: OSM way ids; at least one of each
    from_ways: tuple[int, ...]
    via_node: int | None  # OSM node id, or None where the via members are ways
    via_ways: tuple[int, ...]  # OSM way ids in the relation's order; empty with a via node
    to_ways: tuple[int, ...]


def find_members(
    relation: RawRelation, carried: Mapping[int, RawWay], same_node: Mapping[int, int]
) -> RelationMembers | str:
    """Return the members of a relation, or a few words on why it cannot be used.

    Parameters
    ----------
    relation
        The relation.
    carried
        The ways that become streets, by id; relations that need others cannot be used.
    same_node
        Ids of nodes that others stand for.
    """
    ways: dict[str, tuple[int, ...]] = {}
    missing: dict[str, bool] = {}
    for role in ("from", "via", "to"):
        members = [member.ref for member in relation.members if member.role == role and member.type == "way"]
        ways[role] = tuple(ref for ref in members if ref in carried)
        missing[role] = len(ways[role]) < len(members)
    nodes = [member.ref for member in relation.members if member.role == "via" and member.type == "node"]
    if not ways["from"] or not ways["to"] or missing["via"]:
        return "needs ways that are absent or left out" if any(missing.values()) else "lacks a from or to member"
    if len(nodes) + (1 if ways["via"] else 0) != 1:
        return f"has {len(nodes) or 'no'} via nodes"
    if not nodes:
        return RelationMembers(ways["from"], None, ways["via"], ways["to"])
    apart = [ref for ref in (*ways["from"], *ways["to"]) if nodes[0] not in carried[ref].refs]
    if apart:
        return f"is via a node that is not on way {apart[0]}"
    return RelationMembers(ways["from"], same_node.get(nodes[0], nodes[0]), (), ways["to"])
