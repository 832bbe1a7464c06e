"""What stands on and beside roads, for the page: objects as arrays, signals and their controllers as rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from osm2xodr.furniture_shapes import (
    DASH,
    DASH_GAP,
    DRAWN_MARK_WIDTH,
    FURNITURE_FROM,
    LARGEST_SYMBOL,
    MARKS_FROM,
    SMALLEST_SYMBOL,
    SYMBOL,
    Area,
    Disc,
    Symbol,
    face_of,
    forms_of,
    headings,
    in_layers,
    placed_objects,
    placed_signals,
    type_of,
)
from osm2xodr.opendrive import OpenDrive
from osm2xodr.viewing.page.packing import Packed, quantised, rounded

_CENTIMETRE = 0.01
_TENTH = 0.1
_AREA, _DISC, _STROKE = range(3)


@dataclass(frozen=True, eq=False)
class Objects:
    """Objects in drawing order, and the forms of each with their corners."""

    types: list[str]  # Of each object
    colours: list[str]  # Of forms
    arrays: dict[str, Packed]


def objects_of(file: OpenDrive, x0: float, y0: float) -> Objects:
    """Return the objects of a file; x0, y0 is the page's origin, m."""
    things = in_layers(placed_objects(file))
    colours: dict[str, int] = {}
    owner: list[int] = []
    kind: list[int] = []
    colour: list[int] = []
    size: list[float] = []
    least: list[float] = []
    start = [0]
    corners: list[tuple[float, float]] = []
    for k, thing in enumerate(things):
        for form in forms_of(thing):
            owner.append(k)
            colour.append(colours.setdefault(form.colour, len(colours)))
            if isinstance(form, Disc):
                corners.append((form.x, form.y))
                kind.append(_DISC)
                size.append(form.radius)
                least.append(form.least)
            else:
                corners += form.corners
                is_area = isinstance(form, Area)
                kind.append(_AREA if is_area else _STROKE)
                size.append(0.0 if isinstance(form, Area) else form.width)
                least.append(0.0)
            start.append(len(corners))
    places = np.array(corners, np.float64).reshape(-1, 2)
    arrays = {
        "object_road": np.array([thing.item.road for thing in things], np.int32),
        "object_x": quantised(np.array([thing.x - x0 for thing in things]), _CENTIMETRE),
        "object_y": quantised(np.array([thing.y - y0 for thing in things]), _CENTIMETRE),
        "object_z": quantised(np.array([thing.z for thing in things]), _CENTIMETRE),
        "form_object": np.array(owner, np.int32),
        "form_kind": np.array(kind, np.int32),
        "form_colour": np.array(colour, np.int32),
        "form_size": quantised(np.array(size), _CENTIMETRE),
        "form_least": quantised(np.array(least), _TENTH),
        "form_start": np.array(start, np.int32),
        "form_x": quantised(places[:, 0] - x0, _CENTIMETRE),
        "form_y": quantised(places[:, 1] - y0, _CENTIMETRE),
    }
    return Objects([type_of(thing) for thing in things], list(colours), arrays)


def signal_info(file: OpenDrive, x0: float, y0: float) -> dict[str, Any]:
    """Return signals, their faces, and the controllers, of which each lists its signals and junctions.

    A signal is its road, x, y, z of the road there, heading of what it faces (rad), height of its foot above the
    road, height of its body, whether it is a traffic light, its face, its attributes and the roads that refer to it.
    """
    signals = placed_signals(file)
    faces: dict[str, int] = {}
    symbols: list[Symbol] = []
    facing = headings(file, signals)
    rows = []
    by_id: dict[str, list[int]] = {}
    referring: dict[str, list[int]] = {}
    for item in file.furniture:
        if item.kind == "signalReference" and item.road >= 0:
            referring.setdefault(item.attributes.get("id", ""), []).append(item.road)
    for k, (signal, heading) in enumerate(zip(signals, facing, strict=True)):
        item = signal.item
        symbol = face_of(signal)
        face = faces.setdefault(repr(symbol), len(faces))
        if face == len(symbols):
            symbols.append(symbol)
        number = item.attributes.get("id", "")
        by_id.setdefault(number, []).append(k)
        rows.append(
            [
                item.road,
                rounded(signal.x - x0),
                rounded(signal.y - y0),
                rounded(signal.z),
                rounded(heading, 3),
                rounded(item.z_offset),
                rounded(item.height),
                int(signal.is_light),
                face,
                [[key, value] for key, value in item.attributes.items()],
                referring.get(number, []),
            ]
        )
    junctions: dict[str, list[int]] = {}
    for junction, name in file.junctions.controllers:
        junctions.setdefault(name, []).append(junction)
    return {
        "signals": rows,
        "faces": [
            [[[rounded(value) for corner in corners for value in corner], colour] for corners, colour in symbol]
            for symbol in symbols
        ],
        "controllers": [
            [
                item.id,
                item.name,
                [k for number in dict.fromkeys(item.signal_ids) for k in by_id.get(number, [])],
                junctions.get(item.id, []),
            ]
            for item in file.controllers
        ],
    }


def drawing_rules() -> dict[str, float]:
    """Return how marks and symbols are drawn: pixels per metre from which on, and sizes, m and pixels."""
    return {
        "marks_from": MARKS_FROM,
        "furniture_from": FURNITURE_FROM,
        "mark_width": DRAWN_MARK_WIDTH,
        "dash": DASH,
        "gap": DASH_GAP,
        "symbol": SYMBOL,
        "smallest_symbol": SMALLEST_SYMBOL,
        "largest_symbol": LARGEST_SYMBOL,
    }
