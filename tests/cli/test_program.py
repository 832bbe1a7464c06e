"""The command line as users meet it: exit status, what is said where, and which files are there afterwards."""

from __future__ import annotations

import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import rasterio
from lxml import etree
from small_area import OSM, write_area, write_dem

import osm2xodr
from osm2xodr.cli import main
from osm2xodr.conventions import Group
from osm2xodr.python_api import DECLARATIONS
from osm2xodr.reporting import conversion


@pytest.fixture
def area(tmp_path: Path) -> Path:
    return write_area(tmp_path)


@pytest.fixture
def dem(tmp_path: Path) -> Path:
    return write_dem(tmp_path)


@pytest.fixture
def out(tmp_path: Path) -> Path:
    folder = tmp_path / "out"
    folder.mkdir()
    return folder / "map.xodr"


# A restriction that does not say where it holds, which needs attention.
BROKEN = OSM.replace(
    "</osm>",
    ' <relation id="1"><member type="way" ref="10" role="from"/><tag k="type" v="restriction"/>'
    '<tag k="restriction" v="no_left_turn"/></relation>\n</osm>',
)


def run(*arguments: object, **options: Any) -> subprocess.CompletedProcess[bytes]:
    """Run the command in a process of its own."""
    command = [sys.executable, "-m", "osm2xodr", *map(str, arguments)]
    return subprocess.run(command, capture_output="stdout" not in options, timeout=120, check=False, **options)


def convert(*arguments: object) -> int:
    return main(["convert", *map(str, arguments)])


def error_line(text: str) -> str:
    """Return the one line of an error, and see that there is no other."""
    found = re.fullmatch(r"osm2xodr: error: (.+)\n", text)
    assert found is not None, text
    return found[1]


# ---------------------------------------------------------------- what works


def test_convert(area: Path, dem: Path, out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert convert(area, "--dem", dem, "-o", out) == 0
    root = etree.parse(out).getroot()
    header = root.find("header")
    assert header is not None
    assert header.get("name") == "village"
    assert header.get("revMinor") == "7"
    plain = [road for road in root.findall("road") if road.get("junction") == "-1"]
    assert sorted(road.get("name", "") for road in plain) == ["", "Carrer Major", "Carrer Major"]
    stdout, stderr = capsys.readouterr()
    assert stdout == ""
    lines = stderr.splitlines()
    assert re.fullmatch(rf"osm2xodr: wrote {re.escape(str(out))} \(0\.0 MB, OpenDRIVE 1\.7\) in \d+\.\d s", lines[0])
    # That the limit of way/11 is the law's is a guess, and nothing to act on.
    assert re.fullmatch(r"  0\.5 km of road, 1 junction; AD, 0\.\d x 0\.\d km, traffic on the right", lines[1])
    assert re.match(r"  heights from 1,0\d\d\.\d to 1,0\d\d\.\d m, measured on 100 % of the roads; 95 %", lines[2])
    assert lines[3:] == [lines[-1]]
    assert re.fullmatch(r"\d guesses, 0 dropped, 0 repaired: --report-json, -v", lines[-1])
    assert "\x1b" not in stderr
    assert "\r" not in stderr
    assert list(out.parent.iterdir()) == [out]


def test_heights_come_from_the_elevation_model(area: Path, dem: Path, out: Path) -> None:
    """The model rises by 1 m per second of arc to the east; the street begins 18 seconds from its west edge."""
    assert convert(area, "--dem", dem, "-o", out, "-q") == 0
    heights = [float(item.get("a", "nan")) for item in etree.parse(out).iter("elevation")]
    west, east = 1000.0 + 0.005 * 3600.0 - 0.5, 1000.0 + 0.009 * 3600.0 - 0.5
    assert min(heights) == pytest.approx(west, abs=1.0)
    assert west - 1.0 <= max(heights) <= east + 1.0


def test_without_elevation_model_the_world_is_flat_and_that_is_said(
    area: Path, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert convert(area, "-o", out) == 0
    # Without a profile roads lie at height 0.
    assert list(etree.parse(out).iter("elevationProfile")) == []
    assert "flat at height 0" in capsys.readouterr().err


def test_same_input_same_bytes(area: Path, dem: Path, out: Path) -> None:
    documents = []
    for seed in ("1", "2"):
        done = run("convert", area, "--dem", dem, "-o", "-", env={**os.environ, "PYTHONHASHSEED": seed})
        assert done.returncode == 0
        documents.append(done.stdout)
    assert convert(area, "--dem", dem, "-o", out, "-q") == 0
    assert documents == [out.read_bytes()] * 2


def test_standard_output_has_the_document_alone(
    area: Path, out: Path, capsysbinary: pytest.CaptureFixture[bytes]
) -> None:
    assert convert(area, "-o", "-") == 0
    stdout, stderr = capsysbinary.readouterr()
    assert stdout.startswith(b"<?xml")
    assert stdout.endswith(b"</OpenDRIVE>\n")
    assert stderr.startswith(b"osm2xodr: wrote standard output")
    assert convert(area, "-o", out, "-q") == 0
    assert out.read_bytes() == stdout


def test_quiet_and_verbose(area: Path, out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert convert(area, "-o", out, "-q") == 0
    assert capsys.readouterr() == ("", "")
    assert convert(area, "-o", out, "--overwrite", "-v") == 0
    stages = re.findall(r"^ +\d+\.\d\d s  (.+)$", capsys.readouterr().err, re.MULTILINE)
    assert stages == [
        "starting",
        f"reading {area}",
        "building roads",
        "placing signals and objects",
        f"writing {out}",
    ]
    assert convert(area, "-o", out, "--overwrite", "-v") == 0
    told = capsys.readouterr().err
    assert "  note            1  flat: " in told
    assert "  note: flat: " not in told
    assert convert(area, "-o", out, "--overwrite", "-vv") == 0
    assert "  note: flat: " in capsys.readouterr().err


def test_options_reach_the_stages(area: Path, out: Path) -> None:
    status = convert(
        area, "-o", out, "--name", "A & B", "--date", "2024-05-01", "--left-hand", "--xodr-version", "1.8",
        "--ways", "tertiary", "--default-lane-width", "2.75", "--no-guessed-sidewalks",
    )  # fmt: skip
    assert status == 0
    root = etree.parse(out).getroot()
    header = root.find("header")
    assert header is not None
    assert (header.get("name"), header.get("date"), header.get("revMinor")) == ("A & B", "2024-05-01", "8")
    assert [road.get("rule") for road in root.findall("road")] == ["LHT"]
    widths = {item.get("a") for item in root.iter("width")}
    assert widths == {"2.75"}


def test_the_country_decides_on_which_side_traffic_drives(area: Path, out: Path) -> None:
    assert convert(area, "-o", out, "-q") == 0
    # Right-hand traffic is the default.
    assert {road.get("rule") for road in etree.parse(out).iter("road")} == {None}
    london = write_area(out.parent, OSM.replace('lat="42.', 'lat="51.').replace('lon="1.57', 'lon="-0.12'), "gb.osm")
    assert convert(london, "-o", out, "-q", "--overwrite") == 0
    assert {road.get("rule") for road in etree.parse(out).iter("road")} == {"LHT"}


def test_report(area: Path, dem: Path, out: Path) -> None:
    report = out.with_suffix(".json")
    assert convert(area, "--dem", dem, "-o", out, "--report-json", report, "-q") == 0
    found = json.loads(report.read_text(encoding="utf-8"))
    assert found["format"] == 2
    assert found["input"]["area"] == str(area)
    assert found["input"]["dem"] == [str(dem)]
    assert found["input"]["osm2xodr"] == osm2xodr.__version__
    sums = {"bytes": out.stat().st_size, "sha256": hashlib.sha256(out.read_bytes()).hexdigest()}
    assert found["output"] == {"file": str(out), **sums, "xodr_version": "1.7"}
    assert found["statistics"]["roads"] == 3
    assert found["statistics"]["junctions"] == 1
    assert found["statistics"]["road_length"] == pytest.approx(328.0 + 167.0, abs=40.0)
    assert found["statistics"]["dem_coverage"] == 1.0
    (model,) = found["elevation_models"]
    assert (model["path"], model["crs"], model["unit"], model["share"]) == (str(dem), "EPSG:4326", "metre", 1.0)
    assert model["cell_size"] == pytest.approx(30.87 * 0.737**0.5, abs=0.3)
    assert sum(item["count"] for item in found["counts"]) == len(found["diagnostics"])
    assert {"guessed", "way/11"} <= {text for item in found["diagnostics"] for text in (item["kind"], item["osm_id"])}
    first = report.read_bytes()
    assert convert(area, "--dem", dem, "-o", out, "--report-json", report, "-q", "--overwrite") == 0
    assert report.read_bytes() == first


def test_report_on_standard_output(area: Path, out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert convert(area, "-o", out, "--report-json", "-", "-q") == 0
    assert json.loads(capsys.readouterr().out)["output"]["file"] == str(out)


def test_version_and_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"osm2xodr {osm2xodr.__version__}\n"
    assert main(["convert", "--help"]) == 0
    text = capsys.readouterr().out
    assert "osm2xodr convert area.osm --dem dem.tif -o area.xodr" in text
    assert "Exit status: 0 written, 1 cannot convert" in text


def test_help_has_groups_and_the_rest_on_request(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["convert", "--help"]) == 0
    text = capsys.readouterr().out
    headings = [line for line in text.splitlines() if line.endswith(":") and line[0] not in " E"]
    assert headings == [f"{group.value}:" for group in Group if group is not Group.MORE]
    assert "--date, --polynomial-order, --plan, --corrections-shared, --frame, --tile" in " ".join(text.split())
    assert "Date for the header" not in text
    assert main(["convert", "--help-all"]) == 0
    everything = capsys.readouterr().out
    for name in DECLARATIONS:
        assert f"--{name.replace('_', '-')} " in everything
    assert "Date for the header" in everything


def test_check_and_page_in_one_go(area: Path, dem: Path, out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_area(area.parent, BROKEN)
    page, report = out.with_suffix(".html"), out.with_suffix(".json")
    assert convert(area, "--dem", dem, "-o", out, "--check", "--html", page, "--report-json", report) == 0
    told = capsys.readouterr().err
    assert f"{out}: 0 errors, 0 warnings" in told
    assert f"wrote {page}" in told
    # The summary stands at the end, where one reads it.
    assert told.splitlines()[-1].endswith("repaired: --report-json, -v")
    assert told.index(f"wrote {page}") < told.index("needs attention")
    assert len(told.splitlines()) <= 10
    text = page.read_text(encoding="utf-8")
    assert text.startswith("<!doctype html>")
    assert "Content-Security-Policy" in text
    assert report.exists()


# Two streets that cross without a node, as if one passed above the other, and no tag that says so.
CROSSING = """<osm version="0.6">
  <node id="1" lat="50" lon="11"/><node id="2" lat="50" lon="11.002"/>
  <node id="3" lat="49.999" lon="11.001"/><node id="4" lat="50.001" lon="11.001"/>
  <way id="1"><nd ref="1"/><nd ref="2"/><tag k="highway" v="residential"/></way>
  <way id="2"><nd ref="3"/><nd ref="4"/><tag k="highway" v="residential"/></way>
</osm>
"""


def test_findings_of_the_check_decide_the_exit_status(
    tmp_path: Path, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    area = tmp_path / "crossing.osm"
    area.write_text(CROSSING, encoding="utf-8")
    assert convert(area, "-o", out, "--check") == 1
    assert "[overlap]" in capsys.readouterr().err
    assert len(etree.parse(out).findall("road")) == 2


@pytest.mark.parametrize("option", ["--check", "--html"])
def test_what_reads_the_file_needs_one(option: str, area: Path, capsys: pytest.CaptureFixture[str]) -> None:
    more = ["page.html"] if option == "--html" else []
    assert convert(area, "-o", "-", option, *more) == 2
    assert f"{option} needs what was written as a file" in capsys.readouterr().err


def test_help_loads_nothing_heavy() -> None:
    script = (
        "import sys; from osm2xodr.cli import main; main(['convert', '--help']);"
        " print({'numpy', 'scipy', 'rasterio', 'osmium', 'pyproj', 'lxml'} & set(sys.modules), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stderr == "set()\n"


def test_options_reach_the_heights(area: Path, dem: Path, out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The village lies on a slope that is steeper than the limit given."""
    report = out.with_name("report.json")
    more = ("--max-grade", "residential=1%,tertiary=1%", "--smoothing", "3", "--no-structures", "--dem-type", "dsm")
    command = (area, "--dem", dem, "-o", out, "--report-json", report, *more, "--dem-sigma", "0.5", "--turnarounds")
    assert convert(*command) == 0
    told = json.loads(report.read_bytes())
    wanted = {"smoothing": 3.0, "structures": False, "turnarounds": True, "dem_type": "dsm", "dem_sigma": 0.5}
    assert wanted.items() <= told["input"].items()
    assert {item["wanted"] for item in told["elevation"]["steep"]} <= {0.01}
    assert told["elevation"]["structures"] == []
    # A loop at each of the dead ends.
    root = etree.parse(out).getroot()
    assert len(root.findall("junction")) == 4
    assert "; 95 % of the ground within " in capsys.readouterr().err


# ---------------------------------------------------------------- surface


def test_surface(dem: Path, out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = out.with_suffix(".html")
    assert main(["surface", str(dem), "-o", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    assert text.startswith("<!doctype html>")
    for method in ("nearest", "bilinear", "bicubic"):
        assert method in text
    assert re.search("https?:", re.sub(r'xmlns="[^"]*"', "", text)) is None
    assert capsys.readouterr().err.splitlines()[0] == f"osm2xodr: wrote {page}"
    assert main(["surface", str(dem), "-o", str(page)]) == 2
    assert "exists; give another file, or --overwrite" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["-o", "{out}"], 2, "Missing argument 'DEM...'"),
        (["{dem}", "-o", "{dem}", "--overwrite"], 2, "is one of the inputs"),
        (["{dem}", "-o", "{out}", "--bbox", "1,2,3"], 2, "--bbox 1,2,3 is not 4 numbers"),
        (["{dem}", "-o", "{out}", "--bbox", "3,2,1,4"], 1, "box"),
        (["{dem}.tif", "-o", "{out}"], 1, "there is no such elevation model"),
    ],
)
def test_surface_that_cannot_be(
    arguments: list[str], status: int, message: str, dem: Path, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["surface", *(item.format(dem=dem, out=out) for item in arguments)]) == status
    stdout, stderr = capsys.readouterr()
    assert message in " ".join(stderr.split())
    assert stdout == ""
    assert not out.exists()


# ---------------------------------------------------------------- wrong usage


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "Missing argument 'AREA'"),
        (["{area}"], "Missing option '-o'"),
        (["{area}", "-o", "{out}", "--xodr-version", "1.5"], "'1.5' is not one of '1.4', '1.6', '1.7', '1.8'"),
        (["{area}", "-o", "{out}", "--ways", "footway"], "--ways: 'footway' is not a kind of way that cars drive on"),
        (["{area}", "-o", "{out}", "--default-lane-width", "0"], "--default-lane-width: a lane cannot be 0 m wide"),
        (["{area}", "-o", "{out}", "--left-hand", "--right-hand"], "--left-hand and --right-hand exclude each other"),
        (["{area}", "-o", "{out}", "--polynomial-order", "9"], "9 is not in the range 2<=x<=5"),
        (["{area}", "-o", "{area}", "--overwrite"], "village.osm is one of the inputs; give another file"),
        (["{area}", "-o", "{out}", "--report-json", "{out}"], "-o and --report-json name the same file"),
        (["{area}", "-o", "-", "--report-json", "-"], "-o and --report-json name the same file"),
        (["{area}", "-o", "{out}", "--report-json", "{area}", "--overwrite"], "--report-json"),
        (
            ["{area}", "-o", "{out}", "--dem-sigma", "0"],
            "--dem-sigma: the elevation model's standard error 0.0 m is not above 0",
        ),
        (["{area}", "-o", "{out}", "--dem-vertical-datum", "EPSG:3855"], "give --vertical-datum too"),
        (["{area}", "-o", "{out}", "--smoothing", "0"], "--smoothing: 0 is not above 0"),
        (["{area}", "-o", "{out}", "--smoothing", "nan"], "--smoothing: nan is not above 0"),
        (["{area}", "-o", "{out}", "--smoothing", "100000"], "--smoothing: 100000 is above 100, which levels mount"),
        (["{area}", "-o", "{out}", "--date", "yesterday"], "--date: 'yesterday' is not a date; write one such as 20"),
        (
            ["{area}", "-o", "{out}", "--vertical-datum", "EPSG:3855"],
            "--vertical-datum is about elevation models; give one with --dem, or leave it out",
        ),
        (["{area}", "-o", "{out}", "--dem-sigma", "3"], "--dem-sigma is about elevation models; give one with --dem"),
        (["{area}", "dem.tif", "-o", "{out}"], "dem.tif: elevation models stand after --dem; write --dem dem.tif"),
        (["{area}", "b.osm.pbf", "-o", "{out}"], "b.osm.pbf: one area at a time; osmium merge joins files"),
        (
            ["https://example.org/a.osm", "-o", "{out}"],
            "https://example.org/a.osm is an address, and files are read from disk alone; download it first",
        ),
        (
            ["{area}", "--dem", "https://example.org/dem.tif", "-o", "{out}"],
            "https://example.org/dem.tif is an address",
        ),
        (
            ["{area}", "-o", "{out}", "--max-grade", "motorway"],
            "--max-grade: max grade 'motorway' is not class=limit",
        ),
        (["{area}", "-o", "{out}", "--max-grade", "canal=5%"], "--max-grade: max grade for 'canal': no such class"),
        (["{area}", "-o", "{out}", "--frobnicate"], "No such option"),
    ],
)
def test_wrong_usage(
    arguments: list[str], message: str, area: Path, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = area.read_bytes()
    assert convert(*(item.format(area=area, out=out) for item in arguments)) == 2
    stdout, stderr = capsys.readouterr()
    assert stdout == ""
    assert message in " ".join(stderr.split())
    assert list(out.parent.iterdir()) == []
    assert area.read_bytes() == before


@pytest.mark.parametrize(
    ("name", "command"), [("{area}", "convert {area} -o area.xodr"), ("map.xodr", "check map.xodr")]
)
def test_a_file_in_place_of_a_command(
    name: str, command: str, area: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name, command = name.format(area=area), command.format(area=area)
    assert main([name]) == 2
    assert f"Error: {name} is no command; write osm2xodr {command}\n" in capsys.readouterr().err


def test_an_area_on_standard_input(area: Path, out: Path) -> None:
    report = out.with_suffix(".json")
    done = run("convert", "-", "-o", out, "--report-json", report, input=area.read_bytes())
    assert done.returncode == 0, done.stderr
    told = json.loads(report.read_bytes())
    assert (told["input"]["area"], told["input"]["name"]) == ("-", "standard_input")
    other = out.with_name("other.xodr")
    assert convert(area, "-o", other, "--name", "standard_input", "-q") == 0
    assert other.read_bytes() == out.read_bytes()


def test_an_elevation_model_of_zeros_is_told(
    tmp_path: Path, area: Path, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    level = write_dem(tmp_path)
    with rasterio.open(level) as source:
        profile, cells = source.profile, source.read()
    with rasterio.open(level, "w", **profile) as target:
        target.write(0 * cells)
    assert convert(area, "--dem", level, "-o", out) == 0
    told = capsys.readouterr().err
    assert re.search(r"\n  dem-level: .*dem\.tif: all [\d,]+ cells", told)


def test_existing_files_are_kept(area: Path, out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out.write_bytes(b"precious")
    assert convert(area, "-o", out) == 2
    assert "exists; give another file, or --overwrite to replace it" in capsys.readouterr().err
    assert convert(area, "-o", out.with_name("new.xodr"), "--report-json", out) == 2
    assert out.read_bytes() == b"precious"
    assert list(out.parent.iterdir()) == [out]
    assert convert(area, "-o", out, "--overwrite") == 0
    assert out.read_bytes().startswith(b"<?xml")


def test_an_input_by_another_name_is_still_an_input(area: Path, out: Path) -> None:
    link = out.with_name("link.osm")
    link.symlink_to(area)
    assert convert(area, "-o", link, "--overwrite") == 2
    assert area.read_text(encoding="utf-8") == OSM


# ---------------------------------------------------------------- what cannot be converted


def no_file(folder: Path) -> list[object]:
    return [folder / "none.osm"]


def a_folder(folder: Path) -> list[object]:
    return [folder]


def empty_file(folder: Path) -> list[object]:
    return [write_area(folder, "")]


def prose(folder: Path) -> list[object]:
    return [write_area(folder, "This is no map.\n")]


def other_xml(folder: Path) -> list[object]:
    return [write_area(folder, '<?xml version="1.0"?><gpx version="1.1"/>')]


def cut_xml(folder: Path) -> list[object]:
    return [write_area(folder, OSM[: len(OSM) // 2])]


def no_ways(folder: Path) -> list[object]:
    return [write_area(folder, '<osm version="0.6"/>')]


def no_drivable_way(folder: Path) -> list[object]:
    return [write_area(folder, OSM.replace("tertiary", "footway").replace("residential", "steps"))]


def entities(folder: Path) -> list[object]:
    bomb = '<?xml version="1.0"?><!DOCTYPE osm [<!ENTITY a "aaaa">]>'
    return [write_area(folder, OSM.replace('<?xml version="1.0" encoding="UTF-8"?>', bomb).replace("Major", "&a;"))]


def cut_pbf(folder: Path) -> list[object]:
    import osmium

    whole = folder / "whole.osm.pbf"
    with osmium.SimpleWriter(str(whole)) as writer:
        for item in osmium.FileProcessor(str(write_area(folder))):
            writer.add(item)
    part = folder / "part.osm.pbf"
    part.write_bytes(whole.read_bytes()[:-40])
    return [part]


def no_dem(folder: Path) -> list[object]:
    return [write_area(folder), "--dem", folder / "none.tif"]


def not_a_raster(folder: Path) -> list[object]:
    path = folder / "dem.tif"
    path.write_text("no raster")
    return [write_area(folder), "--dem", path]


def dem_without_crs(folder: Path) -> list[object]:
    return [write_area(folder), "--dem", write_dem(folder, crs=None)]


def dem_elsewhere(folder: Path) -> list[object]:
    return [write_area(folder), "--dem", write_dem(folder, west=7.0)]


def dem_all_void(folder: Path) -> list[object]:
    return [write_area(folder), "--dem", write_dem(folder, void=True)]


def dem_too_small(folder: Path) -> list[object]:
    return [write_area(folder), "--dem", write_dem(folder, columns=21)]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (no_file, r"none\.osm"),
        (a_folder, r"director|folder"),
        (empty_file, r"village\.osm.*empty"),
        (prose, r"village\.osm"),
        (other_xml, r"village\.osm"),
        (cut_xml, r"village\.osm"),
        (no_ways, r"village\.osm"),
        (no_drivable_way, r"village\.osm"),
        (entities, r"village\.osm"),
        (cut_pbf, r"part\.osm\.pbf"),
        (no_dem, r"none\.tif: there is no such elevation model"),
        (not_a_raster, r"dem\.tif: the file is not a raster"),
        (dem_without_crs, r"dem\.tif: the raster has no coordinate reference system"),
        (dem_elsewhere, r"dem\.tif: the elevation model covers .* but the roads lie at"),
        (dem_all_void, r"dem\.tif: all cells around the roads are nodata"),
        (dem_too_small, r"dem\.tif: only \d+ % of the roads have a measured height; .*--allow-partial"),
    ],
)
@pytest.mark.filterwarnings("ignore::rasterio.errors.NotGeoreferencedWarning")
def test_what_cannot_be_converted(
    make: Callable[[Path], list[object]],
    message: str,
    tmp_path: Path,
    out: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """One sentence on standard error with the file, exit status 1, nothing written, and what was there is whole."""
    out.write_bytes(b"precious")
    arguments = make(tmp_path)
    assert convert(*arguments, "-o", out, "--overwrite") == 1
    stdout, stderr = capfd.readouterr()
    assert stdout == ""
    assert re.search(message, error_line(stderr))
    assert list(out.parent.iterdir()) == [out]
    assert out.read_bytes() == b"precious"


def test_partial_elevation_models_can_be_allowed(
    tmp_path: Path, area: Path, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    small = write_dem(tmp_path, columns=21)
    assert convert(area, "--dem", small, "-o", out, "--allow-partial") == 0
    assert re.search(r"measured on \d+\.\d % of the roads", capsys.readouterr().err)


def test_targets_that_cannot_be(area: Path, out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert convert(area, "-o", out.parent) == 1
    assert "is a directory; name a file in it" in error_line(capsys.readouterr().err)
    assert convert(area, "-o", area / "map.xodr") == 1
    assert "is a file, where a folder should be" in error_line(capsys.readouterr().err)
    assert list(out.parent.iterdir()) == []


# ---------------------------------------------------------------- what goes wrong on the way


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no device that is always full")
@pytest.mark.parametrize("report", [False, True])
def test_a_full_disk(report: bool, area: Path, out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["-o", out, "--report-json", "/dev/full"] if report else ["-o", "/dev/full"]
    assert convert(area, *arguments) == 1
    assert error_line(capsys.readouterr().err) == (
        "cannot write /dev/full: no space left on device; free some space or choose another place"
    )
    assert list(out.parent.iterdir()) == []


def test_a_disk_that_fills_up(area: Path, out: Path) -> None:
    """The kernel lets no file grow beyond 8 kB; the document has more."""
    out.write_bytes(b"precious")
    script = (
        "import resource, signal, sys\n"
        "from osm2xodr.cli import main\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192))\n"
        "sys.exit(main(sys.argv[1:]))\n"
    )
    command = [sys.executable, "-c", script, "convert", str(area), "-q", "-o", str(out), "--overwrite"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert error_line(done.stderr).startswith(f"cannot write {out}: file too large")
    assert list(out.parent.iterdir()) == [out]
    assert out.read_bytes() == b"precious"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no device that is always full")
def test_standard_output_onto_a_full_disk(area: Path) -> None:
    with Path("/dev/full").open("wb") as full:
        done = run("convert", area, "-q", "-o", "-", stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 1
    assert error_line(done.stderr.decode()) == "cannot write standard output: no space left on device"


def test_a_reader_that_goes_away(area: Path) -> None:
    command = [sys.executable, "-m", "osm2xodr", "convert", str(area), "-q", "-o", "-"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    assert process.stderr.read() == b""
    process.stderr.close()
    assert process.wait(timeout=60) == 1


@pytest.fixture
def half_written(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[], None]], None]:
    """Make writing stop half way with whatever is done then."""

    def stop_with(action: Callable[[], None]) -> None:
        def write(road_map: object, stream: Any, options: object, diagnostics: object, jobs: int) -> None:
            stream.write(b"<?xml half of a document")
            action()

        monkeypatch.setattr(conversion, "write_xodr", write)

    return stop_with


def crash() -> None:
    raise ValueError("two\nlines")


def memory() -> None:
    raise MemoryError


def wrapped(number: signal.Signals) -> None:
    """Wrap what a signal raises, as Python does up to 3.11 where a class is made."""
    try:
        os.kill(os.getpid(), number)
        time.sleep(10.0)
    except BaseException as error:
        raise RuntimeError("Error calling __set_name__") from error


@pytest.mark.parametrize(
    ("action", "status", "message"),
    [
        (lambda: os.kill(os.getpid(), signal.SIGINT), 130, "interrupted"),
        (lambda: os.kill(os.getpid(), signal.SIGTERM), 143, "ended by the system"),
        (lambda: wrapped(signal.SIGINT), 130, "interrupted"),
        (lambda: wrapped(signal.SIGTERM), 143, "ended by the system"),
        (memory, 1, "the memory is not enough for this area"),
        (crash, 1, r"internal error \(ValueError: two lines\); please report it .*; -vv shows where"),
    ],
)
def test_whatever_stops_it_the_old_file_stays(
    action: Callable[[], None],
    status: int,
    message: str,
    area: Path,
    out: Path,
    half_written: Callable[[Callable[[], None]], None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    out.write_bytes(b"precious")
    report = out.with_suffix(".json")
    half_written(action)
    assert convert(area, "-o", out, "--overwrite", "--report-json", report) == status
    assert re.match(message, error_line(capsys.readouterr().err.lstrip("\n")))
    assert list(out.parent.iterdir()) == [out]
    assert out.read_bytes() == b"precious"
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_tracebacks_on_request(
    area: Path,
    out: Path,
    half_written: Callable[[Callable[[], None]], None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    half_written(crash)
    assert convert(area, "-o", out, "-vv") == 1
    stderr = capsys.readouterr().err
    assert "Traceback (most recent call last):" in stderr
    assert stderr.splitlines()[-1].endswith("please report it with the command and the area")


def test_progress_on_terminals_only(area: Path, out: Path) -> None:
    import pty

    ours, theirs = pty.openpty()
    write_area(area.parent, BROKEN)
    done = run("convert", area, "-o", out, stdout=subprocess.DEVNULL, stderr=theirs)
    os.close(theirs)
    text = os.read(ours, 100_000).decode()
    os.close(ours)
    assert done.returncode == 0
    assert "\r\x1b[Kbuilding roads …" in text
    assert "osm2xodr: wrote" in text.split("\x1b[K")[-1]
    assert "\x1b[33m\x1b[1mneeds attention" in text


def test_no_colours_where_they_are_not_wanted(area: Path, out: Path) -> None:
    import pty

    ours, theirs = pty.openpty()
    environment = {**os.environ, "NO_COLOR": "1"}
    write_area(area.parent, BROKEN)
    done = run("convert", area, "-o", out, stdout=subprocess.DEVNULL, stderr=theirs, env=environment)
    os.close(theirs)
    text = os.read(ours, 100_000).decode()
    os.close(ours)
    assert done.returncode == 0
    assert "\nneeds attention" in text
    assert "\x1b[33m" not in text


def test_document_on_standard_output_and_report_in_a_file(area: Path, out: Path) -> None:
    report = out.with_suffix(".json")
    done = run("convert", area, "-o", "-", "--report-json", report)
    assert done.returncode == 0
    assert json.loads(report.read_text(encoding="utf-8"))["output"]["bytes"] == len(done.stdout)
