"""A part of a road network as a network of its own.

Roads that lie in it in part are cut to a stretch.
"""

from __future__ import annotations

import copy
import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from osm2xodr.crop_and_merge.choice import Choice, Stretch
from osm2xodr.crop_and_merge.defaults import STUB
from osm2xodr.crop_and_merge.document import read_tree
from osm2xodr.crop_and_merge.links import drop_dangling, mend_junction, mend_road
from osm2xodr.crop_and_merge.records import AT_ONE, Element, clip, cut_records, lane_sections, number, put, remove
from osm2xodr.defaults import UNMEASURED_HEIGHTS
from osm2xodr.errors import EmptyAreaError
from osm2xodr.opendrive import ABSENT, LinkKind, OpenDrive, pose

_LANE_CUBICS: Final = ("width", "border")
_LANE_RECORDS: Final = ("roadMark", "material", "visibility", "speed", "access", "height", "rule")


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
