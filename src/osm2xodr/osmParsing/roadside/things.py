"""Footways and things beside streets: what their tags mean, and those of a file that are near streets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set as AbstractSet
from types import MappingProxyType
from typing import Final

import numpy as np

from osm2xodr.curves import hypot, repeated, sorted_unique, unique_all
from osm2xodr.model import FloatArray, Footway, IntArray, RoadsideKind, RoadsideThing
from osm2xodr.osmParsing.file import OtherWays, RawNodes, RawWay
from osm2xodr.osmParsing.options import DRIVABLE
from osm2xodr.osmParsing.roadside.reach import StreetSamples, near_streets
from osm2xodr.osmParsing.tags import SIGN_KEYS, read_thing_facts

# Nodes of the smallest area, the first one at the end again.
_LEAST_OF_AREA: Final = 4

# Nodes with one of these keys are read, on streets and beside them.
_NODE_KEYS: Final = frozenset(
    {"highway", "traffic_signals", "traffic_signals:direction", "direction", "stop", "diameter", "ele"}
)
_FURNITURE_NODE_KEYS: Final = frozenset(
    (*SIGN_KEYS, "crossing", "traffic_calming", "city_limit", "maxspeed", "barrier", "railway", "public_transport")
)
_CROSSING_DETAILS: Final = tuple(
    f"crossing{what}" for what in (":island", ":markings", ":signals", ":width", ":kerb", "_ref")
)
# Further tags that are kept of them.
_NODE_DETAILS: Final = frozenset(
    {
        *(*_CROSSING_DETAILS, "crossing:saltire", "crossing:light", "crossing:barrier"),
        *("button_operated", "tactile_paving", "kerb", "width", "height", "length", "material", "layer"),
        *("traffic_sign:direction", "name", "side", "support", "hazard", "maxheight", "maxwidth", "maxweight"),
        *("maxspeed:forward", "maxspeed:backward", "bus", "bus_bay", "bay", "shelter", "tram", "train", "trolleybus"),
        *("subway", "ferry", "light_rail", "access", "motor_vehicle", "segregated"),
    }
)
# What says that a crossing is none.
_CROSSED: Final = frozenset({"crossing"})
_LAMP_DETAILS: Final = frozenset({"lamp_mount", "lamp_type"})
_TREE_DETAILS: Final = frozenset({"natural", "leaf_type", "leaf_cycle", "circumference", "diameter_crown"})
# Names are kept only where a sign or a stop shows them.
_NAMED: Final = (*SIGN_KEYS, "city_limit", "public_transport")

# Ways for walking or cycling; stairs are not part of a street.
FOOT_HIGHWAYS: Final = frozenset({"footway", "path", "pedestrian", "cycleway"})
# Keys that show that a path is built rather than trodden (OSM wiki, Tag:highway=path).
_BUILT_PATH: Final = frozenset({"footway", "path", "cycleway", "segregated", "crossing", "crossing:markings"})
_BARRIERS: Final[Mapping[str, RoadsideKind]] = MappingProxyType(
    {
        **dict.fromkeys(("guard_rail", "jersey_barrier"), RoadsideKind.GUARD_RAIL),
        **dict.fromkeys(("wall", "retaining_wall"), RoadsideKind.WALL),
        "fence": RoadsideKind.FENCE,
        "hedge": RoadsideKind.HEDGE,
        "bollard": RoadsideKind.BOLLARD,
        "kerb": RoadsideKind.KERB,
    }
)
# The other kinds, as nodes, are gaps in or points of a barrier mapped as a way.
_BARRIER_NODES: Final = frozenset({"guard_rail", "jersey_barrier", "bollard"})
# Modes of transport whose platforms are not in the street unless buses stop there as well.
_RAIL_MODES: Final = ("train", "subway", "light_rail", "ferry", "tram")

_FOOTWAY_DETAILS: Final = frozenset(
    {
        *("highway", "area", "footway", "path", "cycleway", "width", "est_width", "surface", "bicycle", "foot"),
        *("segregated", "layer", "bridge", "tunnel", "kerb", "oneway", "oneway:bicycle", "crossing"),
        *_CROSSING_DETAILS,
    }
)
_BARRIER_DETAILS: Final = frozenset(
    ("barrier", "height", "width", "material", "fence_type", "kerb", "layer", "bridge", "tunnel")
)
# By key, the value of areas that are raised between carriageways.
_ISLANDS: Final[Mapping[str, str]] = MappingProxyType({"area:highway": "traffic_island", "traffic_calming": "island"})
# Areas of carriageways, by the class of the road (OSM wiki, Key:area:highway).
_CARRIAGEWAYS: Final = DRIVABLE.highways
# Values of ``kerb`` on lines that are kerbs (OSM wiki, Key:kerb).
_KERBS: Final = frozenset({"raised", "lowered", "flush", "rolled", "yes"})
_TRACK_DETAILS: Final = frozenset({"railway", "gauge", "layer", "bridge", "tunnel", "embedded", "service"})
_STOP_DETAILS: Final = frozenset(
    {
        *("highway", "public_transport", "bus", "trolleybus", "name", "ref", "shelter", "bus_bay", "bay", "height"),
        *("width", "layer", *_RAIL_MODES),
    }
)
_SIGN_DETAILS: Final = frozenset(
    {
        *(*SIGN_KEYS, "traffic_sign:direction", "highway", "hazard", "maxheight", "maxwidth", "maxweight", "height"),
        *("direction", "maxspeed", "maxspeed:forward", "maxspeed:backward", "name", "city_limit", "side", "support"),
        *("stop", "layer"),
    }
)
_LIGHT_DETAILS: Final = frozenset(
    {"highway", "traffic_signals", "traffic_signals:direction", "direction", "crossing", "button_operated", "layer"}
)
# Tags that are kept of things, by kind.
_DETAILS: Final[Mapping[RoadsideKind, frozenset[str]]] = MappingProxyType(
    {
        RoadsideKind.TREE: _TREE_DETAILS | {"height"},
        RoadsideKind.STREET_LAMP: _LAMP_DETAILS | {"highway", "height", "support", "direction"},
        RoadsideKind.BUS_STOP: _STOP_DETAILS,
        RoadsideKind.TRAM_TRACK: _TRACK_DETAILS,
        RoadsideKind.TRAFFIC_SIGN: _SIGN_DETAILS,
        RoadsideKind.TRAFFIC_SIGNALS: _LIGHT_DETAILS,
        RoadsideKind.ISLAND: frozenset({*_ISLANDS, "layer"}),
        **{kind: _BARRIER_DETAILS for kind in _BARRIERS.values()},
    }
)
# All tags of ways that are read here.
BESIDE_TAGS: Final = (
    _FOOTWAY_DETAILS
    | _BARRIER_DETAILS
    | _TRACK_DETAILS
    | _STOP_DETAILS
    | _TREE_DETAILS
    | {"building", "natural", *_ISLANDS}
)


def ways_beside(streets: AbstractSet[str], extra: AbstractSet[str], fronts: bool) -> OtherWays:
    """Return which ways are read besides those whose ``highway`` is among `streets`.

    `extra` are kinds of things read on request: ``lamps``, ``trees``; `fronts` says whether buildings are read.
    """
    values = way_values(streets, extra)

    def wanted(tags: Mapping[str, str]) -> bool:
        read = any(tags.get(key) in names for key, names in values.items())
        if read and (is_footway(tags) or kind_of_way(tags) is not None or _bounds_carriageways(tags)):
            return True
        return fronts and is_building(tags)

    return OtherWays(values, BESIDE_TAGS, wanted, frozenset({"building"}) if fronts else frozenset())


def kerbs_beside() -> OtherWays:
    """Return which ways are read besides streets if nothing but their widths is asked for."""
    return OtherWays(kerb_values(), BESIDE_TAGS, _bounds_carriageways)


def _bounds_carriageways(tags: Mapping[str, str]) -> bool:
    return is_kerb(tags) or is_carriageway_area(tags)


def read_beside(
    ways: Sequence[RawWay],
    nodes: RawNodes,
    points: FloatArray,
    samples: StreetSamples,
    carried: IntArray,
    extra: AbstractSet[str],
    country: str,
) -> tuple[tuple[Footway, ...], tuple[RoadsideThing, ...]]:
    """Select the footways (ascending in id) and things (in kind and id, nodes before ways) within reach of streets.

    `ways` are those of `ways_beside`, `points` (n, 2) the local x, y of the nodes, m, `samples` points along the
    streets, `carried` (m,) the OSM ids of nodes on streets, ascending. `extra` are the kinds of things read on
    request; `country` (ISO 3166-1 alpha-2) says whose signs they are.
    """
    ways = [way for way in ways if is_footway(way.tags) or kind_of_way(way.tags) is not None]
    lengths = np.array([len(way.refs) for way in ways], np.int64)
    refs = np.concatenate([np.zeros(0, np.int64), *[way.refs for way in ways]])
    row = np.searchsorted(nodes.ids, refs)
    row[row == len(nodes.ids)] = 0
    present = (nodes.ids[row] == refs) & np.isfinite(points[row]).all(axis=1)
    row, way = row[present], repeated(lengths)[present]
    # Nodes that are things and not on streets.
    single_ids = np.array([number for number, tags in nodes.tags.items() if kind_of_node(tags, extra)], np.int64)
    single = np.searchsorted(nodes.ids, single_ids[~np.isin(single_ids, carried)])
    asked = sorted_unique(np.concatenate([row, single]))
    near = np.zeros(len(nodes.ids), np.bool_)
    near[asked] = near_streets(samples, points[asked])
    things = [_node(int(index), nodes, points, extra, country) for index in single[near[single]].tolist()]
    near[np.searchsorted(nodes.ids, carried)] = True
    reached = np.zeros(len(ways), np.bool_)
    reached[way[near[row]]] = True
    row, way = row[reached[way]], way[reached[way]]
    # Consecutive nodes at one place count once.
    again = np.zeros(len(row), np.bool_)
    again[1:] = (way[1:] == way[:-1]) & (points[row[1:]] == points[row[:-1]]).all(axis=1)
    row, way = row[~again], way[~again]
    ids, places = nodes.ids[row], points[row]
    numbers, begin, _, count = unique_all(way)
    footways: list[Footway] = []
    for number, first, size in zip(numbers.tolist(), begin.tolist(), count.tolist(), strict=True):
        # A way of a single node has no extent.
        if size > 1:
            _add_way(ways[number], ids[first : first + size], places[first : first + size], footways, things)

    def order(thing: RoadsideThing) -> tuple[str, str, int]:
        element, _, number = thing.osm_id.partition("/")
        return thing.kind.value, element, int(number)

    return tuple(footways), tuple(sorted(things, key=order))


def _node(index: int, nodes: RawNodes, points: FloatArray, extra: AbstractSet[str], country: str) -> RoadsideThing:
    ids, points = nodes.ids[index : index + 1].copy(), points[index : index + 1].copy()
    tags = nodes.tags[int(ids[0])]
    kind = kind_of_node(tags, extra)
    assert kind is not None
    facts = read_thing_facts(kind, thing_tags(kind, tags), country)
    return RoadsideThing(kind, f"node/{ids[0]}", points, ids, facts)


def _add_way(
    way: RawWay, ids: IntArray, points: FloatArray, footways: list[Footway], things: list[RoadsideThing]
) -> None:
    """Add a way to the footways or the things, or to both."""
    if is_footway(way.tags):
        footways.append(Footway(way.id, is_crossing(way.tags), points, ids, footway_tags(way.tags)))
    kind = kind_of_way(way.tags)
    if kind is None or (kind is RoadsideKind.ISLAND and (len(ids) < _LEAST_OF_AREA or ids[0] != ids[-1])):
        return
    facts = read_thing_facts(kind, thing_tags(kind, way.tags), "")
    if kind is RoadsideKind.BUS_STOP:
        # Of a platform's outline or line only the middle is kept.
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))[None, :]
        nearest = int(np.argmin(hypot(*(points - middle).T)))
        points, ids = middle, ids[nearest : nearest + 1]
    things.append(RoadsideThing(kind, f"way/{way.id}", points, ids, facts))


def node_keys(furniture: bool, extra: AbstractSet[str]) -> tuple[frozenset[str], frozenset[str]]:
    """Return the keys of which a node must have one to be read, and further keys that are kept.

    `furniture` says whether anything but turning circles, signals, heights and places where people cross is needed;
    `extra` are kinds of things read on request: ``lamps``, ``trees``.
    """
    if not furniture:
        return _NODE_KEYS, _CROSSED
    keys, details = _NODE_KEYS | _FURNITURE_NODE_KEYS, _NODE_DETAILS
    if "trees" in extra:
        keys, details = keys | {"natural"}, details | _TREE_DETAILS
    if "lamps" in extra:
        details |= _LAMP_DETAILS
    return keys, details


def way_values(streets: AbstractSet[str], extra: AbstractSet[str]) -> dict[str, frozenset[str]]:
    """Return the values by key of which a way must have one to be read.

    `streets` are the values of ``highway`` of ways that become streets; `extra` as of `node_keys`.
    """
    values = {
        "highway": FOOT_HIGHWAYS - streets,
        "barrier": frozenset(_BARRIERS),
        "railway": frozenset({"tram"}),
        "public_transport": frozenset({"platform"}),
        **{key: frozenset({value}) for key, value in _ISLANDS.items()},
    }
    for key, more in kerb_values().items():
        values[key] = values.get(key, frozenset()) | more
    if "trees" in extra:
        values["natural"] = frozenset({"tree_row"})
    return values


def kerb_values() -> dict[str, frozenset[str]]:
    """Return the values by key of which a way must have one to be a kerb or the area of a carriageway."""
    return {"barrier": frozenset({"kerb"}), "kerb": _KERBS, "area:highway": _CARRIAGEWAYS}


def is_kerb(tags: Mapping[str, str]) -> bool:
    """Whether a way is the line of a kerb."""
    return "highway" not in tags and (tags.get("barrier") == "kerb" or tags.get("kerb") in _KERBS)


def is_carriageway_area(tags: Mapping[str, str]) -> bool:
    """Whether a closed way is the outline of a carriageway."""
    return "highway" not in tags and tags.get("area:highway") in _CARRIAGEWAYS


def is_building(tags: Mapping[str, str]) -> bool:
    """Whether a way is the outline of a building."""
    return tags.get("building", "no") != "no" and "highway" not in tags


def is_footway(tags: Mapping[str, str]) -> bool:
    """Whether a way is for walking or cycling, and neither a trodden path nor a square."""
    highway = tags.get("highway")
    if highway not in FOOT_HIGHWAYS or tags.get("area") == "yes":
        return False
    if highway != "path":
        return True
    return not _BUILT_PATH.isdisjoint(tags) or "designated" in (tags.get("foot"), tags.get("bicycle"))


def is_crossing(tags: Mapping[str, str]) -> bool:
    """Whether a footway crosses a street (OSM wiki, Tag:footway=crossing and the like)."""
    return "crossing" in (tags.get("footway"), tags.get("path"), tags.get("cycleway"))


def kind_of_way(tags: Mapping[str, str]) -> RoadsideKind | None:
    """Return the kind of thing that a way beside the road is, None for others."""
    if tags.get("railway") == "tram":
        return RoadsideKind.TRAM_TRACK
    if tags.get("public_transport") == "platform" and _for_buses(tags):
        return RoadsideKind.BUS_STOP
    if tags.get("natural") == "tree_row":
        return RoadsideKind.TREE
    if "highway" not in tags and any(tags.get(key) == value for key, value in _ISLANDS.items()):
        return RoadsideKind.ISLAND
    return _BARRIERS.get(tags.get("barrier", ""))


def kind_of_node(tags: Mapping[str, str], extra: AbstractSet[str]) -> RoadsideKind | None:
    """Return the kind of thing that a node beside the road is, None for others and those not requested."""
    highway = tags.get("highway", "")
    if highway == "traffic_signals":
        return RoadsideKind.TRAFFIC_SIGNALS
    if highway in ("stop", "give_way") or any(key in tags for key in SIGN_KEYS):
        return RoadsideKind.TRAFFIC_SIGN
    if highway == "bus_stop" or (tags.get("public_transport") == "platform" and _for_buses(tags)):
        return RoadsideKind.BUS_STOP
    if highway == "street_lamp":
        return RoadsideKind.STREET_LAMP if "lamps" in extra else None
    if tags.get("natural") == "tree":
        return RoadsideKind.TREE if "trees" in extra else None
    barrier = tags.get("barrier", "")
    return _BARRIERS[barrier] if barrier in _BARRIER_NODES else None


def is_thing(tags: Mapping[str, str], extra: AbstractSet[str]) -> bool:
    """Whether a node that does not lie on a street is a thing beside it."""
    return kind_of_node(tags, extra) is not None


def _for_buses(tags: Mapping[str, str]) -> bool:
    if "yes" in (tags.get("bus"), tags.get("trolleybus")):
        return True
    return tags.get("railway") is None and all(tags.get(mode, "no") == "no" for mode in _RAIL_MODES)


def thing_tags(kind: RoadsideKind, tags: Mapping[str, str]) -> dict[str, str]:
    """Return the tags that are kept of a kind of thing."""
    return {key: value for key, value in sorted(tags.items()) if key in _DETAILS[kind]}


def footway_tags(tags: Mapping[str, str]) -> dict[str, str]:
    """Return the tags that are kept of a footway."""
    return {key: value for key, value in sorted(tags.items()) if key in _FOOTWAY_DETAILS}


def street_node_tags(tags: Mapping[str, str]) -> dict[str, str]:
    """Return the tags of a node on a street, without names that nothing shows."""
    named = tags.get("highway") == "bus_stop" or any(key in tags for key in _NAMED)
    return {key: value for key, value in sorted(tags.items()) if key != "name" or named}
