"""What marks roads without measured heights disturbs no reader."""

from __future__ import annotations

from pathlib import Path

from real_readers import carla_answers, qc_result, schema_errors, sumo_net
from small_area import write_area, write_dem

from osm2xodr.cli import main


def test_readers_pass_over_the_marks(tmp_path: Path) -> None:
    files = []
    for name, columns in (("whole", 60), ("part", 27)):
        dem = write_dem(tmp_path, f"{name}.tif", columns=columns)
        files.append(tmp_path / f"{name}.xodr")
        words = ["convert", str(write_area(tmp_path)), "--dem", str(dem), "-o", str(files[-1]), "-q"]
        assert main(words) == 0
    whole, part = files
    assert b"unmeasured_heights" in part.read_bytes()
    assert b"unmeasured_heights" not in whole.read_bytes()
    assert schema_errors(part, "1.7") == []
    folders = [tmp_path / file.stem for file in files]
    for folder in folders:
        folder.mkdir()
    assert qc_result(part, folders[1]) == qc_result(whole, folders[0])
    nets = [sumo_net(file, folder) for file, folder in zip(files, folders, strict=True)]
    assert nets[0].errors == nets[1].errors == []
    assert nets[0].edges == nets[1].edges > 0
    answers = [carla_answers(file) for file in files]
    assert answers[0].keys() == answers[1].keys()
