"""Autoware: a folder of maps with the names that it looks for."""

from __future__ import annotations

from typing import Final

from osm2xodr.python_api import export
from osm2xodr.starting.request import FOLDER, Made, Request

_MAP: Final = "lanelet2_map.osm"
# As of Autoware's tutorial on its planning simulator. It wants the path of the folder from the root on.
_COMMAND: Final = (
    f'ros2 launch autoware_launch planning_simulator.launch.xml map_path:="$(realpath {FOLDER})"'
    " vehicle_model:=sample_vehicle sensor_model:=sample_sensor_kit"
)
_POINT_CLOUD: Final = """\
There is no `pointcloud_map.pcd`: a road network does not say what a laser sees. The planning simulator runs without;
its map loader says `invalid path` and `PCD metadata file not found`, and goes on. Localization by a laser needs a
cloud that was recorded, in the coordinates of `map.xodr`: x east and y north of the origin of its `geoReference`, in
metres, and z in the datum of the elevation model."""
_COORDINATES: Final = f"""\
`projector_type: Local` says that places are those of `map.xodr`, whatever the datum of heights, which is not known of
every elevation model. For a receiver of GNSS write MGRS, with heights above the geoid:

    osm2xodr export map.xodr --to lanelet2 --projector mgrs -o {_MAP} --overwrite"""
_NEEDS: Final = (
    "Install [Autoware](https://autowarefoundation.github.io/autoware-documentation/main/installation/), and source"
    " its `install/setup.bash`."
)


def make(request: Request) -> Made:
    """Write the map, and how its coordinates are meant."""
    request.on_stage("making the map of Lanelet2")
    notes: list[str] = []
    _, projector = export(request.xodr, request.folder / _MAP, format="lanelet2", projector="local", say=notes.append)
    files = {_MAP: "the map, Lanelet2 with heights", projector.name: "how its coordinates are meant"}
    notes.append("there is no point cloud; the planning simulator runs without")
    return Made(
        _NEEDS,
        _COMMAND,
        files,
        tuple(notes),
        {"Point cloud": _POINT_CLOUD, "Coordinates": _COORDINATES},
    )
