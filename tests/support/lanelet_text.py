"""Maps of Lanelet2 as they were written."""

from __future__ import annotations

import io
from dataclasses import dataclass

from lxml import etree

from osm2xodr.exporting.lanelet2 import write_lanelet2
from osm2xodr.opendrive.tables import OpenDrive


@dataclass(frozen=True)
class Written:
    """A map: x, y, z of nodes, nodes of ways, members of relations (type, ref, role), tags, and what was left out."""

    nodes: dict[str, tuple[float, float, float]]
    ways: dict[str, list[str]]
    relations: dict[str, list[tuple[str, str, str]]]
    tags: dict[str, dict[str, str]]
    lost: list[str]

    def lanelet(self, road: str, lane: str) -> str:
        """Return the only lanelet of a lane."""
        (found,) = (
            number
            for number in self.relations
            if (self.tags[number].get("xodr:road"), self.tags[number].get("xodr:lane")) == (road, lane)
        )
        return found

    def bound(self, lanelet: str, side: str) -> str:
        """Return the way that is a bound of a lanelet."""
        return self.members(lanelet, side)[0]

    def members(self, relation: str, role: str) -> list[str]:
        """Return the members of a relation by role."""
        return [ref for _, ref, name in self.relations[relation] if name == role]

    def points(self, way: str) -> list[tuple[float, float, float]]:
        """Return the places of a way, to 1 mm."""
        return [tuple(round(value, 3) + 0.0 for value in self.nodes[node]) for node in self.ways[way]]  # type: ignore[misc]

    def rules(self, subtype: str) -> list[str]:
        """Return the regulatory elements of a kind."""
        wanted = ("regulatory_element", subtype)
        return [one for one in self.relations if (self.tags[one]["type"], self.tags[one]["subtype"]) == wanted]


def written(file: OpenDrive, projector: str = "local") -> Written:
    """Write a map and read its text."""
    stream = io.BytesIO()
    _, lost = write_lanelet2(file, stream, 0.05, 10.0, "1", projector)
    root = etree.fromstring(stream.getvalue())
    tags = {
        str(item.get("id")): {str(tag.get("k")): str(tag.get("v")) for tag in item.iterfind("tag")}
        for item in root
        if item.get("id")
    }
    keys = ("local_x", "local_y", "ele")
    return Written(
        {str(item.get("id")): _place(tags[str(item.get("id"))], keys) for item in root.iterfind("node")},
        {str(way.get("id")): [str(nd.get("ref")) for nd in way.iterfind("nd")] for way in root.iterfind("way")},
        {
            str(one.get("id")): [
                (str(m.get("type")), str(m.get("ref")), str(m.get("role"))) for m in one.iterfind("member")
            ]
            for one in root.iterfind("relation")
        },
        tags,
        lost,
    )


def _place(tags: dict[str, str], keys: tuple[str, str, str]) -> tuple[float, float, float]:
    x, y, z = (float(tags[key]) for key in keys)
    return x, y, z
