"""Pages of maps in which every text is markup, in files whose names are markup: no script runs, nothing is loaded."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import pytest
from browser import Page, troubles
from lxml import etree
from page_cases import write_plane
from viewed_file import HOSTILE, hostile, viewed_file, viewed_text

from osm2xodr.cli import main

# As far as a file's name can be: no slash, and not too long.
NAME: Final = "a\"'><img src=x onerror=window.owned=5><script>window.owned=6"
TABS: Final = ("overview", "road", "accuracy", "coverage", "findings", "log")
# Attributes that are free text, by element.
TEXTS: Final = {
    "header": ("name", "vendor", "date"),
    "road": ("name",),
    "junction": ("name", "type"),
    "signal": ("name", "type", "subtype", "country", "text", "unit", "id", "countryRevision"),
    "object": ("name", "type", "subtype", "id"),
    "tunnel": ("name", "id", "type"),
    "controller": ("name", "type", "id"),
    "lane": ("type",),
    "roadMark": ("type", "color"),
    "type": ("type", "country"),
    "userData": ("code", "value"),
}


def all_hostile(text: str) -> bytes:
    """Return the document with markup in each attribute that is free text, and in attributes nobody knows."""
    root = etree.fromstring(text.encode())
    for element in root.iter():
        if not isinstance(element.tag, str):
            continue
        for name in TEXTS.get(element.tag, ()):
            element.set(name, HOSTILE)
        if element.tag in ("road", "junction", "header", "signal", "object"):
            etree.SubElement(element, "userData", code=HOSTILE, value=HOSTILE)
    etree.SubElement(root, "controller", id="1", name=HOSTILE, type=HOSTILE)
    return etree.tostring(root)


TAGS: Final = "".join(
    f'<tag k="{key}" v="{hostile(HOSTILE)}"/>'
    for key in ("name", "ref", "lanes", "maxspeed", "width", "turn:lanes", "layer", "surface", "destination")
)
AREA: Final = """<osm version="0.6" generator="HOSTILE">
<node id="1" lat="50.0" lon="11.0"><tag k="highway" v="traffic_signals"/><tag k="name" v="HOSTILE"/></node>
<node id="2" lat="50.002" lon="11.0"/>
<node id="3" lat="50.0" lon="11.003"/>
<node id="4" lat="49.998" lon="11.0"/>
<node id="5" lat="50.001" lon="11.0"><tag k="traffic_sign" v="HOSTILE"/></node>
<node id="6" lat="50.0" lon="11.001"><tag k="highway" v="give_way"/><tag k="direction" v="HOSTILE"/></node>
<node id="7" lat="49.999" lon="11.0"><tag k="traffic_sign" v="city_limit"/><tag k="name" v="HOSTILE"/></node>
<node id="8" lat="50.0005" lon="11.00005"><tag k="highway" v="bus_stop"/><tag k="name" v="HOSTILE"/></node>
<node id="9" lat="50.0005" lon="11.0"><tag k="barrier" v="HOSTILE"/></node>
<way id="1"><nd ref="4"/><nd ref="7"/><nd ref="1"/><nd ref="9"/><nd ref="5"/><nd ref="2"/>
<tag k="highway" v="secondary"/>TAGS</way>
<way id="2"><nd ref="1"/><nd ref="6"/><nd ref="3"/><tag k="highway" v="residential"/>TAGS</way>
<way id="3"><nd ref="2"/><nd ref="3"/><tag k="highway" v="HOSTILE"/></way>
</osm>
""".replace("TAGS", TAGS).replace("HOSTILE", hostile(HOSTILE))


def look_everywhere(page: Page) -> None:
    """Open each tab, road, junction and fold of a page, and search."""
    page.run(
        "const box = document.getElementById('search'); box.value = 'script'; box.dispatchEvent(new Event('input'))"
    )
    for tab in TABS:
        page.run("document.getElementById(arguments[0])?.click()", f"tab-{tab}")
        page.run("document.querySelectorAll('summary').forEach((item) => item.click())")
    for road in range(page.value("window.osm2xodr.data.info.road.name.length")):
        page.run("window.osm2xodr.openRoad(arguments[0], 1, true)", road)
        page.run("document.querySelectorAll('summary').forEach((item) => item.click())")
    for signal in range(page.value("window.osm2xodr.data.info.signals.length")):
        page.run("window.osm2xodr.openSignal(arguments[0], true)", signal)
    junctions = page.value("window.osm2xodr.data.info.junctions")
    for x, y in zip(junctions["x"], junctions["y"], strict=True):
        page.click(*page.run("return window.osm2xodr.pixelOf(...arguments)", x, y))


def assert_inert(page: Page) -> None:
    """Nothing has run, nothing was made of the markup, and the page's policy had nothing to stop."""
    assert page.value("window.owned === undefined")
    assert page.value("document.querySelectorAll('body img, #panel script, #results script').length") == 0
    assert troubles(page) == []


def test_a_network_in_which_every_text_is_markup(page: Page, tmp_path: Path) -> None:
    source = tmp_path / f"{NAME}.xodr"
    source.write_bytes(all_hostile(viewed_text()))
    out = tmp_path / f"{NAME}.html"
    assert main(["report", str(source), "-o", str(out)]) == 0
    page.open(out)
    look_everywhere(page)
    assert_inert(page)
    assert HOSTILE in page.text("#results")
    info = page.value("window.osm2xodr.data.info")
    assert dict(info["signals"][0][9])["type"] == HOSTILE
    assert info["object_types"] == [HOSTILE]
    assert info["controllers"][0][1] == HOSTILE
    assert info["junctions"]["name"] == [HOSTILE]


def test_a_conversion_in_which_every_text_is_markup(page: Page, tmp_path: Path) -> None:
    area = tmp_path / f"{NAME}.osm"
    area.write_text(AREA, encoding="utf-8")
    out = tmp_path / f"{NAME}.html"
    assert main(["convert", str(area), "-o", str(tmp_path / f"{NAME}.xodr"), "--html", str(out), "-q"]) == 0
    page.open(out)
    look_everywhere(page)
    assert_inert(page)
    info = page.value("window.osm2xodr.data.info")
    assert HOSTILE in info["road"]["name"][0]
    told = " ".join(item[3] for item in info["log"]["items"])
    assert f"maxspeed={HOSTILE}" in told
    assert "highway=</script><script>" in told
    assert "barrier=</script><script>" in told


def test_a_comparison_of_elevation_models_whose_names_are_markup(page: Page, tmp_path: Path) -> None:
    write_plane(tmp_path, viewed_file(tmp_path)).rename(tmp_path / f"{NAME}.tif")
    out = tmp_path / f"{NAME}.html"
    assert main(["surface", str(tmp_path / f"{NAME}.tif"), "-o", str(out), "-q"]) == 0
    page.driver.get(out.as_uri())
    assert page.value("window.owned === undefined")
    assert NAME in page.text("h2")
    assert page.value("Array.from(document.images).every((image) => image.naturalWidth > 0)")
    assert page.value("document.images.length") == 8
    assert page.value("document.querySelectorAll('script').length") == 0
    assert troubles(page) == []


@pytest.mark.parametrize("command", ["render", "export"])
def test_other_views_escape_what_is_markup(command: str, tmp_path: Path) -> None:
    source = tmp_path / f"{NAME}.xodr"
    source.write_bytes(all_hostile(viewed_text()))
    out = tmp_path / f"out.{'svg' if command == 'render' else 'geojson'}"
    assert main([command, str(source), "-o", str(out)]) == 0
    text = out.read_text(encoding="utf-8")
    if command == "render":
        kinds = {str(item.tag).rpartition("}")[2] for item in etree.fromstring(text.encode()).iter()}
        assert kinds.isdisjoint({"script", "img", "image", "foreignObject", "a", "use"})
        assert "<script" not in text
    else:
        assert HOSTILE in text
