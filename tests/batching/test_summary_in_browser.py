"""The page of a batch in a real browser: colours, order, filter, keys; names run nothing."""

from __future__ import annotations

from pathlib import Path

import pytest
from batch_results import leave_files, rectangle, result
from browser import Page, browser
from viewed_file import HOSTILE

from osm2xodr.batching.model import Status
from osm2xodr.batching.summary import write_summary

# Three by three squares, the first row in the south; the last area is nowhere.
_STATES = (
    *(Status.DONE, Status.FAILED, Status.EMPTY),
    *(Status.UNCHANGED, Status.DONE, Status.DONE),
    *(Status.DONE, Status.UNCHANGED, Status.FAILED),
)


@pytest.fixture(scope="module")
def index(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("out")
    results = [
        result(
            f"n{k + 7}",
            status,
            "It is broken." if status is Status.FAILED else "",
            outline_deg=rectangle(7.0 + k % 3 * 0.1, 43.0 + k // 3 * 0.08, 0.1, 0.08),
        )
        for k, status in enumerate(_STATES)
    ]
    results.append(result("nowhere"))
    leave_files(out, results)
    write_summary(out, results)
    return out / "index.html"


def names(page: Page) -> list[str]:
    """Return the names of the rows that are shown, from the top."""
    rows = "Array.from(document.querySelectorAll('tbody tr')).filter((row) => row.offsetHeight)"
    found = page.value(f"{rows}.map((row) => row.cells[0].textContent)")
    return [str(name) for name in found]


def area(name: str) -> str:
    """Return JavaScript that finds an area on the map."""
    return f"Array.from(document.querySelectorAll('#map a')).find((a) => a.textContent.startsWith('{name}:'))"


def press(page: Page, heading: str) -> None:
    page.run(
        "Array.from(document.querySelectorAll('thead button'))"
        ".find((button) => button.textContent === arguments[0]).click()",
        heading,
    )


def key(page: Page, name: str) -> None:
    page.run(
        "document.getElementById('map')"
        ".dispatchEvent(new KeyboardEvent('keydown', {key: arguments[0], bubbles: true, cancelable: true}))",
        name,
    )


def words(page: Page, text: str) -> None:
    page.run(
        "const box = document.getElementById('find'); box.value = arguments[0];"
        " box.dispatchEvent(new Event('input'))",
        text,
    )


def test_the_page_opens_without_complaint(page: Page, index: Path) -> None:
    page.open(index)
    assert page.text("h1") == "10 areas"
    assert names(page) == ["n8", "n15", "n9", "n7", "n11", "n12", "n13", "nowhere", "n10", "n14"]
    assert page.value("document.querySelectorAll('#map .shape').length") == 9
    assert page.text("#scale") == "10 km"
    assert page.troubles() == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_statuses_differ_by_colour_pattern_and_sign(page: Page, index: Path, scheme: str) -> None:
    media = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    page.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
    page.open(index)
    fills = [
        page.value(f"getComputedStyle({area(name)}.querySelector('.shape')).fill")
        for name in ("n7", "n8", "n9", "n10")
    ]
    page.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    assert len(set(fills)) == 4
    assert [fill for fill in fills if "url" in fill] == ['url("#p-empty")', 'url("#p-unchanged")']
    assert page.value(f"{area('n8')}.querySelector('use').getAttribute('href')") == "#s-failed"
    # The legend draws each as the map does.
    for status, fill in zip(("done", "failed", "empty", "unchanged"), fills, strict=True):
        drawn = page.value(f"document.querySelector('#statuses .{status} .shape') !== null")
        assert drawn, fill


def test_headings_sort(page: Page, index: Path) -> None:
    page.open(index)
    press(page, "Area")
    assert names(page) == [*(f"n{k}" for k in range(7, 16)), "nowhere"]
    press(page, "Area")
    assert names(page)[:2] == ["nowhere", "n15"]
    press(page, "Roads km")
    # What has no figures comes last, in whatever direction.
    assert names(page)[:3] == ["nowhere", "n14", "n13"]
    assert page.value("document.querySelector('[aria-sort]').textContent") == "Roads km"
    press(page, "Roads km")
    assert names(page)[:3] == ["n7", "n10", "n11"]
    assert names(page)[-3:] == ["n8", "n15", "n9"]
    press(page, "Memory MB")
    assert names(page)[-2:] == ["n10", "n14"]


def test_statuses_and_words_filter_table_and_map(page: Page, index: Path) -> None:
    page.open(index)
    page.run("document.querySelector('#statuses .failed').click()")
    assert names(page) == ["n8", "n15"]
    assert page.value("document.querySelectorAll('#map a:not(.out)').length") == 2
    assert page.text("#shown") == "2 of 10"
    page.run("document.querySelector('#statuses .empty').click()")
    words(page, "N9")
    assert names(page) == ["n9"]
    page.run("document.getElementById('clear').click()")
    assert len(names(page)) == 10
    words(page, "broken")
    assert names(page) == ["n8", "n15"]


def test_a_click_on_the_map_shows_the_area(page: Page, index: Path) -> None:
    page.open(index)
    x, y = page.value(
        f"(() => {{ const box = {area('n11')}.getBoundingClientRect();"
        " return [box.x + box.width / 2 + 20, box.y + box.height / 2]; })()"
    )
    page.click(x, y)
    assert page.text("#card h3") == "n11"
    assert (
        "5.00 km in 12 roads, 5 junctions · -3.3 to 1,234.5 m high · grades up to 12.3 % · took 12.3 s"
        in page.text("#card")
    )
    links = page.value("Array.from(document.querySelectorAll('#card a')).map((a) => a.getAttribute('href'))")
    assert links[:2] == ["./n11.xodr", "./n11.json"]
    assert links[3] == "https://www.openstreetmap.org/#map=14/43.12001/7.15000"
    assert page.value("document.querySelector('tr.here').cells[0].textContent") == "n11"


def test_keys_go_from_area_to_area(page: Page, index: Path) -> None:
    page.open(index)
    seen = []
    for name in ("ArrowUp", "ArrowUp", "ArrowLeft", "ArrowDown", "ArrowRight", "ArrowDown", "ArrowDown"):
        key(page, name)
        seen.append(page.text("#card h3"))
    # The first press chooses the first area that failed; there is nothing below the last one.
    assert seen == ["n8", "n11", "n10", "n7", "n8", "n8", "n8"]
    before = page.value("document.getElementById('map').viewBox.baseVal.width")
    key(page, "+")
    assert page.value("document.getElementById('map').viewBox.baseVal.width") == pytest.approx(before / 1.5)
    key(page, "0")
    assert page.value("document.getElementById('map').viewBox.baseVal.width") == pytest.approx(before)
    key(page, "ArrowUp")
    key(page, "Enter")
    assert page.value("document.activeElement.getAttribute('href')") == "./n11.xodr"
    key(page, "Escape")
    assert page.value("document.getElementById('card').hidden") is True


def test_the_list_of_failures_leads_to_the_map(page: Page, index: Path) -> None:
    page.open(index)
    page.run("document.querySelectorAll('#failures a')[1].click()")
    assert page.text("#card h3") == "n15"
    assert "It is broken." in page.text("#card")
    page.open(index, "#a0")
    assert page.text("#card h3") == "n8"


def test_names_run_nothing(page: Page, tmp_path: Path) -> None:
    hostile = [
        HOSTILE.replace("/", ""),
        "=cmd|' C'!A0",
        "a' onmouseover='window.owned=3",
        "javascript:window.owned=4",
    ]
    results = [
        result(f"{name} {k}", status, HOSTILE, outline_deg=rectangle(7.0 + 0.1 * k, 43.0, 0.1, 0.08))
        for k, (name, status) in enumerate(zip(hostile, Status, strict=True))
    ]
    leave_files(tmp_path, results)
    write_summary(tmp_path, results)
    page.open(tmp_path / "index.html")
    for _ in results:
        key(page, "ArrowRight")
        page.run("document.querySelector('#card a').focus()")
    for k in range(4):
        page.run(
            "document.querySelectorAll('#map a')[arguments[0]]"
            ".dispatchEvent(new MouseEvent('click', {bubbles: true, cancelable: true}))",
            k,
        )
    words(page, "script")
    assert HOSTILE in page.text("#areas")
    assert page.value("window.owned === undefined")
    assert page.value("document.querySelectorAll('body img, #areas script, #card script, #map script').length") == 0
    links = page.value("Array.from(document.querySelectorAll('tbody a')).map((a) => a.href)")
    assert links
    assert all(str(link).startswith(tmp_path.as_uri()) for link in links)
    assert page.troubles() == []
    # And if something did get in, the page's policy would stop it.
    page.run(
        "const s = document.createElement('script'); s.textContent = 'window.owned = 5'; document.body.append(s);"
    )
    assert page.value("window.owned === undefined")


def test_two_thousand_tiles_open_quickly(page: Page, tmp_path: Path) -> None:
    states = [Status.FAILED if k % 97 == 0 else Status.DONE for k in range(2000)]
    results = [
        result(
            f"tile_{k % 50}_{k // 50}",
            status,
            "It is broken." if status is Status.FAILED else "",
            outline_deg=rectangle(9.0 + k % 50 * 0.06, 46.0 + k // 50 * 0.04, 0.06, 0.04),
        )
        for k, status in enumerate(states)
    ]
    leave_files(tmp_path, results)
    write_summary(tmp_path, results)
    page.driver.execute_cdp_cmd("Performance.enable", {"timeDomain": "threadTicks"})
    page.open(tmp_path / "index.html")
    found = page.driver.execute_cdp_cmd("Performance.getMetrics", {})["metrics"]
    spent = {item["name"]: item["value"] for item in found}["TaskDuration"]
    # Seconds of the processor: 0.4 on a machine of 2023; others that run at the same time do not count.
    assert spent < 2.0
    before = len(names(page))
    assert before < 700
    # Further rows come when the reader does.
    page.run("const box = document.querySelector('.scroll'); box.scrollTop = box.scrollHeight")
    shown = "Array.from(document.querySelectorAll('tbody tr')).filter((row) => !row.hidden).length"
    page.wait(f"{shown} > {before}")
    words(page, "tile_49_39")
    assert names(page) == ["tile_49_39"]
    assert page.troubles() == []


def test_without_scripts_everything_is_there(tmp_path: Path, index: Path) -> None:
    with browser(tmp_path / "profile") as page:
        page.driver.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
        page.driver.get(f"{index.as_uri()}#a0")
        page.driver.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})
        assert len(names(page)) == 10
        assert page.value("document.querySelectorAll('#map .shape').length") == 9
        assert page.value("document.querySelector('.bar').hidden") is True
