"""Loads a file into carla.Map, offline, and prints what CARLA sees as JSON. Run as a process, for it may crash."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import carla

STEP = 1.0


def lane_key(waypoint: Any) -> tuple[int, int, int]:
    return waypoint.road_id, waypoint.section_id, waypoint.lane_id


def place(waypoint: Any) -> list[float]:
    """Return road, section and lane of a waypoint, its s, x, y, z (y to the north, as in the file) and width."""
    p = waypoint.transform.location
    return [*lane_key(waypoint), waypoint.s, p.x, -p.y, p.z, waypoint.lane_width]


def step_figures(waypoint: Any) -> list[dict[str, Any]]:
    """Say how far each waypoint that lies STEP ahead is, and how far the heading turns up to there."""
    a = waypoint.transform
    figures = []
    for ahead in waypoint.next(STEP):
        b = ahead.transform
        flat = math.hypot(a.location.x - b.location.x, a.location.y - b.location.y)
        turn = abs((a.rotation.yaw - b.rotation.yaw + 180.0) % 360.0 - 180.0)
        rise = b.location.z - a.location.z
        where = f"{lane_key(waypoint)} s={waypoint.s:.2f} to {lane_key(ahead)} s={ahead.s:.2f}"
        figures.append({"where": where, "flat": flat, "rise": rise, "turn": math.radians(turn)})
    return figures


def crosswalks(world: Any) -> list[list[list[float]]]:
    """Return the corners of each crosswalk, x, y, z; one ends where its first corner comes again."""
    found: list[list[list[float]]] = []
    begun = False
    for point in world.get_crosswalks():
        corner = [point.x, -point.y, point.z]
        if not begun:
            found.append([])
        begun = not begun or corner != found[-1][0]
        found[-1].append(corner)
    return found


def changes(waypoint: Any) -> list[bool]:
    """Say whether the marks beside a lane let its drivers leave it to the left and to the right."""
    sides = (carla.LaneChange.Left, waypoint.left_lane_marking), (carla.LaneChange.Right, waypoint.right_lane_marking)
    # Lanes at the edge of the road may have no mark.
    return [mark is not None and bool(int(mark.lane_change) & int(side)) for side, mark in sides]


def landmark(item: Any) -> dict[str, Any]:
    """Say what a landmark is: where it was read from, and where the thing itself stands."""
    p = item.transform.location
    return {
        "id": item.id,
        "road": item.road_id,
        "s": item.s,
        "t": item.t,
        "type": item.type,
        "country": item.country,
        "value": item.value,
        "unit": item.unit,
        "light": item.is_dynamic,
        "orientation": str(item.orientation),
        "place": [p.x, -p.y, p.z],
        "lanes": [list(pair) for pair in item.get_lane_validities()],
    }


def probe(path: str) -> dict[str, Any]:
    """Return origin, lanes, topology and steps between waypoints of a file."""
    world = carla.Map("probe", Path(path).read_text(encoding="utf-8"))
    origin = world.transform_to_geolocation(carla.Location(0, 0, 0))
    waypoints = world.generate_waypoints(STEP)
    return {
        "origin_lat_lon": [origin.latitude, origin.longitude],
        "lanes": sorted({lane_key(w) for w in waypoints}),
        "changes": sorted({lane_key(w): changes(w) for w in waypoints}.items()),
        "topology": sorted({(lane_key(a), lane_key(b)) for a, b in world.get_topology()}),
        "places": [place(w) for w in waypoints],
        "steps": [figure for w in waypoints for figure in step_figures(w)],
        "crosswalks": crosswalks(world),
        "landmarks": [landmark(item) for item in world.get_all_landmarks()],
    }


if __name__ == "__main__":
    print(json.dumps(probe(sys.argv[1])))
