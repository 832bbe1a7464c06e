"""Cuts areas out of a map: complete ways, what stands beside them, and the relations about them.

A map is read once for all areas, in a few passes, and then once for every `_OPEN_MAX` of the files that are written.
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
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.osmParsing import open_osm_file

# So many files are open at a time; systems allow a process 256 or more.
_OPEN_MAX: Final = 200


def cut_areas(source: Path, requests: Sequence[CutRequest], diagnostics: Diagnostics) -> dict[str, int]:
    """Write parts of a map.

    Kept is all that a conversion looks at, with all tags: ways of any ``highway`` and what stands beside streets, if
    a node or a segment of them lies in the area, with all their nodes; nodes that stand for something by themselves;
    turn restrictions and lane connectivities about any of these ways, with all ways that they name.

    With a context it is also what is near (`defaults.BORDER_REACH` and `defaults.CONTEXT_REACH`), the streets that
    come near from end to end, what lies beside them (`defaults.CONTEXT_BESIDE`), and what is around their ends:
    whatever shapes a road that crosses a border is then the same on both sides of it.

    Parameters
    ----------
    source
        The map.
    requests
        What is cut out.
    diagnostics
        Gets what is worth telling.

    Returns
    -------
    dict
        By the requests' names: how many ways in the area become streets. Where there are none no file is written, and
        one that is there is removed.

    Raises
    ------
    InputError
        The map cannot be read.
    OutputError
        A cut cannot be written.
    """
    file = open_osm_file(source)
    driven = [Driven(request.ways, request.include_private) for request in requests]
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
    """Return west, south, east, north of what cars can drive on, degrees; east is above 180 across the antimeridian.

    Raises
    ------
    InputError
        The map cannot be read, or there is nothing to drive on.
    """
    found = read_source(open_osm_file(source), [Driven()], only_driven=True)
    if not len(found.node_ids):
        raise InputError(f"{source} has no way that cars can drive on; check the area that it covers")
    return projection.bounds_deg(*found.degrees())
