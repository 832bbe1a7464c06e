"""What kerbs and the same street before and behind tell of the carriageways of ways."""

from __future__ import annotations

from collections.abc import Sequence, Set as AbstractSet

from osm2xodr.model import FloatArray
from osm2xodr.osmParsing.file import RawNodes, RawWay
from osm2xodr.osmParsing.roadside.kerbs import WayPieces, kerbs_along
from osm2xodr.osmParsing.roadside.parking_pauses import parking_pauses
from osm2xodr.osmParsing.tags import StreetFacts


def street_facts(
    ways: Sequence[RawWay],
    pieces: WayPieces,
    beside: Sequence[RawWay],
    nodes: RawNodes,
    points: FloatArray,
    without: AbstractSet[int],
) -> dict[int, StreetFacts]:
    """Return what is known of ways, by index of the way; those of which nothing is known are left out.

    `pieces` are those of the `ways`; `beside` other ways, among them kerbs; `points` (k, 2) the local x, y of the
    `nodes`, m. Kerbs along ways whose OSM id is in `without` tell nothing.
    """
    kerbs = kerbs_along(ways, pieces, beside, nodes, points, without)
    pauses = parking_pauses(ways, pieces.way_lengths(len(ways)), kerbs)
    return {
        index: StreetFacts(kerbs.get(index), no_parking=pauses.get(index, (0.0, 0.0)))
        for index in sorted(kerbs.keys() | pauses.keys())
    }
