"""The signals and objects of an area, without those around it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import ceil, floor
from typing import Final

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.tile_edges.pieces import Piece, Pieces, check_ids
from osm2xodr.model import (
    Controller,
    Furniture,
    ObjectRepeat,
    RoadObject,
    RoadStructure,
    Signal,
    SignalLink,
    SignalProgramme,
    SignalReference,
)

# Copies lie on a border if they are nearer to it than this share of their distance.
_ON_BORDER: Final = 1e-6


def kept_furniture(furniture: Furniture, pieces: Pieces, diagnostics: Diagnostics) -> Furniture:
    """Return the furniture on kept pieces of roads, with new ids; raise an InputError if these do not suffice."""
    signals, references = _signals(furniture, pieces, diagnostics)
    objects = [part for thing in furniture.objects for part in _objects(thing, pieces)]
    first = pieces.partition.first_ids[pieces.partition.own]
    structures = [part for item in furniture.structures for part in _structures(item, pieces)]
    count = len(signals) + len(objects) + len(structures)
    check_ids(pieces.partition, count, "signals, objects, bridges and tunnels")
    # The parts of an object still share its id. Signals and objects share one range of ids.
    parts: list[RoadObject | RoadStructure] = [*objects, *structures]
    old = sorted([(item.id, -1, item.s) for item in signals] + [(item.id, item.road, item.s) for item in parts])
    number = {key: first + k for k, key in enumerate(old)}
    signal_id = {item.id: number[item.id, -1, item.s] for item in signals}
    signals = [replace(item, id=signal_id[item.id]) for item in signals]
    objects = [replace(item, id=number[item.id, item.road, item.s]) for item in objects]
    structures = [replace(item, id=number[item.id, item.road, item.s]) for item in structures]
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
) -> tuple[list[Signal], list[SignalReference]]:
    """Return the signals and references on kept pieces; a kept reference to a lost signal becomes that signal."""
    signals: dict[int, Signal] = {}
    for item in furniture.signals:
        piece = pieces.at(item.road, item.s)
        if piece.id:
            signals[item.id] = replace(item, road=piece.id, s=item.s - piece.begin)
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
            signals[signal.id] = replace(
                signal, road=there.road, s=there.s, t=there.t, orientation=there.orientation, validity=there.validity
            )
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


def _objects(thing: RoadObject, pieces: Pieces) -> list[RoadObject]:
    """Return the parts of an object on kept pieces: all or nothing of it, unless it repeats along its road."""
    if thing.repeat is None:
        piece = pieces.at(thing.road, thing.s)
        return [replace(thing, road=piece.id, s=thing.s - piece.begin)] if piece.id else []
    found = (_part(thing, thing.repeat, piece) for piece in pieces.of(thing.road) if piece.id)
    return [item for item in found if item is not None]


def _structures(item: RoadStructure, pieces: Pieces) -> list[RoadStructure]:
    """Return the parts of a bridge or tunnel on kept pieces of its road."""
    parts = (
        (piece, max(item.s, piece.begin), min(item.s + item.length, piece.end)) for piece in pieces.of(item.road)
    )
    return [
        replace(item, road=piece.id, s=begin - piece.begin, length=end - begin)
        for piece, begin, end in parts
        if piece.id and end > begin
    ]


def _part(thing: RoadObject, repeat: ObjectRepeat, piece: Piece) -> RoadObject | None:
    """Return the part on a piece of a road of an object that repeats along it; None if nothing of it lies there."""
    begin = 0.0 if piece.at_start else max(piece.begin - repeat.s, 0.0)
    ends_there = piece.at_end or piece.end > repeat.s + repeat.length
    end = repeat.length if ends_there else piece.end - repeat.s
    if begin == 0.0 and ends_there:
        s = repeat.s - piece.begin
        return replace(thing, road=piece.id, s=thing.s - piece.begin, repeat=replace(repeat, s=s))
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
    return replace(thing, road=piece.id, s=s, t=t_start, length=length, repeat=part)


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
