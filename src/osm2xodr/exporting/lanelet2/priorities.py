"""Who has right of way in junctions."""

from __future__ import annotations

from collections import defaultdict

from osm2xodr.exporting.lanelet2.furniture import FurnitureMaker
from osm2xodr.exporting.lanelet2.lanelets import Placed
from osm2xodr.exporting.lanelet2.primitives import Primitives
from osm2xodr.exporting.lanelet2.words import LANELETS, TURNING
from osm2xodr.opendrive import ABSENT, End


def add_priorities(placed: Placed, primitives: Primitives, furniture: FurnitureMaker) -> None:
    """Add an element for each connecting road that must yield: it, those that it yields to, and its stop line."""
    file = placed.cut.file
    index = {name: k for k, name in reversed(list(enumerate(file.roads.id)))}
    yields: dict[int, set[int]] = defaultdict(set)
    for _, first, second in file.junctions.priorities:
        if first in index and second in index and first != second:
            yields[index[second]].add(index[first])
    for low in sorted(yields):
        waits = _lanelets(placed, low)
        goes = sorted({number for high in yields[low] for number in _lanelets(placed, high)} - set(waits))
        if not waits or not goes:
            continue
        line = _line(placed, furniture, low)
        members = [
            *(("right_of_way", "lanelet", number) for number in goes),
            *(("yield", "lanelet", number) for number in waits),
            *(("ref_line", "way", way) for way in line),
        ]
        tags = {"type": "regulatory_element", "subtype": "right_of_way"}
        primitives.add_rule(members, tags, sorted([*goes, *waits]))


def _lanelets(placed: Placed, road: int) -> list[int]:
    """Return the lanelets for motor traffic of a road."""
    return sorted(
        placed.by_strip[strip][lane.id]
        for strip in placed.by_road.get(road, ())
        for lane in placed.cut.strips[strip].words.lanes
        if LANELETS[lane.kind][0] in TURNING
    )


def _line(placed: Placed, furniture: FurnitureMaker, road: int) -> list[int]:
    """Return the stop line where traffic comes from that enters a connecting road, as a list of at most one."""
    file = placed.cut.file
    table = file.connections
    for k in range(len(table.connecting)):
        if table.connecting[k] != road or table.incoming[k] == ABSENT:
            continue
        incoming = int(table.incoming[k])
        at_end = int(file.roads.link[incoming, End.END]) == int(table.junction[k])
        s = float(file.roads.length[incoming]) if at_end else 0.0
        for row in range(int(table.link_start[k]), int(table.link_start[k + 1])):
            found = furniture.lines_before(incoming, s, forward=at_end, lane=int(table.link_from[row]))
            if found:
                return found
    return []
