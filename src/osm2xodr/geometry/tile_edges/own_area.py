"""Cut off the surroundings of an area, so that it fits together with the areas beside it; furniture as well."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import takewhile
from math import ceil, floor
from typing import Any, Final, TypeAlias

import numpy as np

from osm2xodr.curves import cubic_value, cut_curves, lengths, part_of_cubics, part_of_profile, pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.roadside import has_width
from osm2xodr.geometry.tile_edges.pieces import Piece, Pieces, check_ids
from osm2xodr.geometry.tile_edges.report import kept_report, kept_statistics
from osm2xodr.model import (
    BorderEnd,
    Borders,
    Connection,
    Controller,
    CubicProfile,
    Furniture,
    Junction,
    Lane,
    LaneSection,
    ObjectRepeat,
    Partition,
    Road,
    RoadLink,
    RoadMap,
    RoadObject,
    RoadStructure,
    RoadType,
    Signal,
    SignalLink,
    SignalProgramme,
    SignalReference,
)

# Copies lie on a border if they are nearer to it than this share of their distance.
_ON_BORDER: Final = 1e-6

# A lane section or type that reaches beyond a cut by less is left out there, m.
_SHORTEST_REST: Final = 0.01

# What a part of some furniture has other than the whole: values of fields by their names; `road` and `s` always.
_Part: TypeAlias = dict[str, Any]


def kept_furniture(furniture: Furniture, pieces: Pieces, diagnostics: Diagnostics) -> Furniture:
    """Return the furniture on kept pieces of roads, with new ids; raise an InputError if these do not suffice."""
    on_signals, references = _signals(furniture, pieces, diagnostics)
    on_objects = [(item, part) for item in furniture.objects for part in _objects(item, pieces)]
    on_structures = [(item, part) for item in furniture.structures for part in _structures(item, pieces)]
    first = pieces.partition.first_ids[pieces.partition.own]
    count = len(on_signals) + len(on_objects) + len(on_structures)
    check_ids(pieces.partition, count, "signals, objects, bridges and tunnels")
    # The parts of an object still share its id. Signals and objects share one range of ids.
    old = [(item.id, -1, part["s"]) for item, part in on_signals]
    old += [(item.id, part["road"], part["s"]) for item, part in on_objects]
    old += [(item.id, part["road"], part["s"]) for item, part in on_structures]
    number = {key: first + k for k, key in enumerate(sorted(old))}
    signals = [replace(item, id=number[item.id, -1, part["s"]], **part) for item, part in on_signals]
    objects = [replace(item, id=number[item.id, part["road"], part["s"]], **part) for item, part in on_objects]
    structures = [replace(item, id=number[item.id, part["road"], part["s"]], **part) for item, part in on_structures]
    signal_id = {item.id: signal.id for (item, _), signal in zip(on_signals, signals, strict=True)}
    references = [replace(item, signal=signal_id[item.signal]) for item in references]
    controllers = _controllers(furniture.controllers, signal_id, pieces, first)
    return Furniture(
        signals=tuple(sorted(signals, key=_place)),
        references=tuple(sorted(references, key=lambda item: (item.road, item.s, item.signal))),
        controllers=controllers,
        programmes=_programmes(furniture.programmes, pieces),
        objects=tuple(sorted(objects, key=_place)),
        structures=tuple(sorted(structures, key=_place)),
        statistics=_statistics(furniture, signals, controllers, objects),
    )


def _place(item: Signal | RoadObject | RoadStructure) -> tuple[int, float, int]:
    return item.road, item.s, item.id


def _signals(
    furniture: Furniture, pieces: Pieces, diagnostics: Diagnostics
) -> tuple[list[tuple[Signal, _Part]], list[SignalReference]]:
    """Return the signals and references on kept pieces; a kept reference to a lost signal becomes that signal."""
    signals: dict[int, tuple[Signal, _Part]] = {}
    for item in furniture.signals:
        piece = pieces.at(item.road, item.s)
        if piece.id:
            signals[item.id] = item, {"road": piece.id, "s": item.s - piece.begin}
    gone = {item.id: item for item in furniture.signals if item.id not in signals} if furniture.references else {}
    references: list[SignalReference] = []
    for reference in furniture.references:
        piece = pieces.at(reference.road, reference.s)
        if not piece.id:
            continue
        there = replace(reference, road=piece.id, s=reference.s - piece.begin)
        if reference.signal in signals:
            references.append(there)
        elif reference.signal in gone:
            signal = gone[reference.signal]
            as_referred = ("road", "s", "t", "orientation", "validity")
            signals[signal.id] = signal, {name: getattr(there, name) for name in as_referred}
            text = "it stands on a road of a neighbouring area and is moved to where the junction of this area begins"
            diagnostics.repaired("border-signal", signal.osm_id, text)
    return list(signals.values()), references


def _controllers(
    controllers: Iterable[Controller], signal_id: dict[int, int], pieces: Pieces, first: int
) -> tuple[Controller, ...]:
    """Return the controllers that keep any signal; ids count up from `first`."""
    out: list[Controller] = []
    for item in controllers:
        signals = tuple(sorted(signal_id[signal] for signal in item.signals if signal in signal_id))
        if signals:
            named = () if item.junction is None else (item.junction, *item.further_junctions)
            kept = sorted(here for junction in named if (here := pieces.junction(junction)) is not None)
            junction, further = (kept[0], tuple(kept[1:])) if kept else (None, ())
            out.append(
                replace(item, id=first + len(out), signals=signals, junction=junction, further_junctions=further)
            )
    return tuple(out)


def _programmes(programmes: Iterable[SignalProgramme], pieces: Pieces) -> tuple[SignalProgramme, ...]:
    """Return the programmes of kept junctions; the pieces of roads that touch these are kept as well."""

    def here(link: SignalLink) -> SignalLink:
        road, exit_road = pieces.of(link.road), pieces.of(link.exit_road)
        return replace(
            link,
            connecting_road=pieces.of(link.connecting_road)[0].id,
            road=road[-1 if link.at_end else 0].id,
            exit_road=exit_road[0 if link.exit_at_start else -1].id,
        )

    kept = ((pieces.junction(item.junction), item) for item in programmes)
    return tuple(
        replace(item, junction=junction, links=tuple(map(here, item.links)))
        for junction, item in kept
        if junction is not None
    )


def _objects(thing: RoadObject, pieces: Pieces) -> list[_Part]:
    """Return the parts of an object on kept pieces: all or nothing of it, unless it repeats along its road."""
    if thing.repeat is None:
        piece = pieces.at(thing.road, thing.s)
        return [{"road": piece.id, "s": thing.s - piece.begin}] if piece.id else []
    found = (_part(thing, thing.repeat, piece) for piece in pieces.of(thing.road) if piece.id)
    return [part for part in found if part is not None]


def _structures(item: RoadStructure, pieces: Pieces) -> list[_Part]:
    """Return the parts of a bridge or tunnel on kept pieces of its road."""
    parts = (
        (piece, max(item.s, piece.begin), min(item.s + item.length, piece.end)) for piece in pieces.of(item.road)
    )
    return [
        {"road": piece.id, "s": begin - piece.begin, "length": end - begin}
        for piece, begin, end in parts
        if piece.id and end > begin
    ]


def _part(thing: RoadObject, repeat: ObjectRepeat, piece: Piece) -> _Part | None:
    """Return the part on a piece of a road of an object that repeats along it; None if nothing of it lies there."""
    begin = 0.0 if piece.at_start else max(piece.begin - repeat.s, 0.0)
    ends_there = piece.at_end or piece.end > repeat.s + repeat.length
    end = repeat.length if ends_there else piece.end - repeat.s
    if begin == 0.0 and ends_there:
        there = repeat if piece.at_start else replace(repeat, s=repeat.s - piece.begin)
        return {"road": piece.id, "s": thing.s - piece.begin, "repeat": there}
    if repeat.distance > 0.0:
        # From the first copy on the piece to half-way beyond the last one, or to the object's end.
        rank = ceil(begin / repeat.distance - _ON_BORDER)
        copies = ceil(end / repeat.distance - _ON_BORDER) - rank
        if ends_there:
            copies = floor(end / repeat.distance + _ON_BORDER) + 1 - rank
        if copies <= 0:
            return None
        begin = rank * repeat.distance
        end = max(min(end, begin + (copies - 0.5) * repeat.distance), begin)
    if end < begin or (end == begin and not repeat.distance):
        return None
    t_start, t_end = (
        repeat.t_start + (repeat.t_end - repeat.t_start) * at / repeat.length if repeat.length else repeat.t_start
        for at in (begin, end)
    )
    s = max(repeat.s + begin - piece.begin, 0.0)
    part = replace(repeat, s=s, length=end - begin, t_start=t_start, t_end=t_end)
    length = end - begin if thing.length == repeat.length else thing.length
    return {"road": piece.id, "s": s, "t": t_start, "length": length, "repeat": part}


def _statistics(
    furniture: Furniture, signals: list[Signal], controllers: tuple[Controller, ...], objects: list[RoadObject]
) -> dict[str, float]:
    """Return the figures of the whole, counted again."""
    # The two crosswalks beside an island are one crossing.
    crossings = {(item.road, item.s, item.osm_id) for item in objects if item.type == "crosswalk"}
    counted = {
        "traffic_lights": sum(item.dynamic for item in signals),
        "signs": sum(not item.dynamic and not item.derived for item in signals),
        "derived_signs": sum(item.derived for item in signals),
        "controllers": len(controllers),
        "crossings": len(crossings),
        "objects": len(objects),
    }
    return {name: float(count) for name, count in counted.items() if name in furniture.statistics}


def keep_own_area(road_map: RoadMap, diagnostics: Diagnostics, own: int | None = None) -> RoadMap:
    """Return the area that a conversion is for, without its surroundings.

    Each piece of a road that belongs to it becomes a road, without a link where its area ends. Lines, arcs and cubics
    keep their values, so the halves of a road that is cut between two areas meet, up to rounding. Roads, connecting
    roads and junctions get ids from the area's first id on, in this order; so do signals and objects; so do
    controllers.

    Parameters
    ----------
    road_map
        Areas and their surroundings, with `RoadMap.borders` and all furniture. One without borders is returned as is.
    diagnostics
        Receives what had to be changed.
    own
        Index of the area, where it is another one than that of the partition: one of the same block.

    Raises
    ------
    InputError
        If no road belongs to the area, or it has more roads, junctions, signals and objects than ids for them.
    """
    if road_map.borders is None:
        return road_map
    borders = road_map.borders
    if own is not None:
        borders = replace(borders, partition=replace(borders.partition, own=own))
    pieces = Pieces(road_map, borders)
    cut = _cut(road_map, pieces, diagnostics)
    ends = _border_ends(road_map, cut, pieces)
    return replace(cut, statistics=kept_statistics(cut, road_map.statistics), border_ends=ends)


def cut_at_names(road_map: RoadMap, diagnostics: Diagnostics) -> RoadMap:
    """Return an area by itself with its roads cut where their names change; lines and cubics keep their values."""
    outside = sum(road.junction is None for road in road_map.roads)
    if not any(road.names for road in road_map.roads[:outside]):
        return road_map
    nothing = np.zeros(outside, np.int64)
    borders = Borders(
        Partition(road_map.frame, ("",), (), (1,), 0),
        *(np.arange(outside + 1), np.zeros(outside), nothing, np.zeros(len(road_map.junctions), np.int64)),
    )
    return _cut(road_map, Pieces(road_map, borders), diagnostics)


def _cut(road_map: RoadMap, pieces: Pieces, diagnostics: Diagnostics) -> RoadMap:
    """Return the pieces of the own area as a road map."""
    begin, end = np.array([(piece.begin, piece.end) for piece in pieces.kept]).T.copy()
    curve = np.array([piece.curve for piece in pieces.kept], np.int64)

    def part(profile: CubicProfile) -> CubicProfile:
        return part_of_profile(profile, curve, begin, end)

    return replace(
        road_map,
        roads=kept_roads(road_map, pieces),
        junctions=kept_junctions(road_map, pieces),
        plan_view=cut_curves(road_map.plan_view, begin, end, curve),
        elevation=part(road_map.elevation),
        superelevation=part(road_map.superelevation),
        lane_offset=part(road_map.lane_offset),
        elevation_report=kept_report(road_map, pieces),
        places=None,
        furniture=kept_furniture(road_map.furniture, pieces, diagnostics),
        borders=None,
    )


def _border_ends(road_map: RoadMap, cut: RoadMap, pieces: Pieces) -> tuple[BorderEnd, ...]:
    """Return where the roads of the own area continue in others, in the order of roads."""
    found: list[tuple[int, bool, int]] = []
    for k, piece in enumerate(pieces.kept):
        for at_start in (True, False):
            area = _beyond(road_map, piece, pieces, at_start=at_start)
            if area is not None:
                found.append((k, at_start, area))
    row = np.array([k for k, _, _ in found], np.int64)
    s = np.where([at_start for _, at_start, _ in found], 0.0, lengths(cut.plan_view, row))
    along_x, along_y, along_hdg = pose(cut.plan_view, row, s)
    columns = (along_x, along_y, cubic_value(cut.elevation, row, s), along_hdg)
    places = zip(*(column.tolist() for column in columns), strict=True)
    names = pieces.partition.names
    return tuple(
        BorderEnd(cut.roads[k].id, at_start, names[area] if area >= 0 else "", x, y, z, hdg, cut.roads[k].osm_way_ids)
        for (k, at_start, area), (x, y, z, hdg) in zip(found, places, strict=True)
    )


def _beyond(road_map: RoadMap, piece: Piece, pieces: Pieces, *, at_start: bool) -> int | None:
    """Return the area in which a piece continues at one of its ends, None where it does not leave the own one."""
    other = pieces.beside(piece, at_start=at_start)
    if other is not None:
        # Where its name changes, a road goes on in its own area.
        return None if other.id else other.area
    road = road_map.roads[piece.curve]
    link = road.predecessor if at_start else road.successor
    if link is None or link.to_junction or link_beyond(road, piece, pieces, at_start=at_start) is not None:
        return None
    return pieces.touched(link).area


def kept_roads(road_map: RoadMap, pieces: Pieces) -> tuple[Road, ...]:
    """Return the pieces of the own area as roads, in their order."""
    return tuple(_road(road_map.roads[piece.curve], piece, pieces) for piece in pieces.kept)


def kept_junctions(road_map: RoadMap, pieces: Pieces) -> tuple[Junction, ...]:
    """Return the junctions of the own area, in their order; `Borders` keeps the roads that touch them with them."""
    return tuple(
        replace(
            junction,
            id=number,
            connections=tuple(_connection(item, road_map, pieces) for item in junction.connections),
            priorities=tuple((pieces.first(high), pieces.first(low)) for high, low in junction.priorities),
        )
        for junction in road_map.junctions
        if (number := pieces.junction(junction.id)) is not None
    )


def link_beyond(road: Road, piece: Piece, pieces: Pieces, *, at_start: bool) -> RoadLink | None:
    """Return the link of a kept piece of a road at one of its ends, with new ids; None at the end of the area."""
    if not (piece.at_start if at_start else piece.at_end):
        beside = pieces.beside(piece, at_start=at_start)
        return RoadLink(False, beside.id, not at_start) if beside is not None and beside.id else None
    link = road.predecessor if at_start else road.successor
    return None if link is None else pieces.link(link)


def _connection(item: Connection, road_map: RoadMap, pieces: Pieces) -> Connection:
    """Return a connection with new ids. Both ends of a road may touch a junction: the connecting road knows which."""
    through = pieces.of(item.connecting_road)[0]
    link = road_map.roads[through.curve].predecessor
    incoming = pieces.first(item.incoming_road) if link is None or link.to_junction else pieces.touched(link).id
    if not incoming:
        raise ValueError(f"road {item.incoming_road} and the junction that it touches belong to different areas")
    return Connection(item.id, incoming, through.id, item.lane_links)


def _road(road: Road, piece: Piece, pieces: Pieces) -> Road:
    before = link_beyond(road, piece, pieces, at_start=True)
    after = link_beyond(road, piece, pieces, at_start=False)
    types, sections = road.types, road.lane_sections
    if not (piece.at_start and piece.at_end):
        types, sections = _types(types, piece), _sections(sections, piece)
        if before is not None and not piece.at_start:
            sections = (_linked(sections[0], road, piece.begin, at_start=True), *sections[1:])
        if after is not None and not piece.at_end:
            sections = (*sections[:-1], _linked(sections[-1], road, piece.end, at_start=False))
    if before is None and not (piece.at_start and road.predecessor is None):
        sections = (_unlinked(sections[0], at_start=True), *sections[1:])
    if after is None and not (piece.at_end and road.successor is None):
        sections = (*sections[:-1], _unlinked(sections[-1], at_start=False))
    middle = 0.5 * (piece.begin + piece.end)
    named = max((item for item in road.names if item.s <= middle), key=lambda item: item.s) if road.names else road
    junction = None if road.junction is None else pieces.junction(road.junction)
    return Road(piece.id, named.name, junction, before, after, types, sections, named.osm_way_ids, named.guesses)


def _overlapping(starts: Sequence[float], piece: Piece) -> range:
    """Return the indices of the records that lie on a piece, given where along its road each begins, m."""
    last = max((k for k, s in enumerate(starts) if piece.at_end or s < piece.end - _SHORTEST_REST), default=0)
    first = max((k for k, s in enumerate(starts[: last + 1]) if s <= piece.begin + _SHORTEST_REST), default=0)
    return range(0 if piece.at_start else first, last + 1)


def _types(types: tuple[RoadType, ...], piece: Piece) -> tuple[RoadType, ...]:
    kept, begin = _overlapping([item.s for item in types], piece) if types else range(0), piece.begin
    return tuple(replace(types[k], s=0.0 if k == kept[0] and begin else types[k].s - begin) for k in kept)


def _sections(sections: tuple[LaneSection, ...], piece: Piece) -> tuple[LaneSection, ...]:
    starts = [section.s for section in sections]
    kept = _overlapping(starts, piece)
    out: list[LaneSection] = []
    for k in kept:
        begin = piece.begin if k == kept[0] and piece.begin else starts[k]
        stop = starts[k + 1] if k + 1 < len(starts) else piece.end
        end = piece.end if k == kept[-1] and not piece.at_end else stop
        lanes = sections[k].lanes
        if begin != starts[k] or end != stop or not (piece.at_end or k + 1 < len(starts)):
            lanes = tuple(
                replace(lane, widths=part_of_cubics(lane.widths, begin - starts[k], end - starts[k]))
                for lane in lanes
            )
        out.append(LaneSection(begin - piece.begin, lanes))
    return tuple(out)


def _linked(section: LaneSection, road: Road, cut: float, *, at_start: bool) -> LaneSection:
    """Return a section whose lanes go on beyond a cut: where sections meet as these do, else all that are there."""
    if any(abs(item.s - cut) <= _SHORTEST_REST for item in road.lane_sections):
        return section
    whole = max((item for item in road.lane_sections if item.s < cut), key=lambda item: item.s)
    there = {lane.id for lane in whole.lanes if lane.id and has_width(lane.widths, cut - whole.s)}
    lanes = ((lane, lane.id if lane.id in there else None) for lane in section.lanes)
    return LaneSection(
        section.s,
        tuple(
            replace(lane, predecessor=beyond) if at_start else replace(lane, successor=beyond)
            for lane, beyond in lanes
        ),
    )


def _unlinked(section: LaneSection, *, at_start: bool) -> LaneSection:
    """Return a section at a cut: without links beyond it, and without outermost lanes that have no width left."""
    lanes = tuple(
        replace(lane, predecessor=None) if at_start else replace(lane, successor=None) for lane in section.lanes
    )
    gone = {lane.id for order in (lanes, lanes[::-1]) for lane in takewhile(_is_nothing, order)}
    return LaneSection(section.s, tuple(lane for lane in lanes if lane.id not in gone))


def _is_nothing(lane: Lane) -> bool:
    """Say whether a lane has no width anywhere, and no link."""
    wide = any(item.a or item.b or item.c or item.d for item in lane.widths)
    return lane.id != 0 and not wide and lane.predecessor is None and lane.successor is None
