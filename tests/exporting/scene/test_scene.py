"""Whole scenes: what stands on the surface, bodies of bridges and tunnels, and what is written."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from exported_network import network
from glb_reader import read_glb
from scene_cases import crossing
from scene_files import Conversions, scene_named
from scipy.spatial import cKDTree
from xodr_text import read_text

from osm2xodr.errors import InputError, OptionError, OutputError
from osm2xodr.exporting.scene.folder import Tile, carla_names, in_single_precision, tiles_info, tiles_of, without_gaps
from osm2xodr.exporting.scene.model import Part
from osm2xodr.exporting.scene.scene import Scene, make_scene
from osm2xodr.model import FloatArray, Surroundings, Water
from osm2xodr.opendrive import Header, frame_of
from osm2xodr.python_api import export_scene, read

BRIDGE = '<objects><bridge id="b" s="20" length="60" type="concrete"/></objects>'
TUNNEL = '<objects><tunnel id="t" s="20" length="60" type="standard" lighting="1" daylight="0"/></objects>'


def level(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.zeros(len(x))


def part(scene: Scene, name: str) -> Part:
    (found,) = [item for item in scene.parts if item.name == name]
    return found


def is_closed(vertices: FloatArray, faces: FloatArray) -> bool:
    """Whether every edge has another one the other way round, by places rounded to a millimetre.

    Upright edges are left out: several short ones may stand beside a long one.
    """
    points, place = np.unique(np.round(vertices, 3), axis=0, return_inverse=True)
    rows = place.ravel()[faces]
    ways = Counter((int(row[k]), int(row[(k + 1) % 3])) for row in rows for k in range(3))
    return all(ways[b, a] == n for (a, b), n in ways.items() if (points[a, :2] != points[b, :2]).any())


def test_a_deck_is_a_body(tmp_path: Path) -> None:
    scene = make_scene(crossing(tmp_path, height=6.0, more=BRIDGE), 0.05, 10.0, level, None, 500.0)
    deck = part(scene, "Bridge_Deck")
    assert deck.vertices[:, 2].min() == pytest.approx(5.0)
    # With the road on it, it is closed.
    on_it = [item for item in scene.parts if item.name in {"Road_Road", "Road_Sidewalk", "Road_Curb"}]
    vertices, faces = [deck.vertices], [deck.faces]
    for item in on_it:
        middle = item.vertices[item.faces].mean(1)
        rows = item.faces[(np.abs(middle[:, 1]) < 30) & (middle[:, 2] > 3)]
        faces.append(rows + sum(map(len, vertices)))
        vertices.append(item.vertices)
    assert is_closed(np.concatenate(vertices), np.concatenate(faces))


def test_piers_stand_on_the_ground_beside_the_road_below(tmp_path: Path) -> None:
    longer = BRIDGE.replace('s="20" length="60"', 's="15" length="70"')
    scene = make_scene(crossing(tmp_path, height=6.0, more=longer), 0.05, 10.0, level, None, 500.0)
    pier = part(scene, "Bridge_Pier")
    # Three spans, two piers, 1 m thick and 60 % of 11 m wide, half a metre in the ground and a little in the deck.
    assert sorted({round(y, 3) for y in pier.vertices[:, 1].tolist()}) == [-12.167, -11.167, 11.167, 12.167]
    np.testing.assert_allclose(np.abs(pier.vertices[:, 0]), 3.3)
    assert sorted(set(np.round(pier.vertices[:, 2], 6).tolist())) == [-0.5, 5.1]


def test_no_pier_stands_on_a_road(tmp_path: Path) -> None:
    # Two spans, whose pier would stand in the middle of the road below.
    scene = make_scene(crossing(tmp_path, height=6.0, more=BRIDGE), 0.05, 10.0, level, None, 500.0)
    assert "Bridge_Pier" not in {item.name for item in scene.parts}


def test_tunnels_have_walls_and_a_ceiling(tmp_path: Path) -> None:
    def hill(x: FloatArray, y: FloatArray) -> FloatArray:
        return np.where(np.abs(y) < 28.0, 0.0, -8.0)

    scene = make_scene(crossing(tmp_path, height=-8.0, more=TUNNEL), 0.05, 10.0, hill, None, 500.0)
    tube = part(scene, "Tunnel")
    assert tube.vertices[:, 2].max() == pytest.approx(-8.0 + 5.0 + 0.12)
    assert np.abs(tube.vertices[:, 1]).max() == pytest.approx(30.0)


def test_marks_lie_on_the_road(tmp_path: Path) -> None:
    scene = make_scene(network(tmp_path), 0.05, 10.0, None, None, 500.0)
    crosswalk = part(scene, "Road_Crosswalk")
    a, b, c = np.moveaxis(crosswalk.vertices[crosswalk.faces], 1, 0)
    assert 0.5 * np.cross(b - a, c - a)[:, 2].sum() == pytest.approx(2.0 * 6.0)
    bars = part(scene, "Road_Marking")
    # The road rises by 2 % from 100 m.
    height = bars.vertices[:, 2] - (100 + 0.02 * bars.vertices[:, 0])
    assert height.min() > 0.009
    assert height.max() < 0.021
    sign = [item for item in scene.parts if item.name == "TrafficSign"]
    assert {item.material for item in sign} == {"#c1272d", "#ffffff", "sign_back"}
    assert min(float(item.vertices[:, 2].min()) for item in sign) == pytest.approx(100 + 0.02 * 30 + 3, abs=0.01)
    assert "Vegetation" in {item.name for item in scene.parts}


def test_what_lies_on_the_road_has_its_material_not_the_colour_of_maps(tmp_path: Path) -> None:
    rail = (
        '<object id="90" type="patch" subtype="tramTrack" s="20" t="1" zOffset="0" hdg="0" length="30" width="0.07"/>'
    )
    repair = '<object id="91" type="patch" s="45" t="1" zOffset="0" hdg="0" length="3" width="2"/>'
    network(tmp_path)
    text = (tmp_path / "map.xodr").read_text(encoding="utf-8")
    file = read_text(tmp_path, text.replace("</objects>", f"{rail}{repair}</objects>", 1))
    scene = make_scene(file, 0.05, 10.0, None, None, 500.0)
    size = {item.material: np.ptp(item.vertices[:, 0]) for item in scene.parts if item.name == "Static"}
    assert size == {"metal": pytest.approx(30.0, abs=0.01), "asphalt": pytest.approx(3.0, abs=0.01)}


def test_lines_tagged_as_water_are_said(tmp_path: Path) -> None:
    frame, why = frame_of(Header((1, 7), {}, "+proj=tmerc +lat_0=47 +lon_0=11 +datum=WGS84", None))
    assert frame is not None, why
    around = Surroundings((), Water(unclosed=("way/7", "way/8")))
    scene = make_scene(network(tmp_path), 0.05, 10.0, None, (around, frame), 500.0)
    assert scene.notes == (
        "not closed, though tagged as areas of water, and left out (2): way/7, way/8",
        "0 buildings",
    )


@pytest.mark.parametrize("name", ["montlake_roundabout", "fremantle_placement"])
def test_real_scenes_are_sound(name: str, conversions: Conversions, tmp_path: Path) -> None:
    place = scene_named(name)
    xodr = conversions.of(place).path
    said: list[str] = []
    files = export_scene(xodr, tmp_path / "scene", dem=place.dem, osm=place.osm, say=said.append)
    manifest = json.loads((tmp_path / "scene" / "scene.json").read_text(encoding="utf-8"))
    assert "OpenStreetMap contributors" in manifest["attribution"][0]
    assert [tile["file"] for tile in manifest["tiles"]] == [path.name for path in files if path.suffix == ".glb"]
    road: list[FloatArray] = []
    ground: list[FloatArray] = []
    for tile in manifest["tiles"]:
        _, meshes = read_glb((tmp_path / "scene" / tile["file"]).read_bytes())
        assert sorted(item["name"] for item in tile["parts"]) == sorted(mesh.name for mesh in meshes)
        for mesh in meshes:
            a, b, c = np.moveaxis(mesh.points[mesh.faces], 1, 0)
            assert (np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0).all(), mesh.name
            if mesh.name.startswith("Terrain_LOD0"):
                ground.append(mesh.points[mesh.faces])
            elif mesh.name.startswith("Road_") and not mesh.name.startswith(("Road_Marking", "Road_Crosswalk")):
                road.append(mesh.points)
    # Roads meet the ground: at a corner that both have, one of the road's (a kerb has two) is where the ground is.
    corners = np.unique(np.round(np.concatenate(ground).reshape(-1, 3), 3), axis=0)
    roads = np.unique(np.round(np.concatenate(road), 3), axis=0)
    met = 0
    for point, rows in zip(corners, cKDTree(roads[:, :2]).query_ball_point(corners[:, :2], 0.002), strict=True):
        if rows:
            apart = np.abs(roads[rows, 2] - point[2]).min()
            # Below bridges the ground goes on.
            assert apart < 0.05 or (roads[rows, 2] - point[2]).min() > 1.0
            met += apart < 0.002
    assert met > 500


def test_scenes_are_the_same_every_time_and_whole(tmp_path: Path) -> None:
    network(tmp_path)
    target = tmp_path / "scene"
    first = {path.name: path.read_bytes() for path in export_scene(tmp_path / "map.xodr", target)}
    second = {path.name: path.read_bytes() for path in export_scene(tmp_path / "map.xodr", target)}
    assert first == second
    assert sorted(first) == sorted(path.name for path in target.iterdir())
    assert not list(tmp_path.glob(".osm2xodr-*"))


def test_corners_closer_than_single_precision_become_no_triangle(tmp_path: Path) -> None:
    # 250 m from the middle of the tile, 4 µm are nothing; in the scene's own numbers the first triangle has 90 mm².
    points = np.array([(0.0, 0.0, 0.0), (45.0, 0.0, 0.0), (45.0, 4e-6, 0.0), (45.0, 9.0, 0.0)])
    thin = Part("Building", "wall", points, points[:, :2].copy(), np.array([(0, 1, 2), (0, 2, 3)]))
    (tile,) = tiles_of([thin], 500.0)
    (part,) = in_single_precision(tile, (250.0, 250.0, 0.0)).parts
    assert part.vertices[part.faces].tolist() == [[points[k].tolist() for k in (0, 2, 3)]]
    alone = replace(tile, parts=(replace(thin, faces=thin.faces[:1]),))
    assert in_single_precision(alone, (250.0, 250.0, 0.0)).parts == ()


def test_folders_of_others_stay(tmp_path: Path) -> None:
    network(tmp_path)
    target = tmp_path / "mine"
    target.mkdir()
    (target / "diary.txt").write_text("dear diary", encoding="utf-8")
    with pytest.raises(OutputError, match="other files than what is written there"):
        export_scene(tmp_path / "map.xodr", target)
    assert [path.name for path in target.iterdir()] == ["diary.txt"]


def test_what_cannot_be_read_leaves_the_old_scene(tmp_path: Path) -> None:
    network(tmp_path)
    target = tmp_path / "scene"
    names = sorted(path.name for path in export_scene(tmp_path / "map.xodr", target))
    with pytest.raises(InputError):
        export_scene(tmp_path / "map.xodr", target, dem=tmp_path / "nothing.tif")
    assert sorted(path.name for path in target.iterdir()) == names


def test_tiles_of_carla_count_from_the_south_west(tmp_path: Path) -> None:
    network(tmp_path)
    files = export_scene(tmp_path / "map.xodr", tmp_path / "Import", carla="Bend", tile=100.0)
    names = sorted(path.name for path in files)
    assert {"Bend.json", "Bend.xodr", "scene.json", "TilesInfo.txt", "Bend_Tile_0_0.glb"} <= set(names)
    package = json.loads((tmp_path / "Import" / "Bend.json").read_text(encoding="utf-8"))
    (entry,) = package["maps"]
    assert (entry["name"], entry["xodr"], entry["tile_size"]) == ("Bend", "./Bend.xodr", 100.0)
    assert sorted(entry["tiles"]) == sorted(f"./{name[:-4]}.fbx" for name in names if name.endswith(".glb"))
    # x and y of CARLA, whose y is to the south; tile X, Y lies X and -Y tiles from the first one.
    first_x, first_y, size = map(
        float, (tmp_path / "Import" / "TilesInfo.txt").read_text(encoding="ascii").split(",")
    )
    assert size == 100.0
    manifest = json.loads((tmp_path / "Import" / "scene.json").read_text(encoding="utf-8"))
    for tile in manifest["tiles"]:
        column, row = (int(word) for word in tile["file"][:-4].split("_")[2:])
        low, high = np.array(tile["bounds"])
        middle = np.array([first_x + column * size, -(first_y - row * size)])
        assert (low[:2] >= middle - 0.5 * size - 10.0).all()
        assert (high[:2] <= middle + 0.5 * size + 10.0).all()
        # Engines that know no levels of detail would show all of them.
        assert not [part["name"] for part in tile["parts"] if "_LOD" in part["name"]]


def test_what_fits_into_one_tile_is_no_large_map_of_carla(tmp_path: Path) -> None:
    # It lies on both sides of y = 0.
    network(tmp_path)
    files = export_scene(tmp_path / "map.xodr", tmp_path / "Import", carla="Bend")
    assert sorted(path.name for path in files) == ["Bend.glb", "Bend.json", "Bend.xodr", "scene.json"]
    package = json.loads((tmp_path / "Import" / "Bend.json").read_text(encoding="utf-8"))
    assert package == {
        "maps": [{"name": "Bend", "xodr": "./Bend.xodr", "use_carla_materials": True, "source": "./Bend.fbx"}],
        "props": [],
    }


def test_carla_gets_tiles_without_gaps() -> None:
    points = np.array([(0.0, 0.0, 7.0), (1.0, 0.0, 7.0), (0.0, 1.0, 9.0)])
    some = (Part("Building", "wall", points, points[:, :2].copy(), np.array([(0, 1, 2)])),)
    tiles = without_gaps([Tile(2, -1, some), Tile(0, 1, some)], 100.0)
    assert [(tile.column, tile.row) for tile in tiles] == [(0, -1), (1, -1), (2, -1), (0, 0), (0, 1)]
    assert [tile.parts is some for tile in tiles] == [False, False, True, False, True]
    patch = tiles[1].parts[0]
    assert (patch.name, patch.vertices.mean(0).tolist()) == ("Terrain", [150.0, -50.0, 7.0])
    assert tiles_info(tiles[0], 100.0) == "50.000,50.000,100.000"
    assert carla_names(tiles, "A", "glb")[-1] == "A_Tile_0_2.glb"


def test_obj_has_every_part_once(tmp_path: Path) -> None:
    network(tmp_path)
    files = export_scene(tmp_path / "map.xodr", tmp_path / "scene", format="obj", up="y")
    manifest = json.loads((tmp_path / "scene" / "scene.json").read_text(encoding="utf-8"))
    assert manifest["up"] == "y"
    library = (tmp_path / "scene" / "scene.mtl").read_text(encoding="utf-8").splitlines()
    known = {line.split()[1] for line in library if "newmtl" in line}
    for tile in manifest["tiles"]:
        lines = (tmp_path / "scene" / tile["file"]).read_text(encoding="utf-8").splitlines()
        words = Counter(line.split()[0] for line in lines)
        assert words["f"] == sum(item["triangles"] for item in tile["parts"])
        assert words["v"] == words["vt"]
        assert {line.split()[1] for line in lines if line.startswith("usemtl")} <= known
        last = max(int(corner.split("/")[0]) for line in lines if line[:2] == "f " for corner in line.split()[1:])
        assert last == words["v"]
    assert len(files) == len(manifest["tiles"]) + 2


@pytest.mark.parametrize(
    ("options", "name"),
    [({"tile": 30.0}, "tile"), ({"carla": "a b"}, "carla"), ({"up": "y"}, "up"), ({"format": "fbx"}, "format")],
)
def test_options_that_cannot_be(options: dict[str, object], name: str, tmp_path: Path) -> None:
    network(tmp_path)
    with pytest.raises(OptionError, match=name):
        export_scene(tmp_path / "map.xodr", tmp_path / "scene", **options)  # type: ignore[arg-type]
    assert not (tmp_path / "scene").exists()


def scene_with_work_of_others(folder: Path) -> Path:
    """Write a scene, and put a file of the user into its folder."""
    network(folder)
    target = folder / "scene"
    export_scene(folder / "map.xodr", target, format="obj")
    (target / "work.blend").write_text("mine", encoding="utf-8")
    return target


def test_only_listed_files_are_replaced_and_removed(tmp_path: Path) -> None:
    target = scene_with_work_of_others(tmp_path)
    inode = target.stat().st_ino
    assert {"tile_0_0.obj", "scene.mtl"} <= {path.name for path in target.iterdir()}
    export_scene(tmp_path / "map.xodr", target, carla="Town")
    listed = json.loads((target / "scene.json").read_text(encoding="utf-8"))["files"]
    assert {path.name for path in target.iterdir()} == {*listed, "scene.json", "work.blend"}
    assert not {"tile_0_0.obj", "scene.mtl"} & set(listed)
    assert {"Town.json", "Town.xodr"} <= set(listed)
    assert (target / "work.blend").read_text(encoding="utf-8") == "mine"
    # The folder itself may be a mount point.
    assert target.stat().st_ino == inode


def test_an_input_in_the_folder_is_refused(tmp_path: Path) -> None:
    target = scene_with_work_of_others(tmp_path)
    (target / "in.xodr").write_bytes((tmp_path / "map.xodr").read_bytes())
    before = {path.name: path.read_bytes() for path in target.iterdir()}
    with pytest.raises(OutputError, match=r"the input .*in\.xodr lies in the folder"):
        export_scene(target / "in.xodr", target)
    with pytest.raises(OutputError, match=r"the input .*in\.xodr lies in the folder"):
        export_scene(read(target / "in.xodr"), target)
    assert {path.name: path.read_bytes() for path in target.iterdir()} == before


def test_a_file_of_the_name_of_a_tile_stays(tmp_path: Path) -> None:
    target = scene_with_work_of_others(tmp_path)
    (target / "tile_0_0.glb").write_text("mine", encoding="utf-8")
    before = {path.name: path.read_bytes() for path in target.iterdir()}
    with pytest.raises(OutputError, match=r"tile_0_0\.glb is not of what was written there before"):
        export_scene(tmp_path / "map.xodr", target)
    assert {path.name: path.read_bytes() for path in target.iterdir()} == before


@pytest.mark.parametrize("text", ["{}", "[" * 10**5, '{"files": ["../work.blend"]}', '{"files": [1]}', "\udcff"])
def test_an_index_that_lists_no_files_is_refused(text: str, tmp_path: Path) -> None:
    target = scene_with_work_of_others(tmp_path)
    (target / "scene.json").write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(OutputError, match=r"scene\.json does not list the files"):
        export_scene(tmp_path / "map.xodr", target)
    assert (target / "work.blend").is_file()


def test_a_killed_export_is_completed_by_the_next(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = scene_with_work_of_others(tmp_path)
    old = {path.name for path in target.iterdir()}
    moves: list[Path] = []
    replace_file = Path.replace

    def killed(self: Path, other: Path) -> Path:
        moves.append(other)
        if len(moves) == 3:
            raise KeyboardInterrupt
        return replace_file(self, other)

    monkeypatch.setattr(Path, "replace", killed)
    with pytest.raises(KeyboardInterrupt):
        export_scene(tmp_path / "map.xodr", target, carla="Town")
    monkeypatch.undo()
    assert old <= {path.name for path in target.iterdir()}
    assert json.loads((target / "scene.json").read_text(encoding="utf-8"))["incomplete"] is True
    files = export_scene(tmp_path / "map.xodr", target, carla="Town")
    assert {path.name for path in target.iterdir()} == {*(path.name for path in files), "work.blend"}
