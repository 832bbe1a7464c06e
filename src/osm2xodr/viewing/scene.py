"""What is drawn of a file: stations along its roads, and across them the borders of lanes.

A *strip* is one lane section: rows of stations, each with the same borders from left to right. Its surface is the
grid that they span. Page and picture share all this.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from osm2xodr.curves import repeated, runs, starts
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import OpenDrive


@dataclass(frozen=True, eq=False)
class Scene:
    """Stations, strips and lanes of all roads, in the order of the file."""

    strip_road: IntArray  # (strips,) Index of the road
    station_start: IntArray  # (strips + 1,) Into the stations
    lane_start: IntArray  # (strips + 1,) Into the lanes
    # (stations,) On the reference line: m, rad, rise per metre; NaN where unknown. A positive roll lowers the right
    # side, as OpenDRIVE's superelevation does.
    s: FloatArray
    x: FloatArray
    y: FloatArray
    z: FloatArray
    heading: FloatArray
    roll: FloatArray
    grade: FloatArray
    ground: FloatArray  # (stations,) Height of the elevation model, m; NaN where there is none
    # (stations x borders,) t of the borders, m: strip after strip, station after station, from left to right. A strip
    # has one border more than lanes.
    border: FloatArray
    lane: IntArray  # (lanes,) Rows in the file's table of lanes, from left to right, without centre lanes
    centre: IntArray  # (strips,) Row of the centre lane, -1 without one

    @property
    def strip_stations(self) -> IntArray:
        """Number of stations of each strip."""
        return np.diff(self.station_start)

    @property
    def strip_borders(self) -> IntArray:
        """Number of borders of each strip."""
        return np.diff(self.lane_start) + 1

    @property
    def border_start(self) -> IntArray:
        """Where the borders of each strip begin, and those of the last one end."""
        return starts(self.strip_stations * self.strip_borders)

    @property
    def station_strip(self) -> IntArray:
        """Strip of each station."""
        return repeated(self.strip_stations)

    @property
    def station_road(self) -> IntArray:
        """Road of each station."""
        return self.strip_road[self.station_strip]

    def border_station(self) -> IntArray:
        """Return the station of each border."""
        return repeated(self.strip_borders[self.station_strip])

    def border_places(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x, y, z of the borders, m."""
        at = self.border_station()
        across = self.border * np.cos(self.roll)[at]
        return (
            self.x[at] - across * np.sin(self.heading)[at],
            self.y[at] + across * np.cos(self.heading)[at],
            self.z[at] + self.border * np.sin(self.roll)[at],
        )

    def only(self, strips: IntArray) -> Scene:
        """Return the scene of some of the strips, in the order in which they are given."""
        parts = {
            ("strip_road", "centre"): strips,
            ("s", "x", "y", "z", "heading", "roll", "grade", "ground"): _rows(self.station_start, strips),
            ("border",): _rows(self.border_start, strips),
            ("lane",): _rows(self.lane_start, strips),
        }
        return replace(
            self,
            # Where the rows of each strip begin, and those of the last one end.
            station_start=starts(self.strip_stations[strips]),
            lane_start=starts(np.diff(self.lane_start)[strips]),
            **{name: getattr(self, name)[rows] for names, rows in parts.items() for name in names},
        )


def junction_places(file: OpenDrive, scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Return x and y of the middle of each junction's roads, (junctions,), m; NaN for junctions without roads."""
    n = len(file.junctions.id)
    junction = file.roads.junction[scene.station_road]
    rows = np.flatnonzero((junction >= 0) & (junction < n))
    count = np.bincount(junction[rows], minlength=n)
    with np.errstate(invalid="ignore"):
        x = np.bincount(junction[rows], weights=scene.x[rows], minlength=n) / count
        y = np.bincount(junction[rows], weights=scene.y[rows], minlength=n) / count
    return x, y


def _rows(start: IntArray, strips: IntArray) -> IntArray:
    """Return the rows of some strips, one strip after the other."""
    return runs(start[strips], np.diff(start)[strips])
