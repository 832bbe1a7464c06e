"""Pictures: what is drawn where, in which colour, and the same every time."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lxml import etree
from PIL import Image
from street_cases import Case
from viewed_file import HOSTILE, viewed_file
from xodr_text import LINE, cubics, document, geometry, lane, read_text, road, section

from osm2xodr.defaults import UNMEASURED_HEIGHTS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.model import IntArray, Rule
from osm2xodr.opendrive.reader import read_xodr
from osm2xodr.opendrive.space import frame_of
from osm2xodr.opendrive.tables import OpenDrive
from osm2xodr.viewing import PictureOptions, write_picture
from osm2xodr.viewing.colours import Categories, Ramp
from osm2xodr.viewing.picture.contents import Picture, box_of_degrees, make_picture
from osm2xodr.viewing.picture.details import HATCHING, Line, Polygon
from osm2xodr.viewing.picture.drawing import draw_png, draw_svg
from osm2xodr.xodrWriter import WriteOptions, write_xodr

# 800 pixels for 160 m: five per metre.
BOX = (0.0, -40.0, 160.0, 40.0)
OPTIONS = PictureOptions(BOX, 800)
RAIL = {"t": -2, "height": 1, "zOffset": 0, "width": 1}
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def file(tmp_path: Path) -> OpenDrive:
    return viewed_file(tmp_path)


def image_of(file: OpenDrive, options: PictureOptions) -> IntArray:
    return np.asarray(Image.open(io.BytesIO(draw_png(make_picture(file, options)))).convert("RGB"), np.int64)


def at(image: IntArray, x: float, y: float) -> tuple[int, ...]:
    """Return the colour at x, y of the file, m."""
    return tuple(image[round((40.0 - y) * 5.0), round(x * 5.0)].tolist())


def test_lanes_lie_where_they_should(file: OpenDrive) -> None:
    image = image_of(file, OPTIONS)
    assert image.shape[:2] == (444, 800)
    assert at(image, 50.0, 4.5) == (0xD9, 0xC7, 0xA3)
    assert at(image, 50.0, 1.5) == at(image, 50.0, -2.0) == (0x5D, 0x6B, 0x7A)
    assert at(image, 50.0, 8.0) == at(image, 50.0, -6.0) == (0xF6, 0xF7, 0xF5)
    # The bend has left the axis by 2 m after 20 m of 100 m radius.
    assert at(image, 159.5, 2.0) == (0x5D, 0x6B, 0x7A)


def test_a_turning_circle_has_no_hole(tmp_path: Path) -> None:
    """Its strip meets itself between the curves into the circle and out of it, but nothing stays open."""
    nodes, ways = {"w": (-80.0, 0.0), "o": (0.0, 0.0)}, {1: ("w o", "width=6 lanes=2")}
    roads = Case(nodes, ways, node_tags={"o": "highway=turning_circle"}).build(Rule.RIGHT_HAND)
    with (tmp_path / "loop.xodr").open("wb") as stream:
        write_xodr(roads, stream, WriteOptions(), Diagnostics())
    # The origin is half-way along the street.
    image = image_of(read_xodr(tmp_path / "loop.xodr"), PictureOptions((30.0, -8.0, 50.0, 8.0), 400))
    rows, columns = np.nonzero(np.all(image[:320] == (0xF6, 0xF7, 0xF5), axis=2))
    off = np.hypot(columns / 20.0 - 10.0, 8.0 - rows / 20.0)
    assert off[off < 7.0].max(initial=0.0) < 0.3


def test_lanes_without_width_are_not_drawn(tmp_path: Path) -> None:
    """A sidewalk beside a street that begins at 50 m."""
    walk = lane(1, (0, 0.0), (50.0, 0.0, 0.04), kind="sidewalk")
    text = document(road(lanes=section(0.0, walk, lane(-1, (0, 3.5)))))
    shapes = make_picture(read_text(tmp_path, text), PictureOptions((0.0, -40.0, 160.0, 40.0), 800)).shapes
    (sidewalk,) = (shape for shape in shapes if isinstance(shape, Polygon) and shape.colour == "#d9c7a3")
    assert (sidewalk.corners[:, 0].min(), sidewalk.corners[:, 0].max()) == pytest.approx((250.0, 500.0), abs=0.1)


def test_roads_through_one_junction_lie_in_their_order(tmp_path: Path) -> None:
    """A sidewalk past a driveway lies under its lanes, as what fills gaps does: what is driven on shows."""
    verge = lane(2, (0, 2.0), kind="border", more='<height sOffset="0" inner="0.12" outer="0.12"/>')
    lanes = section(0.0, verge + lane(1, (0, 2.0), kind="shoulder"), lane(-1, (0, 4.0), kind="sidewalk"))
    text = document(
        road("1", geometry(LINE, 40.0, y=-2.0), 40.0, junction="9", elevation=cubics("elevation", (0, 0.01))),
        road("2", geometry(LINE, 40.0, x=20.0, y=-20.0, hdg=math.pi / 2), 40.0, junction="9", lanes=lanes),
        '<junction id="9" name=""/>',
    )
    image = image_of(read_text(tmp_path, text), OPTIONS)
    assert at(image, 22.0, 15.0) == (0xD9, 0xC7, 0xA3)
    assert {at(image, x, 0.0) for x in (17.0, 19.0, 22.0)} == {(0x5D, 0x6B, 0x7A)}
    assert at(image, 17.0, 15.0) != at(image, 19.0, 15.0) == (0x5D, 0x6B, 0x7A)


@pytest.mark.parametrize("swapped", [False, True])
def test_bicycle_lanes_lead_on_over_what_cars_drive_on(tmp_path: Path, swapped: bool) -> None:
    """Whichever comes first in the file."""
    bikes = section(0.0, right=lane(-1, (0, 4.0), kind="biking"))
    roads = [
        road("1", geometry(LINE, 40.0), 40.0, junction="9", lanes=bikes),
        road("2", geometry(LINE, 40.0, x=20.0, y=-20.0, hdg=math.pi / 2), 40.0, junction="9"),
    ]
    text = document(*(roads[::-1] if swapped else roads), '<junction id="9" name=""/>')
    image = image_of(read_text(tmp_path, text), OPTIONS)
    assert {at(image, x, -2.0) for x in (10.0, 22.0, 30.0)} == {(0x2F, 0x8F, 0x83)}
    assert at(image, 22.0, 10.0) == (0x5D, 0x6B, 0x7A)


@pytest.mark.parametrize("swapped", [False, True])
def test_a_driveway_covers_the_sidewalk_that_it_crosses(tmp_path: Path, swapped: bool) -> None:
    street = road(
        "1",
        geometry(LINE, 160.0),
        160.0,
        lanes=section(0.0, lane(-1, (0, 4.0)) + lane(-2, (0, 4.0), kind="sidewalk")),
    )
    drive = road(
        "2", geometry(LINE, 40.0, x=80.0, y=-38.0, hdg=math.pi / 2), 40.0, elevation=cubics("elevation", (0, 0.0))
    )
    image = image_of(read_text(tmp_path, document(*((drive, street) if swapped else (street, drive)))), OPTIONS)
    assert at(image, 60.0, -6.0) == (0xD9, 0xC7, 0xA3)
    assert at(image, 82.0, -6.0) == (0x5D, 0x6B, 0x7A)


def test_nothing_of_the_road_below_shows_on_a_bridge(tmp_path: Path) -> None:
    """The road below climbs a hill: most of it is higher than the bridge, and its sign stands where it begins."""
    mark = '<roadMark sOffset="0" type="solid" color="white" width="0.15"/>'
    low = lane(-1, (0, 4.0), more=mark) + lane(-2, (0, 4.0), kind="sidewalk", more=mark)
    ends = " ".join(f'{name}{end}="{value}"' for end in ("Start", "End") for name, value in RAIL.items())
    repeat = f'<repeat s="0" length="150" distance="0" {ends}/>'
    rail = f'<object id="5" type="barrier" s="0" t="-2" zOffset="0" height="1">{repeat}</object>'
    below = road(
        *("1", geometry(LINE, 160.0), 160.0),
        lanes=section(0.0, low),
        elevation=cubics("elevation", (0, 0.0, 0.25)),
        more=f"<objects>{rail}</objects>",
    )
    bridge = road(
        *("2", geometry(LINE, 60.0, x=20.0, y=-30.0, hdg=math.pi / 2), 60.0),
        lanes=section(0.0, lane(-1, (0, 8.0), kind="shoulder")),
        elevation=cubics("elevation", (0, 15.0)),
    )
    image = image_of(read_text(tmp_path, document(below, bridge)), OPTIONS)
    assert at(image, 100.0, -6.0) == (0xD9, 0xC7, 0xA3)
    on_bridge = {at(image, x, y) for x in (22.0, 24.0, 26.0) for y in np.arange(-9.0, 3.0, 0.2).tolist()}
    assert on_bridge == {(0x76, 0x82, 0x8E)}


def test_pavement_between_the_lanes_of_a_junction_looks_like_these(tmp_path: Path) -> None:
    """Not what leads on, but beside a sidewalk, nor what lies beside plain roads; nor is it in the legend."""
    asphalt = (0x5D, 0x6B, 0x7A)
    link = '<link><predecessor id="2"/></link>'
    paved, led = (
        section(0.0, lane(1, (0, 2.0), kind="shoulder", more=more), lane(-1, (0, 4.0))) for more in ("", link)
    )
    walk = lane(2, (0, 2.0), kind="sidewalk", more=link) + lane(1, (0, 2.0), kind="shoulder", more=link)
    roads = [
        road(str(k), geometry(LINE, 40.0, x=20.0, y=20.0 - 20.0 * k), 40.0, junction=junction, lanes=lanes)
        for k, (junction, lanes) in enumerate(
            (("9", paved), ("9", led), ("-1", paved), ("9", section(0.0, walk, lane(-1, (0, 4.0)))))
        )
    ]
    image = image_of(read_text(tmp_path, document(*roads, '<junction id="9" name=""/>')), OPTIONS)
    assert at(image, 40.0, 21.0) == at(image, 40.0, 18.0) == asphalt
    assert at(image, 40.0, 1.0) == at(image, 40.0, -19.0) == (0x76, 0x82, 0x8E)
    assert at(image, 40.0, -39.0) == asphalt
    shown = make_picture(read_text(tmp_path, document(roads[0], '<junction id="9" name=""/>')), OPTIONS).mode.scale
    assert isinstance(shown, Categories)
    assert [name for name, present in zip(shown.names, shown.present, strict=True) if present] == ["driving"]


def test_svg_holds_the_same_areas(file: OpenDrive) -> None:
    picture = make_picture(file, OPTIONS)
    tree = etree.fromstring(draw_svg(picture))
    assert (tree.get("width"), tree.get("height")) == ("800", "444")
    assert tree.findtext(f"{SVG}title") == HOSTILE
    assert {node.tag.removeprefix(SVG) for node in tree.iter()} == {
        "svg",
        "title",
        "clipPath",
        "rect",
        "g",
        "path",
        "polygon",
        "text",
    }
    fills = [node.get("fill") for node in tree.iter(f"{SVG}path") if node.get("fill") != "none"]
    areas = [shape for shape in picture.shapes if isinstance(shape, Polygon)]
    assert fills == [area.colour for area in areas]
    first = next(tree.iter(f"{SVG}path")).get("d")
    assert first is not None
    start, steps = first.removeprefix("M").rstrip("Z").split("l")
    numbers = np.array([float(word) for word in steps.split()]).reshape(-1, 2)
    corners = np.concatenate(([[float(word) for word in start.split()]], numbers)).cumsum(axis=0)
    np.testing.assert_allclose(corners, areas[0].corners, atol=0.051)


def test_grades_are_coloured_and_explained(file: OpenDrive) -> None:
    picture = make_picture(file, replace(OPTIONS, colour="grade"))
    street = next(shape for shape in picture.shapes if isinstance(shape, Polygon) and shape.corners[0, 0] < 1.0)
    ramp = picture.mode.scale
    assert isinstance(ramp, Ramp)
    # The street rises by 5 %; colours are those of 64 steps.
    step = (ramp.high - ramp.low) / 63.0
    shades = ramp.colours(np.linspace(5.0 - step, 5.0 + step, 50)).tolist()
    assert street.colour in {f"#{r:02x}{g:02x}{b:02x}" for r, g, b in shades}
    words = re.findall(r">([^<]+)</text>", draw_svg(picture).decode())
    assert words[:2] == ["20 m", "N"]
    assert "Grade, %" in words
    assert f"{ramp.high:.0f}" in words


@pytest.mark.parametrize("draw", [draw_svg, draw_png])
def test_the_same_file_gives_the_same_bytes(tmp_path: Path, draw: Callable[[Picture], bytes]) -> None:
    pictures = [make_picture(viewed_file(tmp_path), OPTIONS) for _ in range(2)]
    assert draw(pictures[0]) == draw(pictures[1])


def test_everything_is_shown_unless_a_box_is_given(file: OpenDrive) -> None:
    picture = make_picture(file, PictureOptions(width=500))
    corners = np.concatenate([shape.corners for shape in picture.shapes])
    margin = 0.03 * 500 / 1.06
    assert corners[:, 0].min() == pytest.approx(margin, abs=0.2)
    assert corners[:, 0].max() == pytest.approx(500 - margin, abs=0.2)
    assert corners[:, 1].min() > 10.0
    assert corners[:, 1].max() < picture.map_height - 10.0


def test_a_box_in_degrees_is_the_same_place(file: OpenDrive) -> None:
    frame, _ = frame_of(file.header)
    assert frame is not None
    lon, lat = frame.to_geographic(np.array([10.0, 90.0]), np.array([-20.0, 30.0]))
    found = box_of_degrees(file, (lon[0], lat[0], lon[1], lat[1]))
    assert found == pytest.approx((10.0, -20.0, 90.0, 30.0), abs=0.01)


def test_boxes_with_swapped_axes(file: OpenDrive) -> None:
    frame, _ = frame_of(file.header)
    assert frame is not None
    lon, lat = frame.to_geographic(np.array([10.0, 90.0]), np.array([-20.0, 30.0]))
    with pytest.raises(InputError, match="has roads within --bbox only if its axes are swapped; write west,south"):
        box_of_degrees(file, (lat[0], lon[0], lat[1], lon[1]))
    with pytest.raises(InputError, match="--bbox reaches beyond the poles; write west,south,east,north"):
        box_of_degrees(file, (10.0, 91.5, 11.0, 99.5))


def test_boxes_beyond_the_projection_raise_an_error_alone(file: OpenDrive) -> None:
    """Where no place has finite coordinates, NumPy must not warn; warnings are errors here."""
    with pytest.raises(InputError, match="--bbox lies beyond the projection of the file; give one nearer"):
        box_of_degrees(file, (100.9, 0.0, 101.0, 1e-9))


def test_what_cannot_be_drawn_is_reported(file: OpenDrive, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no road within --bbox; its roads lie at x and y within -7,-13,"):
        make_picture(file, PictureOptions((1000.0, 1000.0, 1100.0, 1100.0)))
    with pytest.raises(InputError, match="pixels; give a smaller --width or a flatter box"):
        make_picture(file, PictureOptions((0.0, -1e6, 10.0, 1e6), 1600))
    (tmp_path / "bare").mkdir()
    (tmp_path / "bare" / "map.xodr").write_text(document(road("1", lanes="")), encoding="utf-8")
    with pytest.raises(InputError, match="has no road that can be drawn"):
        write_picture(tmp_path / "bare" / "map.xodr", tmp_path / "x.svg", OPTIONS, "svg")
    (tmp_path / "bare" / "map.xodr").write_text(document(road("1")), encoding="utf-8")
    with pytest.raises(InputError, match="states no speeds"):
        write_picture(tmp_path / "bare" / "map.xodr", tmp_path / "x.svg", replace(OPTIONS, colour="speed"), "svg")
    assert not (tmp_path / "x.svg").exists()


def test_roads_without_measured_heights_are_hatched(tmp_path: Path) -> None:
    """The first road is 100 m long and lies on the axis; its lanes are on both sides."""
    plain = viewed_file(tmp_path)
    marked = replace(plain, provenance={**plain.provenance, (0, UNMEASURED_HEIGHTS): "40 60"})
    picture = make_picture(marked, OPTIONS)
    strokes = [shape.corners for shape in picture.shapes if isinstance(shape, Line) and shape.colour == HATCHING]
    middles = sorted(float(corners[:, 0].mean()) / 5.0 for corners in strokes)
    assert middles == pytest.approx([42.0, 46.0, 50.0, 54.0, 58.0], abs=0.01)
    # From edge to edge, the left end ahead.
    assert all(corners[0, 1] < corners[1, 1] and corners[0, 0] > corners[1, 0] for corners in strokes)
    assert picture.hatched
    assert "hatched: height not measured" in draw_svg(picture).decode()
    assert not make_picture(plain, OPTIONS).hatched
    # What cannot be read marks nothing.
    for text in ("40", "60 40", "40 nan", "x y", "-5 10", "40 900", ""):
        odd = replace(plain, provenance={**plain.provenance, (0, UNMEASURED_HEIGHTS): text})
        assert not make_picture(odd, OPTIONS).hatched, text
