"""Lamps, trees and bollards beside roads."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Final

import numpy as np

from osm2xodr.diagnostics import Kind
from osm2xodr.furniture import defaults
from osm2xodr.furniture.objects.barriers import size_of
from osm2xodr.furniture.world import RoadsideFinder, World
from osm2xodr.model import RoadObject, RoadsideKind, RoadsideThing

_TYPES: Final[Mapping[RoadsideKind, tuple[str, str, str]]] = {
    RoadsideKind.BOLLARD: ("pole", "bollard", "bollard"),
    RoadsideKind.GUARD_RAIL: ("barrier", "guardRail", "guard rail"),
    RoadsideKind.STREET_LAMP: ("streetLamp", "", "street lamp"),
    RoadsideKind.TREE: ("tree", "", "tree"),
}
# Kinds that are there on request only.
_ON_REQUEST: Final[Mapping[RoadsideKind, str]] = {RoadsideKind.STREET_LAMP: "lamps", RoadsideKind.TREE: "trees"}


def point_objects(world: World, finder: RoadsideFinder, things: Iterable[RoadsideThing]) -> list[RoadObject]:
    """Make the objects of single things beside roads.

    Parameters
    ----------
    world, finder
        The roads.
    things
        Those of `StreetNetwork.roadside` that may be of use.
    """
    chosen = [thing for thing in things if _wanted(world, thing)]
    if not chosen:
        return []
    rows = [(thing, x, y) for thing in chosen for x, y in _points(thing)]
    places = finder.places(np.array([x for _, x, _ in rows]), np.array([y for _, _, y in rows]))
    leftwards = places.t - places.left > places.right - places.t
    out: list[RoadObject] = []
    left_out: defaultdict[tuple[str, str], list[str]] = defaultdict(list)
    for k, (thing, _, _) in enumerate(rows):
        if places.road[k] < 0:
            why = f"no road lies within {defaults.OBJECT_REACH:g} m"
            left_out[thing.kind.value, why].append(thing.osm_id)
            continue
        width, height = size_of(thing)
        off = 0.5 * width + defaults.OBJECT_GAP
        if places.beyond[k] < -defaults.OBJECT_INSIDE:
            left_out[thing.kind.value, "they would stand on the carriageway"].append(thing.osm_id)
            continue
        t, left, right = float(places.t[k]), float(places.left[k]), float(places.right[k])
        t = max(t, left + off) if leftwards[k] else min(t, right - off)
        kind, subtype, name = _TYPES[thing.kind]
        out.append(
            RoadObject(
                id=world.ids.thing(),
                road=world.road_map.roads[int(places.road[k])].id,
                type=kind,
                subtype=subtype,
                name=name,
                s=float(places.s[k]),
                t=t,
                height=height,
                radius=0.5 * width,
                osm_id=thing.osm_id,
            )
        )
    for (kind, why), names in sorted(left_out.items()):
        noun = kind.replace("_", " ")
        world.diagnostics.count(Kind.DROPPED, "roadside-left-out", names, noun, f"left out: {why}")
    return out


def _wanted(world: World, thing: RoadsideThing) -> bool:
    if thing.kind not in _TYPES:
        return False
    extra = _ON_REQUEST.get(thing.kind)
    if extra is not None:
        return extra in world.options.extra_objects
    return len(thing.points) == 1


def _points(thing: RoadsideThing) -> list[tuple[float, float]]:
    """Return where a thing stands: rows of trees are mapped as lines."""
    points = thing.points
    if len(points) == 1:
        return [(float(points[0, 0]), float(points[0, 1]))]
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.linspace(0.0, along[-1], max(round(along[-1] / defaults.TREE_SPACING), 1) + 1)
    x, y = np.interp(at, along, points[:, 0]), np.interp(at, along, points[:, 1])
    return list(zip(x.tolist(), y.tolist(), strict=True))
