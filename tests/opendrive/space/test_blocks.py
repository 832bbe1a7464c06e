from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from viewed_file import viewed_file

from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive.space import elevation, lane_borders, pose, positions


def test_many_places_are_evaluated_block_by_block(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = viewed_file(tmp_path)
    road = np.arange(50) % len(file.roads.id)
    s = np.linspace(0.0, 40.0, 50)
    lane = np.arange(50) % len(file.lanes.id)

    def found() -> list[FloatArray]:
        ends = lane_borders(file, lane, s, before=True)
        return [*pose(file, road, s), elevation(file, road, s), *lane_borders(file, lane, s), *ends]

    whole = found()
    monkeypatch.setattr(positions, "BLOCK", 7)
    for one, other in zip(whole, found(), strict=True):
        np.testing.assert_array_equal(one, other)


def test_blocks_hold_no_more_than_they_should(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(positions, "BLOCK", 4)
    sizes: list[int] = []

    @positions.in_blocks
    def doubled(file: None, rows: IntArray, s: FloatArray) -> FloatArray:
        sizes.append(len(s))
        return np.asarray(2.0 * s)

    assert doubled(None, np.arange(10), np.arange(10.0)).tolist() == [2.0 * k for k in range(10)]
    assert sizes == [4, 4, 2]
