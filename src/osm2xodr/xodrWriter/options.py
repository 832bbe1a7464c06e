"""The user's choices about the written file, and the differences between versions of OpenDRIVE.

Imports nothing heavy: the command line needs it to start.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from datetime import datetime
from types import MappingProxyType
from typing import Final

from osm2xodr import __version__
from osm2xodr.conventions import DEFAULT_TARGET, TARGETS, Group, Reported, Target, option, same_option
from osm2xodr.system import record


@record
class Dialect:
    """The features of one version of OpenDRIVE, as far as they matter here."""

    rev_minor: int  # ``header@revMinor``
    has_rule: bool = True  # Whether roads have ``rule``
    has_license: bool = False  # Whether the header has ``<license>``
    # Words of the model that the version lacks, and the nearest that it has
    lane_types: Mapping[str, str] = field(default_factory=dict)
    # Words for who may drive on a lane that the version lacks, and those that it has for them
    access: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    road_types: Mapping[str, str] = field(default_factory=dict)
    mark_types: Mapping[str, str] = field(default_factory=dict)
    mark_colors: Mapping[str, str] = field(default_factory=dict)
    object_types: Mapping[str, str] = field(default_factory=dict)
    has_subtype: bool = True  # Whether objects have ``subtype``
    has_outlines: bool = True  # Whether they have ``<outlines>``
    # Whether lanes have ``direction``. If so, ``bidirectional`` alone does not say that a lane is driven both ways.
    has_direction: bool = False
    has_boundary: bool = False  # Whether junctions have ``<boundary>``


# Speed bumps and the like have a type of their own since 1.8.
_NO_ROAD_SURFACE: Final = MappingProxyType({"roadSurface": "patch"})

# Types of roads in towns that 1.4 does not know.
_TOWN_ROADS: Final = ("Expressway", "Collector", "Arterial", "Private", "Local", "PlayStreet")

# Buses and motorcycles may use lanes for cars with several people in them (OSM wiki, Key:hov).
_HOV: Final = MappingProxyType({"HOV": ("passengerCar", "bus", "motorcycle")})

# The versions that can be written, oldest first. The differences are those of the XML schemas of ASAM.
DIALECTS: Final[Mapping[str, Dialect]] = MappingProxyType(
    {
        "1.4": Dialect(
            rev_minor=4,
            has_rule=False,
            # 1.4 has no lanes for buses and taxis; ``restricted`` is its word for lanes not open to all. It has no
            # kerbs either, which are the border of the strip beyond.
            lane_types=MappingProxyType({"bus": "restricted", "taxi": "restricted", "curb": "border"}),
            access=MappingProxyType({"HOV": ()}),
            road_types=MappingProxyType({f"town{kind}": "town" for kind in _TOWN_ROADS}),
            mark_types=MappingProxyType({"edge": "none"}),
            mark_colors=MappingProxyType({"orange": "standard", "violet": "standard"}),
            object_types=_NO_ROAD_SURFACE,
            has_subtype=False,
            has_outlines=False,
        ),
        "1.6": Dialect(
            rev_minor=6,
            access=_HOV,
            mark_colors=MappingProxyType({"violet": "standard"}),
            object_types=_NO_ROAD_SURFACE,
        ),
        "1.7": Dialect(rev_minor=7, access=_HOV, object_types=_NO_ROAD_SURFACE),
        "1.8": Dialect(rev_minor=8, has_license=True, has_direction=True, has_boundary=True),
    }
)
VERSIONS: Final = tuple(DIALECTS)


def check_date(text: str) -> str:
    """Return a date for the header; ValueError if it is not one of ISO 8601, or empty for none."""
    try:
        # Python 3.10 does not know Z.
        datetime.fromisoformat(text.removesuffix("Z") or "2000-01-01")
    except ValueError:
        raise ValueError(f"{text!r} is not a date; write one such as 2024-05-01 or 2024-05-01T12:30:00") from None
    return text


@record
class WriteOptions:
    """How to write."""

    version: str = option(
        "xodr_version",
        Group.OUTPUT,
        "Version of OpenDRIVE.",
        default="1.7",
        choices=VERSIONS,
        reported=Reported.NEVER,
    )
    name: str = ""  # Name of the road network in the header
    # ISO 8601; empty leaves it out. Never the time of writing, so that the same input gives the same bytes.
    date: str = option(
        "date",
        Group.MORE,
        "Date for the header, such as 2024-05-01.  [default: none]",
        default="",
        metavar="TEXT",
        parse=check_date,
    )
    tool_version: str = __version__  # Version of the converter, for the header
    osm_data: bool = True  # Whether the data are OpenStreetMap's, whose licence asks to be named
    elevation_credits: tuple[str, ...] = ()  # Whom the heights are owed
    target: Target = same_option("target", TARGETS[DEFAULT_TARGET])  # The reader to write for

    def __post_init__(self) -> None:
        if self.version not in DIALECTS:
            msg = f"OpenDRIVE {self.version} cannot be written; choose one of {', '.join(VERSIONS)}"
            raise ValueError(msg)
        check_date(self.date)

    @property
    def dialect(self) -> Dialect:
        """The features of the chosen version."""
        return DIALECTS[self.version]
