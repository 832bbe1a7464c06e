"""A map of Lanelet2, read with Lanelet2's own library, beside the OpenDRIVE that it was made from."""

from __future__ import annotations

import json
import re
import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree
from numpy.typing import NDArray
from real_readers import need, run_reader
from xodr_file import Road, XodrFile, read_xodr
from xodr_measure import lane_steps

# Road, lane and s of the begin of a lanelet, as its tags say.
Name = tuple[str, str, str]
Edge = tuple[Name, Name]

PARTICIPANTS = ("vehicle", "bicycle", "pedestrian")
# No lane is farther from the reference line, m.
FARTHEST = 20.0
# Of so many nodes of a road one is measured.
EVERY = 11


@dataclass(frozen=True)
class Lanelet:
    """A lanelet of a lane: its tags, the nodes of its left and right bound, the subtypes of its rules."""

    tags: dict[str, str]
    bounds: tuple[list[int], list[int]]
    rules: list[str]


@dataclass(frozen=True)
class Edges:
    """Which lanelets follow each other, and to which one may change."""

    follow: set[Edge]
    left: set[Edge]
    right: set[Edge]


@dataclass(frozen=True)
class LaneletMap:
    """What Lanelet2's library reads; `others` are lanelets that stand for no lane, such as crosswalks."""

    errors: list[str]
    lanelets: dict[Name, Lanelet]
    others: int
    rules: dict[str, int]
    edges: dict[str, Edges]


def read_map(path: Path) -> LaneletMap:
    """Read a map with Lanelet2's own library."""
    need("lanelet2", "Lanelet2's library (lanelet2)")
    done = run_reader([sys.executable, str(Path(__file__).with_name("lanelet_probe.py")), str(path)])
    assert done.returncode == 0, done.stderr[-2000:]
    answers: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    lanelets = {_name(one["name"]): Lanelet(one["tags"], one["bounds"], one["rules"]) for one in answers["lanelets"]}
    edges = {
        who: Edges(*({(_name(a), _name(b)) for a, b in found[key]} for key in ("follow", "left", "right")))
        for who, found in answers["edges"].items()
    }
    return LaneletMap(answers["errors"], lanelets, answers["others"], answers["rules"], edges)


def _name(words: list[str]) -> Name:
    road, lane, s = words
    return road, lane, s


def height_errors(path: Path, source: Path, found: LaneletMap) -> NDArray[np.float64]:
    """Return how far some nodes of bounds lie above or below the road that they bound, m.

    Places are looked up by x and y alone: of those that lie beside several s the best one counts.
    """
    pattern = r'<node id="(\d+)".*?k="ele" v="(.*?)"/><tag k="local_x" v="(.*?)"/><tag k="local_y" v="(.*?)"'
    nodes = {
        int(number): (float(x), float(y), float(z))
        for number, z, x, y in re.findall(pattern, path.read_text(encoding="utf-8"))
    }
    network = read_xodr(source)
    errors: list[float] = []
    on_road: dict[str, set[int]] = defaultdict(set)
    for (road, _, _), lanelet in found.lanelets.items():
        on_road[road] |= {node for line in lanelet.bounds for node in line}
    for name, rows in on_road.items():
        errors += _errors_on(network.roads[name], np.array([nodes[node] for node in sorted(rows)[::EVERY]]))
    return np.array(errors)


def _errors_on(road: Road, points: NDArray[np.float64]) -> Iterator[float]:
    s = np.linspace(0.0, road.length, max(3, int(road.length / 0.25)))
    x, y, hdg = road.pose(s)
    for point in points:
        ahead = (point[0] - x) * np.cos(hdg) + (point[1] - y) * np.sin(hdg)
        # Where the point passes from before a station to behind it; and the ends of the road.
        row = np.flatnonzero(ahead[:-1] * ahead[1:] <= 0)
        low, high, sign = s[row], s[row + 1], np.sign(ahead[row])
        # To half a millimetre.
        for _ in range(9):
            middle = (low + high) / 2
            px, py, turn = road.pose(middle)
            same = ((point[0] - px) * np.cos(turn) + (point[1] - py) * np.sin(turn)) * sign > 0
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        at = np.append(low, [0.0, road.length])
        px, py, turn = road.pose(at)
        beside = -(point[0] - px) * np.sin(turn) + (point[1] - py) * np.cos(turn)
        places = road.points(at, beside)
        # Far away a line square to another stretch of the road may pass.
        there = (np.hypot(*(places[:, :2] - point[:2]).T) < 2e-3) & (np.abs(beside) < FARTHEST)
        if there.any():
            yield float(np.min(np.abs(places[there, 2] - point[2])))


class ExpectedGraph:
    """The edges that the lane links of a file ask for."""

    def __init__(self, path: Path, lanelets: dict[Name, Lanelet]) -> None:
        self._network: XodrFile = read_xodr(path)
        self._marks = {road.get("id", ""): _marks(road) for road in etree.parse(str(path)).getroot().iter("road")}
        self._who = {
            name: {key.split(":", 1)[1] for key in one.tags if key.startswith("participant:")}
            for name, one in lanelets.items()
        }
        self._both = {name for name, one in lanelets.items() if one.tags["one_way"] == "no"}
        # Lanelets of each lane along s: from, to and name.
        self._along: dict[tuple[str, str], list[tuple[float, float, Name]]] = defaultdict(list)
        for name, one in lanelets.items():
            low, high = map(float, one.tags["xodr:s"].split())
            self._along[name[:2]].append((low, high, name))
        for places in self._along.values():
            places.sort()

    def following(self, participant: str) -> set[Edge]:
        """Return which lanelets follow each other."""
        out = set()
        for one, other, leaves, enters in self._contacts():
            for a, b, out_of, into in ((one, other, leaves, enters), (other, one, enters, leaves)):
                both_may = participant in self._who[a] and participant in self._who[b]
                # From the end of one to the begin of the other, as traffic runs.
                leads_out = a in self._both or out_of == self._forward(a)
                leads_in = b in self._both or into != self._forward(b)
                if both_may and leads_out and leads_in:
                    out.add((a, b))
        return out

    def changes(self, participant: str) -> tuple[set[Edge], set[Edge]]:
        """Return between which lanelets one may change to the left and to the right, by the road marks."""
        left, right = set[Edge](), set[Edge]()
        for name in self._who:
            road, number, s = name[0], int(name[1]), float(name[2])
            for step in (1, -1):
                other = number + step or step
                beside = (road, str(other), name[2])
                if beside not in self._who or any(participant not in self._who[one] for one in (name, beside)):
                    continue
                # The mark on the inner border of the outer lane, which across the centre is that of lane 0.
                owner = min(number, other, key=abs) if number * other > 0 else 0
                if not _allowed(self._marks[road], owner, s, up=step > 0):
                    continue
                for forward in (True, False):
                    if all(one in self._both or self._forward(one) == forward for one in (name, beside)):
                        (left if (step > 0) == forward else right).add((name, beside))
        return left, right

    def _forward(self, name: Name) -> bool:
        return self._network.roads[name[0]].forward(int(name[1]))

    def _contacts(self) -> Iterator[tuple[Name, Name, bool, bool]]:
        """Yield two lanelets whose ends are linked, and of each whether it is the one at its greater s."""
        for places in self._along.values():
            for (_, high, one), (low, _, other) in pairwise(places):
                if high == low and self._inside(one, high):
                    yield one, other, True, False
        for road in self._network.roads.values():
            for k, (section, following) in enumerate(pairwise(road.sections)):
                for lane in section.lanes.values():
                    yield from self._inner(road, k, lane.id, lane.successors)
                for lane in following.lanes.values():
                    for to in lane.predecessors:
                        yield from self._inner(road, k, to, (lane.id,))
        for step in lane_steps(self._network):
            here = self._at_end(self._network.roads[step.road], step.lane, step.at_start)
            there = self._at_end(self._network.roads[step.beyond], step.beyond_lane, step.beyond_at_start)
            if here and there:
                yield here, there, not step.at_start, not step.beyond_at_start

    def _inner(self, road: Road, k: int, lane: int, to: tuple[int, ...]) -> Iterator[tuple[Name, Name, bool, bool]]:
        s = road.sections[k].end
        for number in to:
            one = [name for low, high, name in self._along[road.id, str(lane)] if low < s - 1e-3 <= high]
            other = [name for low, high, name in self._along[road.id, str(number)] if low <= s + 1e-3 < high]
            if one and other and one != other:
                yield one[0], other[0], True, False

    def _inside(self, name: Name, s: float) -> bool:
        """Return whether s lies within a lane section, where a strip was cut because a mark or a limit changes."""
        sections = self._network.roads[name[0]].sections
        return all(abs(section.s - s) > 2e-3 for section in sections)

    def _at_end(self, road: Road, lane: int, at_start: bool) -> Name | None:
        places = self._along.get((road.id, str(lane)))
        if not places:
            return None
        low, high, name = places[0] if at_start else places[-1]
        return name if abs((low if at_start else high) - (0.0 if at_start else road.length)) < 2e-3 else None


# Marks of a road: lane, s, type and ``laneChange`` (empty where it is missing).
_Marks = list[tuple[int, float, str, str]]


def _marks(road: etree._Element) -> _Marks:
    return [
        (
            int(lane.get("id", "")),
            float(section.get("s", "")) + float(mark.get("sOffset", "")),
            mark.get("type", ""),
            mark.get("laneChange", ""),
        )
        for section in road.iter("laneSection")
        for lane in section.iter("lane")
        for mark in lane.iter("roadMark")
    ]


def _allowed(marks: _Marks, lane: int, s: float, *, up: bool) -> bool:
    """Return whether one may change to the next higher (or lower) id across the mark of a lane at s."""
    found = [item for item in marks if item[0] == lane and item[1] <= s + 1e-3]
    _, _, kind, change = found[-1] if found else (lane, 0.0, "none", "")
    if change:
        return change in ("both", "increase" if up else "decrease")
    return kind in ("none", "broken", "broken broken", "botts dots")
