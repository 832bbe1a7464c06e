"""Square areas side by side, and the roads of a problem divided among them."""

from __future__ import annotations

import numpy as np

from osm2xodr.geometry.heights import ProfileProblem
from osm2xodr.geometry.tile_edges.pieces import find_borders
from osm2xodr.model import Borders, LocalFrame, Outline, Partition

WEST, EAST = 0, 1


def square(west: float, south: float, size: float = 1000.0) -> Outline:
    corners = [(west, south), (west + size, south), (west + size, south + size), (west, south + size)]
    return Outline((np.array(corners),))


def partition(own: int = WEST, *outlines: Outline) -> Partition:
    found = outlines or (square(-1000.0, -500.0), square(0.0, -500.0))
    names = tuple("abcd"[: len(found)])
    return Partition(LocalFrame("", 0.0, 0.0), names, found, tuple(range(1, len(found) + 1)), own)


def borders_of(problem: ProfileProblem, areas: Partition) -> Borders:
    return find_borders(areas, problem.plan_view, problem.end_junction, problem.junction_xy)


def listed(borders: Borders, road: int) -> list[tuple[float, int]]:
    part = slice(borders.piece_start[road], borders.piece_start[road + 1])
    return [
        (round(float(s), 4), int(area))
        for s, area in zip(borders.piece_s[part], borders.piece_area[part], strict=True)
    ]
