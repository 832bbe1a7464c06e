"""What kerbs and the same street before and behind tell of the carriageways of ways."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from osm2xodr.osmParsing.file import RawWay
from osm2xodr.osmParsing.roadside.kerbs import WayPieces
from osm2xodr.osmParsing.roadside.parking_pauses import parking_pauses
from osm2xodr.osmParsing.tags import Kerbs, StreetFacts


def street_facts(ways: Sequence[RawWay], pieces: WayPieces, kerbs: Mapping[int, Kerbs]) -> dict[int, StreetFacts]:
    """Return what is known of ways, by index of the way; those of which nothing is known are left out.

    `pieces` are those of the `ways`, `kerbs` those along ways, by index.
    """
    pauses = parking_pauses(ways, pieces, kerbs)
    return {
        index: StreetFacts(kerbs.get(index), no_parking=pauses.get(index, (0.0, 0.0)))
        for index in sorted(kerbs.keys() | pauses.keys())
    }
