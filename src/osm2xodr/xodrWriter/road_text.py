"""Roads and junctions as XML; the numbers of their tables, lanes and furniture come from elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

from osm2xodr.model import Junction, Road, RoadLink, RoadType
from osm2xodr.xodrWriter.formatting import attribute, position, road_speed_attributes
from osm2xodr.xodrWriter.furniture_text import FurnitureWriter, provenance_text
from osm2xodr.xodrWriter.lane_text import LaneWriter
from osm2xodr.xodrWriter.words import Words


@dataclass(frozen=True, slots=True)
class RoadTables:
    """The records of one road in the tables of a road map, as text."""

    length: float  # m
    # Only the last two may be empty
    geometry: str
    elevation: str
    superelevation: str
    lane_offset: str


class RoadWriter:
    """Make the text of roads; `rule` is ``RHT`` or ``LHT``, None where the version has no such attribute."""

    def __init__(self, rule: str | None, words: Words, furniture: FurnitureWriter) -> None:
        self._furniture = furniture
        self._side = "" if rule is None else f' rule="{rule}"'
        self._words = words
        self._lanes = LaneWriter(words)
        self._types: dict[RoadType, str] = {}

    def road(self, road: Road, tables: RoadTables) -> str:
        """Return a ``<road>``, its parts in the order of the schema."""
        junction = -1 if road.junction is None else road.junction
        lateral = ""
        if tables.superelevation:
            lateral = f"  <lateralProfile>\n{tables.superelevation}  </lateralProfile>\n"
        return (
            f' <road name="{attribute(road.name)}" length="{position(tables.length)}" id="{road.id}"'
            f' junction="{junction}"{self._side}>\n'
            f"{_links(road)}"
            f"{''.join([self._types.get(item) or self._type(item) for item in road.types])}"
            f"  <planView>\n{tables.geometry}  </planView>\n"
            f"  <elevationProfile>\n{tables.elevation}  </elevationProfile>\n"
            f"{lateral}"
            f"  <lanes>\n{tables.lane_offset}"
            f"{self._lanes.sections(road.lane_sections, tables.length)}"
            "  </lanes>\n"
            f"{self._furniture.road(road.id, tables.length)}"
            f"{provenance_text(road.osm_way_ids, road.guesses)}"
            " </road>\n"
        )

    def _type(self, item: RoadType) -> str:
        """Return and remember a ``<type>`` with its speed limit."""
        text = f'  <type s="{position(item.s)}" type="{self._words.road_type(item.type)}"'
        if item.speed is None:
            text += "/>\n"
        else:
            text += f">\n   <speed {road_speed_attributes(item.speed)}/>\n  </type>\n"
        self._types[item] = text
        return text


def _links(road: Road) -> str:
    """Return the ``<link>`` of a road, which must exist even if empty: some readers use it unchecked."""
    if road.predecessor is None and road.successor is None:
        return "  <link/>\n"
    return f"  <link>\n{_link('predecessor', road.predecessor)}{_link('successor', road.successor)}  </link>\n"


def _link(element: str, link: RoadLink | None) -> str:
    """Return the link of one end of a road."""
    if link is None:
        return ""
    if link.to_junction:
        return f'   <{element} elementType="junction" elementId="{link.id}"/>\n'
    contact = "start" if link.at_start else "end"
    return f'   <{element} elementType="road" elementId="{link.id}" contactPoint="{contact}"/>\n'


def junction_text(junction: Junction, controllers: str = "") -> str:
    """Return a ``<junction>``: its connections, then priorities, then the text of its controllers."""
    connections = [
        f'  <connection id="{item.id}" incomingRoad="{item.incoming_road}"'
        f' connectingRoad="{item.connecting_road}" contactPoint="start">\n'
        + "".join([f'   <laneLink from="{a}" to="{b}"/>\n' for a, b in item.lane_links])
        + "  </connection>\n"
        for item in junction.connections
    ]
    priorities = [f'  <priority high="{high}" low="{low}"/>\n' for high, low in junction.priorities]
    return (
        f' <junction name="{attribute(junction.name)}" id="{junction.id}">\n'
        f"{''.join(connections)}{''.join(priorities)}{controllers}  </junction>\n"
    )
