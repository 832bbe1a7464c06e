"""Stations and borders: they lie where the space of roads says.

Whom a file owes its data stands in pictures and on the page.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from lxml import etree
from page_cases import info_of
from PIL import Image
from viewed_file import viewed_file, viewed_text
from xodr_text import cubics, document, lane, read_text, road, section

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.opendrive.space import elevation, pose, surface_points
from osm2xodr.opendrive.tables import OpenDrive
from osm2xodr.viewing import PictureOptions, ReportOptions
from osm2xodr.viewing.page import make_report
from osm2xodr.viewing.page.accuracy import station_lengths
from osm2xodr.viewing.picture.contents import make_picture
from osm2xodr.viewing.picture.drawing import draw_png, draw_svg
from osm2xodr.viewing.scene import credits_of, make_scene

OSM = "© OpenStreetMap contributors, Open Database License 1.0 (ODbL)"
DEM = "© DLR e.V. 2010-2014 and © Airbus Defence and Space GmbH 2014-2018"


def test_borders_of_a_street_run_from_left_to_right(tmp_path: Path) -> None:
    file = viewed_file(tmp_path)
    scene = make_scene(file, 0.03, 10.0)
    assert scene.strip_road.tolist() == [0, 1, 2]
    first = scene.border[: scene.border_start[1]].reshape(-1, 4)
    assert first[0].tolist() == [5.5, 3.5, 0.0, -3.5]
    # The right lane widens by 0.05 per metre from 60 m on.
    assert first[-1].tolist() == pytest.approx([5.5, 3.5, 0.0, -6.5])
    assert [file.lanes.id[row] for row in scene.lane[:3]] == [2, 1, -1]
    assert scene.s[0] == 0.0
    assert scene.s[scene.station_start[1] - 1] == 120.0


def test_places_are_those_of_road_space(tmp_path: Path) -> None:
    file = viewed_file(tmp_path)
    scene = make_scene(file, 0.03, 10.0)
    x, y, heading = pose(file, scene.station_road, scene.s)
    np.testing.assert_allclose(np.stack((scene.x, scene.y)), np.stack((x, y)), atol=1e-9)
    np.testing.assert_allclose(scene.heading, heading, atol=1e-12)
    np.testing.assert_allclose(scene.z, elevation(file, scene.station_road, scene.s), atol=1e-12)
    at = scene.border_station()
    wanted = surface_points(file, scene.station_road[at], scene.s[at], scene.border)
    np.testing.assert_allclose(np.stack(scene.border_places()), np.stack(wanted), atol=1e-9)


def test_chords_stay_close_to_the_bend(tmp_path: Path) -> None:
    scene = make_scene(viewed_file(tmp_path), 0.03, 10.0)
    rows = slice(int(scene.station_start[1]), int(scene.station_start[2]))
    step = np.diff(scene.s[rows])
    # Sagitta of a chord on a circle of 100 m, whose outer border lies at 103.5 m.
    assert np.max(step**2 / 8.0 / 100.0 * 1.035) <= 0.03 + 1e-9


def test_a_step_of_the_lane_offset_belongs_to_the_section_behind_it(tmp_path: Path) -> None:
    lanes = (
        cubics("laneOffset", (0, 0.0), (50, 2.0))
        + section(0.0, right=lane(-1, (0, 3.0)))
        + section(50.0, right=lane(-1, (0, 3.0)) + lane(-2, (0, 2.0), kind="biking"))
    )
    scene = make_scene(read_text(tmp_path, document(road("1", lanes=lanes))), 0.03, 10.0)
    assert scene.strip_borders.tolist() == [2, 3]
    assert scene.border[: scene.border_start[1]].reshape(-1, 2)[-1].tolist() == [0.0, -3.0]
    assert scene.border[scene.border_start[1] :].reshape(-1, 3)[0].tolist() == [2.0, -1.0, -3.0]
    assert scene.s[scene.station_start[1] - 1] == scene.s[scene.station_start[1]] == 50.0
    assert station_lengths(scene).sum() == pytest.approx(100.0)


def test_roads_that_cannot_be_drawn_are_left_out(tmp_path: Path) -> None:
    text = document(road("1", plan=""), road("2", lanes=""), road("3"))
    scene = make_scene(read_text(tmp_path, text), 0.03, 10.0)
    assert scene.strip_road.tolist() == [2]


def test_some_strips_alone_are_as_they_were(tmp_path: Path) -> None:
    scene = make_scene(viewed_file(tmp_path), 0.03, 10.0)
    order = np.array([2, 0])
    part = scene.only(order)
    assert part.strip_road.tolist() == scene.strip_road[order].tolist()
    x, y, _ = scene.border_places()
    own_x, own_y, _ = part.border_places()
    for k, strip in enumerate(order.tolist()):
        old = slice(int(scene.border_start[strip]), int(scene.border_start[strip + 1]))
        new = slice(int(part.border_start[k]), int(part.border_start[k + 1]))
        assert own_x[new].tolist() == x[old].tolist()
        assert own_y[new].tolist() == y[old].tolist()
        lanes = slice(int(scene.lane_start[strip]), int(scene.lane_start[strip + 1]))
        own = slice(int(part.lane_start[k]), int(part.lane_start[k + 1]))
        assert part.lane[own].tolist() == scene.lane[lanes].tolist()
    assert scene.only(np.arange(len(scene.strip_road))).border.tolist() == scene.border.tolist()


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
