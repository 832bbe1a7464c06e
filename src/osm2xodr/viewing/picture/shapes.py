"""What pictures are made of, in pixels from the top left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from osm2xodr.model import FloatArray

PAPER, INK, SOFT, EDGE = "#f6f7f5", "#1d2630", "#5a6672", "#3d4853"


@dataclass(frozen=True, eq=False)
class Polygon:
    """A filled area."""

    corners: FloatArray  # (n, 2)
    colour: str  # Of the area
    # Whether a line of the same colour runs around it, so that no seam shows between neighbours
    outlined: bool = True


@dataclass(frozen=True, eq=False)
class Line:
    """A line."""

    corners: FloatArray  # (n, 2)
    # Of the line; those of the edge of a carriageway, if nothing is said
    colour: str = EDGE
    width: float = 0.6


Shape: TypeAlias = Polygon | Line
