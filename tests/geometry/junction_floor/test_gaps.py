"""Areas of free cells in the grids of several junctions."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from osm2xodr.geometry.junction_floor import Faces
from osm2xodr.geometry.junction_floor.cells import FREE
from osm2xodr.geometry.junction_floor.gaps import Grids, Runs, _free_runs
from osm2xodr.model import BoolArray


def grids_of(pictures: list[BoolArray]) -> Grids:
    """Return grids with the given free cells (True)."""
    sizes = [picture.size for picture in pictures]
    road = np.concatenate([np.where(picture, FREE, 7).ravel() for picture in pictures]).astype(np.int32)
    none = np.zeros(0, np.int64)
    return Grids(
        np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
        np.array([picture.shape[1] for picture in pictures], np.int64),
        np.zeros((len(pictures), 2), np.int64),
        road,
        Faces.none(),
        Runs(none, none, none, none),
        none,
        none,
        np.zeros(1, bool),
    )


def test_runs_belong_to_the_areas_that_a_flood_fill_finds() -> None:
    """Beside SciPy's labels, an implementation of its own: one grid after the other, in the order of first cells."""
    random = np.random.default_rng(1)
    pictures = [random.random((deep, wide)) < 0.6 for deep, wide in ((9, 14), (6, 6), (23, 11), (5, 40))]
    for picture in pictures:
        picture[[0, -1], :] = picture[:, [0, -1]] = True
    grids = grids_of(pictures)
    runs = _free_runs(grids)
    found = np.full(len(grids.cells), -1)
    for begin, end, number in zip(runs.first.tolist(), runs.last.tolist(), runs.area.tolist(), strict=True):
        found[begin:end] = number
    known, expected = 0, []
    for picture in pictures:
        label, count = ndimage.label(picture)
        expected.append(np.where(label > 0, label - 1 + known, -1).ravel())
        known += count
    assert found.tolist() == np.concatenate(expected).tolist()


def test_a_run_ends_at_the_end_of_its_row() -> None:
    found = _free_runs(grids_of([np.ones((2, 3), bool), np.ones((1, 4), bool)]))
    assert found.grid.tolist() == [0, 0, 1]
    assert found.first.tolist() == [0, 3, 6]
    assert found.last.tolist() == [3, 6, 10]
