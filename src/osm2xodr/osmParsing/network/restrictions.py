"""Relations that restrict turns become `TurnRestriction` as far as they hold for cars at all times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import TurnRestriction
from osm2xodr.osmParsing.file import RawRelation, RawWay
from osm2xodr.osmParsing.network.relation_members import find_members

# OSM wiki, Relation:restriction: keys that hold for cars, the most specific first, and users it may except.
_CAR_KEYS: Final = ("restriction:motorcar", "restriction:motor_vehicle", "restriction:vehicle", "restriction")
_CARS: Final = frozenset({"motorcar", "motor_vehicle", "vehicle"})
_CAR_TYPES: Final = frozenset({"restriction", *(f"restriction:{user}" for user in _CARS)})
_TIMES: Final = ("day_on", "day_off", "hour_on", "hour_off")


def read_restrictions(
    relations: Sequence[RawRelation],
    ways: Sequence[RawWay],
    same_node: Mapping[int, int],
    diagnostics: Diagnostics,
) -> tuple[TurnRestriction, ...]:
    """Read the relations that restrict turns.

    Parameters
    ----------
    relations
        What to read.
    ways
        The ways that are carried; relations that need others are left out.
    same_node
        Ids of nodes that others stand for.
    diagnostics
        Gets what is left out.
    """
    carried = {way.id: way for way in ways}
    found = (_restriction(relation, carried, same_node, diagnostics) for relation in relations)
    return tuple(restriction for restriction in found if restriction is not None)


def _value(relation: RawRelation, diagnostics: Diagnostics) -> str | None:
    """Return the restriction for cars at all times; None if there is none."""
    tags, osm_id = relation.tags, f"relation/{relation.id}"
    if tags.get("type") not in _CAR_TYPES:
        return None
    excepted = {user.strip() for user in tags.get("except", "").split(";")}
    value = next((tags[key] for key in _CAR_KEYS if key in tags), None)
    conditional = any(f"{key}:conditional" in tags for key in _CAR_KEYS) or any(key in tags for key in _TIMES)
    if excepted & _CARS or (value is None and not conditional):
        return None  # it is not about cars
    if conditional:
        diagnostics.note("restriction", osm_id, "holds at times only and is not applied")
        return None
    if value is None or not value.startswith(("no_", "only_")):
        diagnostics.dropped("restriction", osm_id, f"{value!r} is no restriction that is known")
        return None
    return value


def _restriction(
    relation: RawRelation,
    carried: Mapping[int, RawWay],
    same_node: Mapping[int, int],
    diagnostics: Diagnostics,
) -> TurnRestriction | None:
    value = _value(relation, diagnostics)
    if value is None:
        return None
    members = find_members(relation, carried, same_node)
    if isinstance(members, str):
        diagnostics.dropped("restriction", f"relation/{relation.id}", f"{value} {members} and is not applied")
        return None
    return TurnRestriction(
        osm_relation_id=relation.id,
        only=value.startswith("only_"),
        value=value,
        from_ways=members.from_ways,
        to_ways=members.to_ways,
        via_node=members.via_node,
        via_ways=members.via_ways,
    )
