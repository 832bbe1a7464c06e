"""Ground that ends at a smooth line, and where the elevation model has no heights: gaps are interpolated."""

from __future__ import annotations

from typing import Final

import numpy as np
import scipy.sparse as sp
from scipy import ndimage
from scipy.sparse.linalg import spsolve

from osm2xodr.curves import PointTree
from osm2xodr.exporting.scene.ground.cells import GROUND_BLOCK, Cells
from osm2xodr.exporting.scene.ground.defaults import APRON, GROUND_CELL, LARGEST_GAP
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Corners and crossings of a cut triangle in order: pairs of corners, those of corners with themselves.
_AROUND: Final = np.array([[0, 0], [0, 1], [1, 1], [1, 2], [2, 2], [2, 0]])
_HALVES: Final = np.array([[0, 1, 2], [0, 2, 3]])


def cut_at_outline(vertices: FloatArray, faces: IntArray, inside: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return vertices (n, 3), m, those that were there first, and triangles up to where `inside` (n,) is 0.

    Triangles that share a side share the corner on it: the ground stays without a gap.
    """
    value = inside[faces]
    whole, cut = (value >= 0.0).all(1), (value < 0.0).any(1) & (value > 0.0).any(1)
    corners, values = faces[cut], value[cut]
    a, b = corners[:, _AROUND[:, 0]], corners[:, _AROUND[:, 1]]
    crossed: BoolArray = values[:, _AROUND[:, 0]] * values[:, _AROUND[:, 1]] < 0.0
    kept = np.where(a == b, values[:, _AROUND[:, 0]] >= 0.0, crossed)
    count = len(vertices)
    key, new = np.unique(np.minimum(a, b)[crossed] * count + np.maximum(a, b)[crossed], return_inverse=True)
    number = a.copy()
    number[crossed] = count + new
    one, other = np.divmod(key, count)
    share = (inside[one] / (inside[one] - inside[other]))[:, None]
    more = vertices[one] + share * (vertices[other] - vertices[one])
    # Three or four corners, first.
    order = np.argsort(~kept, axis=1, kind="stable")
    pieces = np.take_along_axis(number, order, axis=1)[:, _HALVES]
    real = np.column_stack([np.ones(len(corners), np.bool_), kept.sum(1) == 4])
    return np.concatenate([vertices, more]), np.concatenate([faces[whole], pieces[real]])


# ---------------------------------------------------------------- what no elevation model knows

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
        away, nearest = PointTree(rim[:, :2]).nearest(at, _FARTHEST)
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
