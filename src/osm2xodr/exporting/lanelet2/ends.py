"""Ends of strips, joined where lanes are linked: lanelets follow each other exactly if they share their end nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr.curves import unique_inverse
from osm2xodr.exporting.lanelet2.strips import Cut
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import End

# An end of a border: strip, border, and at which `End` of the strip.
Slot = tuple[int, int, int]


@dataclass(frozen=True)
class Ends:
    """The ends of all borders of strips, as nodes that linked lanes share."""

    node: dict[Slot, int]  # Which node each end is
    place: FloatArray  # (nodes, 3) x, y, z in the middle of the ends that meet, m
    gap: FloatArray  # (nodes,) How far the ends that meet lie apart, horizontally, m


def join_ends(cut: Cut) -> Ends:
    """Join the ends of borders where their lanes are linked, or where one strip was cut from the next."""
    slots: dict[Slot, int] = {}
    points = []
    for k, strip in enumerate(cut.strips):
        for border, _ in strip.words.marks:
            line = cut.line(strip, border)
            for end, row in ((End.START, 0), (End.END, -1)):
                slots[k, border, int(end)] = len(slots)
                points.append(line[row])
    parent = list(range(len(slots)))
    for one, other in [*_links(cut), *_seams(cut)]:
        a, b = _root(parent, slots[one]), _root(parent, slots[other])
        parent[max(a, b)] = min(a, b)
    roots = np.array([_root(parent, k) for k in range(len(parent))], np.int64)
    group = unique_inverse(roots)[1]
    place = np.array(points).reshape(-1, 3)
    return _placed(slots, group.astype(np.int64), place)


def _placed(slots: dict[Slot, int], group: IntArray, points: FloatArray) -> Ends:
    """Return the nodes of groups of ends, (ends,), at `points`, (ends, 3)."""
    count = int(group.max(initial=-1)) + 1
    place = np.zeros((count, 3))
    np.add.at(place, group, points)
    place /= np.bincount(group, minlength=count)[:, None]
    gap = np.zeros(count)
    np.maximum.at(gap, group, 2 * np.hypot(*(points - place[group])[:, :2].T))
    return Ends({slot: int(group[k]) for slot, k in slots.items()}, place, gap)


def lane_ends(cut: Cut) -> dict[tuple[int, int], tuple[Slot, Slot]]:
    """Return the ends of the left and right borders, along s, of lanes (rows) where their strips end."""
    out = {}
    for k, strip in enumerate(cut.strips):
        for end, (section, _, _) in ((End.START, strip.pieces[0]), (End.END, strip.pieces[-1])):
            bounds = strip.s[0] <= _begin(cut, section) if end == End.START else strip.s[1] >= _end(cut, section)
            if not bounds:
                continue
            rows = _rows(cut, section)
            for lane in strip.words.lanes:
                out[rows[lane.id], int(end)] = (k, lane.left, int(end)), (k, lane.left + 1, int(end))
    return out


def _links(cut: Cut) -> list[tuple[Slot, Slot]]:
    """Return the ends of borders that links between lanes join."""
    ends = lane_ends(cut)
    pairs = []
    for a, end_a, b, end_b in zip(*(column.tolist() for column in cut.contacts), strict=True):
        one, other = ends.get((a, end_a)), ends.get((b, end_b))
        if one is None or other is None:
            continue
        # Where two ends or two starts meet, left is right.
        other = other if end_a != end_b else other[::-1]
        pairs += list(zip(one, other, strict=True))
    return pairs


def _seams(cut: Cut) -> list[tuple[Slot, Slot]]:
    """Return the ends of borders where one strip goes on as the next one within a section."""
    pairs = []
    for k, (one, other) in enumerate(zip(cut.strips, cut.strips[1:], strict=False)):
        (section, _, last), (following, first, _) = one.pieces[-1], other.pieces[0]
        if section == following and last == first:
            common = {border for border, _ in one.words.marks} & {border for border, _ in other.words.marks}
            pairs += [((k, border, int(End.END)), (k + 1, border, int(End.START))) for border in sorted(common)]
    return pairs


def _root(parent: list[int], k: int) -> int:
    while parent[k] != k:
        parent[k] = parent[parent[k]]
        k = parent[k]
    return k


def _rows(cut: Cut, section: int) -> dict[int, int]:
    """Return the rows of the lanes of a section by id; of those with the same id the first."""
    lanes = cut.file.lanes
    rows: dict[int, int] = {}
    for row in range(int(lanes.start[section]), int(lanes.start[section + 1])):
        rows.setdefault(int(lanes.id[row]), row)
    return rows


def _begin(cut: Cut, section: int) -> float:
    return _stations(cut, section)[0]


def _end(cut: Cut, section: int) -> float:
    return _stations(cut, section)[1]


def _stations(cut: Cut, section: int) -> tuple[float, float]:
    """Return s of the first and last station of a section."""
    border = int(cut.border_start[section])
    rows = cut.ribbons.station[cut.ribbons.start[border] : cut.ribbons.start[border + 1]]
    return float(cut.stations.s[rows[0]]), float(cut.stations.s[rows[-1]])
