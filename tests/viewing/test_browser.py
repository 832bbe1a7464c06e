"""The report's page in a real browser: it shows what is clicked, colours, turns, and runs nothing of the file."""

from __future__ import annotations

import base64
import io
import re
from pathlib import Path

import numpy as np
import pytest
from browser import Page, browser, troubles
from page_cases import TERTIARY, write_plane
from PIL import Image
from small_area import write_area
from viewed_file import HOSTILE, viewed_file, write_ways

from osm2xodr.cli import main
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import IntArray
from osm2xodr.opendrive.space import elevation, surface_points
from osm2xodr.opendrive.tables import OpenDrive
from osm2xodr.python_api import read_corrections
from osm2xodr.viewing import ReportOptions, write_report


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("report")


@pytest.fixture(scope="module")
def file(folder: Path) -> OpenDrive:
    return viewed_file(folder)


@pytest.fixture(scope="module")
def report(folder: Path, file: OpenDrive) -> Path:
    hostile = TERTIARY.replace(
        "Hauptstraße", HOSTILE.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    )
    area = write_ways(folder, file, {4: (hostile, [(0.0, 1.0), (120.0, 1.0)]), 5: (hostile, [(0, 60), (90, 60)])})
    said = [{"kind": "guessed", "code": HOSTILE, "osm_id": "way/4", "message": HOSTILE}]
    options = ReportOptions(area, (write_plane(folder, file),), {"input": {"area": HOSTILE}, "diagnostics": said})
    out = folder / "report.html"
    write_report(file, out, options, Diagnostics())
    return out


def at(page: Page, file: OpenDrive, road: int, s: float, t: float) -> tuple[float, float]:
    """Return the pixel at which a place on a road is drawn."""
    x, y, _ = surface_points(file, np.array([road]), np.array([s]), np.array([t]))
    x0, y0 = page.value("window.osm2xodr.data.info.origin")
    px, py = page.run("return window.osm2xodr.pixelOf(...arguments)", float(x[0]) - x0, float(y[0]) - y0)
    return px, py


def pixels(page: Page, png: str) -> IntArray:
    """Return a picture as numbers, (rows, columns, 3)."""
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(png))).convert("RGB"), np.int64)


def test_the_page_opens_without_complaint(page: Page, report: Path) -> None:
    page.open(report)
    assert page.text("#title") == HOSTILE
    assert page.text("#message") == ""
    assert page.text("#content").count("roads") >= 1
    assert page.value("document.querySelectorAll('.leaflet-tile-container canvas').length") > 0
    assert troubles(page) == []


def test_a_click_on_a_road_shows_its_profile_with_the_right_height(page: Page, report: Path, file: OpenDrive) -> None:
    page.open(report)
    page.click(*at(page, file, 1, 50.0, 1.0))
    assert page.value("document.getElementById('profile').hidden") is False
    assert page.text("#profile-title") == "Road 2"
    said = page.text("#profile-value")
    numbers = re.search(r"s ([\d.]+) m · height ([\d.]+) m · grade ([\d.]+) %", said)
    assert numbers is not None, said
    s, height, grade = (float(number) for number in numbers.groups())
    # The profile points at the station nearest to the click.
    assert s == pytest.approx(50.0, abs=5.1)
    exact = float(elevation(file, np.array([1]), np.array([s]))[0])
    assert height == pytest.approx(exact, abs=0.01 + 0.05 * 0.2 * s / 100)
    assert grade == pytest.approx(0.2 * s, abs=0.02)
    assert "tunnel" in page.text("#content")
    assert "20\u201360 m" in page.text("#content")
    assert troubles(page) == []


def test_the_pointer_shows_place_and_height(page: Page, report: Path, file: OpenDrive) -> None:
    page.open(report)
    px, py = at(page, file, 0, 60.0, 2.0)
    page.move(px, py)
    page.wait("document.getElementById('place').textContent.includes('road 1')")
    said = page.text("#place")
    x, y, z = (float(re.search(rf"{name} (-?[\d.]+)", said).group(1)) for name in "xyz")  # type: ignore[union-attr]
    assert (x, y) == pytest.approx((60.0, 2.0), abs=0.5)
    assert z == pytest.approx(10.0 + 0.05 * x, abs=0.02)
    lat, lon = (float(word) for word in re.findall(r"(\d+\.\d{6})", said))
    assert lat == pytest.approx(50.0, abs=1e-4)
    assert lon == pytest.approx(11.0 + 60.0 / 71_700, abs=1e-4)


def test_the_colour_switch_repaints_the_map(page: Page, report: Path, file: OpenDrive) -> None:
    page.open(report)
    colours = {}
    # Beside the street's name, off its edges and marks.
    x, y = at(page, file, 0, 6.0, -1.7)
    for mode in ("type", "height", "grade", "error", "speed", "finding", "class"):
        page.choose("mode", mode)
        image = pixels(page, page.driver.get_screenshot_as_base64())
        colours[mode] = tuple(image[round(y), round(x)].tolist())
        assert page.text("#legend h2") != ""
    assert colours["type"] == (0x5D, 0x6B, 0x7A)
    # 2 m above the elevation model is the ramp's upper end: orange.
    red, _, blue = colours["error"]
    assert red > blue + 40
    assert len({colours[mode] for mode in ("type", "height", "grade", "error", "speed")}) == 5
    assert troubles(page) == []


def test_the_view_in_3d_draws_roads_and_turns(page: Page, report: Path) -> None:
    page.open(report)
    page.run("document.getElementById('view-3d').click()")
    page.wait("window.osm2xodr.state.scene !== null && document.getElementById('scene-message').textContent === ''")
    shot = "return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() =>"
    shot += " done(document.getElementById('canvas').toDataURL('image/png').split(',')[1]))))"
    before = pixels(page, page.run(shot))
    assert len(np.unique(before.reshape(-1, 3), axis=0)) > 50
    page.run(
        "const box = document.getElementById('exaggeration'); box.value = 9; box.dispatchEvent(new Event('input'))"
    )
    higher = pixels(page, page.run(shot))
    assert np.count_nonzero(np.abs(before - higher).sum(axis=2)) > 1000
    page.drag((500.0, 400.0), (700.0, 420.0))
    assert np.count_nonzero(np.abs(higher - pixels(page, page.run(shot))).sum(axis=2)) > 1000
    assert troubles(page) == []


def test_names_of_the_file_run_nothing(page: Page, report: Path) -> None:
    page.open(report)
    for tab in ("overview", "road", "accuracy", "coverage", "findings", "log"):
        page.run("document.getElementById(arguments[0]).click()", f"tab-{tab}")
        page.run("document.querySelectorAll('summary').forEach((item) => item.click())")
        page.run("window.osm2xodr.openRoad(0, 10, true)") if tab == "road" else None
    page.run(
        "const box = document.getElementById('search'); box.value = 'script'; box.dispatchEvent(new Event('input'))"
    )
    assert HOSTILE in page.text("#results")
    assert page.value("window.owned === undefined")
    assert page.value("document.querySelectorAll('body img, #panel script, #results script').length") == 0
    # And if something did get in, the page's policy would stop it.
    page.run(
        "const s = document.createElement('script'); s.textContent = 'window.owned = 3'; document.body.append(s);"
        " document.body.insertAdjacentHTML('beforeend', \"<img src=x onerror='window.owned=4'>\")"
    )
    assert page.value("window.owned === undefined")
    assert any("Content Security Policy" in line for line in page.troubles())


def test_a_click_on_a_junction_lists_its_roads(page: Page, report: Path) -> None:
    page.open(report)
    x0, y0 = page.value("window.osm2xodr.data.info.origin")
    page.click(*page.run("return window.osm2xodr.pixelOf(...arguments)", 130.0 - x0, 0.0 - y0))
    assert "Connecting roads (1)" in page.text("#content")
    assert "Corner" in page.text("#content")


def search(page: Page, words: str) -> None:
    """Type words into the search and press Enter."""
    page.run(
        "const box = document.getElementById('search'); box.value = arguments[0];"
        " box.dispatchEvent(new Event('input'));"
        " box.dispatchEvent(new KeyboardEvent('keydown', {key: 'Enter'}))",
        words,
    )


def test_search_finds_roads_junctions_and_ways(page: Page, report: Path) -> None:
    page.open(report)
    for words, wanted in (("2", "Road 2"), ("way/4", "Road 1")):
        search(page, words)
        assert page.text("#profile-title").startswith(wanted)
    search(page, "7")
    assert "Connecting roads (1)" in page.text("#content")
    assert "Roads that meet here (2)" in page.text("#content")


def test_the_address_keeps_what_is_shown(page: Page, report: Path) -> None:
    page.open(report, "#mode=grade&road=2")
    assert page.value("document.getElementById('mode').value") == "grade"
    assert page.text("#profile-title") == "Road 2"
    page.choose("mode", "speed")
    assert "mode=speed" in page.value("location.hash")
    assert "road=2" in page.value("location.hash")


def test_ways_without_a_road_link_to_openstreetmap(page: Page, report: Path) -> None:
    page.open(report)
    page.run("document.getElementById('tab-coverage').click()")
    links = page.value("Array.from(document.querySelectorAll('#content a')).map((a) => [a.href, a.rel])")
    assert links == [["https://www.openstreetmap.org/way/5", "noopener noreferrer"]]


def test_the_map_needs_no_webgl(tmp_path: Path, report: Path) -> None:
    with browser(tmp_path / "profile", "--disable-3d-apis") as page:
        page.open(report)
        assert page.value("document.querySelectorAll('.leaflet-tile-container canvas').length") > 0
        page.run("document.getElementById('view-3d').click()")
        page.wait("document.getElementById('scene-message').textContent.includes('no WebGL')")


def test_lines_for_corrections_are_offered(page: Page, tmp_path: Path) -> None:
    """For the ways of a road, with its values, for the nodes of a junction, and beside guesses."""
    area, out, shown = write_area(tmp_path), tmp_path / "village.xodr", tmp_path / "village.html"
    assert main(["convert", str(area), "-o", str(out), "--html", str(shown), "-q"]) == 0
    page.open(shown)
    road = page.value("window.osm2xodr.data.info.user")
    west = next(number for number, items in sorted(road.items()) if ["osm_way_ids", "10"] in items)
    page.run(f"window.osm2xodr.openRoad({west})")
    lines = page.text("#content pre.line").splitlines()
    assert lines[0] == "way.10.lanes = 2"
    assert lines[2] == "way.10.speed = 50"
    known = tmp_path / "known.toml"
    page.run("window.osm2xodr.openJunction(0)")
    junction = page.text("#content pre.line").splitlines()
    assert junction == ["node.2.z = 0.00", "node.2.no-u-turn = true"]
    known.write_text("\n".join([*lines, *junction]), encoding="utf-8")
    assert len(list(read_corrections(known).entries())) == 5
    page.run("document.getElementById('tab-log').click()")
    page.run("for (const item of document.querySelectorAll('#content details')) item.open = true")
    page.wait("document.querySelectorAll('#content code.line').length > 0")
    offered = page.value(
        "Array.from(document.querySelectorAll('#content code.line')).map((item) => item.textContent)"
    )
    assert {"way.11.lanes = 2", "way.11.speed = 50"} <= set(offered)
    assert troubles(page) == []
