"""The simulators that there are folders for, what the module of each is given, and what it returns.

Imports nothing heavy: the command line reads it for its help.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from pathlib import Path
from types import MappingProxyType
from typing import Final

from osm2xodr.conventions import DEFAULT_TARGET
from osm2xodr.reporting import Conversion
from osm2xodr.system import record

# Stands for the folder in a command.
FOLDER: Final = "{folder}"
# The road network in the folder.
XODR: Final = "map.xodr"

# The option --target of the conversion for each of them.
TARGET_OF: Final[Mapping[str, str]] = MappingProxyType(
    {"carla": "carla", "sumo": "sumo", "esmini": "esmini", "autoware": DEFAULT_TARGET}
)
SIMULATORS: Final = tuple(TARGET_OF)
# Options of a conversion that these folders have no use for: the simulator decides, or a batch does.
NOT_CHOSEN: Final = frozenset({"target", "frame", "tile", "corrections_shared"})


@record
class Request:
    """A road network, and the folder that is being written for a simulator."""

    conversion: Conversion  # Written as `XODR` in the folder
    area: Path  # The OpenStreetMap file, of the area alone
    dems: tuple[Path, ...]
    dem_options: Mapping[str, str | None]  # ``dem_crs``, ``dem_unit`` and ``dem_encoding``
    folder: Path
    name: str  # Of the map: letters, digits and underscores
    tile: float | None  # Width of tiles of a scene, m; None where that is not said
    on_stage: Callable[[str], None]

    @property
    def xodr(self) -> Path:
        """The road network."""
        return self.folder / XODR


@record
class Made:
    """What was written for a simulator."""

    needs: str  # What has to be installed, a sentence
    command: str  # Starts the simulator; `FOLDER` stands for the folder
    files: Mapping[str, str]  # What each file is, but for `XODR`
    notes: tuple[str, ...] = ()  # What is good to know, without a full stop
    sections: Mapping[str, str] = field(default_factory=dict)  # Further ones of the README by heading, Markdown
