"""What a user knows better than OpenStreetMap, by the elements that it is about.

Corrections of tags are applied as tags are read, those of junctions and heights where these are made. Each place that
applies some says of each one of them either that it was `applied`, or why it was `unused`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field
from typing import TYPE_CHECKING, Final

from osm2xodr.system import record

if TYPE_CHECKING:
    from osm2xodr.diagnostics import Diagnostics

# Stands for all lanes among the numbers of lanes.
EVERY_LANE: Final = 0


@record
class WayCorrection:
    """What is known of a way."""

    drop: bool = False  # Whether it is left out
    keep: bool = False  # Whether it becomes a street although its access or the choice of ways leaves it out
    highway: str = ""  # The class that it is kept as; empty for its own
    # Numbers of lanes as OSM counts them, by direction: ``forward``, ``backward``, ``both_ways``; empty text for all
    lanes: Mapping[str, int] = field(default_factory=dict)
    width: float | None = None  # Of the carriageway, m
    # Of lanes, m, by their number, counted from 1 on from the left, seen along the way; `EVERY_LANE` for all lanes
    lane_width: Mapping[int, float] = field(default_factory=dict)
    # Limits in OSM's words, by direction: ``forward``, ``backward``; empty text for both
    speed: Mapping[str, str] = field(default_factory=dict)
    layer: int | None = None
    clearance: float | None = None  # From road to road where others pass over or under it, m
    no_u_turn: bool = False  # Whether nobody turns from it into the opposite carriageway


@record
class NodeCorrection:
    """What is known of a node."""

    drop: bool = False  # Whether its tags are ignored
    z: float | None = None  # Height of the road there, m, in the datum of the result
    no_u_turn: bool = False  # Whether nobody turns at its junction into the opposite carriageway
    join: tuple[int, ...] = ()  # Nodes that make one junction with it
    split: tuple[int, ...] = ()  # Nodes whose junctions are others than its own
    split_all: bool = False  # Whether its junction has no other node


@record
class Corrections:
    """All that is known, by OSM id."""

    ways: Mapping[int, WayCorrection] = field(default_factory=dict)
    nodes: Mapping[int, NodeCorrection] = field(default_factory=dict)
    relations: frozenset[int] = frozenset()  # Those that are left out
    # Whether they are for more than one area, so that those that match nothing in it are no mistakes
    shared: bool = False

    def kept_ways(self) -> frozenset[int]:
        """Return the ways that become streets in any case."""
        return frozenset(way for way, item in self.ways.items() if item.keep)

    def entries(self) -> Iterator[tuple[str, str]]:
        """Yield each correction as its element, such as ``way/1``, and its key."""
        for way, known in sorted(self.ways.items()):
            given = {
                "drop": known.drop,
                "keep": known.keep,
                "lanes": known.lanes,
                "width": known.width is not None,
                "lane-width": known.lane_width,
                "speed": known.speed,
                "layer": known.layer is not None,
                "clearance": known.clearance is not None,
                "no-u-turn": known.no_u_turn,
            }
            yield from ((f"way/{way}", key) for key, there in given.items() if there)
        for node, at in sorted(self.nodes.items()):
            given = {
                "drop": at.drop,
                "z": at.z is not None,
                "no-u-turn": at.no_u_turn,
                "join": at.join,
                "split": at.split or at.split_all,
            }
            yield from ((f"node/{node}", key) for key, there in given.items() if there)
        yield from ((f"relation/{relation}", "drop") for relation in sorted(self.relations))


def applied(diagnostics: Diagnostics, osm_id: str, key: str, what: str) -> None:
    """Report a correction of an element as applied."""
    diagnostics.repaired("correction", osm_id, f"{key}: {what}")


def unused(diagnostics: Diagnostics, osm_id: str, key: str, why: str) -> None:
    """Report a correction of an element that matches nothing, or changes nothing."""
    diagnostics.note("correction-unused", osm_id, f"{key}: {why}")
