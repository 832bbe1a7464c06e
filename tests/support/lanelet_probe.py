"""Loads a map of Lanelet2 with its own library and prints what that sees as JSON. Run as a process: it may crash."""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import lanelet2
import lanelet2.projection
import lanelet2.routing
import lanelet2.traffic_rules

PARTICIPANTS = ("vehicle", "bicycle", "pedestrian")


def name(item: Any) -> list[str]:
    """Return road, lane and s of a lanelet's begin, as its tags say."""
    tags = item.attributes
    return [tags["xodr:road"], tags["xodr:lane"], tags["xodr:s"].split()[0]]


def edges(lanelets: list[Any], loaded: Any, participant: str) -> dict[str, list[Any]]:
    """Return which lanelets follow each other, and to which one may change; both directions count where both are."""
    rules = lanelet2.traffic_rules.create(lanelet2.traffic_rules.Locations.Germany, participant)
    graph = lanelet2.routing.RoutingGraph(loaded, rules)
    found: dict[str, list[Any]] = {"follow": [], "left": [], "right": []}
    for item in lanelets:
        for one in (item,) if rules.isOneWay(item) else (item, item.invert()):
            found["follow"] += [(name(item), name(other)) for other in graph.following(one)]
            for side in ("left", "right"):
                other = getattr(graph, side)(one)
                found[side] += [(name(item), name(other))] if other is not None else []
    return found


def main() -> None:
    """Print the answers."""
    text = Path(sys.argv[1]).read_text(encoding="utf-8")
    first = re.search(r'lat="([^"]+)" lon="([^"]+)"', text)
    assert first is not None
    projector = lanelet2.projection.UtmProjector(lanelet2.io.Origin(float(first[1]), float(first[2])))
    loaded, errors = lanelet2.io.loadRobust(sys.argv[1], projector)
    lanelets = [item for item in loaded.laneletLayer if "xodr:lane" in item.attributes]
    rules = Counter(item.attributes["subtype"] for item in loaded.regulatoryElementLayer)
    answers = {
        "errors": list(errors),
        "lanelets": [
            {
                "name": name(item),
                "tags": {entry.key(): entry.data() for entry in item.attributes},
                "bounds": [[point.id for point in line] for line in (item.leftBound, item.rightBound)],
                "rules": [rule.attributes["subtype"] for rule in item.regulatoryElements],
            }
            for item in lanelets
        ],
        "others": len(list(loaded.laneletLayer)) - len(lanelets),
        "rules": dict(rules),
        "edges": {who: edges(lanelets, loaded, who) for who in PARTICIPANTS},
    }
    print(json.dumps(answers))


main()
