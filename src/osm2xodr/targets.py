"""Readers of OpenDRIVE that a file can be written for, and what they differ in.

Imports nothing heavy: the command line reads it before it knows what to do.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final


@dataclass(frozen=True, slots=True)
class Target:
    """What one reader wants.

    Parameters
    ----------
    name
        Of the option.
    own_codes
        Whether signs have the codes of their own country everywhere; else those that CARLA and esmini know.
    """

    name: str
    own_codes: bool = False


# The default suits CARLA, esmini and SUMO alike.
DEFAULT_TARGET: Final = "generic"
TARGETS: Final[Mapping[str, Target]] = MappingProxyType(
    {
        item.name: item
        for item in (
            Target(DEFAULT_TARGET),
            Target("carla"),
            Target("esmini"),
            Target("sumo"),
            Target("roadrunner", own_codes=True),
        )
    }
)
