"""Whom a file owes its data stands in pictures and on the page."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from lxml import etree
from page_cases import info_of
from PIL import Image
from viewed_file import viewed_text
from xodr_text import read_text

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.opendrive.tables import OpenDrive
from osm2xodr.viewing import PictureOptions, ReportOptions
from osm2xodr.viewing.credits import credits_of
from osm2xodr.viewing.page.html import make_report
from osm2xodr.viewing.picture.contents import make_picture
from osm2xodr.viewing.picture.png import draw_png
from osm2xodr.viewing.picture.svg import draw_svg

OSM = "© OpenStreetMap contributors, Open Database License 1.0 (ODbL)"
DEM = "© DLR e.V. 2010-2014 and © Airbus Defence and Space GmbH 2014-2018"


def credited(folder: Path, *pairs: tuple[str, str]) -> OpenDrive:
    data = "".join(f'<userData code="{code}" value="{value}"/>' for code, value in pairs)
    return read_text(folder, viewed_text("Town").replace("</header>", f"{data}</header>"))


def test_each_source_is_named_once(tmp_path: Path) -> None:
    pairs = (("attribution", OSM), ("osm2xodr", "0.1"), ("demAttribution", DEM), ("oldAttribution", OSM))
    assert credits_of(credited(tmp_path, *pairs)) == f"{OSM}; {DEM}"
    assert credits_of(credited(tmp_path)) == ""


def test_the_svg_ends_with_the_credits(tmp_path: Path) -> None:
    file = credited(tmp_path, ("attribution", OSM), ("demAttribution", DEM))
    for width, lines in ((900, 1), (500, 2)):
        picture = make_picture(file, PictureOptions(width=width))
        assert len(picture.credits) == lines
        tree = etree.fromstring(draw_svg(picture))
        texts = [item for item in tree.iter("{*}text") if item.get("font-size") == "11.0"]
        last = [item for item in texts if item.text in picture.credits]
        assert " ".join(str(item.text) for item in last) == f"{OSM}; {DEM}"
        # Within the picture and below the legend.
        places = [float(str(item.get("y"))) for item in last]
        assert picture.map_height + picture.band < places[0]
        assert places[-1] < picture.height == int(str(tree.get("height")))


def test_the_png_shows_the_credits_below_the_legend(tmp_path: Path) -> None:
    plain = make_picture(credited(tmp_path), PictureOptions(width=600))
    named = make_picture(credited(tmp_path, ("attribution", OSM)), PictureOptions(width=600))
    assert named.height == plain.height + 24
    image = np.asarray(Image.open(io.BytesIO(draw_png(named))).convert("L"), np.int64)
    assert image.shape == (named.height, 600)
    line = image[plain.height :]
    # Letters are dark on white, over more than half of the width, and nothing is cut off.
    columns = np.flatnonzero((line < 160).any(axis=0))
    assert 10 < columns.min() < 30
    assert 300 < columns.max() < 590
    np.testing.assert_array_equal(line[-4:], 255)


@pytest.mark.parametrize("draw", [draw_svg, draw_png])
def test_a_file_may_say_anything(draw: Callable[..., bytes], tmp_path: Path) -> None:
    picture = make_picture(credited(tmp_path, ("attribution", "x" * 5000 + " y" * 5000)), PictureOptions(width=200))
    assert len(picture.credits) == 4
    assert picture.credits[-1].endswith("…")
    assert len(draw(picture)) > 1000


def test_the_page_has_the_credits(tmp_path: Path) -> None:
    page = make_report(credited(tmp_path, ("attribution", OSM)), ReportOptions(check=False), Diagnostics())
    assert info_of(page)["credits"] == OSM
