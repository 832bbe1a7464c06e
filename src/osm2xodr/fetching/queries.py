"""Queries to the Overpass API, for all that conversions read of a map."""

from __future__ import annotations

from typing import Final

from osm2xodr.fetching.place import Box
from osm2xodr.osmParsing import RELATION_TYPES, node_keys, way_values

# How long the server may work on a query, s, and the memory that it may take, bytes: the server's own defaults.
QUERY_TIME: Final = 180
_QUERY_MEMORY: Final = 536_870_912
_SETTINGS: Final = f"[out:xml][timeout:{QUERY_TIME}][maxsize:{_QUERY_MEMORY}];"
# What conversions read on request; it is fetched as well.
_EXTRA: Final = frozenset({"lamps", "trees"})
# Keys of nodes of which only some values are of use, since there are many with others.
_VALUES: Final = {"natural": "tree"}


def count_query(box: Box) -> str:
    """Return the query for the number of ways and nodes in a box (west, south, east, north, degrees)."""
    return f"{_SETTINGS}({_ways(box)}{_nodes(box)});out count;"


def area_query(box: Box) -> str:
    """Return the query for all that conversions read in a box (west, south, east, north, degrees).

    Ways come whole, with all of their nodes; relations with all ways that they name.
    """
    kinds = "|".join(sorted(RELATION_TYPES))
    return (
        f"{_SETTINGS}({_ways(box)})->.ways;node(w.ways)->.corners;({_nodes(box)})->.things;"
        f'(rel(bw.ways)["type"~"^({kinds})$"];rel(bn.corners)["type"~"^({kinds})$"];)->.rules;'
        "way(r.rules)->.named;node(w.named)->.ends;"
        "(.ways;.corners;.things;.rules;.named;.ends;);out meta;"
    )


def _bounds(box: Box) -> str:
    """Return a box as filters have it. Each has one, since one for all would hold for the nodes of ways as well."""
    west, south, east, north = (f"{value:.7f}".rstrip("0").rstrip(".") for value in box)
    return f"({south},{west},{north},{east});"


def _ways(box: Box) -> str:
    values = way_values(frozenset(), _EXTRA)
    del values["highway"]
    others = (f'way["{key}"~"^({"|".join(sorted(names))})$"]' for key, names in sorted(values.items()))
    return "".join(f"{item}{_bounds(box)}" for item in ('way["highway"]', *others))


def _nodes(box: Box) -> str:
    keys, _ = node_keys(True, _EXTRA)
    wanted = (f'="{_VALUES[key]}"' if key in _VALUES else "" for key in sorted(keys))
    return "".join(f'node["{key}"{value}]{_bounds(box)}' for key, value in zip(sorted(keys), wanted, strict=True))
