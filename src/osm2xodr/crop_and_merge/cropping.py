"""A part of a road network as a network of its own.

Roads that lie in it in part are cut to a stretch.
"""

from __future__ import annotations

import copy
import re
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from osm2xodr.crop_and_merge.document import (
    AT_ONE,
    CELL,
    STUB,
    Element,
    clip,
    cut_records,
    drop_dangling,
    lane_sections,
    mend_junction,
    mend_road,
    number,
    put,
    read_tree,
    remove,
)
from osm2xodr.defaults import UNMEASURED_HEIGHTS
from osm2xodr.errors import EmptyAreaError
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, LinkKind, OpenDrive, Shape, pose
from osm2xodr.system import record

_LANE_CUBICS: Final = ("width", "border")
_LANE_RECORDS: Final = ("roadMark", "material", "visibility", "speed", "access", "height", "rule")

# Says which points, x and y (n,), are inside.
Inside = Callable[[FloatArray, FloatArray], BoolArray]


@dataclass
class _Names:
    """The ids of what is left of roads."""

    ends: dict[tuple[str, str], str] = field(default_factory=dict)  # By former id and contact point
    whole: dict[str, str] = field(default_factory=dict)  # Of whole roads


def crop_network(file: OpenDrive, choice: Choice) -> tuple[Element, list[str]]:
    """Return the document of the chosen part of a file, and sentences about what was lost.

    Elements that OpenDRIVE does not know are kept. `EmptyAreaError` if nothing is chosen.
    """
    if not choice.stretches:
        raise EmptyAreaError(f"{file.path} has no road in this part; give another area or other roads")
    root = read_tree(file.path)
    elements = root.findall("road")
    stretches: dict[int, list[Stretch]] = defaultdict(list)
    for stretch in choice.stretches:
        stretches[stretch.road].append(stretch)
    fresh = _fresh_ids(root)
    names, furniture, cut = _Names(), 0, 0
    pieces: list[tuple[Element, str]] = []
    for k, element in enumerate(elements):
        parts = stretches.get(k, [])
        copies = [element, *(copy.deepcopy(element) for _ in parts[1:])]
        if not parts:
            remove(element)
            continue
        before = element
        for place, (piece, stretch) in enumerate(zip(copies, parts, strict=True)):
            if place:
                piece.set("id", next(fresh))
                # Only these may lie on several pieces.
                for item in (*piece.findall("objects/bridge"), *piece.findall("objects/tunnel")):
                    item.set("id", next(fresh))
                before.addnext(piece)
                before = piece
            furniture += cut_road(piece, file, stretch)
            cut += not (stretch.has_start and stretch.has_end)
            _name(names, element.get("id"), piece.get("id"), stretch)
            pieces.append((piece, file.roads.id[k]))
    kept = frozenset(file.junctions.id[k] for k in choice.junctions)
    for junction in root.findall("junction"):
        if junction.get("id") not in kept:
            remove(junction)
    for piece, former in pieces:
        mend_road(piece, former, names.ends, kept)
    arms = _arms(file, names)
    connections = sum(
        mend_junction(junction, names.whole, arms.get(junction.get("id"), {}), names.ends)
        for junction in root.findall("junction")
    )
    dangling = drop_dangling(root)
    _set_bounds(root, file, choice)
    gone = len(elements) - len(stretches)
    counts = {
        "road": gone,
        "junction": len(file.junctions.id) - len(choice.junctions),
        "connection of junctions": connections,
        "signal or object beyond cuts": furniture,
        **dangling,
    }
    return root, _sentences(cut, counts)


def _words(what: str, count: int) -> str:
    """Return what is counted; its first word, and one after "or", stands for several if there are."""
    return what if count == 1 else re.sub(r"^\w+|(?<= or )\w+", lambda found: f"{found[0]}s", what)


def _sentences(cut: int, counts: dict[str, int]) -> list[str]:
    found = [f"{count} {_words(what, count)}" for what, count in counts.items() if count]
    lines = [f"{cut} {'end of a road was' if cut == 1 else 'ends of roads were'} cut off"] if cut else []
    return [*lines, f"left out: {', '.join(found)}"] if found else lines


def _name(names: _Names, former: str, now: str, stretch: Stretch) -> None:
    if stretch.has_start:
        names.ends.setdefault((former, "start"), now)
    if stretch.has_end:
        names.ends.setdefault((former, "end"), now)
    if stretch.has_start and stretch.has_end:
        names.whole.setdefault(former, now)


def _fresh_ids(root: Element) -> Iterator[str]:
    """Yield ids that are not used in a document: numbers above all others."""
    names = (item.get("id", "") for item in root.iter() if isinstance(item.tag, str))
    number = max((int(name) for name in names if name.isascii() and name.isdigit()), default=0)
    while True:
        number += 1
        yield str(number)


def _arms(file: OpenDrive, names: _Names) -> dict[str, dict[tuple[str, str], str]]:
    """Return the ids of what is left of the incoming roads of each junction, by its id."""
    out: dict[str, dict[tuple[str, str], str]] = defaultdict(dict)
    roads = file.roads
    for k, name in enumerate(roads.id):
        for end, word in ((0, "start"), (1, "end")):
            junction = int(roads.link[k, end])
            if roads.link_kind[k, end] == LinkKind.JUNCTION and junction != ABSENT and (name, word) in names.ends:
                out[file.junctions.id[junction]].setdefault((name, ""), names.ends[name, word])
    return out


def _set_bounds(root: Element, file: OpenDrive, choice: Choice) -> None:
    """Write the bounds of what is left into the header, if it has some."""
    header = root.find("header")
    if header is None or header.get("north") is None:
        return
    places = [
        (stretch.road, s)
        for stretch in choice.stretches
        for s in np.linspace(stretch.begin, stretch.end, 2 + int((stretch.end - stretch.begin) / STUB)).tolist()
    ]
    x, y, _ = pose(file, np.array([road for road, _ in places], np.int64), np.array([s for _, s in places]))
    for name, value in (("north", y.max()), ("south", y.min()), ("east", x.max()), ("west", x.min())):
        if np.isfinite(value):
            put(header, name, round(float(value), 3))


def cut_road(element: Element, file: OpenDrive, stretch: Stretch) -> int:
    """Cut a road to a stretch, whose s counts from its begin; returns how many signals and objects were left out."""
    begin, end = stretch.begin, stretch.end
    length = float(file.roads.length[stretch.road])
    if stretch.has_start and stretch.has_end:
        return 0
    put(element, "length", end - begin)
    _cut_plan_view(element, file, stretch)
    for path in ("elevationProfile/elevation", "lateralProfile/superelevation", "lanes/laneOffset"):
        cut_records(element.findall(path), begin, end, cubic=True)
    sides = {item.get("side") for item in element.findall("lateralProfile/crossfall")}
    for side in sorted(sides, key=str):
        rows = [item for item in element.findall("lateralProfile/crossfall") if item.get("side") == side]
        cut_records(rows, begin, end, cubic=True)
    for path in ("type", "lateralProfile/shape"):
        cut_records(element.findall(path), begin, end)
    _cut_sections(element, length, begin, end)
    for surface in element.findall("surface/CRG"):
        low, high = max(number(surface, "sStart"), begin), min(number(surface, "sEnd"), end)
        if high - low < AT_ONE:
            remove(surface)
            continue
        put(surface, "sStart", low - begin)
        put(surface, "sEnd", high - begin)
    _cut_unmeasured(element, begin, end)
    return _cut_furniture(element, stretch)


def _cut_plan_view(element: Element, file: OpenDrive, stretch: Stretch) -> None:
    """Cut lines, arcs and spirals; other records lie inside the stretch or outside of it as wholes."""
    records = sorted(element.findall("planView/geometry"), key=lambda item: number(item, "s"))
    starts = [number(item, "s") for item in records]
    ends = [*starts[1:], float(file.roads.length[stretch.road])][: len(starts)]
    for item, low, high in zip(records, starts, ends, strict=True):
        if high <= stretch.begin + AT_ONE or low >= stretch.end - AT_ONE:
            remove(item)
            continue
        first, last = max(low, stretch.begin), min(high, stretch.end)
        if first > low + AT_ONE:
            at = pose(file, np.array([stretch.road]), np.array([first], np.float64))
            for name, values in zip(("x", "y", "hdg"), at, strict=True):
                put(item, name, float(values[0]))
        spiral = item.find("spiral")
        if spiral is not None:
            one, other = number(spiral, "curvStart"), number(spiral, "curvEnd")
            rate = (other - one) / number(item, "length", 1.0)
            put(spiral, "curvStart", one + rate * (first - low))
            put(spiral, "curvEnd", one + rate * (last - low) if last < high - AT_ONE else other)
        put(item, "s", first - stretch.begin if first > stretch.begin + AT_ONE else 0.0)
        if first > low + AT_ONE or last < high - AT_ONE:
            put(item, "length", last - first)


def _cut_sections(element: Element, length: float, begin: float, end: float) -> None:
    """Cut lane sections, and what lies along their lanes."""
    sections = lane_sections(element)
    starts = [number(item, "s") for item in sections]
    # What stands before the first section is part of it.
    starts[:1] = [min(starts[0], begin)] if starts else []
    for section, low, high in zip(sections, starts, [*starts[1:], length], strict=False):
        if high <= begin + AT_ONE or low >= end - AT_ONE:
            remove(section)
            continue
        first, last = max(low, begin), min(high, end)
        put(section, "s", first - begin if first > begin + AT_ONE else 0.0)
        for lane in section.findall("*/lane"):
            for tag in (*_LANE_CUBICS, *_LANE_RECORDS):
                rows = lane.findall(tag)
                cut_records(rows, first - low, last - low, key="sOffset", cubic=tag in _LANE_CUBICS)


def _cut_unmeasured(element: Element, begin: float, end: float) -> None:
    """Cut the stretches without measured heights, as this program writes them."""
    for item in element.findall("userData"):
        if item.get("code") != UNMEASURED_HEIGHTS:
            continue
        try:
            ends = [float(word) for word in item.get("value", "").split()]
        except ValueError:
            continue
        pairs = [(max(low, begin), min(high, end)) for low, high in zip(ends[::2], ends[1::2], strict=False)]
        kept = [
            f"{round(s - begin, 7) + 0.0:.12g}" for low, high in pairs if high - low > AT_ONE for s in (low, high)
        ]
        item.set("value", " ".join(kept))
        if not kept:
            remove(item)


def _cut_furniture(element: Element, stretch: Stretch) -> int:
    """Keep the signals and objects on a stretch, and return how many others there were."""
    lost = 0
    for item in [*element.findall("objects/*"), *element.findall("signals/*")]:
        if item.get("s") is None:
            continue
        if item.tag in ("bridge", "tunnel"):
            if not clip(item, stretch.begin, stretch.end):
                remove(item)
            continue
        s = number(item, "s")
        if s < stretch.begin or (s >= stretch.end and not stretch.has_end):
            remove(item)
            lost += 1
            continue
        put(item, "s", s - stretch.begin)
        for corner in item.iter("cornerRoad"):
            put(corner, "s", number(corner, "s") - stretch.begin)
        for repeat in item.findall("repeat"):
            if not clip(repeat, stretch.begin, stretch.end):
                remove(repeat)
    return lost


@record
class Stretch:
    """A part of a road that is kept, from s to s, m."""

    road: int
    begin: float
    end: float
    # Whether it has the begin and the end of the road
    has_start: bool
    has_end: bool


@record
class Choice:
    """What is kept: stretches of roads, in the order of the file, and junctions."""

    stretches: tuple[Stretch, ...]
    junctions: frozenset[int]


def choose_inside(file: OpenDrive, inside: Inside) -> Choice:
    """Choose what lies inside an area.

    A junction is inside if the middle of its connecting roads is; these and the ends of its arms go with it. Other
    places of roads are decided by their reference line, in stretches of about `CELL`, so that areas side by side have
    everything exactly once.
    """
    kept = _junctions_inside(file, inside)
    whole = _whole_roads(file)
    stretches: list[Stretch] = []
    for road in range(len(file.roads.id)):
        length = float(file.roads.length[road])
        if not length > 0:
            continue
        if whole[road] != ABSENT:
            if kept[whole[road]]:
                stretches.append(Stretch(road, 0.0, length, True, True))
            continue
        stretches += _stretches_inside(file, road, inside, kept)
    return Choice(tuple(stretches), frozenset(np.flatnonzero(kept).tolist()))


def choose_roads(file: OpenDrive, names: frozenset[str]) -> Choice:
    """Choose roads by id, each as a whole, and the junctions of which they are all arms."""
    chosen = {k for k, name in enumerate(file.roads.id) if name in names}
    whole = _whole_roads(file)
    table = file.connections
    missing = {
        int(table.junction[k])
        for k in range(len(table.id))
        if table.incoming[k] != ABSENT and whole[table.incoming[k]] == ABSENT and int(table.incoming[k]) not in chosen
    }
    junctions = frozenset(range(len(file.junctions.id))) - missing - _without_arms(file)
    kept = [
        road
        for road in range(len(file.roads.id))
        if (whole[road] in junctions if whole[road] != ABSENT else road in chosen)
    ]
    length = file.roads.length
    stretches = tuple(Stretch(road, 0.0, float(length[road]), True, True) for road in kept if length[road] > 0)
    return Choice(stretches, junctions)


def _whole_roads(file: OpenDrive) -> IntArray:
    """Return the junction that each road is never parted from, (roads,); `ABSENT` for roads that may be cut."""
    return np.where(file.roads.junction >= 0, file.roads.junction, ABSENT)


def _without_arms(file: OpenDrive) -> frozenset[int]:
    """Return junctions without a connection."""
    return frozenset(np.flatnonzero(np.diff(file.junctions.start) == 0).tolist())


def _junctions_inside(file: OpenDrive, inside: Inside) -> BoolArray:
    """Return which junctions are inside, (junctions,): those whose roads have their middle there."""
    roads = file.roads
    count = len(file.junctions.id)
    member = np.flatnonzero((roads.junction >= 0) & (roads.length > 0))
    owner = roads.junction[member]
    # Direct junctions have no roads of their own: their arms count.
    bare = ~np.isin(np.arange(count), owner)
    table = file.connections
    arms = np.flatnonzero((table.incoming != ABSENT) & bare[table.junction])
    x, y, _ = pose(file, member, 0.5 * roads.length[member])
    at = _ends_at(file, table.incoming[arms], table.junction[arms])
    arm_x, arm_y, _ = pose(file, table.incoming[arms], at)
    owner = np.concatenate([owner, table.junction[arms]])
    x, y = np.concatenate([x, arm_x]), np.concatenate([y, arm_y])
    good = np.isfinite(x + y)
    number = np.bincount(owner[good], minlength=count)
    sums = [np.bincount(owner[good], values[good], minlength=count) for values in (x, y)]
    has = number > 0
    out = np.zeros(count, np.bool_)
    out[has] = inside(*(total[has] / number[has] for total in sums))
    return out


def _ends_at(file: OpenDrive, road: IntArray, junction: IntArray) -> FloatArray:
    """Return s of the end of roads at which junctions lie, (n,)."""
    roads = file.roads
    at_end = (roads.link_kind[road, 1] == LinkKind.JUNCTION) & (roads.link[road, 1] == junction)
    return np.where(at_end, roads.length[road], 0.0)


def _stretches_inside(file: OpenDrive, road: int, inside: Inside, kept: BoolArray) -> list[Stretch]:
    """Return the stretches of a road that are inside, along s."""
    length = float(file.roads.length[road])
    cuts = _cells(file, road)
    middle = 0.5 * (cuts[1:] + cuts[:-1])
    x, y, _ = pose(file, np.full(len(middle), road), middle)
    in_cell = np.zeros(len(middle), np.bool_)
    known = np.isfinite(x + y)
    in_cell[known] = inside(x[known], y[known])
    for end, off in ((0, middle), (1, length - middle)):
        near = (off < STUB) & (off <= length / 2)
        junction = int(file.roads.link[road, end])
        if file.roads.link_kind[road, end] == LinkKind.JUNCTION and junction != ABSENT:
            in_cell[near] = kept[junction]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], in_cell, [False]]).astype(np.int8)))
    return [
        Stretch(road, float(cuts[first]), float(cuts[last]), first == 0, last == len(middle))
        for first, last in edges.reshape(-1, 2).tolist()
    ]


def _cells(file: OpenDrive, road: int) -> FloatArray:
    """Return where a road may be cut, with its ends; polynomials of plan views are not cut."""
    length = float(file.roads.length[road])
    # Two at least where the junctions of both ends may be parted.
    fewest = 1 + bool((file.roads.link_kind[road] == LinkKind.JUNCTION).all())
    cuts = np.linspace(0.0, length, max(fewest, round(length / CELL)) + 1)
    plan = file.plan_view
    free = np.ones(len(cuts), np.bool_)
    more = []
    for k in range(int(plan.start[road]), int(plan.start[road + 1])):
        if plan.shape[k] in (Shape.POLY3, Shape.PARAM_POLY3):
            begin, end = float(plan.s[k]), float(plan.s[k] + plan.length[k])
            free &= (cuts <= begin - CELL / 2) | (cuts >= end + CELL / 2)
            more += [begin, end]
    inner = [s for s in more if CELL / 2 < s < length - CELL / 2]
    found = np.unique(np.concatenate([cuts[free], inner, [0.0, length]]))
    # Records that are shorter than a cell are not parted from the one before.
    wide = np.concatenate([[True], np.diff(found) > min(CELL / 4, length / 3)])
    wide[-1] = True
    return np.asarray(found[wide], np.float64)
