"""Road networks as tables with geometry: `geopandas.GeoDataFrame`, and GeoPackage by GDAL."""

from __future__ import annotations

import math
import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import geopandas
import numpy as np
import pyogrio
import shapely

from osm2xodr.checking import lane_index
from osm2xodr.exporting.geojson import NARROWEST_SHOWN, middle_lengths
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import (
    ABSENT,
    OpenDrive,
    frame_of,
    lane_ribbons,
    sample_roads,
    speed_limits,
    surface_points,
)
from osm2xodr.system import ByteSink

_KMH: Final = 3.6
# Attributes of signals, and their columns: tables with geometry have a ``type`` of their own.
_SIGNAL_TEXTS: Final = {
    "name": "signal_name",
    "type": "signal_type",
    "subtype": "signal_subtype",
    "country": "country",
    "unit": "unit",
    "orientation": "orientation",
}
# A GeoPackage says when it was changed last. The same input shall give the same bytes.
_NO_TIME: Final = "1970-01-01T00:00:00Z"


def geodataframe(file: OpenDrive, layer: str, tolerance: float, step: float) -> Any:
    """Return ``lanes``, ``roads`` or ``signals`` as a table; see `osm2xodr.RoadNetwork.to_geodataframe`."""
    frame, _ = frame_of(file.header)
    columns, geometry = _LAYERS[layer](file, tolerance, step)
    return geopandas.GeoDataFrame(columns, geometry=geometry, crs=None if frame is None else frame.crs.to_2d())


def write_geopackage(file: OpenDrive, stream: ByteSink, tolerance: float, step: float) -> None:
    """Write all layers as a GeoPackage."""
    before = pyogrio.get_gdal_config_option("OGR_CURRENT_DATE")
    pyogrio.set_gdal_config_options({"OGR_CURRENT_DATE": _NO_TIME})
    try:
        # GDAL writes to files alone.
        with tempfile.TemporaryDirectory(prefix="osm2xodr-") as folder:
            path = Path(folder) / "network.gpkg"
            for layer in _LAYERS:
                table = geodataframe(file, layer, tolerance, step)
                table["osm_ways"] = [" ".join(map(str, ways)) for ways in table["osm_ways"]]
                table.to_file(path, layer=layer, driver="GPKG", engine="pyogrio")
            with path.open("rb") as made:
                shutil.copyfileobj(made, stream)
    finally:
        pyogrio.set_gdal_config_options({"OGR_CURRENT_DATE": before})


def _lanes(file: OpenDrive, tolerance: float, step: float) -> tuple[dict[str, Any], Any]:
    """Return the columns of lanes, without those that have no width anywhere, and their outlines."""
    ribbons = lane_ribbons(file, sample_roads(file, tolerance, step))
    x, y, z = _projected(file, ribbons.x, ribbons.y, ribbons.z)
    points = np.column_stack([x, y, z])
    good = np.isfinite(points).all(1)
    start = ribbons.start.tolist()
    rows: list[int] = []
    rings: list[FloatArray] = []
    owners: list[IntArray] = []
    middles, widths = [], []
    for row in np.flatnonzero(ribbons.left != ABSENT).tolist():
        left, right = (slice(*start[k : k + 2]) for k in (int(ribbons.left[row]), int(ribbons.right[row])))
        width = ribbons.t[left] - ribbons.t[right]
        ring = np.concatenate([points[right], points[left][::-1]])[np.concatenate([good[right], good[left][::-1]])]
        if len(ring) < 3 or not np.nanmax(width, initial=0.0) > NARROWEST_SHOWN:
            continue
        owners.append(np.full(len(ring) + 1, len(rows)))
        rings.append(np.concatenate([ring, ring[:1]]))
        rows.append(row)
        widths.append(float(np.nanmean(width)))
        middles.append(float(np.nanmean(0.5 * (ribbons.t[left] + ribbons.t[right]))))
    row = np.array(rows, np.int64)
    lanes, sections, index = file.lanes, file.sections, lane_index(file)
    section = lanes.section[row]
    road = sections.road[section]
    direction = np.where(index.both_ways, "both", np.where(index.forward, "forward", "backward"))
    columns = {
        **_of_roads(file, road),
        "lane_id": lanes.id[row],
        "lane_type": _texts(lanes.type, row),
        "direction": direction[row].tolist(),
        "s_start_m": sections.s[section],
        "s_end_m": sections.end[section],
        "t_m": middles,
        "width_m": widths,
        "length_m": middle_lengths(file, ribbons)[row],
        "speed_kmh": speed_limits(file)[row] * _KMH,
    }
    outlines = shapely.linearrings(np.concatenate(rings), indices=np.concatenate(owners)) if rings else []
    return columns, shapely.polygons(outlines)


def _roads(file: OpenDrive, tolerance: float, step: float) -> tuple[dict[str, Any], Any]:
    """Return the columns of roads, and their reference lines; those without a place have none."""
    stations = sample_roads(file, tolerance, step)
    points = np.column_stack(_projected(file, stations.x, stations.y, stations.z))
    good = np.isfinite(points).all(1)
    count = np.bincount(stations.road[good], minlength=len(file.roads.id))
    good &= count[stations.road] > 1
    lines = np.full(len(file.roads.id), None, object)
    if good.any():
        with_line, owner = np.unique(stations.road[good], return_inverse=True)
        lines[with_line] = shapely.linestrings(points[good], indices=owner)
    types, row = file.types, np.arange(len(file.roads.id))
    has = types.start[1:] > types.start[:-1]
    first = types.start[:-1].tolist()
    speed = np.full(len(row), np.nan)
    speed[has] = types.speed[types.start[:-1][has]]
    columns = {
        **_of_roads(file, row),
        "road_type": [types.type[k] if known else "" for k, known in zip(first, has.tolist(), strict=True)],
        "rule": ["LHT" if left else "RHT" for left in file.roads.left_hand.tolist()],
        "predecessor_id": [ids[0] for ids in file.roads.link_id],
        "successor_id": [ids[1] for ids in file.roads.link_id],
        "length_m": file.roads.length,
        "speed_kmh": speed * _KMH,
    }
    return columns, lines


def _signals(file: OpenDrive, tolerance: float, step: float) -> tuple[dict[str, Any], Any]:
    """Return the columns of signals, and their places; those without a known one have none."""
    items = [item for item in file.furniture if item.kind == "signal"]
    road = np.array([item.road for item in items], np.int64)
    s, t, up = (np.array([getattr(item, name) for item in items], np.float64) for name in ("s", "t", "z_offset"))
    points = np.column_stack(_projected(file, *surface_points(file, road, s, t, np.nan_to_num(up))))
    places = np.full(len(items), None, object)
    good = np.isfinite(points).all(1)
    places[good] = shapely.points(points[good])
    words = {name: [item.attributes.get(name, "") for item in items] for name in ("id", *_SIGNAL_TEXTS)}
    columns = {
        "signal_id": words["id"],
        **_of_roads(file, road),
        **{column: words[name] for name, column in _SIGNAL_TEXTS.items()},
        "value": [_value(item.attributes.get("value", "")) for item in items],
        "dynamic": [item.attributes.get("dynamic", "") == "yes" for item in items],
        "s_m": s,
        "t_m": t,
        "z_offset_m": up,
        "height_m": [item.height for item in items],
        "width_m": [item.width for item in items],
    }
    return columns, places


def _of_roads(file: OpenDrive, road: IntArray) -> dict[str, Any]:
    """Return the columns that name roads by their rows, (n,)."""
    rows = road.tolist()
    return {
        "road_id": _texts(file.roads.id, road),
        "road_name": _texts(file.roads.name, road),
        "junction_id": ["" if file.roads.junction[k] == -1 else file.roads.junction_id[k] for k in rows],
        "osm_ways": [file.osm_ways(k) for k in rows],
    }


def _texts(texts: Sequence[str], row: IntArray) -> list[str]:
    return [texts[k] for k in row.tolist()]


def _value(text: str) -> float:
    """Return the number that a text stands for, or NaN where it is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def _projected(file: OpenDrive, x: FloatArray, y: FloatArray, z: FloatArray) -> tuple[FloatArray, ...]:
    """Return inertial coordinates in the projection of the file, or as they are without one."""
    frame, _ = frame_of(file.header)
    return (x, y, z) if frame is None else (*frame.to_projected(x, y), frame.height(z))


_LAYERS: Final[Mapping[str, Callable[[OpenDrive, float, float], tuple[dict[str, Any], Any]]]] = {
    "lanes": _lanes,
    "roads": _roads,
    "signals": _signals,
}
