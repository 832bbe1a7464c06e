"""The file that says how areas lie side by side: what is read, and what is said about damaged ones."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from osm2xodr.batching.areas import read_partition
from osm2xodr.cli import main
from osm2xodr.errors import InputError
from osm2xodr.projection import make_frame

SQUARE = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]]
GOOD: dict[str, Any] = {
    "format": 1,
    "lat_0_deg": 42.5,
    "lon_0_deg": 1.5,
    "areas": [
        {"name": "a", "first_id": 1, "rings": [SQUARE]},
        {"name": "b", "first_id": 100_001, "rings": [[[10.0, 0.0], [20.0, 0.0], [20.0, 10.0]], SQUARE]},
    ],
}


def written(folder: Path, table: object) -> Path:
    path = folder / "frame.json"
    path.write_text(table if isinstance(table, str) else json.dumps(table), encoding="utf-8")
    return path


def test_what_is_read(tmp_path: Path) -> None:
    partition = read_partition(written(tmp_path, GOOD), "b")
    assert partition.frame == make_frame(42.5, 1.5)
    assert partition.names == ("a", "b")
    assert partition.first_ids == (1, 100_001)
    assert partition.own == 1
    assert [len(outline.rings) for outline in partition.outlines] == [1, 2]
    np.testing.assert_array_equal(partition.outlines[0].rings[0], SQUARE)


def test_blocks(tmp_path: Path) -> None:
    areas = [{**GOOD["areas"][0], "name": name, "block": block} for name, block in zip("abc", "xyx", strict=True)]
    path = written(tmp_path, {**GOOD, "areas": [*areas, GOOD["areas"][1] | {"name": "d"}]})
    assert read_partition(path, "c", in_block=True).together() == (0, 2)
    assert read_partition(path, "c").together() == (2,)
    with pytest.raises(InputError, match="area 'd' is in no block"):
        read_partition(path, "d", in_block=True)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({**GOOD, "format": 2}, "has format 2, and this version reads 1"),
        ("no JSON", "does not say how areas lie side by side"),
        ([], "does not say how areas lie side by side"),
        ({**GOOD, "areas": [{"name": "b", "first_id": 1, "rings": []}]}, "does not say how areas lie side by side"),
        (
            {**GOOD, "areas": [{"name": "b", "first_id": 1, "rings": [[[0, 0], [1, 1]]]}]},
            "does not say how areas lie side by side",
        ),
        (
            {**GOOD, "areas": [{"name": "b", "first_id": 1, "rings": [[[0, 0], [1, 1], [float("inf"), 0]]]}]},
            "does not say how areas lie side by side",
        ),
        ({**GOOD, "areas": GOOD["areas"][:1]}, "has no area 'b'"),
    ],
)
def test_damaged_files_get_one_sentence(tmp_path: Path, table: object, words: str) -> None:
    path = written(tmp_path, table)
    with pytest.raises(InputError, match=words) as told:
        read_partition(path, "b")
    assert str(path) in str(told.value)


def test_a_file_that_is_not_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["convert", str(tmp_path / "a.osm"), "-o", str(tmp_path / "a.xodr"), "--frame", str(tmp_path / "no")]
    assert main(arguments) == 1
    assert (
        "no cannot be read: no such file or directory; give the file that the batch wrote" in capsys.readouterr().err
    )
