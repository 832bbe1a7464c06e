"""Readers of OpenDRIVE that a file can be written for, and their differences.

Imports nothing heavy, as the command line needs it first.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from pathlib import Path
from types import MappingProxyType
from typing import Final

from osm2xodr.system import record


class Crosswalks(Enum):
    """The element with the corners of crosswalks.

    The standard has ``<outlines>`` (since 1.5, ASAM OpenDRIVE 1.7, 13.4), the only one that esmini reads
    (``RoadManager.cpp``). CARLA 0.9.16 reads only the older ``<outline>``, and misplaces it
    (`osm2xodr.xodrWriter.furniture_text`). All schemas allow both in one object.
    """

    STANDARD = "outlines as the standard says"
    CARLA = "an outline that CARLA puts at the right place"
    BOTH = "both"


@record
class Target:
    """The requirements of one reader.

    Three requirements suit all readers and are always met: every signal has a ``<validity>``, as CARLA
    (``MapBuilder.cpp``) otherwise takes the lanes of the *other* direction; it has ``dynamic``, without which SUMO
    ignores it; and it lies within its road, as esmini otherwise terminates.
    """

    name: str  # Value of the option
    # Whether all signs have the codes of their own country; else those that CARLA and esmini know
    own_codes: bool = False
    # Whether the subtype of a speed limit sign is the number on it, as CARLA wants; esmini then knows only the type,
    # and wants an empty one
    value_in_subtype: bool = True
    # Types of lanes that it misunderstands, and their replacements. SUMO lets cars drive on lanes for parking, at
    # 5 km/h (SUMO's documentation, Networks/Import/OpenDRIVE; measured with 1.28); CARLA and esmini do not. esmini
    # 3.6 finds no lane where there is one for buses. SUMO's netconvert leaves out lanes for buses and taxis and gives
    # their ways through junctions to the outermost lane for cars; as lanes for all with an ``<access>`` it knows them
    # (measured with 1.28).
    lane_types: tuple[tuple[str, str], ...] = ()
    # Where it looks for the corners of crosswalks; in version 1.4, BOTH is written as STANDARD
    crosswalks: Crosswalks = Crosswalks.STANDARD
    # Whether connecting roads refer to the lights that govern them: CARLA needs this; SUMO does not, and takes some
    # for lights of the next junction (measured with netconvert 1.28); esmini does not support them, and says so
    light_references: bool = True
    # Whether objects name their elements of OSM; esmini knows other user data of objects alone, and says so of each
    object_ids: bool = True
    # Whether lights apart from junctions have controllers. CARLA never switches the lights of a controller that no
    # junction names, while those without one get a group each (``TrafficLightManager.cpp``,
    # ``RegisterLightComponentFromOpenDRIVE``).
    controllers_apart: bool = True
    lights_for_people: bool = True  # Whether crossings have lights for people; SUMO takes them for lights for cars
    # Whether ``laneChange`` of road marks is as drivers see it. In the standard, ``increase`` and ``decrease`` mean
    # towards higher and lower lane ids (ASAM OpenDRIVE 1.8, road markings). CARLA 0.9.16 takes them for ``Right`` and
    # ``Left`` (``LaneMarking.lane_change``, which its route planner uses): the same for lanes above 0, the opposite
    # for those below; on the centre line one word lets both directions cross, the other none. Measured with its
    # client, for both driving sides. Its ``Waypoint.lane_change`` is wrong with either word about marks that only one
    # side may cross.
    changes_as_driven: bool = False
    # Whether connecting roads have marks of type ``none``. They are most of all marks, and say nothing, except to
    # CARLA: without them `Waypoint.left_lane_marking` is None there, and `lane_change` is ``Both`` although there is
    # no other lane for cars (``Waypoint.cpp``; measured with its client).
    marks_in_junctions: bool = False
    # Whether lane ids of left-hand networks are negated. SUMO's netconvert ignores ``rule``: it takes lanes of
    # negative ids for those along s, and `--lefthand` puts them on the left (measured with 1.28; its own export of
    # left-hand networks does the same, option ``opendrive-output.lefthand-left``).
    negated_left_hand: bool = False
    # Whether signals have one range of lanes at most, with those for bicycles between lanes for cars. SUMO's
    # netconvert reads the last range alone (1.28), and guesses which lights the other lanes have.
    one_validity: bool = False
    # Whether signs that say who yields are added where the map has none. SUMO's netconvert does not read
    # ``<priority>``; the last sign 205, 301 or 306 of a road's direction in the file gives the priority of that edge
    # (``NIImporter_OpenDrive::OpenDriveEdge::getPriority``, 1.28).
    priority_signs: bool = False
    # Distance of the points of polylines that it makes of reference lines, from the start of each record, m; 0 if it
    # makes none. SUMO moves such lines to the lanes (``opendrive.curve-resolution``).
    polyline_step: float = 0.0
    # Whether signal programmes are made: for SUMO's netconvert, which would guess them, as it reads no controllers by
    # default and OpenDRIVE has no times; and for scenarios of esmini.
    programmes: bool = False
    # The command that loads a file, and what it needs where traffic drives on the left and on the right; empty if
    # there is none to say. SUMO's netconvert cuts roads that part at acute angles by up to 50 m, but for
    # `--junctions.endpoint-shape`. It draws its own paths through junctions, on which cars that wait to turn touch
    # others; ours it takes on demand, but does not mirror them with `--lefthand` (all measured with 1.28).
    command: str = ""
    left_hand_option: str = ""
    right_hand_option: str = ""
    programmes_option: str = ""  # With which programmes are read that are written beside the file; empty for none

    def load_command(self, path: str, *, left_hand: bool, programmes: bool = False) -> str:
        """Return the command that loads a file, with signal programmes beside it or without; empty for none.

        The path is quoted for a shell.
        """
        stem, quote = path.removesuffix("'").removesuffix(".xodr"), "'" * path.endswith("'")
        lights = f" {self.programmes_option} {stem}{_PROGRAMMES}{quote}" if programmes else ""
        side = self.left_hand_option if left_hand else self.right_hand_option
        side = f" {side}" if side else ""
        return self.command.format(path=path, net=f"{stem}.net.xml{quote}", side=side, lights=lights)


# What the file with signal programmes has in place of ``.xodr``, as SUMO calls such files.
_PROGRAMMES: Final = ".tll.xml"
# How such files begin, so that one whose OpenDRIVE file is replaced is known for ours.
PROGRAMMES_HEAD: Final = '<?xml version="1.0" encoding="UTF-8"?>\n<!-- osm2xodr: belongs to the file beside it -->\n'


def programmes_file(path: Path) -> Path:
    """Return the file for the signal programmes that belong to an OpenDRIVE file."""
    return path.with_name(path.name.removesuffix(".xodr") + _PROGRAMMES)


# What reference lines consist of: with spirals, the default, curvature is continuous; or lines and arcs alone.
SPIRALS: Final = "spirals"
PLANS: Final = (SPIRALS, "arcs")

# Where the cross slope of motorways and trunk roads comes from: an elevation model of the ground with cells of 2 m
# and less, elsewhere what roads are designed with; such a model alone; or roads are level across.
MEASURED: Final = "model"
NO_SUPERELEVATION: Final = "none"
SUPERELEVATION: Final = ("auto", MEASURED, NO_SUPERELEVATION)

# The default suits CARLA, esmini and SUMO alike.
DEFAULT_TARGET: Final = "generic"
TARGETS: Final[Mapping[str, Target]] = MappingProxyType(
    {
        item.name: item
        for item in (
            Target(DEFAULT_TARGET, crosswalks=Crosswalks.BOTH, controllers_apart=False),
            Target(
                "carla",
                crosswalks=Crosswalks.CARLA,
                controllers_apart=False,
                changes_as_driven=True,
                marks_in_junctions=True,
            ),
            Target(
                "esmini",
                value_in_subtype=False,
                # It draws shoulders as grass, and lanes of type stop as asphalt.
                lane_types=(("bus", "restricted"), ("shoulder", "stop"), ("taxi", "restricted")),
                light_references=False,
                object_ids=False,
                programmes=True,
            ),
            Target(
                "sumo",
                lane_types=(
                    *(("bus", "driving"), ("taxi", "driving")),
                    *(("parking", "shoulder"), ("restricted", "shoulder")),
                ),
                light_references=False,
                lights_for_people=False,
                negated_left_hand=True,
                one_validity=True,
                priority_signs=True,
                polyline_step=2.0,
                programmes=True,
                command="netconvert{side} --junctions.endpoint-shape --opendrive-files {path}{lights} -o {net}",
                left_hand_option="--lefthand",
                right_hand_option="--opendrive.internal-shapes",
                programmes_option="--tllogic-files",
            ),
            Target("roadrunner", own_codes=True),
        )
    }
)
