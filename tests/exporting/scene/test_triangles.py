"""Triangles whose edges meet have a corner there."""

from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.exporting.scene.triangles import Soup, edges_of, merged_places, split_where_they_meet, steps_between
from osm2xodr.model import FloatArray


def soup_of(*triangles: list[tuple[float, float, float]]) -> Soup:
    corners = np.array(triangles)
    place, xy = merged_places(corners[:, :, :2].reshape(-1, 2))
    return Soup(place.reshape(-1, 3), xy, corners[:, :, 2], corners[:, :, :2], np.arange(len(corners)))


def areas(soup: Soup) -> FloatArray:
    a, b, c = np.moveaxis(soup.xy[soup.place], 1, 0)
    twice = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    return np.array([0.5 * twice[soup.tag == tag].sum() for tag in np.unique(soup.tag)])


def corners_at(soup: Soup, x: float, y: float) -> set[tuple[int, float]]:
    """Tag and height of all corners at a place, of which there is one."""
    (place,) = np.flatnonzero(np.hypot(soup.xy[:, 0] - x, soup.xy[:, 1] - y) < 1e-9)
    row, corner = np.nonzero(soup.place == place)
    return {(int(soup.tag[k]), round(float(soup.z[k, j]), 9)) for k, j in zip(row, corner, strict=True)}


def test_outlines_that_cross_have_a_corner_in_common() -> None:
    # The second one's lower side runs from 0.1 m below the first one's upper side to 0.1 m above it.
    below = [(0.0, 0.0, 1.0), (10.0, 4.0, 1.0), (0.0, 4.0, 1.0)]
    above = [(0.0, 3.9, 1.0), (10.0, 4.1, 1.2), (5.0, 9.0, 1.0)]
    found = split_where_they_meet(soup_of(below, above))
    assert corners_at(found, 5.0, 4.0) == {(0, 1.0), (1, 1.1)}
    np.testing.assert_allclose(areas(found), [20.0, areas(soup_of(above))[0]], rtol=1e-9)


def test_a_corner_on_an_edge_divides_it() -> None:
    found = split_where_they_meet(
        soup_of(
            [(0.0, 0.0, 0.0), (8.0, 0.0, 4.0), (4.0, 6.0, 0.0)],
            [(2.0, 0.0, 1.0), (0.0, -5.0, 0.0), (4.0, -5.0, 0.0)],
        )
    )
    assert corners_at(found, 2.0, 0.0) == {(0, 1.0), (1, 1.0)}
    np.testing.assert_allclose(areas(found), [24.0, 10.0])


def test_corners_of_others_close_to_a_corner_become_one_with_it() -> None:
    """Either of two corners, 2.8 mm apart, lies on an edge of the triangle with the other one: the fifth of them."""
    west, south, east, north = (-1.7, -1.0), (0.97, -1.0), (6.22, -1.97), (-0.39, 0.388)
    near, other = (0.0, 0.0), (0.002, -0.002)
    corners = (
        (west, near, north),
        (west, other, near),
        (west, south, other),
        (south, east, other),
        (near, east, north),
    )
    found = split_where_they_meet(soup_of(*([(*xy, 0.0) for xy in item] for item in corners)))
    start, end = found.place.ravel(), np.roll(found.place, -1, axis=1).ravel()
    edges = set(zip(start.tolist(), end.tolist(), strict=True))
    alone = [found.xy[one].tolist() for one, another in edges if (another, one) not in edges]
    assert sorted(alone) == sorted(map(list, (west, south, east, north)))
    assert areas(found).sum() == pytest.approx(
        areas(soup_of([(*xy, 0.0) for xy in (west, south, east)], [(*xy, 0.0) for xy in (west, east, north)])).sum(),
        abs=0.01,
    )


def test_outlines_on_different_levels_are_left_alone() -> None:
    one = [(0.0, 0.0, 1.0), (10.0, 0.0, 1.0), (5.0, 9.0, 1.0)]
    other = [(5.0, -4.0, 4.0), (9.0, 5.0, 4.0), (1.0, 5.0, 4.0)]
    soup = soup_of(one, other)
    found = split_where_they_meet(soup)
    np.testing.assert_array_equal(found.place, soup.place)


def test_edges_between_the_same_vertices_match_before_others() -> None:
    # A road 0.1 m above the edge of another one, and a sliver beside it, above that one as well.
    faces = np.array([(0, 1, 2), (4, 3, 5), (3, 4, 6)])
    xyz = np.array(
        [(0, 0, 0.0), (1, 0, 0.0), (0.5, 1, 0.0), (0, 0, 0.1), (1, 0, 0.1), (0.5, -1, 0.1), (0.5, 0.01, 0.1)], float
    )
    place = np.array([0, 1, 2, 0, 1, 3, 4])
    found = edges_of(faces, place, xyz)
    assert sorted(map(sorted, found.pairs.tolist())) == [[3, 6]]
    assert len(steps_between(faces, found.pairs)[0]) == 0
    # Half edges of the lower road, then of the upper one and of the sliver.
    assert found.alone.tolist() == [0, 1, 2, 4, 5, 7, 8]
