"""Ids of a document, given anew where another document has them already."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from osm2xodr.parts.records import Element

# What has ids of its own, by the path of its elements.
_KINDS: Final = {
    "road": "road",
    "junction": "junction",
    "controller": "controller",
    "signal": "road/signals/signal",
    "object": "road/objects/object",
    "bridge": "road/objects/bridge",
    "tunnel": "road/objects/tunnel",
    "junctionGroup": "junctionGroup",
    "station": "station",
}
# Attributes that name something of a kind; paths count from the root.
_REFERENCES: Final = {
    "road": (
        ("junction/connection", ("incomingRoad", "connectingRoad", "linkedRoad")),
        ("junction/priority", ("high", "low")),
        ("junction/boundary/segment", ("roadId",)),
        ("junction", ("mainRoad",)),
        ("junction/crossPath", ("crossingRoad", "roadAtStart", "roadAtEnd")),
        ("station/platform/segment", ("roadId",)),
        ("road/link/neighbor", ("elementId",)),
        (".//positionRoad", ("roadId",)),
    ),
    "junction": (("road", ("junction",)), ("junctionGroup/junctionReference", ("junction",))),
    "controller": (("junction/controller", ("id",)),),
    "signal": (
        ("road/signals/signalReference", ("id",)),
        ("road/signals/signal/dependency", ("id",)),
        ("controller/control", ("signalId",)),
    ),
    "object": (("road/objects/objectReference", ("id",)),),
}
# Attributes that name something of the kind that stands beside them.
_TYPED: Final = ("road/link/predecessor", "road/link/successor", "road/signals/signal/reference")


class Names:
    """The ids that are in use while documents are joined, one after another.

    Roads and junctions have different ones, as CARLA wants it.
    """

    def __init__(self, roots: Sequence[Element]) -> None:
        self._used: dict[str, set[str]] = {kind: set() for kind in _KINDS}
        self._used["junction"] = self._used["road"]
        names = {item.get("id", "") for root in roots for path in _KINDS.values() for item in root.findall(path)}
        # New ids are numbers above all others.
        self._fresh = max((int(name) for name in names if name.isascii() and name.isdigit()), default=0)

    def rename(self, root: Element, given: dict[str, dict[str, str]]) -> int:
        """Give new ids to what has one that is in use, and return to how many; then all of these are in use.

        `given` are new ids that are decided already, by kind and former id: of what the other documents have.
        """
        before = self._fresh
        for kind, path in _KINDS.items():
            new = dict(given.get(kind, {}))
            elements = root.findall(path)
            for item in elements:
                name = item.get("id", "")
                if name in self._used[kind] and name not in new:
                    self._fresh += 1
                    new[name] = str(self._fresh)
            for item in elements:
                item.set("id", new.get(item.get("id", ""), item.get("id", "")))
            _rename_references(root, kind, new)
        for kind, path in _KINDS.items():
            self._used[kind].update(item.get("id", "") for item in root.findall(path))
        return self._fresh - before


def _rename_references(root: Element, kind: str, new: dict[str, str]) -> None:
    """Let what names something of a kind name its new id."""
    if not new:
        return
    for path, attributes in _REFERENCES.get(kind, ()):
        for item in root.findall(path):
            for attribute in attributes:
                name = item.get(attribute)
                if name in new:
                    item.set(attribute, new[name])
    for path in _TYPED:
        for item in root.findall(path):
            if item.get("elementType") == kind and item.get("elementId") in new:
                item.set("elementId", new[item.get("elementId")])
