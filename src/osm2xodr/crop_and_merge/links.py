"""References between elements, after some of these are gone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

from osm2xodr.crop_and_merge.records import Element, lane_sections, remove

# The id of the road that has an end of a road now; by its former id and the contact point there.
RoadEnds = Mapping[tuple[str, str], str]
_ENDS = (("predecessor", "start"), ("successor", "end"))


def mend_road(road: Element, former: str, ends: RoadEnds, junctions: frozenset[str]) -> None:
    """Mend the links of a road, and drop those that lead to nothing, with those of its lanes there."""
    name = road.get("id")
    sections = lane_sections(road)
    for tag, end in _ENDS:
        link = road.find(f"link/{tag}")
        good = ends.get((former, end)) == name and link is not None and _mend(link, ends, junctions)
        if good:
            continue
        if link is not None:
            remove(link)
        for lane in sections[0 if end == "start" else -1].findall("*/lane") if sections else []:
            for item in lane.findall(f"link/{tag}"):
                remove(item)
    for item in road.findall("link/neighbor"):
        remove(item)


def _mend(link: Element, ends: RoadEnds, junctions: frozenset[str]) -> bool:
    """Let a link lead to what its target is now; False where that is gone."""
    if link.get("elementType") == "junction":
        return link.get("elementId") in junctions
    contact = link.get("contactPoint")
    found = ends.get((link.get("elementId"), contact if contact in ("start", "end") else "start"))
    if found is None:
        return False
    link.set("elementId", found)
    return True


def mend_junction(junction: Element, roads: Mapping[str, str], arms: RoadEnds, ends: RoadEnds) -> int:
    """Mend the connections and the boundary of a junction and return how many connections were dropped.

    `roads` are the new ids of whole roads by their former ones, `arms` of incoming roads, whose contact is ``""``. A
    boundary that would not be closed is dropped.
    """
    lost = 0
    for connection in junction.findall("connection"):
        good = True
        for name in ("connectingRoad", "linkedRoad"):
            old = connection.get(name)
            if old is not None:
                new = roads.get(old, arms.get((old, "")))
                good &= new is not None
                connection.set(name, new or old)
        old = connection.get("incomingRoad")
        if old is not None:
            new = arms.get((old, ""), roads.get(old))
            good &= new is not None
            connection.set("incomingRoad", new or old)
        if not good:
            remove(connection)
            lost += 1
    for priority in junction.findall("priority"):
        names = [priority.get(word) for word in ("high", "low")]
        if any(name is not None and name not in roads for name in names):
            remove(priority)
    for boundary in junction.findall("boundary"):
        if not all([_mend_segment(item, roads, ends) for item in boundary.findall("segment")]):
            remove(boundary)
    return lost


def _mend_segment(segment: Element, roads: Mapping[str, str], ends: RoadEnds) -> bool:
    """Let a segment of a boundary name what its road is now; False where that is gone or may be cut there."""
    old = segment.get("roadId")
    new = ends.get((old, segment.get("contactPoint")), roads.get(old))
    segment.set("roadId", new or old)
    return new is not None


def drop_dangling(root: Element) -> Counter[str]:
    """Drop what refers to signals, objects, controllers, junctions and roads that are gone; count it by kind."""
    lost: Counter[str] = Counter()
    signals, objects = _ids(root.iter("signal")), _ids(root.iter("object"))
    _drop(root, "road/signals/signalReference", "id", signals, lost, "reference to signals")
    _drop(root, "road/signals/signal/dependency", "id", signals, lost, "reference to signals")
    _drop(root, "road/objects/objectReference", "id", objects, lost, "reference to objects")
    for item in root.findall("road/signals/signal/reference"):
        if item.get("elementId") not in (signals if item.get("elementType") == "signal" else objects):
            remove(item)
            lost["reference of signals"] += 1
    _drop(root, "controller/control", "signalId", signals, Counter(), "")
    _drop_empty(root, "controller", "control", lost, "controller")
    _drop(root, "junction/controller", "id", _ids(root.findall("controller")), Counter(), "")
    junctions = _ids(root.findall("junction"))
    _drop(root, "junctionGroup/junctionReference", "junction", junctions, lost, "junction of groups")
    _drop_empty(root, "junctionGroup", "junctionReference", Counter(), "")
    _drop(root, "station/platform/segment", "roadId", _ids(root.findall("road")), lost, "segment of platforms")
    _drop_empty(root, "station/platform", "segment", Counter(), "")
    _drop_empty(root, "station", "platform", lost, "station")
    return lost


def _ids(elements: Iterable[Element]) -> set[str | None]:
    return {item.get("id") for item in elements}


def _drop(root: Element, path: str, name: str, known: set[str | None], lost: Counter[str], what: str) -> None:
    """Drop elements whose attribute names nothing that is known, and count them."""
    for item in root.findall(path):
        if item.get(name) not in known:
            remove(item)
            lost[what] += 1


def _drop_empty(root: Element, path: str, child: str, lost: Counter[str], what: str) -> None:
    """Drop elements that have lost all children of a kind, and count them."""
    for item in root.findall(path):
        if item.find(child) is None:
            remove(item)
            lost[what] += 1
