"""`convert --config` and `--from-report`: what files say in place of the command line."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from small_area import OSM, write_area, write_dem

import osm2xodr
from osm2xodr.cli import main

DOCUMENT = Path(__file__).parents[2] / "docs" / "config.md"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a map and an elevation model, which is not the one that commands are started in."""
    found = tmp_path / "project"
    found.mkdir()
    write_area(found)
    write_dem(found)
    return found


def convert(*arguments: object) -> int:
    return main(["convert", *map(str, arguments)])


def write_config(folder: Path, text: str) -> Path:
    path = folder / "osm2xodr.toml"
    path.write_text(text, encoding="utf-8")
    return path


FULL = """
area = "village.osm"
dem = ["*.tif"]
bbox = [1.569, 42.549, 1.575, 42.552]
[options]
name = "lane"
ways = ["tertiary", "residential"]
max-grade = { residential = 0.12 }
smoothing = 2
left-hand = true
xodr-version = 1.8
date = "2024-05-01"
[outputs]
xodr = "lane.xodr"
report-json = "lane.json"
html = "lane.html"
check = false
"""


def test_a_config_does_what_the_command_line_does(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert convert("--config", write_config(folder, FULL), "-q") == 0
    words = ["--bbox", "1.569,42.549,1.575,42.552", "--name", "lane", "--ways", "tertiary,residential", "--left-hand"]
    more = ["--max-grade", "residential=0.12", "--smoothing", "2", "--xodr-version", "1.8", "--date", "2024-05-01"]
    out = tmp_path / "other.xodr"
    assert convert(folder / "village.osm", "--dem", folder / "dem.tif", *words, *more, "-o", out, "-q") == 0
    assert (folder / "lane.xodr").read_bytes() == out.read_bytes()
    assert (folder / "lane.html").is_file()
    assert json.loads((folder / "lane.json").read_bytes())["input"]["date"] == "2024-05-01"


def test_the_command_line_counts_more(folder: Path, tmp_path: Path) -> None:
    config = write_config(folder, FULL)
    out, other = tmp_path / "out.xodr", write_area(tmp_path, OSM.replace("Carrer Major", "High Street"))
    assert convert("--config", config, other, "--name", "mine", "--xodr-version", "1.6", "-o", out, "-q") == 0
    text = out.read_text(encoding="utf-8")
    assert 'revMinor="6"' in text
    assert 'name="mine"' in text
    assert "High Street" in text
    assert not (folder / "lane.xodr").exists()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("area = ", "osm2xodr.toml is not TOML: "),
        ('aera = "a.osm"', "osm2xodr.toml: 'aera' is unknown; do you mean 'area'?"),
        ('[options]\nwayz = "major"', "osm2xodr.toml: [options]: 'wayz' is unknown; do you mean 'ways'?"),
        ('[outputs]\npage = "a.html"', "osm2xodr.toml: [outputs]: 'page' is unknown; known are xodr, "),
        ("area = 3", "osm2xodr.toml: area is 3, and no path; write such as area = "),
        ("dem = [1]", "osm2xodr.toml: dem is 1, and no path"),
        ('bbox = "1,2,3,4"', "osm2xodr.toml: bbox is not a list; write such as bbox = [1.50, "),
        ("options = 1", "osm2xodr.toml: options is not a table; write [options]"),
        ("[options]\nleft-hand = 1", "osm2xodr.toml: [options]: left-hand is 1; write true or false"),
        ("[options]\npolynomial-order = 2.5", "[options]: polynomial-order is 2.5; write a whole number"),
        ("[options]\nname = [1]", "[options]: name is neither text nor a number; write it as after --name"),
        ("[outputs]\ncheck = 1", "osm2xodr.toml: [outputs]: check is 1; write true or false"),
        ("[options]\npolynomial-order = 9", "--polynomial-order"),
        ('[options]\nways = "wide"', "--ways"),
        ("", "Missing"),
    ],
)
def test_wrong_configs_are_refused(text: str, message: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = "" if "area" in text or not text else 'area = "village.osm"\n'
    if "xodr" not in text and files and "[outputs]" not in text:
        text += '\n[outputs]\nxodr = "lane.xodr"'
    assert convert("--config", write_config(folder, files + text)) in (1, 2)
    assert message in capsys.readouterr().err
    assert not (folder / "lane.xodr").exists()


def test_a_config_is_an_input(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config = write_config(folder, FULL)
    assert convert("--config", config, "-o", config, "--overwrite") == 2
    assert "osm2xodr.toml is one of the inputs" in capsys.readouterr().err
    assert convert("--config", folder / "none.toml") == 1
    assert "none.toml cannot be read: no such file or directory" in capsys.readouterr().err
    assert convert("--config", config, "--from-report", config) in (1, 2)


def test_areas_of_batches_have_none(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config = write_config(folder, FULL)
    assert main(["batch", str(config), "-o", str(tmp_path / "out"), "--options", f"--config {config}"]) == 2
    assert "--config cannot be given to areas of a batch; leave it out" in capsys.readouterr().err


def test_a_report_repeats_its_run(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert convert("--config", write_config(folder, FULL), "--no-structures", "--no-default-speeds", "-q") == 0
    out, report = folder / "lane.xodr", folder / "lane.json"
    first, said = out.read_bytes(), report.read_bytes()
    out.unlink()
    kept = report.rename(tmp_path / "kept.json")
    assert convert("--from-report", kept, "--report-json", report, "-q", "--jobs", "1") == 0
    assert out.read_bytes() == first
    assert report.read_bytes() == said
    # To another place, and as asked for on the command line.
    other = tmp_path / "other.xodr"
    assert convert("--from-report", kept, "-o", other, "-q") == 0
    assert other.read_bytes() == first
    assert convert("--from-report", kept, "--right-hand", "--left-hand", "-o", other) == 2
    assert convert("--from-report", kept, "--name", "mine", "-o", other, "--overwrite", "-q") == 0
    assert other.read_bytes() != first
    # The map has changed.
    write_area(folder, OSM.replace('v="50"', 'v="60"'))
    capsys.readouterr()
    assert convert("--from-report", kept, "-o", other, "--overwrite", "-q") == 1
    assert "other.xodr is not what" in capsys.readouterr().err


@pytest.mark.parametrize("hand", [[], ["--left-hand"], ["--right-hand"]])
def test_sides_of_the_road_are_repeated(hand: list[str], folder: Path, tmp_path: Path) -> None:
    out, report = tmp_path / "out.xodr", tmp_path / "out.json"
    assert convert(folder / "village.osm", *hand, "--no-furniture", "-o", out, "--report-json", report, "-q") == 0
    first = out.read_bytes()
    assert convert("--from-report", report, "--overwrite", "-q") == 0
    assert out.read_bytes() == first


def test_what_is_no_report_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for text in ("{", "[]", '{"input": {}}'):
        wrong = folder / "wrong.json"
        wrong.write_text(text, encoding="utf-8")
        assert convert("--from-report", wrong) == 1
        said = "wrong.json is not a report of convert; give the file that convert --report-json wrote"
        assert said in capsys.readouterr().err


def test_python_says_the_sum_of_what_it_wrote(folder: Path, tmp_path: Path) -> None:
    written = osm2xodr.convert(folder / "village.osm").write(tmp_path / "out.xodr")
    assert re.fullmatch(r"[0-9a-f]{64}", written.sha256)


def test_the_config_in_the_document_is_one(folder: Path) -> None:
    """All but the files, which are made up."""
    block = re.search(r"```toml\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL)
    assert block is not None
    write_area(folder, name="country.osm.pbf")
    (folder / "dem").mkdir()
    (folder / "extra").mkdir()
    write_dem(folder / "dem")
    write_dem(folder / "extra")
    (folder / "out").mkdir()
    (folder / "corrections.toml").write_text("way.10.lanes = 3", encoding="utf-8")
    text = block[1].replace("[1.55, 42.55, 1.57, 42.565]", "[1.569, 42.549, 1.575, 42.552]")
    assert convert("--config", write_config(folder, text.replace("old_town", "town")), "-q") == 0
    assert (folder / "out" / "town.html").is_file()
    assert (folder / "out" / "town.geojson").is_file()
