"""The folder for CARLA: a lane at every place for cars, what the script asks for, and tiles."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from osm_builder import Area
from real_readers import need, run_reader
from scene_files import SAMPLES, scene_named

import osm2xodr
from osm2xodr import Started

(SAMPLE,) = SAMPLES
LEFT_HAND = scene_named("fremantle_placement")


@pytest.fixture(scope="module", params=(SAMPLE, LEFT_HAND), ids=str)
def started(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Started:
    folder = tmp_path_factory.mktemp("start") / "carla"
    return osm2xodr.start("carla", request.param.osm, folder, request.param.dem, name="My town")


def probe(what: str, folder: Path, *options: str) -> Any:
    """Ask CARLA's package about a folder (see `carla_start_probe`)."""
    need("carla", "the CARLA client (carla)")
    script = Path(__file__).parents[1] / "support" / "carla_start_probe.py"
    done = run_reader([sys.executable, str(script), what, str(folder), *options])
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout.splitlines()[-1])


def test_every_place_for_a_car_lies_on_its_lane(started: Started) -> None:
    found = probe("lookups", started.folder)
    assert len(found) > (3000 if "sample" in started.conversion.inputs["area"] else 100)
    for item in found:
        row = item["row"]
        assert item["on"], row
        assert (item["road"], item["lane"], item["junction"]) == (row["road"], row["lane"], False)
        # Where lanes open and close CARLA's middles differ by decimetres.
        assert item["aside"] < 0.3
        assert item["above"] == pytest.approx(0.5, abs=0.1)
        assert abs(item["turn"]) < 5.0
        assert abs((item["tilt"] + 180.0) % 360.0 - 180.0) < 2.0


def test_places_begin_in_the_middle(started: Started) -> None:
    rows = json.loads((started.folder / "spawn_points.json").read_text(encoding="utf-8"))["spawn_points"]
    assert len({(row["x"], row["y"]) for row in rows}) == len(rows)
    x, y = (statistics.median(row[axis] for row in rows) for axis in ("x", "y"))
    far = [((row["x"] - x) ** 2 + (row["y"] - y) ** 2) ** 0.5 for row in rows]
    assert far == pytest.approx(sorted(far), abs=0.1)


def test_the_script_drives(started: Started) -> None:
    rows = json.loads((started.folder / "spawn_points.json").read_text(encoding="utf-8"))["spawn_points"]
    asked = probe("drive", started.folder, "--seconds", "2", "--vehicles", "5", "--weather", "WetSunset")
    assert (asked["server"], asked["timeout"]) == (["127.0.0.1", 2000], 300.0)
    assert asked["characters"] == len((started.folder / "map.xodr").read_text(encoding="utf-8"))
    wanted = {"vertex_distance": 2.0, "wall_height": 0.0, "smooth_junctions": True, "enable_mesh_visibility": True}
    assert wanted.items() <= asked["parameters"].items()
    assert asked["parameters"]["enable_pedestrian_navigation"] is False
    # The first place is taken: the ego appears at the second, and the others at those around.
    places = [[row["x"], row["y"]] for row in rows]
    assert [item[:2] for item in asked["tried"]] == [["vehicle.tesla.model3", "hero"]] * 2
    assert [item[2:] for item in asked["tried"]] == [pytest.approx(place, abs=1e-3) for place in places[:2]]
    assert asked["ego_autopilot"] == [True, 8123]
    around = [places[0], *places[2:6]]
    assert [item[2:4] for item in asked["batch"]] == [pytest.approx(place, abs=1e-3) for place in around]
    assert {item[4] for item in asked["batch"]} == {"SetAutopilot"}
    assert "vehicle.bh.crossbike" not in {item[0] for item in asked["batch"]}
    assert asked["ticks"] == 40
    assert asked["settings"] == [[True, 0.05], [False, None]]
    assert asked["manager"] == [True, False]
    # The ego and those that could appear: the server refuses the first of five.
    assert asked["destroyed"] == 5


def test_an_imported_map_is_loaded_by_its_name(started: Started) -> None:
    asked = probe("drive", started.folder, "--seconds", "1", "--map", "My_town")
    assert asked["loaded"] == "My_town"
    assert "parameters" not in asked


def test_the_script_says_what_it_can(started: Started) -> None:
    need("carla", "the CARLA client (carla)")
    script = str(started.folder / "drive.py")
    assert started.command == f"python3 {script}"
    done = subprocess.run([sys.executable, script, "--help"], check=True, capture_output=True, text=True)
    assert "--weather" in done.stdout


def test_the_scene_is_a_package_for_the_importer(started: Started) -> None:
    names = sorted(path.name for path in (started.folder / "import").iterdir())
    # The importer takes every JSON file for a package.
    assert [name for name in names if name.endswith(".json")] == ["My_town.json"]
    (entry,) = json.loads((started.folder / "import" / "My_town.json").read_text(encoding="utf-8"))["maps"]
    assert entry["name"] == "My_town"
    assert (started.folder / "import" / "My_town.xodr").read_bytes() == (started.folder / "map.xodr").read_bytes()
    readme = (started.folder / "README.md").read_text(encoding="utf-8")
    assert "bpy.ops.export_scene.fbx" in readme
    tiles = [name for name in names if name.endswith(".glb")]
    if len(tiles) == 1:
        assert (entry["source"], "tile_size" in entry) == ("./My_town.fbx", False)
        assert not [note for note in started.notes if "walkers" in note]
        assert "they go on `Road_Sidewalk`" in readme
    else:
        assert sorted(entry["tiles"]) == [f"./{name[:-4]}.fbx" for name in tiles]
        assert started.notes[1] == (
            f"{len(tiles)} tiles are a large map for CARLA, which makes no walkers' navigation of these"
        )
        assert "walkers are lost there" in readme


@pytest.mark.parametrize(
    ("length", "scene_tile", "tiles"), [(2_480.0, None, 1), (2_600.0, None, 4), (900.0, 500.0, 4)]
)
def test_up_to_two_and_a_half_kilometres_are_one_tile(
    length: float, scene_tile: float | None, tiles: int, tmp_path: Path
) -> None:
    half = length / 2.0
    nodes = {1: (-half, 0.0), 2: (0.0, 0.0), 3: (half, 0.0)}
    osm = Area(nodes, {10: ([1, 2, 3], "highway=tertiary lanes=2 maxspeed=50")}).write(tmp_path)
    started = osm2xodr.start("carla", osm, tmp_path / "carla", scene_tile=scene_tile)
    found = sorted((started.folder / "import").glob("*.glb"))
    assert len(found) == tiles
    assert bool([note for note in started.notes if "walkers' navigation" in note]) == (tiles > 1)
