"""Queries to the Overpass API, for all that conversions and scenes read of a map."""

from __future__ import annotations

from typing import Final

from osm2xodr.defaults import OUTLINE_REACH
from osm2xodr.fetching.place import Box, widened
from osm2xodr.osmParsing import (
    AREA_TYPE,
    RELATION_TYPES,
    SURROUNDINGS_KEYS,
    SURROUNDINGS_TAGS,
    node_keys,
    way_values,
)

# How long the server may work on a query, s, and the memory that it may take, bytes: the server's own defaults.
QUERY_TIME: Final = 180
_QUERY_MEMORY: Final = 536_870_912
_SETTINGS: Final = f"[out:xml][timeout:{QUERY_TIME}][maxsize:{_QUERY_MEMORY}];"
# What conversions read on request; it is fetched as well.
_EXTRA: Final = frozenset({"lamps", "trees"})
# Keys of nodes of which only some values are of use, since there are many with others.
_VALUES: Final = {"natural": "tree"}


def count_query(box: Box, *, surroundings: bool) -> str:
    """Return the query for the number of elements in a box that `area_query` gives, without the nodes of ways."""
    if not surroundings:
        return f"{_SETTINGS}({_ways(box)}{_nodes(box)});out count;"
    return (
        f"{_SETTINGS}({_surroundings('rel', box)})->.areas;"
        f"({_ways(box)}{_nodes(box)}{_surroundings('way', box)}.areas;{_outlines(box)});out count;"
    )


def area_query(box: Box, *, surroundings: bool) -> str:
    """Return the query for all that conversions read in a box (west, south, east, north, degrees).

    Ways come whole, with all of their nodes; relations with all ways that they name. With `surroundings` that is also
    what scenes have beside roads; multipolygons of these come with the ways up to `OUTLINE_REACH` beyond the box.
    Ways and nodes that are only needed for outlines come without tags, so that conversions find nothing more.
    """
    kinds = "|".join(sorted(RELATION_TYPES))
    roads = (
        f"{_SETTINGS}({_ways(box)})->.ways;node(w.ways)->.corners;({_nodes(box)})->.things;"
        f'(rel(bw.ways)["type"~"^({kinds})$"];rel(bn.corners)["type"~"^({kinds})$"];)->.rules;'
        "way(r.rules)->.named;node(w.named)->.ends;"
        "(.ways;.corners;.things;.rules;.named;.ends;"
    )
    if not surroundings:
        return f"{roads});out meta;"
    return (
        f"{roads})->.roads;({_surroundings('rel', box)})->.areas;({_surroundings('way', box)})->.shown;"
        f"(.roads;.areas;.shown;)->.whole;({_outlines(box)}-.whole;)->.outlines;"
        "(.shown;.outlines;)->.lines;(node(w.lines);-.whole;)->.places;"
        ".whole out meta;(.outlines;.places;);out skel;"
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


def _surroundings(kind: str, box: Box) -> str:
    """Return what asks for buildings and water: ``way`` for those that are ways, ``rel`` for multipolygons."""
    start = f'rel["type"="{AREA_TYPE}"]' if kind == "rel" else kind
    values = {key: sorted(value for of, value in SURROUNDINGS_TAGS if of == key) for key, _ in SURROUNDINGS_TAGS}
    filters = [f'["{key}"]' for key in sorted(SURROUNDINGS_KEYS)]
    filters += [f'["{key}"~"^({"|".join(names)})$"]' for key, names in sorted(values.items())]
    return "".join(f"{start}{item}{_bounds(box)}" for item in filters)


def _outlines(box: Box) -> str:
    """Return what asks for the ways of the multipolygons in the set ``areas`` that come with them."""
    return f"way(r.areas){_bounds(widened(box, OUTLINE_REACH))}"
