"""A road cut to a stretch of it."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.defaults import UNMEASURED_HEIGHTS
from osm2xodr.opendrive import OpenDrive, pose
from osm2xodr.parts.choice import Stretch
from osm2xodr.parts.records import AT_ONE, Element, clip, cut_records, lane_sections, number, put, remove

_LANE_CUBICS: Final = ("width", "border")
_LANE_RECORDS: Final = ("roadMark", "material", "visibility", "speed", "access", "height", "rule")


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
            at = pose(file, np.array([stretch.road]), np.array([first]))
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
