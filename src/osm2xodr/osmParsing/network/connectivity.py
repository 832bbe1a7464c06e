"""Relations that say which lane leads to which become `LaneConnectivity` (OSM wiki, Relation:connectivity)."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Final

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import LaneConnectivity
from osm2xodr.osmParsing.defaults import LANES_PLAUSIBLE_MAX
from osm2xodr.osmParsing.file import RawRelation, RawWay
from osm2xodr.osmParsing.network.relation_members import find_members

_CODE: Final = "connectivity"
_LANE: Final = re.compile(r"\d{1,3}", re.ASCII)
_OPTIONAL: Final = re.compile(r"\(([^()]*)\)")


def read_connectivities(
    relations: Sequence[RawRelation],
    ways: Sequence[RawWay],
    same_node: Mapping[int, int],
    diagnostics: Diagnostics,
) -> tuple[LaneConnectivity, ...]:
    """Read the relations that connect lanes.

    Parameters
    ----------
    relations
        What to read; others than connectivity relations are passed over.
    ways
        The ways that are carried; relations that need others are left out.
    same_node
        Ids of nodes that others stand for.
    diagnostics
        Gets what is left out.
    """
    carried = {way.id: way for way in ways}
    found: list[LaneConnectivity] = []
    for relation in relations:
        if relation.tags.get("type") != "connectivity":
            continue
        connectivity = _connectivity(relation, carried, same_node)
        if isinstance(connectivity, str):
            words = f"the connectivity {connectivity} and is not applied"
            diagnostics.dropped(_CODE, f"relation/{relation.id}", words)
        else:
            found.append(connectivity)
    return tuple(found)


def _connectivity(
    relation: RawRelation, carried: Mapping[int, RawWay], same_node: Mapping[int, int]
) -> LaneConnectivity | str:
    """Return what a relation says, or a few words on why it cannot be used."""
    lanes = parse_connectivity(relation.tags.get("connectivity", ""))
    if isinstance(lanes, str):
        return lanes
    members = find_members(relation, carried, same_node)
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

    Returns
    -------
    tuple of (int, int, bool), or str
        (from lane, to lane, whether optional) in ascending order, each once; a few words where the value cannot be
        used.
    """
    found: dict[tuple[int, int], bool] = {}
    if not text.strip():
        return "names no lanes"
    for entry in text.split("|"):
        source, colon, targets = entry.partition(":")
        from_lane = _lane(source)
        if not colon or from_lane is None:
            return _unread(text)
        # Brackets stand round one lane or round several.
        optional = [part for group in _OPTIONAL.findall(targets) for part in group.split(",")]
        certain = [part for part in _OPTIONAL.sub("", targets).split(",") if part.strip()]
        if not optional and not certain:
            return _unread(text)
        for parts, is_optional in ((optional, True), (certain, False)):
            for part in parts:
                to_lane = _lane(part)
                if to_lane is None:
                    return _unread(text)
                found[from_lane, to_lane] = is_optional and found.get((from_lane, to_lane), True)
    return tuple((one, other, is_optional) for (one, other), is_optional in sorted(found.items()))


def _lane(text: str) -> int | None:
    text = text.strip()
    number = int(text) if _LANE.fullmatch(text) else 0
    return number if 1 <= number <= LANES_PLAUSIBLE_MAX else None


def _unread(text: str) -> str:
    # ``bw`` marks lanes against the direction of travel.
    what = "names lanes against the direction of travel" if "bw" in text else "is not understood"
    return f"{text!r} {what}"
