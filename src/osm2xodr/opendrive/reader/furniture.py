"""Signals and objects on and beside roads."""

from __future__ import annotations

from collections.abc import Iterator
from sys import intern
from typing import Final

from osm2xodr.opendrive.reader.elements import Node
from osm2xodr.opendrive.reader.values import NAN, Values
from osm2xodr.opendrive.tables import Furniture

_KINDS: Final = {
    "signals": frozenset({"signal", "signalReference"}),
    "objects": frozenset({"object", "objectReference", "bridge", "tunnel"}),
}
# Elements without a t of their own.
_ALONG: Final = frozenset({"bridge", "tunnel"})
_UNREAD: Final = frozenset({
    "material", "parkingSpace", "markings", "borders", "surface", "skeleton", "dependency", "reference",
    "positionRoad", "positionInertial", "board", "staticBoard", "vmsBoard", "semantics", "vmsGroup", "laneValidity",
})  # fmt: skip
_CORNERS: Final = {"cornerRoad": ("s", "t", "dz", "height"), "cornerLocal": ("u", "v", "z", "height")}
_REPEAT: Final = ("s", "length", "distance", "tStart", "tEnd")

# The corners of an outline, and whether they are local.
_Outline = tuple[tuple[tuple[float, float, float, float], ...], bool]


def read_furniture(values: Values, node: Node) -> Iterator[Furniture]:
    """Yield the furniture in ``<signals>`` or ``<objects>`` of the current road."""
    for child in node.children:
        if child.tag in _KINDS[node.tag]:
            yield _item(values, child)
        else:
            values.check_known(child, node, frozenset({"vmsGroup"}))


def _item(values: Values, node: Node) -> Furniture:
    """Read a signal, an object or a reference to one."""
    old: list[_Outline] = []
    outlines: list[_Outline] = []
    validity: list[tuple[int, int]] = []
    repeats: list[tuple[float, float, float, float, float, float]] = []
    for child in node.children:
        if child.tag == "outline":
            old += _outline(values, child)
        elif child.tag == "outlines":
            outlines += _outlines(values, child)
        elif child.tag == "validity":
            ends = values.lane_id(child, "fromLane"), values.lane_id(child, "toLane")
            validity.append(ends[::-1] if values.negated else ends)
        elif child.tag == "repeat":
            s, length, distance, start, end = values.row(child, _REPEAT)
            repeats.append((s, length, distance, start, end, values.optional(child, "widthStart", NAN)))
        else:
            values.check_known(child, node, _UNREAD)
    along, used = node.tag in _ALONG, outlines or old
    heading = "hOffset" if node.tag.startswith("signal") else "hdg"
    return Furniture(
        kind=node.tag,
        road=node.road,
        attributes={name: intern(text) for name, text in node.attributes.items()},
        s=values.number(node, "s"),
        t=NAN if along else values.number(node, "t"),
        z_offset=values.optional(node, "zOffset", NAN),
        hdg=values.optional(node, heading, NAN),
        length=values.number(node, "length") if along else values.optional(node, "length", NAN),
        width=values.optional(node, "width", NAN),
        height=values.optional(node, "height", NAN),
        outlines=tuple(corners for corners, _ in used),
        local_outlines=tuple(local for _, local in used),
        validity=tuple(validity),
        line=node.line,
        old_outline=old[0][0] if old else (),
        radius=values.optional(node, "radius", NAN),
        repeats=tuple(repeats),
    )


def _outlines(values: Values, node: Node) -> Iterator[_Outline]:
    """Read ``<outlines>``."""
    for outline in node.children:
        if outline.tag == "outline":
            yield from _outline(values, outline)
        else:
            values.check_known(outline, node)


def _outline(values: Values, node: Node) -> Iterator[_Outline]:
    """Read an ``<outline>``; of corners of both kinds only those of the first one's kind are used."""
    corners: list[tuple[float, float, float, float]] = []
    kind = ""
    for child in node.children:
        if child.tag not in _CORNERS:
            values.check_known(child, node)
        elif kind in ("", child.tag):
            kind = child.tag
            a, b, c, d = _CORNERS[kind]
            # Files of version 1.4 may have no height; only the place is needed.
            place = (values.number(child, a), values.number(child, b), values.optional(child, c, 0.0))
            corners.append((*place, values.optional(child, d, 0.0)))
        else:
            text = f"<outline> has corners of two kinds; <{child.tag}> is left out"
            values.report("misplaced-element", child, text)
    if corners:
        yield tuple(corners), kind == "cornerLocal"
    else:
        values.report("missing-element", node, "<outline> has no corner")
