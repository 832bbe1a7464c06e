"""The steps of stage 1 in order: file, ways, nodes, frame, side of the road, tags, streets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr import projection
from osm2xodr.conventions import find_country
from osm2xodr.defaults import LATITUDE_MAX_DEG
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import EmptyAreaError, InputError
from osm2xodr.model import FloatArray, Footway, IntArray, LocalFrame, RoadsideThing, Rule, StreetNetwork
from osm2xodr.osmParsing.file import RawNodes, RawWay, open_osm_file, read_nodes
from osm2xodr.osmParsing.network import (
    cut_at_shared_nodes,
    cut_gaps,
    find_place,
    join_same_places,
    make_lines,
    make_streets,
    read_connectivities,
    read_restrictions,
    tags_on_streets,
)
from osm2xodr.osmParsing.options import ParseOptions
from osm2xodr.osmParsing.roadside import attach_footways, is_thing, node_keys, read_beside, sample_streets
from osm2xodr.osmParsing.selection import nothing_to_drive_on, read_chosen_ways, tell_unused_nodes
from osm2xodr.osmParsing.tags import (
    is_transition,
    oneway,
    turning_places,
    way_attributes,
    with_urban_speeds,
    without_margins,
)

# How far from the origin the local frame is true to 1 part in 8 000, m: (x / 6371 km)² / 2 of a transverse Mercator.
_FRAME_REACH: Final = 100e3
# How far an area may reach in longitude, degrees: PROJ's transverse Mercator ends 80 degrees from its meridian.
_LONGITUDE_SPAN_MAX_DEG: Final = 160.0


def parse(path: Path, options: ParseOptions, diagnostics: Diagnostics) -> StreetNetwork:
    """Do what `osm2xodr.osmParsing.parse_osm` says."""
    file = open_osm_file(path)
    extra = options.extra_objects if options.furniture else frozenset()
    ways, beside, relations, asked = read_chosen_ways(file, options, extra, diagnostics)
    if not ways:
        raise EmptyAreaError(nothing_to_drive_on(file, asked, options))
    keys, details = node_keys(options.furniture, extra)
    refs = np.unique(np.concatenate([way.refs for way in (*ways, *beside)]))
    nodes = read_nodes(file, refs, keys, details, partial(is_thing, extra=extra) if options.furniture else None)
    lines = make_lines(ways, nodes, diagnostics)
    if not len(lines.node):
        raise InputError(f"{path} has ways but not the nodes that they are made of; export the area with its nodes")
    frame, points = _local(path, nodes, np.unique(lines.node), options.frame, diagnostics)
    lines, same_node = join_same_places(lines, points, nodes, diagnostics)
    lines = cut_gaps(lines, points, ways, diagnostics)
    pieces = cut_at_shared_nodes(lines, points, ways, diagnostics)
    if not len(pieces.first):
        raise EmptyAreaError(f"{path} has no way of any length to drive on; check the area that it covers")
    carried = [ways[index] for index in np.unique(pieces.way).tolist()]
    country, rule = _side(frame, carried, options, diagnostics)
    usual = find_country(country)
    attributes, directions = way_attributes(ways, rule, options.default_lane_width, diagnostics, usual)
    if not options.furniture:
        attributes = [without_margins(item) for item in attributes]
    transitions = frozenset(way.id for way in carried if is_transition(way.tags))
    streets, intersections = make_streets(pieces, nodes, points, attributes, directions, transitions)
    rows = np.unique(np.concatenate([street.node_ids for street in streets]))
    tags = {way.id: way.tags for way in ways}
    node_tags = tags_on_streets(rows, nodes, same_node)
    tell_unused_nodes(node_tags, diagnostics)
    footways: tuple[Footway, ...] = ()
    roadside: tuple[RoadsideThing, ...] = ()
    if options.furniture:
        samples = sample_streets(streets)
        footways, roadside = read_beside(beside, nodes, points, samples, rows, extra)
        streets = attach_footways(streets, samples, footways, tags, diagnostics)
    streets = with_urban_speeds(streets, tags, usual, diagnostics)
    return StreetNetwork(
        frame=frame,
        rule=rule,
        country=country,
        streets=streets,
        intersections=intersections,
        restrictions=read_restrictions(relations, carried, same_node, diagnostics),
        node_tags=node_tags,
        bounds_deg=_bounds(nodes, np.searchsorted(nodes.ids, rows)),
        connectivities=read_connectivities(relations, carried, same_node, diagnostics),
        footways=footways,
        roadside=roadside,
        turning_places=turning_places(node_tags),
    )


def _local(
    path: Path, nodes: RawNodes, carried: IntArray, given: LocalFrame | None, diagnostics: Diagnostics
) -> tuple[LocalFrame, FloatArray]:
    """Make the frame in the middle of the carried nodes, if none is given, and project all nodes."""
    west, south, east, north = _bounds(nodes, carried)
    if max(abs(south), abs(north)) > LATITUDE_MAX_DEG:
        raise InputError(
            f"{path} reaches to latitude {max(south, north, key=abs):.2f}, but the local projection is of use up to "
            f"{LATITUDE_MAX_DEG:g} degrees; choose an area off the poles"
        )
    if east - west > _LONGITUDE_SPAN_MAX_DEG:
        far = int(nodes.ids[_farthest(nodes, carried)])
        raise InputError(
            f"{path} reaches over {east - west:.0f} degrees of longitude, but the local projection is of use over "
            f"{_LONGITUDE_SPAN_MAX_DEG:g}; choose a smaller area, without node/{far}"
        )
    lon = (west + east) / 2.0
    middle = lon - 360.0 if lon > 180.0 else lon
    frame = given or projection.make_frame((south + north) / 2.0, middle)
    x, y = projection.to_local(frame, nodes.lon_deg, nodes.lat_deg)
    reach = float(np.hypot(x[carried], y[carried]).max())
    if not np.isfinite(reach):
        raise InputError(
            f"{path} reaches to the other side of the Earth from the origin at {frame.lat_0_deg:g}, "
            f"{frame.lon_0_deg:g}; give an origin near it"
        )
    if reach > _FRAME_REACH:
        diagnostics.note(
            "extent", "", f"roads lie up to {reach / 1e3:.0f} km from the origin, where lengths are no longer exact"
        )
    return frame, np.column_stack([x, y])


def _farthest(nodes: RawNodes, chosen: IntArray) -> int:
    """Return the index of the node that lies farthest from most others in longitude."""
    lon = np.radians(nodes.lon_deg[chosen])
    # The middle of a map is where most of its nodes are, whichever side of the 180th meridian.
    middle = np.arctan2(np.median(np.sin(lon)), np.median(np.cos(lon)))
    return int(chosen[np.argmin(np.cos(lon - middle))])


def _bounds(nodes: RawNodes, chosen: IntArray) -> tuple[float, float, float, float]:
    """Return west, south, east, north of nodes as `osm2xodr.projection.bounds_deg` does."""
    return projection.bounds_deg(nodes.lon_deg[chosen], nodes.lat_deg[chosen])


def _side(
    frame: LocalFrame, ways: Sequence[RawWay], options: ParseOptions, diagnostics: Diagnostics
) -> tuple[str, Rule]:
    """Find the country, and the side of the road: as asked for, else as most streets are tagged, else the country's.

    ``driving_side`` on single ways marks exceptions (OSM wiki, Key:driving_side), so it speaks for all streets only
    where most of the two-way ones have it.
    """
    place = find_place(frame.lat_0_deg, frame.lon_0_deg)
    rules = {"left": Rule.LEFT_HAND, "right": Rule.RIGHT_HAND}
    tagged = [(way, rules[side]) for way in ways if (side := way.tags.get("driving_side", "")) in rules]
    two_way = sum(oneway(way.tags)[0] == 0 for way in ways) if tagged else 0
    most, number = Counter(rule for _, rule in tagged).most_common(1)[0] if tagged else (Rule.RIGHT_HAND, 0)
    if options.rule is not None:
        rule = options.rule
    elif 2 * number > two_way:
        rule = most
    elif place.drives_left is not None:
        rule = Rule.LEFT_HAND if place.drives_left else Rule.RIGHT_HAND
        if not place.country:
            diagnostics.guessed("driving-side", "", f"out at sea, {_hand(rule)} traffic as in the nearest country")
    else:
        rule = Rule.RIGHT_HAND
        diagnostics.guessed("driving-side", "", "no country is near, right-hand traffic assumed")
    for way, other in tagged:
        if other is not rule:
            words = (
                f"{_hand(other)} traffic on this way only is not kept, it gets {_hand(rule)} traffic as all others"
            )
            diagnostics.dropped("driving-side", f"way/{way.id}", words)
    return place.country, rule


def _hand(rule: Rule) -> str:
    return "left-hand" if rule is Rule.LEFT_HAND else "right-hand"
