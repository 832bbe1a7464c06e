"""The simulators that there are folders for. Imports nothing heavy: the command line reads it for its help."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from osm2xodr.conventions import DEFAULT_TARGET

# The option --target of the conversion for each of them.
TARGET_OF: Final[Mapping[str, str]] = MappingProxyType(
    {"carla": "carla", "sumo": "sumo", "esmini": "esmini", "autoware": DEFAULT_TARGET}
)
SIMULATORS: Final = tuple(TARGET_OF)
# Options of a conversion that these folders have no use for: the simulator decides, or a batch does.
NOT_CHOSEN: Final = frozenset({"target", "frame", "tile", "corrections_shared"})
