"""The benchmark's own figures: copies are copies, and the table says what was measured."""

from __future__ import annotations

import sys
from pathlib import Path

import osmium
import rasterio
from bench import TOOLS, Run, areas_in, run, table
from replicate import Area, count_nodes, replicate

SAMPLE = Path(__file__).parents[2] / "data" / "samples" / "andorra_ordino"


def test_copies_lie_side_by_side(tmp_path: Path) -> None:
    sample = Area("sample", SAMPLE / "area.osm", SAMPLE / "dem.tif")
    three = replicate(sample, 3, tmp_path)
    assert three.dem is not None
    assert count_nodes(three.osm) == 3 * count_nodes(sample.osm)
    ids = [item.id for item in osmium.FileProcessor(str(three.osm), osmium.osm.WAY)]
    assert len(set(ids)) == len(ids) == 3 * sum(1 for _ in osmium.FileProcessor(str(sample.osm), osmium.osm.WAY))
    assert count_nodes(tmp_path / "sample_x3.osm") == count_nodes(three.osm)
    with rasterio.open(three.dem) as dem:
        heights = dem.read(1)
        rows, columns = heights.shape[0] // 2, heights.shape[1] // 2
        assert heights.shape == (2 * rows, 2 * columns)
        assert (heights[:rows, :columns] == heights[rows:, columns:]).all()


def test_a_run_is_measured(tmp_path: Path) -> None:
    target = tmp_path / "out"
    code = f"print('   1.50 s  working'); open({str(target)!r}, 'wb').write(bytes(1000)); sum(range(3_000_000))"
    found = run([sys.executable, "-c", code], target, 60.0)
    assert found is not None
    assert found.size == 1000
    assert found.stages == {"working": 1.5}
    assert 0.0 < found.cpu <= found.wall * 2
    assert found.memory > 5_000_000
    assert run([sys.executable, "-c", "raise SystemExit(1)"], target, 60.0) is None
    assert not target.exists()


def test_memory_is_that_of_all_processes_together(tmp_path: Path) -> None:
    target = tmp_path / "out"
    work = f"import time; held = bytearray(60_000_000); time.sleep(1); open({str(target)!r}, 'w').close()"
    two = f"import subprocess, sys; child = subprocess.Popen([sys.executable, '-c', {work!r}]); {work}; child.wait()"
    alone, together = (run([sys.executable, "-c", code], target, 60.0, watch=True) for code in (work, two))
    assert alone is not None
    assert together is not None
    assert 60e6 < alone.memory < 90e6
    assert 120e6 < together.memory < 180e6


def test_the_table_has_medians_and_ratios(tmp_path: Path) -> None:
    runs: dict[str, list[Run]] = {tool: [] for tool in TOOLS}
    runs["osm2xodr"] = [Run(wall, 2.0, 200_000_000, 3_000_000, {"reading": 0.5}) for wall in (9.0, 2.0, 1.0)]
    runs["netconvert"] = [Run(4.0, 4.0, 100_000_000, 6_000_000)] * 3
    page = table([(Area("town", tmp_path / "area.osm", tmp_path / "dem.tif"), 12_345, runs)], 3)
    assert "| town | 12,345 | osm2xodr with heights | 2.00 | 0.50 | 2.00 | 200 | 2.00 | 3.0 | 0.50 |" in page
    assert "| town | 12,345 | Osm2Odr | failed |" in page
    assert "| town | reading | 0.50 |" in page


def test_areas_of_a_folder(tmp_path: Path) -> None:
    for name, files in (("b", ("area.osm", "dem.tif")), ("a", ("area.osm.pbf",)), ("c", ("other.txt",))):
        (tmp_path / name).mkdir()
        for file in files:
            (tmp_path / name / file).touch()
    found = areas_in(tmp_path)
    assert [(area.name, area.osm.name, area.dem is not None) for area in found] == [
        ("a", "area.osm.pbf", False),
        ("b", "area.osm", True),
    ]
