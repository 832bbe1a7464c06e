"""Road networks of one frame as one network."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Final

from lxml import etree

from osm2xodr.defaults import NEGATED_LANES
from osm2xodr.diagnostics import counted
from osm2xodr.errors import InputError
from osm2xodr.opendrive import OpenDrive, frame_of
from osm2xodr.parts.document import read_tree
from osm2xodr.parts.joints import RoadEnd, free_ends, insert_link, join_ends
from osm2xodr.parts.links import drop_dangling
from osm2xodr.parts.records import Element, number, put, remove
from osm2xodr.parts.renaming import Names

_NO_OFFSET: Final = (0.0, 0.0, 0.0, 0.0)
# The order of the root's elements: OpenDRIVE 1.7, section 5.1.
_ORDER: Final = ("header", "road", "controller", "junction", "junctionGroup", "station")
_BOUNDS: Final = {"north": max, "south": min, "east": max, "west": min}


def merge_networks(files: Sequence[OpenDrive]) -> tuple[Element, list[str]]:
    """Return the document of several files as one, and sentences about what was done.

    The ids of the first file stay; later ones are new where they are in use. Roads that an earlier file has with the
    same plan view and lanes are dropped. `InputError` if the files are not of one frame.
    """
    for file in files[1:]:
        _check_frame(files[0], file)
    roots = [read_tree(file.path) for file in files]
    names, known = Names(roots), dict[str, Element]()
    ends: list[RoadEnd] = []
    renamed = dropped = 0
    for k, (file, root) in enumerate(zip(files, roots, strict=True)):
        elements = root.findall("road")
        same = {element: known[text] for element in elements if (text := _signature(element)) in known}
        renamed += names.rename(root, _given(root, same))
        dropped += len(same)
        for element, earlier in same.items():
            _adopt_links(earlier, element)
        ends += [end for end in free_ends(file, elements, k) if end.element not in same]
        for element in elements:
            known.setdefault(_signature(element), element)
        _drop(root, same)
    linked, unclear = join_ends([end for end in ends if not _has_link(end)])
    merged = roots[0]
    for root in roots[1:]:
        _merge_header(merged, root)
        for item in root:
            if item.tag in _ORDER[1:]:
                _append(merged, item)
    return merged, _sentences(renamed, dropped, linked, unclear)


def _sentences(renamed: int, dropped: int, linked: int, unclear: int) -> list[str]:
    lines = [f"{linked} {'pair' if linked == 1 else 'pairs'} of ends of roads that meet: linked"]
    if renamed:
        lines.append(f"{counted(renamed, 'id')} in use before: given anew")
    if dropped:
        lines.append(f"{counted(dropped, 'road')} that an earlier file has: left out")
    if unclear:
        lines.append(f"{unclear} {'end' if unclear == 1 else 'ends'} of roads where several others meet: not linked")
    return lines


def _check_frame(first: OpenDrive, other: OpenDrive) -> None:
    """Raise `InputError` unless two files have the same projection, offset and kind of lane ids."""
    texts = [" ".join((file.header.geo_reference or "").split()) for file in (first, other)]
    if texts[0] != texts[1]:
        frames = [frame_of(file.header)[0] for file in (first, other)]
        if frames[0] is None or frames[1] is None or frames[0].crs != frames[1].crs:
            raise InputError(
                f"{first.path} and {other.path} have different geoReferences; convert both with --frame, or as areas "
                "of one batch --shared-frame"
            )
    if (first.header.offset or _NO_OFFSET) != (other.header.offset or _NO_OFFSET):
        raise InputError(f"{first.path} and {other.path} have different offsets in their headers; merge files of one")
    code, value = NEGATED_LANES
    if (first.provenance.get((-1, code)) == value) != (other.provenance.get((-1, code)) == value):
        raise InputError(f"{first.path} or {other.path} has negated lane ids for SUMO; convert both in the same way")


def _signature(element: Element) -> str:
    """Return what two files have in common of the same road: its plan view, and its lanes without their links."""
    lanes = element.find("lanes")
    bare = copy.deepcopy(lanes) if lanes is not None else element.makeelement("lanes", {})
    for link in bare.findall("laneSection/*/lane/link"):
        remove(link)
    parts = [element.find("planView"), element.find("elevationProfile"), bare]
    return "".join(etree.tostring(part, method="c14n").decode() for part in parts if part is not None)


def _given(root: Element, same: dict[Element, Element]) -> dict[str, dict[str, str]]:
    """Return the ids that roads and junctions have already in earlier files, by their ids in this one."""
    roads = {element.get("id"): earlier.get("id") for element, earlier in same.items()}
    members: dict[str, list[Element]] = {}
    for element in root.findall("road"):
        members.setdefault(element.get("junction", "-1"), []).append(element)
    junctions = {
        name: same[found[0]].get("junction")
        for name, found in members.items()
        if name != "-1" and all(element in same for element in found)
    }
    return {"road": roads, "junction": junctions}


def _adopt_links(road: Element, twin: Element) -> None:
    """Give a road the links that it lacks and that the same road has in another file."""
    sections = road.findall("lanes/laneSection"), twin.findall("lanes/laneSection")
    for tag, place in (("predecessor", 0), ("successor", -1)):
        found = twin.find(f"link/{tag}")
        if found is None or road.find(f"link/{tag}") is not None:
            continue
        insert_link(road, copy.deepcopy(found))
        for lane in sections[1][place].findall("*/lane"):
            own = sections[0][place].find(f"*/lane[@id='{lane.get('id')}']")
            for item in lane.findall(f"link/{tag}"):
                insert_link(own, copy.deepcopy(item))


def _drop(root: Element, same: dict[Element, Element]) -> None:
    """Drop the roads that earlier files have, the junctions of such roads alone, and what refers to them."""
    if not same:
        return
    gone = {element.get("junction", "-1") for element in same} - {"-1"}
    for element in same:
        remove(element)
    left = {element.get("junction") for element in root.findall("road")}
    for junction in root.findall("junction"):
        if junction.get("id") in gone - left:
            remove(junction)
    signals = {item.get("id") for item in root.iter("signal")}
    if any(control.get("signalId") not in signals for control in root.findall("controller/control")):
        drop_dangling(root)


def _has_link(end: RoadEnd) -> bool:
    """Return whether an end has got a link meanwhile."""
    return end.element.find("link/" + ("successor" if end.end else "predecessor")) is not None


def _merge_header(merged: Element, root: Element) -> None:
    """Let the header cover another document as well."""
    header, other = merged.find("header"), root.find("header")
    if header is None or other is None:
        return
    for name, choose in _BOUNDS.items():
        if header.get(name) is not None and other.get(name) is not None:
            put(header, name, choose(number(header, name), number(other, name)))
    known = {(item.get("code"), item.get("value")) for item in header.findall("userData")}
    # Who has to be named for the data, and the like.
    for item in other.findall("userData"):
        if (item.get("code"), item.get("value")) not in known:
            header.append(item)
    versions = [(number(item, "revMajor"), number(item, "revMinor")) for item in (header, other)]
    if versions[1] > versions[0]:
        for name in ("revMajor", "revMinor"):
            header.set(name, other.get(name, "0"))


def _append(merged: Element, item: Element) -> None:
    """Append an element behind the last one that may stand before it."""
    before = _ORDER[: _ORDER.index(item.tag) + 1]
    places = [k for k, child in enumerate(merged) if child.tag in before]
    merged.insert(places[-1] + 1 if places else 0, item)
