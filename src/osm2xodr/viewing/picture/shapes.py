"""What pictures are made of, in pixels from the top left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, TypeAlias

from osm2xodr.model import FloatArray

PAPER: Final = "#f6f7f5"
INK: Final = "#1d2630"
SOFT: Final = "#5a6672"
EDGE: Final = "#3d4853"
# Strokes across roads whose heights were not measured: they stand out from every colour of roads.
HATCHING: Final = "#f0323c"


@dataclass(frozen=True, eq=False)
class Polygon:
    """A filled area."""

    corners: FloatArray  # (n, 2)
    colour: str  # Of the area
    # Whether it has an outline of the same colour, so that no seam shows between neighbours
    outlined: bool = True


@dataclass(frozen=True, eq=False)
class Line:
    """A line."""

    corners: FloatArray  # (n, 2)
    # By default those of the edge of a carriageway
    colour: str = EDGE
    width: float = 0.6


Shape: TypeAlias = Polygon | Line
