"""Cuts areas out of a map: complete ways, what stands beside them, and the relations about them.

A map is read once for all areas, in a few passes, and then once for every `_OPEN_MAX` files that are written.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from osm2xodr import projection
from osm2xodr.batch.cutting.choice import choose, make_plan
from osm2xodr.batch.cutting.source import Driven, read_source
from osm2xodr.batch.cutting.writing import Target, write_targets
from osm2xodr.batch.model import CutRequest
from osm2xodr.errors import InputError
from osm2xodr.osmParsing import open_osm_file

# Files that are open at a time; systems allow a process 256 or more.
_OPEN_MAX: Final = 200


def cut_areas(source: Path, requests: Sequence[CutRequest]) -> dict[str, int]:
    """Write parts of a map, and return the number of ways that become streets in each area, by the requests' names.

    A cut has all that a conversion reads, with all tags: ways of any ``highway`` and what stands beside streets, if
    a node or a segment of them lies in the area, with all their nodes; nodes that mean something by themselves; turn
    restrictions and lane connectivities about any of these ways, with all ways that they name. Where no way becomes a
    street no file is written, and an old one is removed.

    With a context it also has what is near the area, whole streets that come near it, and what lies beside them and
    around their ends (`choice` says how near): all that shapes a road across a border is the same on both sides.

    Raises
    ------
    InputError
        The map cannot be read.
    OutputError
        A cut cannot be written.
    """
    file = open_osm_file(source)
    driven = [Driven(request.ways, request.include_private, request.kept) for request in requests]
    plan = make_plan(read_source(file, driven), context=any(request.context for request in requests))
    counts: dict[str, int] = {}
    group: list[Target] = []
    for request, streets in zip(requests, driven, strict=True):
        choice = choose(plan, request, streets)
        counts[request.name] = choice.driven
        if choice.driven:
            group.append(Target(request.target, choice))
        else:
            request.target.unlink(missing_ok=True)
        if len(group) == _OPEN_MAX:
            write_targets(plan.source, group)
            group = []
    if group:
        write_targets(plan.source, group)
    return counts


def bounds_of(source: Path) -> tuple[float, float, float, float]:
    """Return west, south, east, north of all ways for cars, degrees; east is above 180 across the antimeridian.

    Raises
    ------
    InputError
        The map cannot be read, or there is nothing to drive on.
    """
    found = read_source(open_osm_file(source), [Driven()], only_driven=True)
    if not len(found.node_ids):
        raise InputError(f"{source} has no way that cars can drive on; check the area that it covers")
    return projection.bounds_deg(*found.degrees())
