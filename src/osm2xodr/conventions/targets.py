"""Readers of OpenDRIVE that a file can be written for, and what they differ in.

Imports nothing heavy: the command line reads it before it knows what to do.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import Final


class Crosswalks(Enum):
    """Where the corners of crosswalks are given.

    The standard has ``<outlines>`` (since 1.5, ASAM OpenDRIVE 1.7, 13.4), which esmini reads alone
    (``RoadManager.cpp``). CARLA 0.9.16 sees but the older ``<outline>``, and misplaces it
    (`osm2xodr.xodrWriter.crosswalk_offsets`). All schemas allow both in one object.
    """

    STANDARD = "outlines as the standard says"
    CARLA = "an outline where CARLA takes it for the right place"
    BOTH = "both"


@dataclass(frozen=True, slots=True)
class Target:
    """What one reader wants.

    Three things that readers differ in need no choice, for what one demands the others take: every signal has a
    ``<validity>``, for CARLA (``MapBuilder.cpp``) takes the lanes of the *other* direction where there is none; it
    has ``dynamic``, without which SUMO reads nothing; it is within its road, or esmini ends.
    """

    name: str  # Of the option
    # Whether signs have the codes of their own country everywhere; else those that CARLA and esmini know
    own_codes: bool = False
    # Whether the subtype of a speed limit sign is the number on it, as CARLA wants; esmini knows types alone then
    value_in_subtype: bool = True
    # Types of lanes that it takes for something else, and what to write instead. SUMO lets cars drive on lanes for
    # parking, at 5 km/h (SUMO's documentation, Networks/Import/OpenDRIVE; measured with 1.28); CARLA and esmini know
    # them for what they are.
    lane_types: tuple[tuple[str, str], ...] = ()
    # Where it looks for the corners of crosswalks. 1.4 has no place for both: there, BOTH is STANDARD.
    crosswalks: Crosswalks = Crosswalks.STANDARD
    # Whether connecting roads refer to the lights that govern them: CARLA finds them by that; SUMO does without, and
    # takes some for lights of the next junction (measured with netconvert 1.28).
    light_references: bool = True
    lights_for_people: bool = True  # Whether crossings have lights for people; SUMO takes them for lights for cars
    # Whether ``laneChange`` of road marks is named as drivers see it. The standard has ``increase`` and ``decrease``
    # mean towards higher and lower lane ids (ASAM OpenDRIVE 1.8, road markings). CARLA 0.9.16 makes ``Right`` and
    # ``Left`` of them (``LaneMarking.lane_change``, which its route planner asks), which is the same for lanes above
    # 0, but the opposite for those below; on the centre line one word lets both directions cross, the other none.
    # Measured with its client, for traffic on either side. Its ``Waypoint.lane_change`` is wrong about marks that
    # only one side may cross under either word.
    changes_as_driven: bool = False


# The default suits CARLA, esmini and SUMO alike.
DEFAULT_TARGET: Final = "generic"
TARGETS: Final[Mapping[str, Target]] = MappingProxyType(
    {
        item.name: item
        for item in (
            Target(DEFAULT_TARGET, crosswalks=Crosswalks.BOTH),
            Target("carla", crosswalks=Crosswalks.CARLA, changes_as_driven=True),
            Target("esmini", value_in_subtype=False),
            Target("sumo", lane_types=(("parking", "shoulder"),), light_references=False, lights_for_people=False),
            Target("roadrunner", own_codes=True),
        )
    }
)
