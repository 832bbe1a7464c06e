"""Count what `width` says in extracts of OSM, by country, town or not, class, direction and number of lanes.

    python tools/lane_widths.py AREA.osm.pbf ...

The second opinion on the tables of `osm2xodr.conventions.countries`; docs/method/lanes.md says what came out. Parked
cars are sometimes counted in, so medians of streets with houses are upper bounds.
"""

from __future__ import annotations

import sys
from collections import defaultdict

import numpy as np
import osmium

from osm2xodr.osmParsing.network import find_place
from osm2xodr.osmParsing.options import DRIVABLE
from osm2xodr.osmParsing.tags.access import oneway
from osm2xodr.osmParsing.tags.legal_speeds import is_town_street
from osm2xodr.osmParsing.tags.values import parse_length

# Fewer ways say nothing.
_LEAST_WAYS = 5


def main(paths: list[str]) -> int:
    """Print a table of the widths in some files."""
    if not paths:
        print(__doc__)
        return 2
    found: dict[tuple[str, ...], list[float]] = defaultdict(list)
    for path in paths:
        country = _country(path)
        for way in osmium.FileProcessor(path, osmium.osm.WAY):
            tags = dict(way.tags)
            width = parse_length(tags.get("width:carriageway") or tags.get("width") or "")
            if tags.get("highway") in DRIVABLE.highways and width:
                direction = "one way" if oneway(tags)[0] else "two ways"
                town = "town" if is_town_street(tags, dense=False) else "-"
                found[country, town, tags["highway"], direction, tags.get("lanes", "-")].append(width)
    print("| country | place | class | direction | lanes | ways | quartiles, m |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for key, widths in sorted(found.items()):
        if len(widths) >= _LEAST_WAYS:
            quartiles = ", ".join(f"{value:.1f}" for value in np.percentile(widths, (25, 50, 75)))
            print(f"| {' | '.join(key)} | {len(widths)} | {quartiles} |")
    return 0


def _country(path: str) -> str:
    """Return the code of the country that the first node of a file lies in."""
    for node in osmium.FileProcessor(path, osmium.osm.NODE):
        if isinstance(node, osmium.osm.Node):
            return find_place(node.lat, node.lon).country
    return ""


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
