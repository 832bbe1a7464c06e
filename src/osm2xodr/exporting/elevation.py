"""Heights of the ground at places of a road network, from elevation models."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import Frame
from osm2xodr.projection import make_frame, to_local

if TYPE_CHECKING:
    from osm2xodr.surface import DemSurface, SurfaceOptions

# Elevation models are read up to this far from roads, m, at points this far apart at most.
_MARGIN: Final = 300.0
_STEP: Final = 25.0
_MOST_POINTS: Final = 250_000

Height = Callable[[FloatArray, FloatArray], FloatArray]


def read_heights(
    models: Sequence[Path],
    frame: Frame,
    x: FloatArray,
    y: FloatArray,
    options: SurfaceOptions,
    diagnostics: Diagnostics,
) -> tuple[Height, DemSurface]:
    """Return what gives the height of the ground at inertial places, m, and the elevation models.

    It takes x, y (n,), m, and returns heights of the file (the header's offset is subtracted), NaN where none is
    measured. `x`, `y`, (n,), are the places that elevation models are read around.

    Raises
    ------
    InputError
        An elevation model cannot be used.
    CoverageError
        No elevation model has heights at the places.
    """
    # Loads slowly, and is needed with elevation models alone.
    from osm2xodr.surface import read_surface

    local, around = frame.local, frame.to_projected(x, y)
    if local is None:
        # Elevation models are read in a local frame, whatever the projection of the file.
        lon, lat = frame.to_geographic(x, y)
        local = make_frame(float(np.mean(lat)), float(np.mean(lon)))
        around = to_local(local, lon, lat)
    surface = read_surface(models, local, *around, options, diagnostics)

    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        at = frame.to_projected(x, y) if frame.local else to_local(local, *frame.to_geographic(x, y))
        z, measured = surface.heights(*at)
        return np.where(measured, z, np.nan) - frame.offset[2]

    return height, surface


def places_around(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the places x, y (n,), m, that are known, and a grid of places over their area and its surroundings."""
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    west, east = float(x.min()) - _MARGIN, float(x.max()) + _MARGIN
    south, north = float(y.min()) - _MARGIN, float(y.max()) + _MARGIN
    step = max(_STEP, math.sqrt((east - west) * (north - south) / _MOST_POINTS))
    columns, rows = np.meshgrid(np.arange(west, east + step, step), np.arange(south, north + step, step))
    return np.concatenate([x, columns.ravel()]), np.concatenate([y, rows.ravel()])
