"""The ground ends at a smooth line: triangles are cut where they cross it."""

from __future__ import annotations

from typing import Final

import numpy as np

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
