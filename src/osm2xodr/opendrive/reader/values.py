"""Attributes as numbers, and reports of what is wrong with them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from osm2xodr.opendrive.reader.nodes import Node
from osm2xodr.opendrive.tables import ABSENT, End, Misfit

NAN: Final = math.nan

# No length, coefficient or curvature of a road is as large as this; larger ones might overflow when multiplied.
_TOO_LARGE: Final = 1e12
_ENDS: Final = {"start": End.START, "end": End.END, "": End.UNSAID}
# m/s per unit; m/s is OpenDRIVE's default.
_UNITS: Final = {"m/s": 1.0, "km/h": 1 / 3.6, "mph": 0.44704}
# Elements that may stand anywhere.
_ANYWHERE: Final = frozenset({"userData", "include", "dataQuality"})
# Elements of which some readers take the last child for the content, whatever it is.
_NO_USER_DATA: Final = frozenset({"geometry", "elevationProfile"})


class Values:
    """Reads attributes and reports what it could not read in `misfits`.

    `road` is the index of the road that is being read, -1 outside roads; `negated` says whether the file has lane ids
    with the other sign than the standard wants.
    """

    def __init__(self, negated: bool = False) -> None:
        self.misfits: list[Misfit] = []
        self.road = -1
        self.negated = negated

    def extend(self, other: Values, first: int) -> None:
        """Add the reports of another part of the file, whose roads begin with the index `first`."""
        self.misfits.extend(replace(item, road=first + item.road if item.road >= 0 else -1) for item in other.misfits)

    def report(self, rule: str, node: Node, text: str) -> None:
        """Report something that is wrong with an element."""
        self.misfits.append(Misfit(rule, node.line, self.road, text))

    def row(self, node: Node, names: Sequence[str]) -> list[float]:
        """Return the numbers of several required attributes."""
        attributes = node.attributes
        try:
            values = [float(attributes[name]) for name in names]
        except (KeyError, ValueError):
            return [self.number(node, name) for name in names]
        # Numbers that are too large, and NaN, show in the sum.
        return values if sum(map(abs, values)) < _TOO_LARGE else [self.number(node, name) for name in names]

    def number(self, node: Node, name: str) -> float:
        """Return the number of a required attribute; NaN where it is missing or not a number."""
        self.text(node, name)
        return self.optional(node, name, NAN)

    def optional(self, node: Node, name: str, default: float) -> float:
        """Return the number of an attribute; a default where it is missing, NaN where it is not a number."""
        text = node.attributes.get(name)
        if text is None:
            return default
        try:
            value = float(text)
        except ValueError:
            value = NAN
        if not abs(value) < _TOO_LARGE:
            self.report("bad-number", node, f"{name}={text!r} of <{node.tag}> is not a usable number")
            return NAN
        return value

    def lane_id(self, node: Node, name: str = "id") -> int:
        """Return a lane id, with the other sign where ids are `negated`; `ABSENT` if missing or not an integer."""
        text = self.text(node, name)
        try:
            value = int(text)
        except ValueError:
            value = ABSENT
        if -(2**62) < value < 2**62:
            return -value if self.negated else value
        if name in node.attributes:
            self.report("bad-number", node, f"{name}={text!r} of <{node.tag}> is not a lane id")
        return ABSENT

    def text(self, node: Node, name: str) -> str:
        """Return a required attribute; empty where it is missing."""
        if name not in node.attributes:
            self.report("missing-attribute", node, f"<{node.tag}> has no attribute {name}")
        return node.get(name)

    def contact(self, node: Node) -> int:
        """Return the `End` that ``contactPoint`` names."""
        text = node.get("contactPoint")
        if text not in _ENDS:
            self.report("bad-value", node, f"contactPoint={text!r} of <{node.tag}> is neither start nor end")
        return _ENDS.get(text, End.UNSAID)

    def speed(self, node: Node) -> float:
        """Return the speed limit of a ``<speed>``, m/s; infinity for no limit, NaN where it is unknown."""
        text, unit = self.text(node, "max"), node.get("unit")
        if text == "no limit":
            return math.inf
        if text in ("undefined", ""):
            return NAN
        if unit and unit not in _UNITS:
            self.report("bad-value", node, f"unit={unit!r} of <speed> is not one of {', '.join(_UNITS)}")
            return NAN
        return self.optional(node, "max", NAN) * _UNITS.get(unit, 1.0)

    def check_known(self, node: Node, parent: Node, known: frozenset[str] = frozenset()) -> None:
        """Report an element that is not read, unless it is one of the `known` children of its parent."""
        tag = node.tag
        if tag in known:
            return
        if tag == "include":
            self.report("include", node, f"<include> of {node.get('file')!r} is not followed: its content is missing")
        elif tag == "userData" and parent.tag in _NO_USER_DATA:
            self.report("misplaced-user-data", node, f"<userData> stands in <{parent.tag}>, which misleads readers")
        elif tag not in _ANYWHERE:
            self.report("unknown-element", node, f"<{tag}> does not belong in <{parent.tag}>")

    def first_only(self, node: Node, parent: Node, found: Node | None) -> Node:
        """Return the first of elements of which there may be only one; report a further one."""
        if found is None:
            return node
        self.report("repeated-element", node, f"<{parent.tag}> has more than one <{node.tag}>; the first is used")
        return found
