"""As much of the Overpass API's query language as `osm2xodr.fetching.overpass` uses, for a map in memory.

Statements are as the OSM wiki has them (Overpass API/Overpass QL): sets, unions, differences, filters by tags, by a
box and by membership, and output as ``meta``, ``skel`` and ``count``. Anything else is an error.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

Key = tuple[str, int]  # Kind and id
Keys = frozenset[Key]
Box = tuple[float, float, float, float]  # West, south, east, north, degrees

_NUMBER: Final = r"(-?\d+(?:\.\d+)?)"
_BOX: Final = re.compile(rf"\({_NUMBER},{_NUMBER},{_NUMBER},{_NUMBER}\)")
_TAG: Final = re.compile(r'\["([^"]+)"(?:(=|~)"([^"]+)")?\]')
_MEMBERS: Final = re.compile(r"\((w|r|bn|bw)\.(\w+)\)")
_SETTINGS: Final = re.compile(r"(\[(out:xml|timeout:\d+|maxsize:\d+)\])+;")
_KINDS: Final = {"node": "node", "way": "way", "rel": "relation"}


class MapData:
    """The elements of a map in XML."""

    def __init__(self, path: Path) -> None:
        root = ElementTree.parse(path).getroot()
        self.items = {(item.tag, int(item.get("id", ""))): item for item in root if item.tag in _KINDS.values()}
        for item in self.items.values():
            item.attrib.setdefault("version", "1")
        self.tags = {
            key: {tag.get("k", ""): tag.get("v", "") for tag in item.iter("tag")} for key, item in self.items.items()
        }
        self.members = {key: frozenset(_members(item)) for key, item in self.items.items()}
        self.places = {
            key: (float(item.get("lon", "")), float(item.get("lat", "")))
            for key, item in self.items.items()
            if item.tag == "node"
        }
        self.with_tag: dict[tuple[str, str], set[Key]] = defaultdict(set)
        self.parents: dict[Key, set[Key]] = defaultdict(set)
        for key in self.items:
            for name in self.tags[key]:
                self.with_tag[key[0], name].add(key)
            for member in self.members[key]:
                self.parents[member].add(key)

    def within(self, key: Key, box: Box) -> bool:
        """Whether an element or one of its members has a node in a box; segments between nodes do not count."""
        if key in self.places:
            lon, lat = self.places[key]
            return box[0] <= lon <= box[2] and box[1] <= lat <= box[3]
        return key in self.items and any(self.within(member, box) for member in self.members[key])

    def run(self, query: str) -> str:
        """Return what a query prints, without head and end."""
        return "".join(_Run(self, query).printed)


def box_of(query: str) -> Box:
    """Return the first box of a query."""
    found = _BOX.search(query)
    assert found is not None
    south, west, north, east = map(float, found.groups())
    return west, south, east, north


def _members(item: ElementTree.Element) -> Iterator[Key]:
    for part in item:
        if part.tag == "nd":
            yield "node", int(part.get("ref", ""))
        elif part.tag == "member":
            yield part.get("type", ""), int(part.get("ref", ""))


class _Run:
    """A query that is carried out."""

    def __init__(self, data: MapData, query: str) -> None:
        self.printed: list[str] = []
        self._data = data
        self._text = query
        self._at = 0
        self._sets: dict[str, Keys] = {}
        self._take(_SETTINGS.pattern)
        while self._at < len(query):
            self._statement()

    def _try(self, pattern: str | re.Pattern[str]) -> re.Match[str] | None:
        found = re.compile(pattern).match(self._text, self._at)
        if found is not None:
            self._at = found.end()
        return found

    def _take(self, pattern: str) -> re.Match[str]:
        found = self._try(pattern)
        assert found is not None, f"{pattern} is expected at {self._text[self._at : self._at + 60]}"
        return found

    def _statement(self) -> Keys:
        if found := self._try(r"(?:\.(\w+) )?out (meta|skel|count);"):
            self._print(self._sets[found[1] or "_"], found[2])
            return frozenset()
        if self._try(r"\("):
            out = self._block()
        elif found := self._try(r"\.(\w+)"):
            out = self._sets[found[1]]
        else:
            out = self._query(_KINDS[self._take(r"(node|way|rel)")[1]])
        target = self._try(r"->\.(\w+)")
        self._sets[target[1] if target else "_"] = out
        self._take(";")
        return out

    def _block(self) -> Keys:
        """Return a union, or a difference of two."""
        out = self._statement()
        if self._try("-"):
            out -= self._statement()
            self._take(r"\)")
            return out
        while not self._try(r"\)"):
            out |= self._statement()
        return out

    def _query(self, kind: str) -> Keys:
        data = self._data
        out: Keys | None = None
        while True:
            if found := self._try(_TAG):
                key, sign, value = found.groups()
                more = {
                    item
                    for item in data.with_tag[kind, key]
                    if sign is None
                    or (data.tags[item][key] == value if sign == "=" else re.search(value, data.tags[item][key]))
                }
            elif found := self._try(_MEMBERS):
                of = self._sets[found[2]]
                more = {"w": self._down("way", of), "r": self._down("relation", of)}.get(found[1]) or set()
                if found[1] in ("bn", "bw"):
                    below = "node" if found[1] == "bn" else "way"
                    more = {parent for item in of if item[0] == below for parent in data.parents[item]}
                more = {item for item in more if item[0] == kind and item in data.items}
            elif found := self._try(_BOX):
                south, west, north, east = map(float, found.groups())
                assert out is not None, "all elements of a box are never wanted"
                more = {item for item in out if data.within(item, (west, south, east, north))}
            else:
                assert out is not None
                return out
            out = frozenset(more) if out is None else out & more

    def _down(self, kind: str, of: Keys) -> set[Key]:
        return {member for item in of if item[0] == kind for member in self._data.members[item]}

    def _print(self, found: Keys, how: str) -> None:
        if how == "count":
            self.printed.append(f'<count id="0"><tag k="total" v="{len(found)}"/></count>')
            return
        order = {"node": 0, "way": 1, "relation": 2}
        for key in sorted(found, key=lambda item: (order[item[0]], item[1])):
            item = self._data.items[key]
            self.printed.append(ElementTree.tostring(item if how == "meta" else _bare(item), "unicode"))


def _bare(item: ElementTree.Element) -> ElementTree.Element:
    """Return what ``skel`` prints: geometry alone."""
    out = ElementTree.Element(item.tag, {key: item.attrib[key] for key in ("id", "lat", "lon") if key in item.attrib})
    for part in item:
        if part.tag != "tag":
            ElementTree.SubElement(
                out, part.tag, {key: part.attrib[key] for key in ("type", "ref") if key in part.attrib}
            )
    return out
