"""What a file has on and beside its roads, as shapes: where things stand, and their forms in the plane.

`placing` finds the places of signals and objects, `forms` says what they look like, `covering` what covers what.
Whoever shows a file uses them.
"""

from __future__ import annotations

from osm2xodr.furniture_shapes.forms import (
    AMBER as AMBER,
    DARK as DARK,
    DASH as DASH,
    DASH_GAP as DASH_GAP,
    DECAL_COLOUR as DECAL_COLOUR,
    DRAWN_MARK_WIDTH as DRAWN_MARK_WIDTH,
    FURNITURE_FROM as FURNITURE_FROM,
    GREEN as GREEN,
    LARGEST_SYMBOL as LARGEST_SYMBOL,
    LEVEL_APART as LEVEL_APART,
    MARKS_FROM as MARKS_FROM,
    RED as RED,
    SMALLEST_SYMBOL as SMALLEST_SYMBOL,
    SYMBOL as SYMBOL,
    WHITE as WHITE,
    Area as Area,
    Corners as Corners,
    Disc as Disc,
    Form as Form,
    Stroke as Stroke,
    Symbol as Symbol,
    colours_by_name as colours_by_name,
    dashed as dashed,
    disc as disc,
    face_of as face_of,
    forms_of as forms_of,
    in_layers as in_layers,
    is_painted as is_painted,
    mark_pattern as mark_pattern,
    rank_of as rank_of,
    type_of as type_of,
)
from osm2xodr.furniture_shapes.placing import (
    PlacedObject as PlacedObject,
    PlacedSignal as PlacedSignal,
    Structures as Structures,
    headings as headings,
    placed_objects as placed_objects,
    placed_signals as placed_signals,
    structures_of as structures_of,
)
