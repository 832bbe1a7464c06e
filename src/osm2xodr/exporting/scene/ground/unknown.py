"""Ground where the elevation model has no heights: gaps are interpolated, and a level strip lies beside roads."""

from __future__ import annotations

from typing import Final

import numpy as np
import scipy.sparse as sp
from scipy import ndimage
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree

from osm2xodr.exporting.scene.ground.cells import GROUND_BLOCK, Cells
from osm2xodr.exporting.scene.ground.defaults import APRON, GROUND_CELL, LARGEST_GAP
from osm2xodr.model import FloatArray

# How far beyond the outline heights are needed, as triangles cross it, m: the diagonal of the largest squares.
_BEYOND: Final = np.sqrt(2) * GROUND_CELL * GROUND_BLOCK
_FARTHEST: Final = APRON + _BEYOND
_SIDES: Final = ((0, 1), (0, -1), (1, 0), (-1, 0))


def interpolated(z: FloatArray) -> FloatArray:
    """Return heights of corners of squares, (rows, columns), m, with gaps of NaN within them closed.

    These are at most as large as `LARGEST_GAP`, and have the smoothest heights in between: each is the mean of those
    around it. What reaches the sides of the rectangle stays unknown.
    """
    gaps, count = ndimage.label(np.isnan(z))
    fill = np.bincount(gaps.ravel(), minlength=count + 1) * GROUND_CELL**2 <= LARGEST_GAP
    fill[np.concatenate([[0], gaps[0], gaps[-1], gaps[:, 0], gaps[:, -1]])] = False
    row, column = np.nonzero(fill[gaps])
    if not len(row):
        return z
    number = np.full(z.shape, -1)
    number[row, column] = np.arange(len(row))
    known = np.zeros(len(row))
    pairs = []
    for dy, dx in _SIDES:
        other = number[row + dy, column + dx]
        inner = np.flatnonzero(other >= 0)
        pairs.append(np.column_stack([inner, other[inner]]))
        known += np.where(other >= 0, 0.0, z[row + dy, column + dx])
    one, other = np.concatenate(pairs).T.astype(np.int32)
    size = len(row)
    matrix = sp.csc_matrix((-np.ones(len(one)), (one, other)), shape=(size, size)) + 4.0 * sp.eye(size, format="csc")
    out = z.copy()
    out[row, column] = spsolve(matrix, known)
    return out


def with_strips(cells: Cells, base: FloatArray, rim: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return heights of corners, (rows, columns), m, and how far these lie within the outline of the ground, m.

    Where they are unknown, the ground is as high as the edge of the nearest road, of points `rim` (n, 3), m, and
    reaches no farther than `APRON` from it.
    """
    row, column = np.nonzero(np.isnan(base) & (cells.inside > -_BEYOND))
    if not len(row):
        return base, cells.inside
    out, inside = base.copy(), cells.inside.copy()
    inside[row, column] = np.minimum(inside[row, column], -GROUND_CELL)
    if len(rim):
        x, y = cells.node_xy()
        at = np.column_stack([x[row, column], y[row, column]])
        away, nearest = (np.asarray(item) for item in cKDTree(rim[:, :2]).query(at, distance_upper_bound=_FARTHEST))
        close = np.isfinite(away)
        row, column, away = row[close], column[close], away[close]
        out[row, column] = rim[nearest[close], 2]
        inside[row, column] = np.minimum(cells.inside[row, column], APRON - away)
    return out, inside


def continued(z: FloatArray) -> FloatArray:
    """Return heights of corners, (rows, columns), m: unknown ones are those of the nearest that is known."""
    unknown = np.isnan(z)
    if not unknown.any() or unknown.all():
        return z
    row, column = ndimage.distance_transform_edt(unknown, return_distances=False, return_indices=True)
    return np.asarray(z[row, column])
