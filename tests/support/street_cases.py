"""Small street networks on a metre grid, built by hand, and what can be said about the roads made of them.

A case is drawn for right-hand traffic; `mirrored` turns it over the x axis, tags and all, for left-hand traffic.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.sax.saxutils import quoteattr

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import ElevationOptions, RoadOptions, build_roads
from osm2xodr.geometry.junctions.clusters import JunctionLayout, lay_out_junctions
from osm2xodr.geometry.junctions.movements import Movement, find_movements
from osm2xodr.geometry.plan_view.ends import StreetEnds, street_ends
from osm2xodr.geometry.plan_view.streets import fit_streets
from osm2xodr.model import RoadMap, Rule, StreetNetwork
from osm2xodr.osmParsing import ParseOptions, parse_osm
from osm2xodr.projection import make_frame, to_geographic
from osm2xodr.surface import FlatSurface

# In Germany, away from its borders.
_FRAME = make_frame(51.0, 10.0)
_SWAPPED = {"left": "right", "right": "left"}


@dataclass(frozen=True)
class Case:
    """A street network.

    Parameters
    ----------
    nodes
        x, y by name, m.
    ways
        By OSM id: names of the nodes, and ``key=value`` tags, both separated by spaces; a tertiary road unless the
        tags say otherwise.
    restrictions
        Value, from way, via (a node's name or way ids separated by spaces), to way.
    node_tags
        Tags by the node's name.
    connectivity
        Relations: from way, via as above, to way, value of ``connectivity``, lanes of the from way, of the to way.
    """

    nodes: Mapping[str, tuple[float, float]]
    ways: Mapping[int, tuple[str, str]]
    restrictions: tuple[tuple[str, int, str, int], ...] = ()
    node_tags: Mapping[str, str] = field(default_factory=dict)
    connectivity: tuple[tuple[int, str, int, str, int, int], ...] = ()

    def mirrored(self) -> Case:
        """Return the same place as left-hand traffic would have it."""
        return Case(
            {name: (x, -y) for name, (x, y) in self.nodes.items()},
            {number: (nodes, _mirrored_tags(tags)) for number, (nodes, tags) in self.ways.items()},
            tuple((_mirrored_words(value), one, via, other) for value, one, via, other in self.restrictions),
            {name: _mirrored_compass(tags) for name, tags in self.node_tags.items()},
            tuple(
                (one, via, other, _mirrored_connectivity(value, n, m), n, m)
                for one, via, other, value, n, m in self.connectivity
            ),
        )

    def osm(self) -> str:
        """Return the OSM file."""
        number = {name: 1001 + k for k, name in enumerate(self.nodes)}
        lon, lat = to_geographic(_FRAME, *zip(*self.nodes.values(), strict=True))
        lines = ['<osm version="0.6">']
        for name, x, y in zip(self.nodes, lon.tolist(), lat.tolist(), strict=True):
            tags = _tags(self.node_tags.get(name, ""))
            lines.append(f'<node id="{number[name]}" lat="{y:.7f}" lon="{x:.7f}">{tags}</node>')
        for way, (nodes, text) in self.ways.items():
            text = text if "highway=" in text else f"highway=tertiary {text}"
            refs = "".join(f'<nd ref="{number[name]}"/>' for name in nodes.split())
            lines.append(f'<way id="{way}">{refs}{_tags(text)}</way>')
        rules = [(f"restriction restriction={value}", one, via, to) for value, one, via, to in self.restrictions]
        rules += [
            (f"connectivity connectivity={value}", one, via, to) for one, via, to, value, *_ in self.connectivity
        ]
        for k, (tags, one, via, other) in enumerate(rules):
            members = [("way", one, "from"), ("way", other, "to")]
            if via in number:
                members.append(("node", number[via], "via"))
            else:
                members += [("way", int(way), "via") for way in via.split()]
            listed = "".join(f'<member type="{kind}" ref="{ref}" role="{role}"/>' for kind, ref, role in members)
            lines.append(f'<relation id="{9001 + k}">{listed}{_tags(f"type={tags}")}</relation>')
        return "\n".join([*lines, "</osm>"])

    def stages(self, rule: Rule = Rule.RIGHT_HAND) -> Stages:
        """Return what the stage makes on its way to roads."""
        return _stages(self.osm(), rule)

    def build(
        self,
        rule: Rule = Rule.RIGHT_HAND,
        *,
        turnarounds: bool = False,
        u_turns: str = "law",
        country: str = "",
        superelevation: str = "auto",
    ) -> RoadMap:
        """Convert it on flat ground, with the laws of a country."""
        return _built(self.osm(), rule, turnarounds, u_turns, country, superelevation)


@dataclass(frozen=True)
class Stages:
    """What there is before the roads: the network, its ends, its junctions, the ways through them."""

    network: StreetNetwork
    ends: StreetEnds
    layout: JunctionLayout
    movements: list[Movement]
    diagnostics: Diagnostics

    def way(self, end: int) -> int:
        """Return the OSM way of a street end."""
        street = self.network.streets[end // 2]
        return street.pieces[-1 if end % 2 else 0][1].osm_way_id

    def end(self, way: int, node: int) -> int:
        """Return the street end of a way at the node that was named as the given one (from 0)."""
        (found,) = (
            end
            for street in self.network.streets
            for end, osm_node in ((2 * street.id, street.node_ids[0]), (2 * street.id + 1, street.node_ids[-1]))
            if self.way(end) == way and osm_node == 1001 + node
        )
        return found


def _network(osm: str, rule: Rule, diagnostics: Diagnostics) -> StreetNetwork:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "case.osm"
        path.write_text(osm, encoding="utf-8")
        return parse_osm(path, ParseOptions(guessed_sidewalks=False, guessed_shoulders=False, rule=rule), diagnostics)


@cache
def _built(osm: str, rule: Rule, turnarounds: bool, u_turns: str, country: str, superelevation: str) -> RoadMap:
    diagnostics = Diagnostics()
    options = RoadOptions(turnarounds=turnarounds, u_turns=u_turns)
    network = _network(osm, rule, diagnostics)
    network = replace(network, country=country) if country else network
    heights = ElevationOptions(superelevation=superelevation)
    return build_roads(network, FlatSurface(), diagnostics, heights, road_options=options)


@cache
def _stages(osm: str, rule: Rule) -> Stages:
    diagnostics = Diagnostics()
    network = _network(osm, rule, diagnostics)
    fitted = fit_streets(network, diagnostics)
    ends = street_ends(network, fitted.plan_view, tuple((p[0][2], p[-1][2]) for p in fitted.pieces))
    layout = lay_out_junctions(network, ends, diagnostics)
    return Stages(network, ends, layout, find_movements(network, ends, layout, diagnostics), diagnostics)


def forget_cases() -> None:
    """Make cases anew from now on, as what they are made with has changed."""
    _built.cache_clear()
    _stages.cache_clear()


# Mutation tests change the code in copies of a process that has made cases already.
os.register_at_fork(after_in_child=forget_cases)


def _tags(text: str) -> str:
    pairs = (item.split("=", 1) for item in text.split())
    return "".join(f"<tag k={quoteattr(key)} v={quoteattr(value)}/>" for key, value in pairs)


def _mirrored_words(value: str) -> str:
    return "_".join(_SWAPPED.get(word, word) for word in value.split("_"))


def _mirrored_compass(tags: str) -> str:
    """Turn what faces north to face south."""
    return re.sub(r"\bdirection=(\d+)", lambda found: f"direction={(180 - int(found[1])) % 360}", tags)


def _mirrored_connectivity(value: str, lanes: int, lanes_after: int) -> str:
    """Count lanes from the other side; optional ones keep their brackets."""
    out = []
    for item in value.split("|"):
        lane, targets = item.split(":")
        turned = [re.sub(r"\d+", lambda found: str(lanes_after + 1 - int(found[0])), to) for to in targets.split(",")]
        out.append(f"{lanes + 1 - int(lane)}:{','.join(turned)}")
    return "|".join(out)


def _mirrored_tags(text: str) -> str:
    out = []
    for item in text.split():
        key, value = item.split("=", 1)
        if ":lanes" in key:
            from_right = reversed(value.split("|"))
            value = "|".join(";".join(map(_mirrored_words, lane.split(";"))) for lane in from_right)
        elif key.startswith("placement"):
            # Lanes of `placement` count from the left; it is used with one-ways only.
            side, number = value.split(":")
            count = int(dict(pair.split("=", 1) for pair in text.split())["lanes"])
            value = f"{_mirrored_words(side)}:{count + 1 - int(number)}"
        out.append(f"{key}={value}")
    return " ".join(out)


Link = tuple[int, int, int, int]
"""(from way, from lane, to way, to lane)."""


def written_links(text: str) -> set[Link]:
    """Read links written as ``1:-1>2:-1,3:-2``: from lane -1 of way 1 to lane -1 of way 2 and lane -2 of way 3."""
    found: set[Link] = set()
    for item in text.split():
        source, targets = item.split(">")
        way, _, lane = source.partition(":")
        for target in targets.split(","):
            to_way, _, to_lane = target.partition(":")
            link = (int(way), int(lane), int(to_way), int(to_lane))
            assert link not in found, f"{link} is written twice"
            found.add(link)
    return found


def mirrored_links(links: set[Link]) -> set[Link]:
    """Return the links of the mirrored case: lanes change sides, streets keep their direction."""
    return {(way, -lane, to_way, -to_lane) for way, lane, to_way, to_lane in links}


def built_links(roads: RoadMap) -> list[Link]:
    """Return the links through all junctions, sorted."""
    by_id = {road.id: road for road in roads.roads}
    found: list[Link] = []
    for junction in roads.junctions:
        for connection in junction.connections:
            path = by_id[connection.connecting_road]
            before, after = path.predecessor, path.successor
            assert before is not None
            assert after is not None
            assert before.id == connection.incoming_road
            assert path.junction == junction.id
            for lane, own in connection.lane_links:
                (found_lane,) = (item for item in path.lane_sections[0].lanes if item.id == own)
                (last_lane,) = (item for item in path.lane_sections[-1].lanes if item.id == own)
                assert found_lane.predecessor == lane
                assert last_lane.successor is not None
                one, other = by_id[before.id], by_id[after.id]
                found.append(
                    (
                        one.osm_way_ids[0 if before.at_start else -1],
                        lane,
                        other.osm_way_ids[0 if after.at_start else -1],
                        last_lane.successor,
                    )
                )
    return sorted(found)
