"""Damaged files are shown as far as they can be: the page and the picture are there, or one sentence says why not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from browser import browser
from lxml import etree
from map_damage import DAMAGES, Damage
from page_cases import info_of
from t_junction import sound_tree

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.opendrive.reader import read_xodr
from osm2xodr.viewing import PictureOptions, ReportOptions
from osm2xodr.viewing.page import make_report
from osm2xodr.viewing.picture.contents import make_picture
from osm2xodr.viewing.picture.drawing import draw_png, draw_svg


def damaged(item: Damage, folder: Path) -> Path:
    tree = sound_tree()
    item.change(tree)
    path = folder / f"{item.name}.xodr"
    path.write_bytes(etree.tostring(tree))
    return path


@pytest.mark.parametrize("item", DAMAGES, ids=lambda item: item.name)
def test_a_damaged_file_is_shown(item: Damage, tmp_path: Path) -> None:
    try:
        file = read_xodr(damaged(item, tmp_path))
    except InputError:
        return
    info = info_of(make_report(file, ReportOptions(check=False), Diagnostics()))
    assert len(info["road"]["id"]) == len(file.roads.id)
    assert np.isfinite(info["bounds"]).all()
    try:
        picture = make_picture(file, PictureOptions(width=300))
    except InputError:
        return
    assert etree.fromstring(draw_svg(picture)).get("width") == "300"
    assert draw_png(picture).startswith(b"\x89PNG")


def test_pages_of_damaged_files_open_and_show_each_road(tmp_path: Path) -> None:
    # Kinds that reach the page as gaps in its numbers: one of each twenty.
    chosen = [item for k, item in enumerate(DAMAGES) if k % 20 == 0]
    with browser(tmp_path / "profile") as page:
        for item in chosen:
            try:
                report = make_report(damaged(item, tmp_path), ReportOptions(), Diagnostics())
            except InputError:
                continue
            out = tmp_path / f"{item.name}.html"
            out.write_bytes(report)
            page.open(out)
            page.run(
                "const { data, openRoad } = window.osm2xodr;"
                " for (let k = 0; k < data.info.road.id.length; k++) openRoad(k, 1, true);"
            )
            page.run("document.getElementById('tab-findings').click()")
            page.run("document.querySelectorAll('summary').forEach((summary) => summary.click())")
            assert page.troubles() == [], item.name
