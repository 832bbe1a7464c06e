"""Documents of OpenDRIVE as trees that keep what they do not understand, and what cropping and merging do to these.

References between elements, after some of these are gone; records along s, cut to a stretch: what held before it
begins holds from its begin. Lengths in m.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

from lxml import etree

from osm2xodr.errors import InputError
from osm2xodr.system import ByteSink, xml_stream

# Roads are cut between stretches of about this length, each of which is inside or outside as a whole: the cut lies
# within half of it from the border. A choice: what is left is never shorter, and readers take 1 m for a road.
CELL: Final = 2.0
# How far the ends of roads at a junction belong to it: what lies nearer stays with the junction, so that its arms
# have something to stand on. A choice, the length of a car.
STUB: Final = 5.0
# Ends of roads of different files meet if they, and the corners of their lanes, are nearer than this: ten times what
# coordinates in files are rounded to by most writers.
MEET_DISTANCE: Final = 0.01
# And if one road goes on within this angle, rad (half a degree): a kink that `check` does not count as one.
MEET_TURN: Final = 0.0087

# The id of the road that has an end of a road now; by its former id and the contact point there.
RoadEnds = Mapping[tuple[str, str], str]
_ENDS = (("predecessor", "start"), ("successor", "end"))

# Elements of lxml: its types are not needed at run time.
Element = Any

# Places closer together than this are one, m.
AT_ONE: Final = 1e-7


def read_tree(path: Path) -> Element:
    """Return the root of a file that was read before, plain or packed by gzip, as it is."""
    try:
        parser = etree.XMLParser(huge_tree=True, resolve_entities=False, no_network=True, remove_blank_text=True)
        with path.open("rb") as stream:
            # The address is one that is always UTF-8, which names of files need not be.
            root = etree.parse(xml_stream(stream), parser, base_url="").getroot()
    except (OSError, EOFError, etree.XMLSyntaxError) as error:
        raise InputError(f"cannot read {path}: {error}; give a file of OpenDRIVE") from error
    if "}" in root.tag:
        raise InputError(f"{path} has a namespace, which OpenDRIVE does not have; remove it")
    return root


def write_tree(root: Element, stream: ByteSink) -> None:
    """Write a document with one element per line."""
    tree = root.getroottree()
    etree.indent(tree, " ")
    stream.write(etree.tostring(tree, xml_declaration=True, encoding="UTF-8"))
    stream.write(b"\n")


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


def number(element: Element, name: str, default: float = 0.0) -> float:
    """Return an attribute as a number; a default where it is missing or unreadable."""
    try:
        return float(element.get(name, default))
    except ValueError:
        return default


def put(element: Element, name: str, value: float) -> None:
    """Write a number into an attribute, to a billionth."""
    element.set(name, f"{round(value, 12) + 0.0:.15g}")


def remove(element: Element) -> None:
    """Remove an element from the document; the white space behind it goes as well."""
    parent = element.getparent()
    if parent is not None:
        parent.remove(element)


def lane_sections(road: Element) -> list[Element]:
    """Return the lane sections of a road, along s."""
    return sorted(road.findall("lanes/laneSection"), key=lambda item: number(item, "s"))


def cut_records(
    elements: Iterable[Element], begin: float, end: float, *, key: str = "s", cubic: bool = False
) -> None:
    """Cut records to a stretch, and let s count from its begin.

    Of several records at one s all are kept, but for cubics, of which the last one holds.
    """
    records = sorted(elements, key=lambda item: number(item, key))
    before = [number(item, key) for item in records if number(item, key) <= begin + AT_ONE]
    base = max(before, default=None)
    holding = [item for item in records if base is not None and number(item, key) == base]
    for k, item in enumerate(records):
        s = number(item, key)
        is_base = item in holding
        over = base is not None and s < base
        beyond = s >= end - AT_ONE and not is_base
        if over or beyond or (cubic and is_base and item is not holding[-1]):
            remove(item)
        elif is_base and begin - s > 0:
            if cubic:
                _begin_later(item, begin - s)
            put(item, key, 0.0)
        elif begin > 0 or k:
            put(item, key, s - begin if abs(s - begin) > AT_ONE else 0.0)


def _begin_later(item: Element, by: float) -> None:
    """Let a cubic a + b ds + c ds² + d ds³ begin later, by its Taylor series about the new begin."""
    a, b, c, d = (number(item, name) for name in "abcd")
    put(item, "a", a + by * (b + by * (c + by * d)))
    put(item, "b", b + by * (2 * c + 3 * by * d))
    put(item, "c", c + 3 * by * d)


def clip(element: Element, begin: float, end: float, *, s: str = "s", length: str = "length") -> bool:
    """Cut something that lies along s to a stretch, and let s count from its begin; False where nothing is left."""
    low = number(element, s)
    high = low + number(element, length)
    if (
        high < begin - AT_ONE
        or low > end + AT_ONE
        or (high - low > AT_ONE and min(high, end) - max(low, begin) < AT_ONE)
    ):
        return False
    put(element, s, max(low, begin) - begin)
    if element.get(length) is not None and (low < begin or high > end):
        put(element, length, min(high, end) - max(low, begin))
    return True
