"""Places of a road network in all of its coordinates: on Earth, in the file, and along its roads."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from functools import cached_property
from typing import Final

import numpy as np

from osm2xodr.curves import wrapped
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray
from osm2xodr.opendrive.reader import first_index, tables_of
from osm2xodr.opendrive.space import (
    Places,
    RoadFinder,
    frame_of,
    grade,
    lane_middles,
    places_on,
    pose,
    section_at,
    superelevation,
    surface_points,
)
from osm2xodr.opendrive.tables import ABSENT, HasTables, OpenDrive

FieldValue = str | int | float | None

# What is known of a place, in order, with the decimals of its numbers: lengths to 1 um, angles to match at 1 km.
LOCATION_FIELDS: Final[dict[str, int]] = {
    "lat": 10, "lon": 10, "x": 6, "y": 6, "z": 6, "height": 6, "hdg": 9, "grade": 9, "superelevation": 9,
    "road": 0, "road_name": 0, "junction": 0, "section_s": 6, "lane": 0, "lane_type": 0,
    "s": 6, "t": 6, "offset": 6, "distance": 6,
}  # fmt: skip


class Locator:
    """Finds places in a network, `file`; `frame` says where it is on Earth, or is None and `reason` says why not.

    Parameters
    ----------
    file
        A road network, or the path of a file, which is read; `InputError` if it cannot be.

    Examples
    --------
    >>> import osm2xodr
    >>> locator = osm2xodr.Locator("area.xodr")  # doctest: +SKIP
    >>> locator.describe(locator.at_geographic(42.5548, 1.5336))[0]["height"]  # doctest: +SKIP
    """

    def __init__(self, file: HasTables | str | os.PathLike[str]) -> None:
        self.file = tables_of(file)
        self.frame, self.reason = frame_of(self.file.header)
        self._ids = first_index(list(self.file.roads.id))

    @cached_property
    def _finder(self) -> RoadFinder:
        """The search index of roads, made when it is first needed."""
        return RoadFinder(self.file)

    def at_geographic(self, lat_deg: FloatArray | float, lon_deg: FloatArray | float) -> Places:
        """Return roads at places on Earth (degrees, WGS 84), the best first for each; see `RoadFinder.find`.

        `InputError` if the file does not say where it is.
        """
        if self.frame is None:
            raise InputError(f"{self.file.path}: {self.reason}; give --x and --y instead")
        return self._finder.find(*self.frame.to_inertial(np.atleast_1d(lon_deg), np.atleast_1d(lat_deg)))

    def at_inertial(self, x: FloatArray | float, y: FloatArray | float) -> Places:
        """Return roads at places in the file's own coordinates, m, the best first for each."""
        return self._finder.find(np.atleast_1d(x), np.atleast_1d(y))

    def on_roads(
        self, roads: Sequence[str], s: FloatArray, t: FloatArray, lanes: Sequence[int | None], offset: FloatArray
    ) -> Places:
        """Return places given by the ids of their roads, s, and either t or the id of a lane.

        `offset` counts from the middle of the lane to the left, m; places without a lane (None) are at t, m.
        `InputError` if there is no such road, s or lane.
        """
        for name in roads:
            if name not in self._ids:
                raise InputError(f"{self.file.path} has no road {name!r}; give the id of a <road>")
        index = np.array([self._ids[name] for name in roads], np.int64)
        for name, k, at in zip(roads, index.tolist(), s.tolist(), strict=True):
            if not 0 <= at <= (length := float(self.file.roads.length[k])):
                raise InputError(f"{self.file.path}: s={at:g} is not on road {name}, which is {length:g} m long")
        asked = [k for k, lane in enumerate(lanes) if lane is not None]
        across = np.array(t, np.float64)
        if asked:
            section = section_at(self.file, index[asked], s[asked])
            rows = [self._lane(roads[k], part, lanes[k]) for k, part in zip(asked, section.tolist(), strict=True)]
            across[asked] = lane_middles(self.file, np.array(rows, np.int64), s[asked]) + offset[asked]
        return places_on(self.file, index, s, across)

    def _lane(self, road: str, section: int, lane: int | None) -> int:
        """Return the row of a lane of a section."""
        lanes = self.file.lanes
        ids = [] if section == ABSENT else lanes.id[lanes.start[section] : lanes.start[section + 1]].tolist()
        if lane not in ids:
            there = ", ".join(str(item) for item in ids if item != ABSENT) or "none"
            raise InputError(f"{self.file.path}: road {road} has no lane {lane} there; its lanes are {there}")
        return int(lanes.start[section]) + ids.index(lane)

    def describe(self, places: Places) -> list[dict[str, FieldValue]]:
        """Return all that is known of places, by the names of `LOCATION_FIELDS`; None where it is unknown."""
        file = self.file
        road, s, t = places.road, places.s, places.t
        x, y, z = surface_points(file, road, s, t)
        _, _, hdg = pose(file, road, s)
        unknown = np.full(len(s), np.nan)
        lon, lat = (unknown, unknown) if self.frame is None else self.frame.to_geographic(x, y)
        section_s = unknown.copy()
        known = places.section != ABSENT
        section_s[known] = file.sections.s[places.section[known]]
        numbers = {
            "lat": lat, "lon": lon, "x": x, "y": y, "z": z, "s": s, "t": t, "section_s": section_s,
            "height": z if self.frame is None else self.frame.height(z), "hdg": wrapped(hdg),
            "grade": grade(file, road, s), "superelevation": superelevation(file, road, s),
            "offset": t - lane_middles(file, places.lane, s), "distance": places.distance,
        }  # fmt: skip
        rounded = {name: np.round(values, LOCATION_FIELDS[name]).tolist() for name, values in numbers.items()}
        return [self._description(places, k, rounded) for k in range(len(s))]

    def _description(self, places: Places, k: int, numbers: dict[str, list[float]]) -> dict[str, FieldValue]:
        """Return all that is known of the k-th place."""
        file = self.file
        road, lane = int(places.road[k]), int(places.lane[k])
        words: dict[str, FieldValue] = {
            "road": file.roads.id[road],
            "road_name": file.roads.name[road],
            "junction": None if file.roads.junction[road] == -1 else file.roads.junction_id[road],
            "lane": None if lane == ABSENT else int(file.lanes.id[lane]),
            "lane_type": None if lane == ABSENT else file.lanes.type[lane],
        }
        return {name: words[name] if name in words else _known(numbers[name][k]) for name in LOCATION_FIELDS}


def caveats(file: OpenDrive) -> list[str]:
    """Return sentences about what is wrong in a file or left out of its places and surfaces."""
    out = []
    if count := len(file.misfits):
        what = "1 thing" if count == 1 else f"{count} things"
        out.append(f"{file.path} has {what} that OpenDRIVE does not allow; osm2xodr check lists them")
    if shapes := int(np.count_nonzero(file.crossfall_shape)):
        roads = "1 road has" if shapes == 1 else f"{shapes} roads have"
        out.append(f"{roads} a lateral <shape>, which is left out: heights beside the reference line are wrong there")
    return out


def _known(value: float) -> float | None:
    """Return a number, never as -0; None where it is not finite."""
    return value + 0.0 if math.isfinite(value) else None
