"""The height of the ground, as surface hands it on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from osm2xodr.model.shared import BoolArray, FloatArray, ReadOnlyArrays


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceQuality(ReadOnlyArrays):
    """How far heights can be trusted, point by point."""

    # (n,) Distance between the heights that the surface is made from there, m (0 for an exact surface)
    cell_size: FloatArray
    sigma: FloatArray  # (n,) Standard error of the heights, m (0 for an exact surface)
    # (n,) Whether the heights are those of a surface model, which lies on canopy and roofs rather than on the ground
    covered: BoolArray


class Surface(Protocol):
    """Height of the ground at local positions."""

    @property
    def cell_size(self) -> float:
        """Distance between the heights that most of the surface is made from, m (0 for an exact surface)."""

    @property
    def sigma(self) -> float:
        """Standard error of most of its heights, m (0 for an exact surface)."""

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return z (n,), m, at local x, y (n,), m, and where it is measured.

        Where it is not measured (voids, outside of the elevation model) z is the surface's best guess.
        """

    def quality(self, x: FloatArray, y: FloatArray) -> SurfaceQuality:
        """Return how far the heights at local x, y (n,), m, can be trusted."""
