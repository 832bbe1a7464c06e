"""Small scenes whose roads, lanes, heights and movements are on record.

Each ``tests/golden/NAME.osm`` has its record in ``NAME.txt``. A change that is meant to alter records renews them
with ``pytest tests/whole/test_golden.py --update-golden``, and its commit shows the difference.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from golden import summary, write_hills
from osm2xodr.cli import main

GOLDEN = Path(__file__).parents[1] / "golden"
SCENES = sorted(GOLDEN.glob("*.osm"))


def test_there_are_twenty() -> None:
    assert len(SCENES) >= 20
    assert {path.stem for path in GOLDEN.glob("*.txt")} == {path.stem for path in SCENES}


@pytest.mark.parametrize("osm", SCENES, ids=lambda path: path.stem)
def test_it_is_as_recorded(osm: Path, tmp_path: Path, pytestconfig: pytest.Config) -> None:
    out = tmp_path / "out.xodr"
    dem = write_hills(osm, tmp_path / "hills.tif")
    assert main(["convert", str(osm), "--dem", str(dem), "-o", str(out), "-q", "--jobs", "1"]) == 0
    found = summary(out)
    record = osm.with_suffix(".txt")
    if pytestconfig.getoption("--update-golden"):
        record.write_text(found, encoding="utf-8")
    assert found.splitlines() == record.read_text(encoding="utf-8").splitlines()
