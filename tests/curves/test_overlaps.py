"""Quadrilaterals that lie over each other."""

from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.curves import overlap_depths, overlapping_pairs
from osm2xodr.model import FloatArray


def box(x: float, y: float, wide: float, high: float, turn: float = 0.0) -> FloatArray:
    """Return the corners of a rectangle about (x, y), turned by an angle, rad."""
    corners = 0.5 * np.array([[-wide, -high], [wide, -high], [wide, high], [-wide, high]])
    cos, sin = np.cos(turn), np.sin(turn)
    return np.asarray(corners @ np.array([[cos, sin], [-sin, cos]]) + [x, y])


@pytest.mark.parametrize(
    ("other", "depth"),
    [
        (box(3.0, 0.0, 4.0, 2.0), 1.0),
        (box(0.0, 1.5, 20.0, 2.0), 0.5),
        (box(5.0, 0.0, 4.0, 2.0), -1.0),
        # A corner points at the middle of the right side.
        (box(2.0 + np.sqrt(2.0) - 0.3, 0.0, 2.0, 2.0, np.pi / 4), 0.3),
    ],
)
def test_depth_is_the_shortest_way_apart(other: FloatArray, depth: float) -> None:
    one = box(0.0, 0.0, 4.0, 2.0)
    found = overlap_depths(np.stack([one, other]), np.stack([other, one]))
    assert found[0] == pytest.approx(found[1])
    assert found[0] == pytest.approx(depth)


def test_shapes_apart_whose_boxes_overlap() -> None:
    one, other = box(0.0, 0.0, 4.0, 2.0)[None], box(3.2, 2.2, 2.0, 2.0, np.pi / 4)[None]
    assert [index.tolist() for index in overlapping_pairs(np.concatenate([one, other]), np.ones(2, bool))] == [
        [0],
        [1],
    ]
    # From the corner (2, 1), 2.4 / sqrt(2) m before the middle of the other, to its side 1 m before that.
    assert overlap_depths(one, other)[0] == pytest.approx(1.0 - 2.4 / np.sqrt(2.0))


def test_edge_without_length_is_no_axis() -> None:
    triangle = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0], [0.0, 2.0]])
    assert overlap_depths(triangle[None], box(2.0, 2.0, 2.0, 2.0)[None])[0] == pytest.approx(0.0)


def test_pairs_are_those_of_all_bounding_boxes_of_which_one_is_probed() -> None:
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-60.0, 60.0, (2, 200)).tolist()
    wide, high = rng.uniform(1.0, 30.0, (2, 200)).tolist()
    turn = rng.uniform(0.0, 3.0, 200).tolist()
    quads = np.stack([box(x[k], y[k], wide[k], high[k], turn[k]) for k in range(200)])
    probe = rng.random(200) < 0.3
    low, high = quads.min(axis=1), quads.max(axis=1)
    expected = [
        (i, j)
        for i in range(200)
        for j in range(i + 1, 200)
        if (probe[i] or probe[j]) and (low[i] < high[j]).all() and (low[j] < high[i]).all()
    ]
    found = overlapping_pairs(quads, probe)
    assert list(zip(*(index.tolist() for index in found), strict=True)) == expected
    assert len(expected) > 100


def test_pairs_of_one_group_are_left_out_where_it_is_alone() -> None:
    # Two pairs far from each other; beside the second there is a quadrilateral of another group.
    boxes = [box(0.0, 0.0, 4.0, 4.0), box(1.0, 0.0, 4.0, 4.0), box(200.0, 0.0, 4.0, 4.0), box(201.0, 0.0, 4.0, 4.0)]
    quads = np.stack([*boxes, box(200.5, 0.0, 1.0, 1.0)])
    found = overlapping_pairs(quads, np.ones(5, bool), np.array([7, 7, 7, 7, 3]))
    assert [index.tolist() for index in found] == [[2, 2, 3], [3, 4, 4]]


def test_wrong_numbers_are_left_out() -> None:
    quads = np.stack(
        [box(0.0, 0.0, 4.0, 4.0), box(1.0, 0.0, 4.0, 4.0), box(0.0, 0.0, 1e9, 1e9), box(0.0, 0.0, np.nan, 1.0)]
    )
    found = overlapping_pairs(quads, np.ones(4, bool))
    assert [index.tolist() for index in found] == [[0], [1]]
    assert [len(index) for index in overlapping_pairs(quads[:0], np.ones(0, bool))] == [0, 0]
