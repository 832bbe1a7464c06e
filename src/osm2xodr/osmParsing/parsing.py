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
from osm2xodr.curves import (
    arctan2,
    cosine,
    hypot,
    runs,
    sine,
    sorted_unique,
)
from osm2xodr.defaults import LATITUDE_MAX_DEG
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import EmptyAreaError, InputError
from osm2xodr.model import FloatArray, Footway, IntArray, LocalFrame, RoadsideThing, Rule, StreetNetwork
from osm2xodr.osmParsing.corrections import correct_nodes
from osm2xodr.osmParsing.defaults import BUILT_UP_CROSSING_SPACING, BUILT_UP_DENSITY, BUILT_UP_STREET_DENSITY
from osm2xodr.osmParsing.file import OsmFile, RawNodes, RawWay, open_osm_file, read_nodes
from osm2xodr.osmParsing.network import (
    Pieces,
    cut_at_shared_nodes,
    cut_gaps,
    find_place,
    join_same_places,
    leave_out_crowds,
    leave_out_far_nodes,
    make_lines,
    make_streets,
    most_met,
    read_connectivities,
    read_restrictions,
    report_head_on,
    sparse_streets,
    tags_on_streets,
    with_default_speeds,
    with_one_flow,
)
from osm2xodr.osmParsing.options import ParseOptions
from osm2xodr.osmParsing.roadside import (
    WayPieces,
    attach_footways,
    crossing_densities,
    is_thing,
    kerbs_along,
    node_keys,
    read_beside,
    sample_streets,
    street_densities,
    street_facts,
    with_guessed_parking,
    with_guessed_shoulders,
    with_guessed_sidewalks,
)
from osm2xodr.osmParsing.selection import read_selected_ways, report_file, report_unused_nodes, why_no_streets
from osm2xodr.osmParsing.tags import (
    is_transition,
    node_heights,
    oneway,
    read_node_facts,
    turning_circles,
    way_attributes,
    with_speed_zones,
    with_urban_speeds,
    without_margins,
)
from osm2xodr.system import release_memory

# Up to this distance from the origin, m, lengths in the local frame are true to 1 part in 8 000: (x / 6371 km)² / 2
# of a transverse Mercator.
_FRAME_REACH: Final = 100e3
# Largest extent of an area in longitude, degrees: PROJ's transverse Mercator ends 80 degrees from its meridian.
_LONGITUDE_SPAN_MAX_DEG: Final = 160.0
# Most streets that may meet at a node; in 24 extracts up to 8 do. The ways between them grow with the square.
_ARMS_MAX: Final = 32


def parse_osm(path: Path, options: ParseOptions, diagnostics: Diagnostics) -> StreetNetwork:
    """Read the streets of an OSM file.

    Parameters
    ----------
    path
        An OSM file: .osm, .osm.pbf, or packed (gzip, bzip2, xz, zip, zstd), recognised by its content.
    options, diagnostics
        What to read of it; what gets the guesses, losses and repairs.

    Raises
    ------
    InputError
        The file cannot be read, is not OSM data, or has no way that cars may drive on.
    """
    network = _parse(path, options, diagnostics)
    # Reading takes many times the memory of the network.
    release_memory()
    return network


def _parse(path: Path, options: ParseOptions, diagnostics: Diagnostics) -> StreetNetwork:
    file = open_osm_file(path)
    file.require_whole(options.allow_partial)
    extra = options.extra_objects if options.furniture else frozenset()
    ways, beside, relations, asked = read_selected_ways(file, options, extra, diagnostics)
    if not ways:
        raise EmptyAreaError(why_no_streets(file, asked, options))
    ways = with_one_flow(ways, diagnostics)
    corrections = options.corrections
    nodes = correct_nodes(_read_nodes(file, [*ways, *beside], options.furniture, extra), corrections, diagnostics)
    report_file(file, diagnostics)
    frame, points, pieces, same_node = _cut_ways(path, ways, nodes, options.frame, diagnostics)
    carried = [ways[index] for index in sorted_unique(pieces.way).tolist()]
    code, rule = _country_and_rule(frame, carried, options, diagnostics)
    country = find_country(code)
    by_piece = _by_piece(pieces, points)
    dense = _built_up(ways, by_piece, nodes)
    known = {way for way, item in corrections.ways.items() if item.width is not None}
    kerbs = kerbs_along(ways, by_piece, beside, nodes, points, known)
    facts = street_facts(ways, by_piece, kerbs)
    if options.furniture and options.guessed_parking:
        facts = with_guessed_parking(facts, ways, by_piece, beside, nodes, points, dense)
    width, speeds = options.default_lane_width, options.default_speeds
    attributes, directions = way_attributes(
        *(ways, rule, width, diagnostics, country),
        default_speeds=speeds,
        dense=dense,
        corrections=corrections.ways,
        facts=facts,
    )
    if not options.furniture:
        attributes = [without_margins(item) for item in attributes]
    attributes = with_speed_zones(attributes, code)
    transitions = frozenset(way.id for way in carried if is_transition(way.tags))
    restrictions = read_restrictions(relations, carried, same_node, diagnostics)
    streets, intersections = make_streets(pieces, nodes, points, attributes, directions, transitions, restrictions)
    report_head_on(streets, intersections, diagnostics)
    ids = sorted_unique(np.concatenate([street.node_ids for street in streets]))
    on_streets = np.searchsorted(nodes.ids, ids)
    tags = {way.id: way.tags for way in ways}
    node_tags = tags_on_streets(ids, nodes, same_node)
    report_unused_nodes(node_tags, diagnostics)
    footways: tuple[Footway, ...] = ()
    roadside: tuple[RoadsideThing, ...] = ()
    if options.furniture:
        samples = sample_streets(streets)
        footways, roadside = read_beside(beside, nodes, points, samples, ids, extra, code)
        streets = attach_footways(streets, samples, footways, tags, diagnostics)
    if options.default_speeds:
        streets = with_urban_speeds(streets, tags, country, diagnostics)
        streets = with_default_speeds(streets, tags, dense, country, diagnostics)
    if options.furniture and options.guessed_sidewalks:
        # Last, as a sidewalk is evidence of a built-up area where it is tagged.
        streets = with_guessed_sidewalks(streets, samples.lines, footways, tags, dense, diagnostics)
    if options.furniture and options.guessed_shoulders:
        streets = with_guessed_shoulders(streets, tags, rule, diagnostics)
    return StreetNetwork(
        frame=frame,
        rule=rule,
        country=code,
        streets=streets,
        intersections=intersections,
        restrictions=restrictions,
        node_tags=node_tags,
        bounds_deg=projection.bounds_deg(nodes.lon_deg[on_streets], nodes.lat_deg[on_streets]),
        connectivities=read_connectivities(relations, carried, same_node, diagnostics),
        footways=footways,
        roadside=roadside,
        node_facts=read_node_facts(node_tags, footways, code),
        node_heights=node_heights(node_tags, diagnostics),
        turning_circles=turning_circles(node_tags),
        corrections=corrections,
    )


def _by_piece(pieces: Pieces, points: FloatArray) -> WayPieces:
    """Return the nodes of each piece of a way; `points` (n, 2) are those of all nodes, m."""
    counts = pieces.last - pieces.first + 1
    nodes = pieces.node[runs(pieces.first, counts)]
    return WayPieces(points[nodes], nodes, counts, pieces.way)


def _built_up(ways: Sequence[RawWay], pieces: WayPieces, nodes: RawNodes) -> set[int]:
    """Return the ids of the ways among residential, or among many, streets, and of those that people often cross."""
    highways = [way.tags["highway"] for way in ways]
    dwellings, streets = street_densities(pieces.points, pieces.count, pieces.way, highways)
    dense = (dwellings >= BUILT_UP_DENSITY) | (streets >= BUILT_UP_STREET_DENSITY)
    crossings = crossing_densities(pieces, len(ways), nodes.ids, nodes.tags)
    dense |= crossings >= 1.0 / BUILT_UP_CROSSING_SPACING
    return {ways[index].id for index in np.flatnonzero(dense).tolist()}


def _read_nodes(file: OsmFile, ways: Sequence[RawWay], furniture: bool, extra: frozenset[str]) -> RawNodes:
    """Read the nodes of ways, and those that are things beside streets."""
    keys, details = node_keys(furniture, extra)
    refs = sorted_unique(np.concatenate([way.refs for way in ways]))
    return read_nodes(file, refs, keys, details, partial(is_thing, extra=extra) if furniture else None)


def _cut_ways(
    path: Path, ways: Sequence[RawWay], nodes: RawNodes, frame: LocalFrame | None, diagnostics: Diagnostics
) -> tuple[LocalFrame, FloatArray, Pieces, dict[int, int]]:
    """Return the local frame, x, y of all nodes (n, 2), the pieces of ways, and the ids of joined nodes."""
    lines = make_lines(ways, nodes, diagnostics)
    if not len(lines.node):
        raise InputError(f"{path} has ways but not the nodes that they are made of; export the area with its nodes")
    lines = leave_out_far_nodes(lines, nodes, ways, diagnostics)
    if not len(lines.node):
        raise InputError(f"{path} has no way whose nodes lie near to each other; look for nodes at wrong places")
    frame, points = _local(path, nodes, sorted_unique(lines.node), frame, diagnostics)
    lines, same_node = join_same_places(lines, points, nodes, diagnostics)
    lines = cut_gaps(lines, points, ways, diagnostics)
    pieces = cut_at_shared_nodes(lines, points, ways, diagnostics)
    met, node = most_met(pieces)
    if met > _ARMS_MAX:
        raise InputError(
            f"{path}: {met:,} streets meet at node/{nodes.ids[node]}, and more than {_ARMS_MAX} have no room there;"
            " correct the map"
        )
    found = len(pieces.first)
    pieces = leave_out_crowds(pieces, points, ways, diagnostics)
    if found and not len(pieces.first):
        raise InputError(f"{path}: all streets lie on each other, as on way/{ways[lines.way[0]].id}; correct the map")
    if not found:
        raise EmptyAreaError(f"{path} has no way of any length to drive on; check the area that it covers")
    if (sparse := sparse_streets(pieces, nodes)) is not None:
        raise InputError(
            f"{path}: {sparse[0] / 1e3:,.0f} km of streets have far fewer nodes than maps of the ground, as on"
            f" way/{ways[sparse[1]].id}; correct the map, or choose a smaller area"
        )
    return frame, points, pieces, same_node


def _local(
    path: Path, nodes: RawNodes, carried: IntArray, given: LocalFrame | None, diagnostics: Diagnostics
) -> tuple[LocalFrame, FloatArray]:
    """Return the given frame, else one in the middle of the carried nodes (indices), and x, y of all nodes."""
    west, south, east, north = projection.bounds_deg(nodes.lon_deg[carried], nodes.lat_deg[carried])
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
    frame = given or projection.make_frame((south + north) / 2.0, lon - 360.0 if lon > 180.0 else lon)
    x, y = projection.to_local(frame, nodes.lon_deg, nodes.lat_deg)
    reach = float(hypot(x[carried], y[carried]).max())
    if not np.isfinite(reach):
        raise InputError(
            f"{path} reaches to the other side of the Earth from the origin at {frame.lat_0_deg:g}, "
            f"{frame.lon_0_deg:g}; give an origin near it"
        )
    if reach > _FRAME_REACH:
        words = f"roads lie up to {reach / 1e3:.0f} km from the origin, where lengths are no longer exact"
        diagnostics.note("extent", "", words)
    return frame, np.column_stack([x, y])


def _farthest(nodes: RawNodes, chosen: IntArray) -> int:
    """Return the index of the node that lies farthest in longitude from where most nodes are."""
    lon = np.radians(nodes.lon_deg[chosen])
    # The middle of most nodes, on either side of the 180th meridian.
    middle = arctan2(np.median(sine(lon)), np.median(cosine(lon)))
    return int(chosen[np.argmin(cosine(lon - middle))])


def _country_and_rule(
    frame: LocalFrame, ways: Sequence[RawWay], options: ParseOptions, diagnostics: Diagnostics
) -> tuple[str, Rule]:
    """Find the country's code, and the driving side: the option, else that of most streets, else the country's.

    ``driving_side`` on single ways marks exceptions (OSM wiki, Key:driving_side), so it holds for all streets only
    if most of the two-way ones have it.
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
                f"{_hand(other)} traffic on this way only is not kept, it gets {_hand(rule)} traffic like all others"
            )
            diagnostics.dropped("driving-side", f"way/{way.id}", words)
    return place.country, rule


def _hand(rule: Rule) -> str:
    return "left-hand" if rule is Rule.LEFT_HAND else "right-hand"
