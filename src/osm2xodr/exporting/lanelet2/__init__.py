"""Road networks as maps of Lanelet2: OSM XML as its own library, Autoware and CommonRoad read it.

Lanes are cut into strips along which nothing changes, their ends joined where lanes are linked, so that lanelets
follow each other in Lanelet2's routing graph exactly where lanes do in OpenDRIVE. Neighbours share their bound.
Written after the documents of Lanelet2 (Poggenhans et al., Lanelet2: A high-definition map framework, ITSC 2018).
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from osm2xodr.errors import InputError
from osm2xodr.exporting.lanelet2.document import (
    GAP_REPORTED,
    LANELETS,
    LOCAL,
    PROJECTORS as PROJECTORS,
    Primitives,
    mark_of as mark_of,
    place,
    projector_info as projector_info,
    write_document,
)
from osm2xodr.exporting.lanelet2.lanelets import Ends, add_lanelets, join_ends
from osm2xodr.exporting.lanelet2.regulatory_elements import FurnitureMaker, add_priorities
from osm2xodr.exporting.lanelet2.strips import cut_into_strips
from osm2xodr.opendrive import ABSENT, OpenDrive
from osm2xodr.system import ByteSink


def write_lanelet2(
    file: OpenDrive, stream: ByteSink, tolerance: float, step: float, version: str, projector: str = LOCAL
) -> tuple[str, list[str]]:
    """Write a road network as a map of Lanelet2.

    `projector` is one of `PROJECTORS`: whether ``local_x`` and ``local_y`` of nodes are the coordinates of the file
    or those of a square of MGRS. For `tolerance` and `step`, m, see `osm2xodr.opendrive.sample_roads`. Returns the
    square, empty without one, and sentences about what was left out. `InputError` if no lane becomes a lanelet.
    """
    cut = cut_into_strips(file, tolerance, step)
    if not cut.strips:
        raise InputError(f"{file.path} has no lane that Lanelet2 knows; osm2xodr check lists what is wrong with it")
    ends = join_ends(cut)
    primitives = Primitives()
    placed = add_lanelets(cut, ends, primitives)
    furniture = FurnitureMaker(placed, primitives)
    furniture.add()
    add_priorities(placed, primitives, furniture)
    places, unknown = place(file, primitives.points(), projector)
    credit = file.provenance.get((-1, "attribution"), "")
    write_document(primitives, places, credit, version, stream)
    return places.square, [*([unknown] if unknown else []), *_left_out(file, ends, furniture)]


def _left_out(file: OpenDrive, ends: Ends, furniture: FurnitureMaker) -> list[str]:
    """Return sentences about what a map of Lanelet2 does not have."""
    out = []
    types = Counter(
        kind or "no type"
        for kind, number in zip(file.lanes.type, file.lanes.id.tolist(), strict=True)
        if number not in (0, ABSENT) and kind not in LANELETS
    )
    if types:
        names = ", ".join(f"{count} {kind}" for kind, count in sorted(types.items()))
        out.append(f"lanes that Lanelet2 has no lanelets for are left out: {names}")
    if furniture.left_out:
        names = ", ".join(f"{count} {what}" for what, count in sorted(furniture.left_out.items()))
        out.append(f"left out because they hold for no lanelet or have no usable place: {names}")
    wide = int(np.count_nonzero(ends.gap > GAP_REPORTED))
    if wide:
        out.append(f"{wide} ends of linked lanes lie up to {ends.gap.max():.2f} m apart and meet in the middle")
    return out
