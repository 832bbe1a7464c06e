"""Boundaries of junctions (OpenDRIVE 1.8) as lines of points, worked out from the file alone."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from lxml import etree
from xodr_file import Road, XodrFile, read_xodr

from osm2xodr.model import FloatArray


@dataclass(frozen=True)
class Outline:
    """The boundary of a junction."""

    junction: str
    segments: tuple[FloatArray, ...]  # x, y (n, 2) of each segment

    @property
    def gap(self) -> float:
        """The largest distance of a segment's end from the next one's begin, m."""
        pairs = zip(self.segments, (*self.segments[1:], self.segments[0]), strict=True)
        return max(float(np.hypot(*(after[0] - before[-1]))) for before, after in pairs)

    @property
    def area(self) -> float:
        """The area within, m²; negative if it runs clockwise."""
        x, y = (np.concatenate(self.segments) - self.segments[0][0]).T
        return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2)

    def has_inside(self, x: float, y: float) -> bool:
        """Say whether a place lies within."""
        a = np.concatenate(self.segments)
        b = np.roll(a, -1, axis=0)
        crosses = (a[:, 1] <= y) != (b[:, 1] <= y)
        a, b = a[crosses], b[crosses]
        return bool(np.sum(a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0]) > x) % 2)


def outlines(path: Path) -> tuple[XodrFile, dict[str, Outline | None]]:
    """Return the network of a file, and the boundaries of its junctions by id, None where there is none."""
    network = read_xodr(path)
    root = etree.parse(path, etree.XMLParser(huge_tree=True)).getroot()
    found: dict[str, Outline | None] = {}
    for junction in root.findall("junction"):
        segments = [
            _segment(item, network.roads[str(item.get("roadId"))]) for item in junction.findall("boundary/segment")
        ]
        name = str(junction.get("id"))
        found[name] = Outline(name, tuple(segments)) if segments else None
    return network, found


def _segment(item: etree._Element, road: Road) -> FloatArray:
    ends = {"start": 0.0, "end": road.length}
    if item.get("type") == "lane":
        begin, end = (ends[word] if word in ends else float(word) for word in _words(item, "sStart", "sEnd"))
        s = np.linspace(begin, end, max(2, int(abs(end - begin) / 0.25)))
        number = int(str(item.get("boundaryLane")))
        t = road.sections[0].edges(number, s)[1] if number else np.zeros_like(s)
        return _line(road, s, t)
    at_end = item.get("contactPoint") == "end"
    s = np.array([ends[str(item.get("contactPoint"))]])
    section = road.sections[-1 if at_end else 0]
    borders = {number: [float(edge[0]) for edge in section.edges(number, s)] for number in section.lanes}
    first, last = (item.get(name) for name in ("jointLaneStart", "jointLaneEnd"))
    if first is not None and last is not None:
        low, high = sorted((int(first), int(last)))
        borders = {number: t for number, t in borders.items() if low <= number <= high}
    every = [t for pair in borders.values() for t in pair] or [0.0]
    # From the right to the left, seen away from the junction.
    across = [max(every), min(every)] if at_end else [min(every), max(every)]
    return _line(road, np.repeat(s, 2), np.array(across))


def _words(item: etree._Element, *names: str) -> list[str]:
    return [str(item.get(name)) for name in names]


def _line(road: Road, s: FloatArray, t: FloatArray) -> FloatArray:
    """Return x, y (n, 2) at s and t of a road, where t counts from its centre lane."""
    t = t + road.lane_offset.value(s)
    x, y, hdg = road.pose(s)
    return np.column_stack([x - t * np.sin(hdg), y + t * np.cos(hdg)])
