"""What one does with the page in a real browser: layers, routes, signals, the ground in 3D."""

from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import Page, troubles
from page_cases import info_of, write_ground
from PIL import Image
from t_junction import ARC, sound_map
from xodr_text import document, read_text, road

from osm2xodr import exporting
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive.space import surface_points
from osm2xodr.opendrive.tables import OpenDrive
from osm2xodr.viewing import PictureOptions, ReportOptions, write_report
from osm2xodr.viewing.page import make_report
from osm2xodr.viewing.picture.contents import make_picture
from osm2xodr.viewing.picture.drawing import draw_png
from osm2xodr.viewing.scene import Scene, make_scene

CREDIT = "© OpenStreetMap contributors"
SIGNALS = """<signal id="903" name="" s="20" t="-5" dynamic="yes" orientation="+" zOffset="3" type="1000001"
 subtype="-1" country="OpenDRIVE" value="-1"/><signal id="904" name="stop" s="30" t="-5" dynamic="no"
 orientation="+" zOffset="2" type="206" subtype="-1" country="DE" value="-1" height="0.9"/></signals>"""
OBJECTS = """<object id="905" type="roadMark" subtype="arrowStraight" s="35" t="-1.75" length="5" width="1" hdg="0"/>
<object id="906" type="roadMark" subtype="signalLines" s="44" t="-1.75" length="0.5" width="3" hdg="0"/>
<object id="907" type="tree" s="25" t="8" zOffset="0" height="7" radius="2"/>
<object id="908" type="building" s="10" t="12" zOffset="0" hdg="0" length="6" width="8" height="5"/></objects>"""
# Roads by index; the connecting roads 10 to 15 follow.
ROADS = {"1": 0, "2": 1, "3": 2, "4": 3, "10": 4, "12": 6}


def text() -> str:
    """Return the T junction with a name, more furniture and a mark of each kind."""
    out = sound_map().replace('name="T"', 'name="Quay"')
    out = out.replace("</header>", f'<userData code="attribution" value="{CREDIT}"/></header>')
    out = out.replace("</signals>", SIGNALS, 1).replace("</objects>", OBJECTS, 1)
    out = out.replace('<control signalId="900" type=""/>', '<control signalId="900"/><control signalId="903"/>')
    centre = '<lane id="0" type="none" level="false"><link></link><roadMark sOffset="0" type="'
    kinds = iter(("broken", "solid solid", "broken solid"))
    parts = out.split(centre + "solid")
    return parts[0] + "".join(centre + next(kinds, "solid") + part for part in parts[1:])


def rough(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return heights 3 m and more above all roads."""
    return np.asarray(15.0 + 1.5 * np.sin(x / 4.0) * np.cos(y / 3.0))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("tools")


@pytest.fixture(scope="module")
def file(folder: Path) -> OpenDrive:
    return read_text(folder, text())


@pytest.fixture(scope="module")
def report(folder: Path, file: OpenDrive) -> Path:
    out = folder / "report.html"
    write_report(file, out, ReportOptions(dem=(write_ground(folder, file, rough),)), Diagnostics())
    return out


@pytest.fixture(scope="module")
def plain(folder: Path, file: OpenDrive) -> Path:
    """Return a report whose view in 3D has lanes alone."""
    out = folder / "plain.html"
    write_report(file, out, ReportOptions(dem=(write_ground(folder, file, rough),), scene=False), Diagnostics())
    return out


def at(page: Page, x: float, y: float) -> tuple[float, float]:
    """Return the pixel of a place, x and y of the file, m."""
    x0, y0 = page.value("window.osm2xodr.data.info.origin")
    px, py = page.run("return window.osm2xodr.pixelOf(...arguments)", x - x0, y - y0)
    return px, py


def look(page: Page, x: float, y: float, zoom: int) -> float:
    """Move the map to a place and return the pixels per metre."""
    x0, y0 = page.value("window.osm2xodr.data.info.origin")
    page.run("window.osm2xodr.setView(...arguments)", x - x0, y - y0, zoom)
    return at(page, x + 1.0, y)[0] - at(page, x, y)[0]


def image_of(png: bytes) -> IntArray:
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), np.int64)


def shot(page: Page) -> IntArray:
    return image_of(base64.b64decode(page.driver.get_screenshot_as_base64()))


def show(page: Page, *layers: str) -> None:
    """Show some layers alone."""
    page.run(
        "const { layers } = window.osm2xodr; for (const [key] of layers.rows) {"
        " if (layers.shown[key] !== arguments[0].includes(key)) layers.boxes[key].click(); }",
        layers,
    )


def in_3d(page: Page) -> None:
    page.run("document.getElementById('view-3d').click()")
    page.wait("window.osm2xodr.state.scene !== null && document.getElementById('scene-message').textContent === ''")


def test_the_headline_is_the_name_of_the_network(page: Page, report: Path) -> None:
    page.open(report)
    assert page.text("#title") == "Quay"
    assert page.text("#credits") == CREDIT


def test_the_map_draws_what_pictures_draw(page: Page, report: Path, file: OpenDrive) -> None:
    page.open(report, "#mode=type")
    scale = look(page, -25.0, -2.0, 1)
    assert scale > 6.0
    show(page, "roads", "marks", "objects", "signals")
    left, top = (round(value) for value in at(page, -45.0, 15.0))
    width, height = round(40.0 * scale), round(28.0 * scale)
    box = (-45.0, 15.0 - height / scale, -45.0 + width / scale, 15.0)
    drawn = shot(page)[top : top + height, left : left + width]
    wanted = image_of(draw_png(make_picture(file, PictureOptions(box, width))))[:height]
    paper = (wanted == (0xF6, 0xF7, 0xF5)).all(axis=2)
    far = np.abs(drawn - wanted).max(axis=2) > 96
    # Edges are smoothed differently, by half a pixel.
    assert np.mean(far[~paper]) < 0.03
    # Each kind of thing is there: white paint, the tree, the lamps and the sign.
    for colour in (
        (0xFF, 0xFF, 0xFF),
        (0x6F, 0x9A, 0x5D),
        (0xC1, 0x27, 0x2D),
        (0x3F, 0xA3, 0x5B),
    ):
        ours, theirs = (np.count_nonzero(np.abs(image - colour).max(axis=2) < 40) for image in (drawn, wanted))
        assert theirs > 5
        assert ours == pytest.approx(theirs, rel=0.35, abs=12), colour
    assert troubles(page) == []


def test_layers_go_on_and_off(page: Page, report: Path) -> None:
    page.open(report)
    look(page, -25.0, -2.0, 3)
    keys = page.value("window.osm2xodr.layers.rows.map((row) => row[0])")
    assert keys == ["roads", "marks", "objects", "signals", "junctions", "findings", "ground"]
    # One after the other, from the last: each takes something away from the map, until nothing is left.
    show(page, "roads", "marks", "objects", "signals", "ground")
    for key in ("signals", "objects", "marks", "roads", "ground"):
        before = shot(page)
        page.run("window.osm2xodr.layers.boxes[arguments[0]].click()", key)
        assert np.count_nonzero(np.abs(shot(page) - before).sum(axis=2) > 30) > 20, key
    assert "off=roads,marks,objects,signals,junctions,findings,ground" in page.value(
        "decodeURIComponent(location.hash)"
    )
    stage = shot(page)[300:500, 100:500]
    assert len(np.unique(stage.reshape(-1, 3), axis=0)) == 1
    page.open(report, "#off=roads,signals")
    assert page.value("window.osm2xodr.layers.hidden()") == ["roads", "signals"]
    in_3d(page)
    names = "['roads', 'marks', 'objects', 'signals', 'ground']"
    meshes = f"{names}.map((key) => window.osm2xodr.state.scene.bodies[key].visible)"
    assert page.value(meshes) == [False, True, True, False, True]
    page.run("window.osm2xodr.layers.boxes.ground.click(); window.osm2xodr.layers.boxes.roads.click()")
    assert page.value(meshes) == [True, True, True, False, False]
    # Colours of data are those of lanes, which lie in place of the surfaces.
    lanes = "[window.osm2xodr.state.scene.roads.visible, window.osm2xodr.state.scene.bodies.roads.visible]"
    assert page.value("document.getElementById('mode').value") == "built"
    assert page.value(lanes) == [False, True]
    page.choose("mode", "grade")
    assert page.value(lanes) == [True, False]
    assert troubles(page) == []


def test_findings_are_pins_unlike_anything_else(page: Page, tmp_path: Path) -> None:
    # The second road begins 2 m beside the first one's end.
    link = '<successor elementType="road" elementId="2" contactPoint="start"/>'
    back = '<predecessor elementType="road" elementId="1" contactPoint="end"/>'
    gap = document(
        road("1", link=link),
        road(
            "2",
            link=back,
            plan=road("2").split("<planView>")[1].split("</planView>")[0].replace('x="0.0"', 'x="102.0"'),
        ),
    )
    out = tmp_path / "gap.html"
    write_report(read_text(tmp_path, gap), out, ReportOptions(), Diagnostics())
    page.open(out)
    x, y, severity = page.value("window.osm2xodr.data.info.findings.map((row) => [row[5], row[6], row[0]])")[0]
    x0, y0 = page.value("window.osm2xodr.data.info.origin")
    look(page, x + x0, y + y0, 2)
    show(page, "roads")
    before = shot(page)
    show(page, "roads", "findings")
    px, py = (round(value) for value in at(page, x + x0, y + y0))
    colour = page.value("window.osm2xodr.data.info.severities")[severity]
    rgb = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
    image = shot(page)
    # The head stands above the place, to which the tip points.
    assert image[py - 12, px - 3].tolist() == image[py - 12, px + 3].tolist() == rgb
    assert (before[py - 12, px - 3] != rgb).any()
    assert image[py + 4, px].tolist() != rgb
    faces = {colour for face in page.value("window.osm2xodr.data.info.faces") for _, colour in face}
    assert colour not in faces or not faces


@pytest.mark.parametrize(
    ("begin", "end", "roads", "length"),
    [
        # Road 1 begins at x = -60 and ends at -10; road 2 goes on from 10 to 60, and road 4 behind it.
        ((-50.0, -1.75), (80.0, -1.75), ["1", "10", "2", "4"], 130.0),
        ((80.0, 1.75), (-50.0, 1.75), ["4", "2", "11", "1"], 130.0),
        ((-50.0, -1.75), (1.75, -40.0), ["1", "12", "3"], 40.0 + ARC + 30.0),
        ((-50.0, -1.75), (-20.0, -1.75), ["1"], 30.0),
    ],
)
def test_two_clicks_give_a_route_and_its_profile(
    begin: tuple[float, float], end: tuple[float, float], roads: list[str], length: float, page: Page, report: Path
) -> None:
    page.open(report)
    look(page, 0.0, -10.0, 0)
    page.run("document.getElementById('route').click()")
    assert page.text("#hint") == "Click where the route begins."
    page.click(*at(page, *begin))
    assert page.text("#hint") == "Click where the route ends."
    page.click(*at(page, *end))
    assert page.value("document.getElementById('hint').hidden") is True
    ids = page.value("window.osm2xodr.data.info.road.id")
    pieces = page.value("window.osm2xodr.state.pieces")
    assert [ids[piece["road"]] for piece in pieces] == roads
    # A pixel is half a metre at most.
    assert sum(abs(piece["to"] - piece["from"]) for piece in pieces) == pytest.approx(length, abs=1.5)
    assert page.text("#profile-title").startswith("Route")
    assert "Route" in page.text("#content")
    assert page.value("document.querySelectorAll('.end').length") == 2
    assert "route=" in page.value("location.hash")
    assert troubles(page) == []


def test_the_profile_of_a_route_has_the_heights_of_its_roads(page: Page, report: Path) -> None:
    page.open(report, "#route=-60,-1.7,80,-1.7")
    path: Any = page.value("window.osm2xodr.profile.path")
    d, z, s = (np.array(path[key]) for key in ("d", "z", "s"))
    assert path["begins"] == pytest.approx([0.0, 50.0, 70.0, 120.0], abs=0.3)
    assert d[-1] == pytest.approx(140.0, abs=0.3)
    assert (np.diff(d) >= 0.0).all()
    # Road 1 falls from 12 m to 10 m; all others are level.
    first = d < 49.0
    exact = np.where(s < 25.0, 12.0 - 0.0016 * s**2, 11.0 - 0.08 * (s - 25.0) + 0.0016 * (s - 25.0) ** 2)
    assert z[first] == pytest.approx(exact[first], abs=0.011)
    assert z[d > 51.0] == pytest.approx(10.0, abs=0.011)
    grade = np.array(path["grade"])
    assert grade[first].min() == pytest.approx(-0.08, abs=0.005)
    # Against s the same hill rises.
    page.open(report, "#route=80,1.7,-60,1.7")
    path = page.value("window.osm2xodr.profile.path")
    assert max(path["grade"]) == pytest.approx(0.08, abs=0.005)
    assert path["z"][-1] == pytest.approx(12.0, abs=0.02)


def test_a_place_that_no_lane_leads_to_is_said(page: Page, report: Path) -> None:
    page.open(report)
    look(page, 0.0, -10.0, 0)
    x, y = at(page, 80.0, -1.75)
    page.run("document.getElementById('route').click()")
    # Road 4 is a dead end: from its right lane nothing leads on, but the left lane of the same place does. From a
    # connecting road there is one way only, and none back to road 1.
    page.click(x, y)
    page.click(*at(page, -8.0, 30.0))
    assert page.text("#hint") == "No car drives there."
    page.run("document.dispatchEvent(new KeyboardEvent('keydown', {key: 'Escape'}))")
    assert page.value("document.getElementById('hint').hidden") is True
    found = page.run(
        "const { graph, data } = window.osm2xodr, strip = (id) => data.roadStrip[data.info.road.id.indexOf(id)];"
        " return graph().route({ strip: strip('10'), s: 5 }, { strip: strip('12'), s: 5 })"
    )
    assert found is None


def test_a_click_on_a_light_shows_its_controller(page: Page, report: Path) -> None:
    page.open(report)
    look(page, -25.0, -2.0, 3)
    page.click(*at(page, -15.0, -4.0))
    said = page.text("#content")
    for words in ("Traffic light 900", "1000001", "OpenDRIVE", "800", "junction"):
        assert words in said
    assert "-15.00, -4.00 m" in said
    # The other light of the controller is listed and marked.
    assert page.value(
        "Array.from(document.querySelectorAll('.controller .link')).map((item) => item.textContent)"
    ) == [
        "100",
        "903, type 1000001",
        "1",
    ]
    assert page.value("document.querySelectorAll('#map path.leaflet-interactive, #map svg path').length") >= 2
    page.run("document.querySelectorAll('.controller .link')[1].click()")
    assert "Traffic light 903" in page.text("#content")
    assert "signal=903" in page.value("location.hash")
    look(page, -25.0, -2.0, 1)
    page.click(*at(page, -30.0, -5.0))
    assert "Sign 904 stop, type 206" in page.text("#content")
    assert "None controls it." in page.text("#content")
    assert troubles(page) == []


def test_fit_all_shows_the_whole_network_again(page: Page, report: Path) -> None:
    page.open(report)
    look(page, 90.0, 0.0, 4)
    page.run("document.getElementById('fit').click()")
    # Road 1 begins in the west, road 4 ends in the east, road 3 begins in the south.
    box = page.value("document.getElementById('map').getBoundingClientRect().toJSON()")
    for x, y in ((-60.0, 0.0), (100.0, 0.0), (0.0, -60.0)):
        px, py = at(page, x, y)
        assert box["left"] < px < box["right"]
        assert box["top"] < py < box["bottom"]
    assert at(page, 100.0, 0.0)[0] - at(page, -60.0, 0.0)[0] > 0.4 * box["width"]
    in_3d(page)
    page.run("window.osm2xodr.state.scene.look(90, 0, 30); document.getElementById('fit').click()")
    x0, y0 = page.value("window.osm2xodr.data.info.origin")
    # In coordinates of the camera, -1 to 1 is in view.
    for x, y in ((-60.0, 0.0), (100.0, 0.0), (0.0, -60.0)):
        u, v = page.run(
            "const { scene } = window.osm2xodr.state; scene.camera.updateMatrixWorld();"
            " const at = new scene.THREE.Vector3(...arguments, 0).project(scene.camera); return [at.x, at.y]",
            x - x0,
            y - y0,
        )
        assert abs(u) < 1.0
        assert abs(v) < 1.0


GROUND = """
const { scene } = window.osm2xodr.state, { THREE } = scene, down = new THREE.Vector3(0, 0, -1);
scene.world.scale.z = 1; scene.world.updateMatrixWorld(true);
const ray = new THREE.Raycaster();
return arguments[0].map(([x, y]) => {
  ray.set(new THREE.Vector3(x, y, 1000), down);
  const hit = ray.intersectObject(scene.bodies[arguments[1]] ?? scene[arguments[1]])[0];
  return hit ? hit.point.z + scene.base : null;
});
"""


def samples(scene: Scene) -> FloatArray:
    """Return x, y, z of places all over the lanes, between their borders and their stations, (n, 3)."""
    out = []
    x, y, z = scene.border_places()
    for strip in range(len(scene.strip_road)):
        rows = slice(int(scene.border_start[strip]), int(scene.border_start[strip + 1]))
        grid = np.stack((x[rows], y[rows], z[rows]), axis=1).reshape(-1, int(scene.strip_borders[strip]), 3)
        for u in (0.0, 0.31, 0.77):
            along = (1.0 - u) * grid[:-1] + u * grid[1:]
            for v in (0.02, 0.5, 0.98):
                out.append(((1.0 - v) * along[:, :-1] + v * along[:, 1:]).reshape(-1, 3))
    return np.asarray(np.concatenate(out))


def test_the_ground_lies_below_all_lanes(page: Page, plain: Path, file: OpenDrive) -> None:
    page.open(plain)
    in_3d(page)
    places = samples(make_scene(file))
    x0, y0 = page.value("window.osm2xodr.data.info.origin")
    ground = page.run(GROUND, (places[:, :2] - (x0, y0)).tolist(), "terrain")
    below = places[:, 2] - np.array(ground, np.float64)
    assert len(below) > 800
    # 0.25 m by rule; the page's numbers are whole centimetres.
    assert below.min() > 0.22
    assert np.percentile(below, 99) < 1.0
    # Away from the roads the ground is that of the elevation model, in a grid of a few metres.
    away = [(-30.0, 40.0), (50.0, 40.0), (-40.0, -40.0), (60.0, -50.0)]
    found = page.run(GROUND, [[x - x0, y - y0] for x, y in away], "terrain")
    assert found == pytest.approx([float(rough(np.array(x), np.array(y))) for x, y in away], abs=0.8)


def test_a_tunnel_stays_below_the_ground(page: Page, tmp_path: Path) -> None:
    tunnel = '<objects><tunnel id="8" s="20" length="60" type="standard" name="Hill"/></objects>'
    file = read_text(tmp_path, document(road("1", more=tunnel)))
    out = tmp_path / "tunnel.html"
    write_report(
        file, out, ReportOptions(check=False, dem=(write_ground(tmp_path, file, rough),), scene=False), Diagnostics()
    )
    page.open(out)
    in_3d(page)
    x0, y0 = page.value("window.osm2xodr.data.info.origin")
    places = [[x - x0, y - y0] for x, y in ((5.0, 0.0), (50.0, 2.0), (95.0, -3.0))]
    entry, middle, exit_ = page.run(GROUND, places, "terrain")
    assert max(entry, exit_) < -0.2
    assert middle > 12.0


def test_things_stand_in_3d_where_the_file_says(page: Page, report: Path, file: OpenDrive) -> None:
    page.open(report)
    in_3d(page)
    x0, y0 = page.value("window.osm2xodr.data.info.origin")
    box = """
const { scene } = window.osm2xodr.state, [layer, x0, y0, radius] = arguments, out = [];
for (const mesh of scene.bodies[layer].children) {
  const place = mesh.geometry.getAttribute("position").array;
  for (let k = 0; k < place.length; k += 3) {
    const [x, y, z] = place.subarray(k, k + 3);
    if (Math.hypot(x - x0, y - y0) <= radius) out.push(z + scene.base);
  }
}
return out.length ? [Math.min(...out), Math.max(...out)] : null;
"""

    def heights(layer: str, s: float, t: float, radius: float) -> tuple[float, float]:
        """Return the lowest and the highest point of a layer around a place on road 1, above the road there, m."""
        x, y, z = (float(v[0]) for v in surface_points(file, np.array([0]), np.array([s]), np.array([t])))
        low, high = page.run(box, layer, x - x0, y - y0, radius)
        return low - z, high - z

    # From the ground to their tops; buildings and poles go half a metre deeper. A light's head is on its pole.
    assert heights("objects", 25.0, 8.0, 2.1) == pytest.approx((0.0, 7.0), abs=0.02)
    assert heights("objects", 10.0, 12.0, 5.1) == pytest.approx((-0.5, 5.0), abs=0.02)
    assert heights("signals", 30.0, -5.0, 0.5) == pytest.approx((-0.5, 2.9), abs=0.03)
    low, high = heights("signals", 20.0, -5.0, 0.5)
    assert low == pytest.approx(-0.5, abs=0.02)
    assert 3.5 < high < 4.2
    # Paint lies on the road: the crosswalk's bars, the arrow, and the marks.
    for layer, s, t, radius in (
        ("objects", 47.0, 0.0, 3.0),
        ("objects", 35.0, -1.75, 2.6),
        ("marks", 25.0, 0.0, 4.0),
    ):
        low, high = heights(layer, s, t, radius)
        assert -0.3 < low < high < 0.35, layer
    arrow, lane, ground = (
        page.run(GROUND, [[-25.0 - x0, -1.75 - y0]], layer)[0] for layer in ("objects", "roads", "ground")
    )
    assert lane == pytest.approx(11.0 - 0.08 * 10.0 + 0.0016 * 100.0, abs=0.05)  # Chords of the hill
    assert arrow - lane == pytest.approx(0.015, abs=0.011)
    # Roads lie on the ground in that they are cut out of it.
    assert ground is None
    assert troubles(page) == []


def test_clicks_in_3d_find_lanes_and_signs_of_the_scene(page: Page, report: Path) -> None:
    page.open(report)
    in_3d(page)
    x0, y0 = page.value("window.osm2xodr.data.info.origin")
    page.run("window.osm2xodr.state.scene.look(...arguments, 30)", -30.0 - x0, -3.0 - y0)
    pixel = (
        "const { scene } = window.osm2xodr.state, box = document.getElementById('canvas').getBoundingClientRect();"
        " scene.camera.updateMatrixWorld();"
        " const [x, y, z] = arguments, at = new scene.THREE.Vector3(x, y, z - scene.base).project(scene.camera);"
        " return [box.left + (1 + at.x) / 2 * box.width, box.top + (1 - at.y) / 2 * box.height]"
    )
    page.click(*page.run(pixel, -25.0 - x0, -1.75 - y0, 10.4))
    assert page.text("#profile-title").startswith("Road 1")
    page.click(*page.run(pixel, -30.0 - x0, -5.0 - y0, 10.0 + 2.9))
    assert "Sign 904 stop" in page.text("#content")


def test_without_a_scene_lanes_are_seen_and_the_page_says_why(
    page: Page, file: OpenDrive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, found = tmp_path / "bare.html", Diagnostics()
    monkeypatch.setattr(exporting, "make_scene", broken, raising=False)
    write_report(file, out, ReportOptions(check=False), found)
    page.open(out, "#view=3d")
    notes = [note for note in page.value("window.osm2xodr.data.info.notes") if "3D" in note]
    assert len(notes) == 1
    assert "GEOSException: torn" in notes[0]
    assert [item.code for item in found] == ["no-scene"]
    assert page.value("window.osm2xodr.state.scene.roads.visible") is True
    assert page.value("document.getElementById('mode').value") == "type"
    assert troubles(page) == []
    with pytest.raises(InputError, match="torn"):
        write_report(file, out, ReportOptions(check=False, scene=True), Diagnostics())


def test_scenes_that_take_long_are_made_on_request_alone(tmp_path: Path) -> None:
    far = road("2", plan=road("2").split("<planView>")[1].split("</planView>")[0].replace('x="0.0"', 'x="2600000.0"'))
    with_far = read_text(tmp_path, document(road("1"), far))
    info = info_of(make_report(with_far, ReportOptions(check=False), Diagnostics()))
    assert info["bodies"] == []
    assert "The view in 3D has lanes alone: 0 km of roads in an area of 520 km² take long" in info["notes"][0]
    further = read_text(tmp_path, document(road("1"), far.replace("2600000", "26000000")))
    with pytest.raises(InputError, match="too much for one page"):
        make_report(further, ReportOptions(check=False, scene=True), Diagnostics())


def broken(*_: object, **__: object) -> None:
    """Fail as geometry of damaged files does."""
    raise type("GEOSException", (Exception,), {})("torn")


def test_files_without_anything_open_and_switch(page: Page, tmp_path: Path) -> None:
    out = tmp_path / "bare.html"
    bare = '<OpenDRIVE><header revMajor="1" revMinor="4"/>PARTS</OpenDRIVE>'
    for parts in ("", road("1", lanes=""), road("1", plan=""), road("1", elevation="")):
        write_report(read_text(tmp_path, bare.replace("PARTS", parts)), out, ReportOptions(), Diagnostics())
        page.open(out)
        page.run("document.getElementById('fit').click(); document.getElementById('route').click()")
        page.click(400.0, 400.0)
        page.click(420.0, 400.0)
        in_3d(page)
        page.run("document.getElementById('fit').click()")
        assert troubles(page) == []


@pytest.mark.parametrize(("route", "begin"), [("-60,-1.7,80,-1.7", 10.0), ("80,1.7,-60,1.7", 120.0)])
def test_profiles_shade_what_is_not_measured_along_and_against_s(
    route: str, begin: float, page: Page, tmp_path: Path
) -> None:
    """Ten metres of road 1, from s = 10 m on."""
    mark = '<userData code="unmeasured_heights" value="10 20"/></road>'
    out = tmp_path / "gap.html"
    write_report(read_text(tmp_path, text().replace("</road>", mark, 1)), out, ReportOptions(), Diagnostics())
    page.open(out, f"#route={route}")
    page.wait("window.osm2xodr.profile.ready")
    shaded = page.run(
        "const { plot } = window.osm2xodr.profile, { top, height } = plot.bbox;"
        " return arguments[0].map((d) => { const x = Math.round(plot.valToPos(d, 'x', true));"
        " const { data } = plot.ctx.getImageData(x, Math.round(top + 0.03 * height), 1, 1);"
        " return data[3] > 20 && data[0] > 150 && data[1] < 80; })",
        [begin + away for away in (-2.0, 1.5, 8.5, 12.0)],
    )
    assert shaded == [False, True, True, False]


@pytest.mark.parametrize("zoom", [1, -5])
def test_the_map_hatches_what_is_not_measured(zoom: int, page: Page, tmp_path: Path) -> None:
    found = []
    for mark in ("", '<userData code="unmeasured_heights" value="0 50"/>'):
        out = tmp_path / "gap.html"
        marked = text().replace("</road>", mark + "</road>", 1)
        write_report(read_text(tmp_path, marked), out, ReportOptions(), Diagnostics())
        page.open(out, "#mode=type")
        look(page, -35.0, -2.0, zoom)
        show(page, "roads")
        red = shot(page) - (0xF0, 0x32, 0x3C)
        found.append(int((np.abs(red).max(axis=2) < 40).sum()))
    assert found[0] == 0 < 5 < found[1]
