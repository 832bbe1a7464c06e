"""What traffic needs to know of a network of SUMO: edges for cars, and which may follow which."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from osm2xodr.model import BoolArray, FloatArray, IntArray

_CARS = "passenger"


@dataclass(frozen=True, eq=False)
class SumoNetwork:
    """Edges for cars outside of junctions."""

    id: tuple[str, ...]
    length: FloatArray  # (edges,) m
    speed: FloatArray  # (edges,) m/s, of its fastest lane
    # (links,) Indices of edges: from the end of one onto the other
    start: IntArray
    end: IntArray

    @cached_property
    def road(self) -> tuple[str, ...]:
        """The id of the road in OpenDRIVE that each edge was made of; netconvert adds the direction and a number."""
        return tuple(name.lstrip("-").partition("#")[0] for name in self.id)

    @cached_property
    def entrances(self) -> BoolArray:
        """Which edges no other one leads to but that of the opposite direction: traffic comes in there."""
        return ~self._met(self.end, self.start)

    @cached_property
    def exits(self) -> BoolArray:
        """Which edges lead to no other one but that of the opposite direction: traffic leaves there."""
        return ~self._met(self.start, self.end)

    def _met(self, edges: IntArray, others: IntArray) -> BoolArray:
        found = np.zeros(len(self.id), np.bool_)
        road = np.array(self.road)
        found[edges[road[edges] != road[others]]] = True
        # Pieces of one road that follow each other in one direction.
        direction = np.array([name.startswith("-") for name in self.id])
        found[edges[(road[edges] == road[others]) & (direction[edges] == direction[others])]] = True
        return found


def read_network(path: Path) -> SumoNetwork:
    """Read the network that netconvert wrote."""
    ids: dict[str, int] = {}
    lengths: list[float] = []
    speeds: list[float] = []
    links: set[tuple[int, int]] = set()
    for element in _elements(path):
        if element.tag == "edge" and not element.get("function"):
            lanes = [lane for lane in element.iter("lane") if _for_cars(lane)]
            if lanes:
                ids[element.get("id", "")] = len(ids)
                lengths.append(float(lanes[0].get("length", "0")))
                speeds.append(max(float(lane.get("speed", "0")) for lane in lanes))
        elif element.tag == "connection":
            pair = ids.get(element.get("from", "")), ids.get(element.get("to", ""))
            if pair[0] is not None and pair[1] is not None:
                links.add((pair[0], pair[1]))
    pairs = np.array(sorted(links), np.int64).reshape(-1, 2)
    return SumoNetwork(tuple(ids), np.array(lengths), np.array(speeds), pairs[:, 0], pairs[:, 1])


def _elements(path: Path) -> Iterator[ET.Element]:
    """Yield the elements of a network one by one; what was read is forgotten."""
    depth = 0
    for event, element in ET.iterparse(path, ("start", "end")):
        depth += 1 if event == "start" else -1
        if event == "end" and depth == 1:
            yield element
            element.clear()


def _for_cars(lane: ET.Element) -> bool:
    allowed = lane.get("allow")
    if allowed is not None:
        return _CARS in allowed.split() or allowed == "all"
    return not {_CARS, "all"} & set(lane.get("disallow", "").split())
