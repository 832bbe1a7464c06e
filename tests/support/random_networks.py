"""Random street networks that a mapper could have drawn, and the same ones mirrored, turned, and in another order.

Positions are whole numbers of OSM's own steps (1e-7 degrees), so that a network mirrored over its meridian is exact.
"""

from __future__ import annotations

import math
import random
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final
from xml.sax.saxutils import quoteattr

from osm2xodr.model import Rule

_STEPS: Final = 10_000_000
_METRES_PER_DEGREE: Final = 111_195.0
_SWAPPED_ALONG: Final = {"forward": "backward", "backward": "forward", "left": "right", "right": "left"}
_SWAPPED_ACROSS: Final = {"left": "right", "right": "left"}
# Latitude and longitude of the middle, degrees; two of them where longitudes jump.
PLACES: Final = ((48.0, 11.0), (51.5, -0.1), (-33.9, 151.2), (-16.8, 180.0), (64.1, -179.9995), (0.0, 20.0))


@dataclass(frozen=True)
class RandomNetwork:
    """A street network.

    Parameters
    ----------
    place
        Latitude and longitude of the middle, degrees.
    rule
        The side that traffic drives on.
    nodes
        By id: offset of longitude and latitude from the middle in OSM's steps, and tags.
    ways
        By id: nodes and tags.
    """

    place: tuple[float, float]
    rule: Rule
    nodes: Mapping[int, tuple[int, int, Mapping[str, str]]]
    ways: Mapping[int, tuple[tuple[int, ...], Mapping[str, str]]]

    def elements(self) -> list[str]:
        """Return the elements of the OSM file."""
        lat, lon = (round(value * _STEPS) for value in self.place)
        out = []
        for number, (dlon, dlat, tags) in self.nodes.items():
            x = (lon + dlon + 180 * _STEPS) % (360 * _STEPS) - 180 * _STEPS
            where = f'lat="{(lat + dlat) / _STEPS:.7f}" lon="{x / _STEPS:.7f}"'
            out.append(f'<node id="{number}" {where}>{_written(tags)}</node>')
        for number, (refs, tags) in self.ways.items():
            out.append(f'<way id="{number}">{"".join(f"<nd ref={str(r)!r}/>" for r in refs)}{_written(tags)}</way>')
        return out

    def osm(self, shuffled: random.Random | None = None) -> str:
        """Return the OSM file, its elements in another order if there are dice to choose it."""
        elements = self.elements()
        if shuffled is not None:
            shuffled.shuffle(elements)
        return "\n".join(['<osm version="0.6">', *elements, "</osm>"])

    def mirrored(self) -> RandomNetwork:
        """Return the network mirrored over its meridian, for traffic on the other side."""
        return replace(
            self,
            rule=Rule.LEFT_HAND if self.rule is Rule.RIGHT_HAND else Rule.RIGHT_HAND,
            nodes={k: (-dlon, dlat, tags) for k, (dlon, dlat, tags) in self.nodes.items()},
            ways={k: (refs, _mirrored(tags)) for k, (refs, tags) in self.ways.items()},
        )

    def turned(self, chosen: frozenset[int]) -> RandomNetwork:
        """Return the network with some ways drawn the other way round."""
        return replace(
            self,
            ways={
                k: (refs[::-1], _turned(tags)) if k in chosen else (refs, tags)
                for k, (refs, tags) in self.ways.items()
            },
        )


def _written(tags: Mapping[str, str]) -> str:
    return "".join(f"<tag k={quoteattr(key)} v={quoteattr(value)}/>" for key, value in tags.items())


def _mirrored(tags: Mapping[str, str]) -> dict[str, str]:
    out = {}
    for key, value in tags.items():
        if ":lanes" in key:
            value = "|".join(_swapped(lane, _SWAPPED_ACROSS) for lane in reversed(value.split("|")))
        elif key in ("sidewalk", "shoulder"):
            value = _swapped(value, _SWAPPED_ACROSS)
        out[_swapped(key, _SWAPPED_ACROSS)] = value
    return out


def _turned(tags: Mapping[str, str]) -> dict[str, str]:
    out = {_swapped(key, _SWAPPED_ALONG): value for key, value in tags.items()}
    for key in ("sidewalk", "shoulder"):
        if key in out:
            out[key] = _swapped(out[key], _SWAPPED_ALONG)
    if "oneway" in out:
        out["oneway"] = {"yes": "-1", "-1": "yes"}.get(out["oneway"], out["oneway"])
    return out


def _swapped(text: str, words: Mapping[str, str]) -> str:
    return re.sub(r"[a-z]+", lambda found: words.get(found[0], found[0]), text)


_CLASSES: Final = (
    *("motorway", "trunk", "primary", "secondary", "secondary", "tertiary", "tertiary", "unclassified"),
    *("residential", "residential", "residential", "living_street", "service", "primary_link", "motorway_link"),
)


SPACINGS: Final = (18.0, 40.0, 70.0, 120.0, 250.0)


def random_network(seed: int, spacings: tuple[float, ...] = SPACINGS) -> RandomNetwork:
    """Return a network of up to some twenty streets: a grid out of shape, of which parts are missing.

    Parameters
    ----------
    seed
        What to make.
    spacings
        Distances of the grid's lines to choose from, m.
    """
    dice = random.Random(seed)
    place = dice.choice(PLACES)
    columns, rows = dice.randint(2, 4), dice.randint(2, 4)
    spacing = dice.choice(spacings)
    jitter = dice.choice((0.1, 0.3, 0.45)) * spacing
    nodes: dict[int, tuple[int, int, Mapping[str, str]]] = {}
    ids = dice.sample(range(1, 1000), columns * rows)
    at = {(i, j): ids[i * rows + j] for i in range(columns) for j in range(rows)}
    stretch = _STEPS / (_METRES_PER_DEGREE * math.cos(math.radians(place[0])))

    def put(number: int, x: float, y: float, tags: Mapping[str, str]) -> None:
        nodes[number] = round(x * stretch), round(y * _STEPS / _METRES_PER_DEGREE), tags

    for (i, j), number in at.items():
        x, y = (k * spacing + dice.uniform(-jitter, jitter) for k in (i, j))
        put(number, x - (columns - 1) * spacing / 2, y - (rows - 1) * spacing / 2, _node_tags(dice))
    edges = [((i, j), (i + 1, j)) for i, j in at if (i + 1, j) in at]
    edges += [((i, j), (i, j + 1)) for i, j in at if (i, j + 1) in at]
    edges += [((i, j), (i + 1, j + 1)) for i, j in at if (i + 1, j + 1) in at and dice.random() < 0.2]
    kept = [(at[one], at[other]) for one, other in edges if dice.random() < 0.8] or [(ids[0], ids[1])]
    ways = {number: (refs, _way_tags(dice)) for number, refs in enumerate(_walks(kept, dice), start=1001)}
    bent: dict[int, tuple[tuple[int, ...], Mapping[str, str]]] = {}
    spare = 2001
    for number, (refs, tags) in ways.items():
        row = [refs[0]]
        for one, other in pairwise(refs):
            if dice.random() < 0.3:
                a, b = nodes[one], nodes[other]
                aside = dice.uniform(-0.15, 0.15)
                middle = (a[0] + b[0]) // 2 + round(aside * (b[1] - a[1])), (a[1] + b[1]) // 2
                nodes[spare] = *middle, _node_tags(dice)
                row.append(spare)
                spare += 1
            row.append(other)
        bent[number] = tuple(row), tags
    rule = dice.choice(tuple(Rule))
    used = {ref for refs, _ in bent.values() for ref in refs}
    return RandomNetwork(place, rule, {k: node for k, node in nodes.items() if k in used}, bent)


def _walks(edges: list[tuple[int, int]], dice: random.Random) -> list[tuple[int, ...]]:
    """Join edges to ways of one to three edges, no way over a node twice."""
    left = edges.copy()
    dice.shuffle(left)
    out = []
    while left:
        row = list(left.pop()) if dice.random() < 0.5 else list(left.pop())[::-1]
        for _ in range(dice.randint(0, 2)):
            onwards = [edge for edge in left if row[-1] in edge and not (set(edge) - {row[-1]}) & set(row)]
            if not onwards:
                break
            edge = onwards[0]
            left.remove(edge)
            row.append(edge[1] if edge[0] == row[-1] else edge[0])
        out.append(tuple(row))
    return out


def _node_tags(dice: random.Random) -> dict[str, str]:
    if dice.random() < 0.75:
        return {}
    kind = dice.choice(("traffic_signals", "crossing", "stop", "give_way", "turning_circle", "bump"))
    if kind == "bump":
        return {"traffic_calming": "bump"}
    return {"highway": kind, **({"crossing": "marked"} if kind == "crossing" else {})}


def _way_tags(dice: random.Random) -> dict[str, str]:
    tags = {"highway": dice.choice(_CLASSES)}
    lanes = dice.choice((0, 0, 1, 2, 2, 3, 4))
    if dice.random() < 0.3 or tags["highway"].startswith("motorway"):
        tags["oneway"] = "yes"
        if lanes > 1 and dice.random() < 0.5:
            turns = ["left", *["through"] * (lanes - 2), "right"]
            tags["turn:lanes"] = "|".join(turns)
    elif lanes > 2:
        tags |= {"lanes:forward": str(lanes // 2), "lanes:backward": str(lanes - lanes // 2)}
    if lanes and not (lanes % 2 and "oneway" not in tags and "lanes:forward" not in tags):
        tags["lanes"] = str(lanes)
    if dice.random() < 0.4:
        tags["sidewalk"] = dice.choice(("both", "left", "right", "no"))
    if dice.random() < 0.2:
        tags[f"parking:{dice.choice(('left', 'right', 'both'))}"] = "lane"
    if dice.random() < 0.2 and "oneway" not in tags:
        tags[f"cycleway:{dice.choice(('left', 'right', 'both'))}"] = dice.choice(("lane", "track"))
    if dice.random() < 0.3:
        tags["maxspeed"] = dice.choice(("30", "50", "30 mph", "none"))
    if dice.random() < 0.1:
        tags |= {"bridge": "yes", "layer": "1"}
    if dice.random() < 0.3:
        tags["name"] = dice.choice(("Alte Straße", "通り", "A & B"))
    return tags
