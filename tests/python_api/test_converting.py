"""`osm2xodr.convert`: the bytes of the command line, from Python."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import rasterio
from scene_files import scene_named
from small_area import OSM, write_area, write_dem

import osm2xodr
from osm2xodr.viewing.scene import credits_of


@pytest.fixture
def area(tmp_path: Path) -> Path:
    return write_area(tmp_path)


@pytest.fixture
def dem(tmp_path: Path) -> Path:
    return write_dem(tmp_path)


def by_command_line(folder: Path, area: Path, dem: Path, *options: str) -> tuple[bytes, bytes]:
    """Return the road network and the report."""
    out, report = folder / "cli.xodr", folder / "cli.json"
    command = [sys.executable, "-m", "osm2xodr", "convert", str(area), "--dem", str(dem), "-o", str(out), "-q"]
    subprocess.run([*command, "--report-json", str(report), *options], check=True)
    return out.read_bytes(), report.read_bytes()


@pytest.mark.parametrize(
    ("name", "words", "options"),
    [
        ("andorra_ordino", [], {}),
        (
            "montlake_roundabout",
            ["--target", "sumo", "--ways", "major,residential", "--max-grade", "primary=0.08", "--jobs", "1"],
            {"target": "sumo", "ways": ["major", "residential"], "max_grade": {"primary": 0.08}},
        ),
    ],
)
def test_the_bytes_are_those_of_the_command_line(
    name: str, words: list[str], options: dict[str, Any], tmp_path: Path
) -> None:
    """Also with the threads of linear algebra that a program of one's own has."""
    area, dem = scene_named(name).osm, scene_named(name).dem
    xodr, report = by_command_line(tmp_path, area, dem, *words)
    code = (
        # Rasterio adds where its certificates are when it is loaded.
        "import os, sys, osm2xodr, rasterio\n"
        "before = dict(os.environ)\n"
        f"network = osm2xodr.convert({str(area)!r}, {str(dem)!r}, **{options!r})\n"
        "written = network.write('own.xodr', report_json='own.json')\n"
        "assert dict(os.environ) == before\n"
        "assert written.size == os.stat('own.xodr').st_size\n"
    )
    environment = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    subprocess.run([sys.executable, "-W", "error", "-c", code], cwd=tmp_path, check=True, env=environment)
    assert (tmp_path / "own.xodr").read_bytes() == xodr
    own, other = json.loads((tmp_path / "own.json").read_bytes()), json.loads(report)
    assert own["output"].pop("file") == "own.xodr"
    assert other["output"].pop("file") == str(tmp_path / "cli.xodr")
    assert own == other


def test_the_header_names_whom_heights_are_owed(area: Path, dem: Path, tmp_path: Path) -> None:
    """As the file of the elevation model says, once for models of one source, in one line."""
    again = tmp_path / "again.tif"
    shutil.copy(dem, again)
    for path in (dem, again):
        with rasterio.open(path, "r+") as dataset:
            dataset.update_tags(TIFFTAG_COPYRIGHT="© DLR e.V.\n2014 & Airbus")
    out = tmp_path / "out.xodr"
    network = osm2xodr.convert(area, [dem, again])
    network.write(out)
    owed = "© DLR e.V. 2014 & Airbus"
    assert [item.attribution for item in network.elevation_models] == [owed, owed]
    credit = f'<userData code="attribution_elevation" value="{owed.replace("&", "&amp;")}"/>'
    assert out.read_text("utf-8").count(credit) == 1
    assert credits_of(osm2xodr.read(out).tables).endswith(f"; {owed}")


def test_options_can_be_put_together_first(area: Path) -> None:
    options = osm2xodr.ConvertOptions(ways="tertiary", default_lane_width=2.75, left_hand=True)
    network = osm2xodr.convert(area, options=options, right_hand=True)
    assert network.statistics.roads == 1
    assert network.inputs["left_hand"] is False
    assert network.inputs["default_lane_width"] == 2.75


@pytest.mark.parametrize(
    ("options", "kind", "message"),
    [
        ({"way": "major"}, TypeError, "convert() has no option 'way'; do you mean 'ways'?"),
        ({"colour_of_the_sky": 1}, TypeError, "convert() has no option 'colour_of_the_sky'"),
        ({"ways": "footway"}, osm2xodr.OptionError, "ways: 'footway' is not a kind of way that cars drive on"),
        ({"objects": ["houses"]}, osm2xodr.OptionError, "objects: 'houses' is not a kind of object"),
        ({"default_lane_width": 0}, osm2xodr.OptionError, "default_lane_width: a lane cannot be 0 m wide"),
        ({"dem_sigma": -1.0}, osm2xodr.OptionError, "dem_sigma: "),
        ({"max_grade": {"canal": 0.05}}, osm2xodr.OptionError, "max_grade: max grade for 'canal'"),
        ({"dem_vertical_datum": "EPSG:3855"}, osm2xodr.OptionError, "dem_vertical_datum: "),
        ({"left_hand": True, "right_hand": True}, osm2xodr.OptionError, "left_hand and right_hand exclude"),
        ({"frame": "none.json"}, osm2xodr.InputError, "none.json cannot be read"),
    ],
)
def test_options_that_cannot_be(options: dict[str, Any], kind: type[Exception], message: str, area: Path) -> None:
    with pytest.raises(kind) as caught:
        osm2xodr.convert(area, **options)
    assert str(caught.value).startswith(message)


def test_files_that_cannot_be(tmp_path: Path, area: Path) -> None:
    with pytest.raises(osm2xodr.InputError, match=r"none\.osm"):
        osm2xodr.convert(tmp_path / "none.osm")
    with pytest.raises(osm2xodr.CoverageError):
        osm2xodr.convert(area, write_dem(tmp_path, west=7.0))
    with pytest.raises(osm2xodr.OutputError):
        osm2xodr.convert(area, output=area / "x.xodr")
    empty = write_area(tmp_path, OSM.replace("tertiary", "footway").replace("residential", "steps"), "empty.osm")
    with pytest.raises(osm2xodr.EmptyAreaError):
        osm2xodr.convert(empty)


def test_stages_are_announced(area: Path, dem: Path) -> None:
    stages: list[str] = []
    osm2xodr.convert(area, dem, on_stage=stages.append)
    assert stages == [
        f"reading {area}", "reading the elevation model", "building roads", "placing signals and objects",
    ]  # fmt: skip
