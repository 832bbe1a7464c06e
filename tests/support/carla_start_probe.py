"""Looks up spawn points in carla.Map, offline, and runs drive.py with a client that only notes what it is asked for.

Prints JSON. Run as a process, for CARLA's package may crash.
"""

from __future__ import annotations

import json
import runpy
import sys
from pathlib import Path
from typing import Any

import carla


def lookups(folder: Path) -> list[dict[str, Any]]:
    """Return what CARLA has at each spawn point."""
    world_map = carla.Map("probe", (folder / "map.xodr").read_text(encoding="utf-8"))
    found = []
    for row in json.loads((folder / "spawn_points.json").read_text(encoding="utf-8"))["spawn_points"]:
        place = carla.Location(row["x"], row["y"], row["z"])
        waypoint = world_map.get_waypoint(place, project_to_road=False, lane_type=carla.LaneType.Driving)
        if waypoint is None:
            found.append({"row": row, "on": False})
            continue
        there = waypoint.transform
        found.append(
            {
                "row": row,
                "on": True,
                "road": str(waypoint.road_id),
                "lane": waypoint.lane_id,
                "junction": waypoint.is_junction,
                "aside": ((there.location.x - place.x) ** 2 + (there.location.y - place.y) ** 2) ** 0.5,
                "above": place.z - there.location.z,
                "turn": (row["yaw"] - there.rotation.yaw + 180.0) % 360.0 - 180.0,
                "tilt": row["pitch"] - there.rotation.pitch,
            }
        )
    return found


class Noted:
    """Stands for an object of CARLA's client, and notes what is asked of it; `state` is shared."""

    def __init__(self, state: dict[str, Any]) -> None:
        self.state = state


class Blueprint(Noted):
    """A kind of vehicle."""

    def __init__(self, state: dict[str, Any], name: str, wheels: int) -> None:
        super().__init__(state)
        self.id, self.wheels, self.role = name, wheels, ""

    def get_attribute(self, name: str) -> str:
        assert name == "number_of_wheels"
        return str(self.wheels)

    def set_attribute(self, name: str, value: str) -> None:
        assert name == "role_name"
        self.role = value


class Actor(Noted):
    """A vehicle in the world."""

    id = 7

    def __init__(self, state: dict[str, Any], place: Any) -> None:
        super().__init__(state)
        self.place = place

    def set_autopilot(self, on: bool, port: int) -> None:
        self.state["ego_autopilot"] = [on, port]

    def get_transform(self) -> Any:
        return self.place


class Settings:
    """Settings of a world."""

    synchronous_mode = False
    fixed_delta_seconds = None


class World(Noted):
    """A world, in which the first place is taken."""

    def set_weather(self, weather: Any) -> None:
        self.state["sun"] = weather.sun_altitude_angle

    def get_settings(self) -> Settings:
        return Settings()

    def apply_settings(self, settings: Settings) -> None:
        self.state["settings"].append([settings.synchronous_mode, settings.fixed_delta_seconds])

    def get_blueprint_library(self) -> World:
        return self

    def filter(self, words: str) -> list[Blueprint]:
        assert words == "vehicle.*"
        kinds = [("vehicle.bh.crossbike", 2), ("vehicle.audi.tt", 4), ("vehicle.tesla.model3", 4)]
        return [Blueprint(self.state, name, wheels) for name, wheels in kinds]

    def try_spawn_actor(self, blueprint: Blueprint, place: Any) -> Actor | None:
        self.state["tried"].append([blueprint.id, blueprint.role, place.location.x, place.location.y])
        return Actor(self.state, place) if len(self.state["tried"]) > 1 else None

    def get_spectator(self) -> World:
        return self

    def set_transform(self, place: Any) -> None:
        self.state["camera"] = [place.location.x, place.location.y, place.location.z, place.rotation.yaw]

    def tick(self) -> None:
        self.state["ticks"] += 1


class Manager(Noted):
    """A traffic manager."""

    def get_port(self) -> int:
        return 8123

    def set_synchronous_mode(self, on: bool) -> None:
        self.state["manager"].append(on)

    def set_random_device_seed(self, seed: int) -> None:
        self.state["seed"] = seed


class Answer:
    """What a server says to a command."""

    def __init__(self, number: int) -> None:
        self.actor_id, self.error = 100 + number, "collision" if number == 0 else ""


class Client(Noted):
    """A client."""

    def __init__(self, host: str, port: int) -> None:
        super().__init__(STATE)
        self.state["server"] = [host, port]

    def set_timeout(self, seconds: float) -> None:
        self.state["timeout"] = seconds

    def generate_opendrive_world(self, text: str, parameters: Any) -> World:
        names = [name for name in dir(parameters) if not name.startswith("_")]
        self.state["parameters"] = {name: getattr(parameters, name) for name in names}
        self.state["characters"] = len(text)
        return World(self.state)

    def load_world(self, name: str) -> World:
        self.state["loaded"] = name
        return World(self.state)

    def get_trafficmanager(self) -> Manager:
        return Manager(self.state)

    def apply_batch_sync(self, batch: list[Any], tick: bool) -> list[Answer]:
        assert tick
        self.state["batch"] = batch
        return [Answer(k) for k in range(len(batch))]

    def apply_batch(self, batch: list[Any]) -> None:
        self.state["destroyed"] = len(batch)


class SpawnActor:
    """The command to let a vehicle appear, which in CARLA takes its own blueprints alone."""

    def __init__(self, blueprint: Blueprint, place: Any) -> None:
        self.row = [blueprint.id, blueprint.role, place.location.x, place.location.y]

    def then(self, command: Any) -> list[Any]:
        return [*self.row, type(command).__name__]


STATE: dict[str, Any] = {"settings": [], "tried": [], "manager": [], "ticks": 0}


def drive(folder: Path, options: list[str]) -> dict[str, Any]:
    """Run the script and return what it asked for."""
    carla.Client, carla.command.SpawnActor = Client, SpawnActor
    sys.argv = ["drive.py", *options]
    runpy.run_path(str(folder / "drive.py"), run_name="__main__")
    return STATE


if __name__ == "__main__":
    if sys.argv[1] == "lookups":
        print(json.dumps(lookups(Path(sys.argv[2]))))
    else:
        print(json.dumps(drive(Path(sys.argv[2]), sys.argv[3:])))
