"""The commands ``report`` and ``render``: what they write, and what they refuse."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
from page_cases import info_of
from PIL import Image
from small_area import write_area, write_dem
from viewed_file import viewed_file, viewed_text

from osm2xodr.cli import main
from osm2xodr.opendrive import read_xodr
from osm2xodr.opendrive.space import frame_of


@pytest.fixture
def xodr(tmp_path: Path) -> Path:
    path = tmp_path / "small.xodr"
    path.write_text(viewed_text("Village"), encoding="utf-8")
    return path


def test_the_report_of_a_conversion_holds_all_its_tables(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    area, dem = write_area(tmp_path), write_dem(tmp_path)
    xodr, log, out = tmp_path / "a.xodr", tmp_path / "a.json", tmp_path / "a.html"
    assert main(["convert", str(area), "--dem", str(dem), "-o", str(xodr), "--report-json", str(log), "-q"]) == 0
    words = ["--osm", str(area), "--dem", str(dem), "--report-json", str(log), "-o", str(out)]
    assert main(["report", str(xodr), *words]) == 0
    assert f"osm2xodr: wrote {out} (" in capsys.readouterr().err
    info = info_of(out.read_bytes())
    assert info["coverage"]["rows"][0][1:] == [pytest.approx(0.494, abs=0.005)] * 2
    assert info["coverage"]["missing"] == []
    # The elevation model is a plane: the road is where it says, to a few centimetres.
    assert info["accuracy"]["rows"][0][3] < 0.1
    assert {item[1] for item in info["log"]["items"]} == {
        item["code"] for item in json.loads(log.read_text(encoding="utf-8"))["diagnostics"]
    }
    assert {row[0] for rows in info["ways"].values() for row in rows} == {10, 11}
    assert info["findings"] == [row for row in info["findings"] if row[0] == "info"]


def test_an_existing_report_stays_unless_it_may_go(xodr: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = xodr.with_suffix(".html")
    out.write_text("mine", encoding="utf-8")
    assert main(["report", str(xodr), "-o", str(out), "--no-check", "-q"]) == 2
    assert out.read_text(encoding="utf-8") == "mine"
    assert "--overwrite" in capsys.readouterr().err
    assert main(["report", str(xodr), "-o", str(out), "--no-check", "-q", "--overwrite", "--title", "Ours"]) == 0
    info = info_of(out.read_bytes())
    assert (info["title"], info["checked"]) == ("Ours", None)
    assert capsys.readouterr().err == ""


def test_an_input_is_never_overwritten(xodr: Path) -> None:
    before = xodr.read_bytes()
    assert main(["report", str(xodr), "-o", str(xodr), "--overwrite"]) == 2
    assert main(["render", str(xodr), "-o", str(xodr), "--overwrite", "--format", "svg"]) == 2
    assert xodr.read_bytes() == before


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "it is not JSON"),
        ("[]", "is not a report of convert"),
        ('{"diagnostics": 1}', "is not a report of convert"),
    ],
)
def test_another_json_is_refused(xodr: Path, capsys: pytest.CaptureFixture[str], text: str, words: str) -> None:
    log = xodr.with_suffix(".json")
    log.write_text(text, encoding="utf-8")
    out = xodr.with_suffix(".html")
    assert main(["report", str(xodr), "--report-json", str(log), "-o", str(out)]) == 1
    assert words in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize("command", ["report", "render"])
def test_a_file_that_is_not_there_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str) -> None:
    out = {"report": "x.html", "render": "x.svg"}[command]
    assert main([command, str(tmp_path / "none.xodr"), "-o", str(tmp_path / out)]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "none.xodr" in error
    assert not (tmp_path / out).exists()


def test_a_picture_is_of_the_kind_that_its_name_says(xodr: Path) -> None:
    assert main(["render", str(xodr), "-o", str(xodr.with_suffix(".svg")), "-q"]) == 0
    assert (
        xodr.with_suffix(".svg")
        .read_text(encoding="utf-8")
        .startswith('<?xml version="1.0" encoding="UTF-8"?>\n<svg')
    )
    assert main(["render", str(xodr), "-o", str(xodr.with_suffix(".png")), "--width", "300", "-q"]) == 0
    with Image.open(xodr.with_suffix(".png")) as image:
        assert image.size[0] == 300


def test_a_picture_goes_to_standard_output(xodr: Path, capfdbinary: pytest.CaptureFixture[bytes]) -> None:
    assert main(["render", str(xodr), "-o", "-", "--format", "png", "--width", "200"]) == 0
    out, error = capfdbinary.readouterr()
    assert Image.open(io.BytesIO(out)).size[0] == 200
    assert b"standard output" in error


def test_boxes_in_degrees_and_in_metres_give_the_same_picture(xodr: Path, tmp_path: Path) -> None:
    frame, _ = frame_of(viewed_file(tmp_path).header)
    assert frame is not None
    lon, lat = frame.to_geographic(np.array([20.0, 100.0]), np.array([-20.0, 20.0]))
    degrees = ",".join(f"{value:.9f}" for value in (lon[0], lat[0], lon[1], lat[1]))
    for name, option in (("a.png", f"--bbox={degrees}"), ("b.png", "--bbox-xy=20,-20,100,20")):
        assert main(["render", str(xodr), option, "-o", str(tmp_path / name), "-q", "--color", "height"]) == 0
    images = []
    for name in ("a.png", "b.png"):
        with Image.open(tmp_path / name) as image:
            images.append(np.asarray(image, np.int64)[:700, :1500])
    # Edges may fall into the next sample.
    assert np.mean(np.abs(images[0] - images[1]).sum(axis=2) > 30) < 0.01


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--bbox", "1,2,3"], "--bbox 1,2,3 is not 4 numbers; write west,south,east,north in degrees"),
        (["--bbox-xy", "5,0,1,9"], "--bbox-xy 5,0,1,9 is empty; write west,south,east,north in metres"),
        (["--bbox", "1,2,3,4", "--bbox-xy", "1,2,3,4"], "exclude each other"),
        (["--color", "taste"], "taste"),
        (["--width", "3"], "3 is not in the range"),
    ],
)
def test_wrong_usage_is_explained(
    xodr: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    assert main(["render", str(xodr), "-o", str(xodr.with_suffix(".svg")), *arguments]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "words"), [("x.jpg", "neither .svg nor .png"), ("-", "no name that tells the kind")]
)
def test_an_unknown_kind_of_picture_is_refused(
    xodr: Path, capsys: pytest.CaptureFixture[str], name: str, words: str
) -> None:
    assert main(["render", str(xodr), "-o", name if name == "-" else str(xodr.parent / name)]) == 2
    assert words in capsys.readouterr().err


def test_report_and_conversion_agree_on_what_is_not_measured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A model of 27 columns ends at 1.5725 E: the last 123 m of the street from there are not measured."""
    area, dem = write_area(tmp_path), write_dem(tmp_path, columns=27)
    xodr, log, out = tmp_path / "a.xodr", tmp_path / "a.json", tmp_path / "a.html"
    assert main(["convert", str(area), "--dem", str(dem), "-o", str(xodr), "--report-json", str(log)]) == 0
    said = capsys.readouterr().err
    made = json.loads(log.read_text(encoding="utf-8"))
    share = made["statistics"]["dem_coverage"]
    # It is the only figure of its kind.
    assert "measured_share" not in log.read_text(encoding="utf-8")
    marks = [
        tuple(map(float, text.split()))
        for (_, code), text in read_xodr(xodr).provenance.items()
        if code == "unmeasured_heights"
    ]
    missing = sum(end - begin for begin, end in marks)
    assert missing == pytest.approx(123.0, abs=8.0)
    # To the rounding of the ends of roads.
    assert 1.0 - share == pytest.approx(missing / read_xodr(xodr).roads.length.sum(), abs=1e-4)
    assert f"measured on {100.0 * share:.1f} % of the roads" in said
    assert f"{100.0 - 100.0 * share:.0f} % of the roads ({missing / 1e3:.1f} km, " in said
    # With the model, whose cells the page also shows around the roads, and without it.
    for words in ([], ["--dem", str(dem), "--osm", str(area)]):
        assert main(["report", str(xodr), "-o", str(out), "--overwrite", *words]) == 0
        info = info_of(out.read_bytes())
        assert dict(info["figures"])["km without a measured height"] == f"{missing / 1e3:.2f}"
        assert f"{100.0 - 100.0 * share:.1f} %)" in next(note for note in info["notes"] if "hatched" in note)
        assert [pair for pairs in info["unmeasured"].values() for pair in pairs] == [list(pair) for pair in marks]
        assert "dem-gap" not in capsys.readouterr().err
    picture = tmp_path / "a.svg"
    assert main(["render", str(xodr), "-o", str(picture), "-q"]) == 0
    assert "hatched: height not measured" in picture.read_text(encoding="utf-8")
