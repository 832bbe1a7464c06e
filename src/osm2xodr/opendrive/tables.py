"""A file of OpenDRIVE as tables, as it was read: what `check`, `report`, `render`, `locate` and `export` share.

Nothing is mended here: numbers that are missing or unreadable are NaN, ids that are named stay text, and every
record knows the line of the file that it stands in. Rows stand in the order of the file, but where an owner's records
are out of order: then they stand in ascending s, unreadable ones last, and a misfit tells. A column `start` of n + 1
entries says where the rows of the k-th owner begin: rows start[k] to start[k + 1] are its own.

Units are OpenDRIVE's own: m, rad, 1/m; speeds are turned into m/s.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

import numpy as np

from osm2xodr.model import BoolArray, CubicProfile, FloatArray, IntArray, freeze_arrays

# No lane, no road, no junction: an index or lane id that is not there.
ABSENT = np.iinfo(np.int64).min


class Shape(IntEnum):
    """Kinds of plan-view records."""

    UNKNOWN = -1
    LINE = 0
    ARC = 1
    SPIRAL = 2
    POLY3 = 3
    PARAM_POLY3 = 4


class End(IntEnum):
    """Which end of a road touches, or what is said instead."""

    UNSAID = -1
    START = 0
    END = 1


class LinkKind(IntEnum):
    """What a road's predecessor or successor names."""

    NONE = 0
    ROAD = 1
    JUNCTION = 2
    UNKNOWN = 3


class _Frozen:
    """Sets the arrays of dataclasses read-only."""

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True, eq=False)
class Header(_Frozen):
    """The header.

    Parameters
    ----------
    revision
        Major and minor number, -1 where missing.
    attributes
        As written.
    geo_reference
        Text of ``<geoReference>``, stripped; None without one.
    offset
        x, y, z, hdg of ``<offset>``; None without one.
    """

    revision: tuple[int, int]
    attributes: Mapping[str, str]
    geo_reference: str | None
    offset: tuple[float, float, float, float] | None


@dataclass(frozen=True, eq=False)
class GeometryTable(_Frozen):
    """``<planView>`` records of all roads.

    Parameters
    ----------
    start : (roads + 1,)
    s, x, y, hdg, length : (records,)
        As written.
    shape : (records,)
        `Shape`.
    parameters : (records, 8)
        Arc: curvature. Spiral: curvStart, curvEnd. Poly3: a, b, c, d. ParamPoly3: aU, bU, cU, dU, aV, bV, cV, dV.
        The rest NaN.
    normalized : (records,)
        Whether a ParamPoly3's p runs from 0 to 1 instead of to the length.
    line : (records,)
    """

    start: IntArray
    s: FloatArray
    x: FloatArray
    y: FloatArray
    hdg: FloatArray
    length: FloatArray
    shape: IntArray
    parameters: FloatArray
    normalized: BoolArray
    line: IntArray


@dataclass(frozen=True, eq=False)
class RoadTable(_Frozen):
    """``<road>`` elements.

    Parameters
    ----------
    id, name : n texts
    length : (n,)
        As written.
    junction : (n,)
        Index of the junction that the road belongs to; -1: none; `ABSENT`: one that is not in the file.
    junction_id : n texts
        As written.
    left_hand : (n,)
        Whether ``rule`` is LHT.
    link_kind : (n, 2)
        `LinkKind` of predecessor and successor.
    link : (n, 2)
        Index of the road or junction that is named there; `ABSENT` where it is not in the file or nothing is named.
    link_id : n pairs of texts
        As written; empty where there is none.
    contact : (n, 2)
        `End` of the other road that touches.
    line : (n,)
    """

    id: tuple[str, ...]
    name: tuple[str, ...]
    length: FloatArray
    junction: IntArray
    junction_id: tuple[str, ...]
    left_hand: BoolArray
    link_kind: IntArray
    link: IntArray
    link_id: tuple[tuple[str, str], ...]
    contact: IntArray
    line: IntArray


@dataclass(frozen=True, eq=False)
class TypeTable(_Frozen):
    """``<type>`` records of all roads, with ``<speed>`` in m/s: NaN where unsaid, infinity for no limit.

    Parameters
    ----------
    start : (roads + 1,)
    s, speed : (records,)
    type : texts
    """

    start: IntArray
    s: FloatArray
    speed: FloatArray
    type: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class SectionTable(_Frozen):
    """``<laneSection>`` elements of all roads.

    Parameters
    ----------
    start : (roads + 1,)
    road : (sections,)
        Index of the road.
    s, end : (sections,)
        Where it begins (as written) and where the next one begins or the road ends.
    line : (sections,)
    """

    start: IntArray
    road: IntArray
    s: FloatArray
    end: FloatArray
    line: IntArray


@dataclass(frozen=True, eq=False)
class LaneTable(_Frozen):
    """``<lane>`` elements of all sections, centre lanes among them, from left to right: the highest id first.

    Parameters
    ----------
    start : (sections + 1,)
    section : (lanes,)
        Index of the section.
    id : (lanes,)
        `ABSENT` where it is no number.
    type : texts
    predecessor, successor : (lanes,)
        Lane ids; `ABSENT` where none is named. Only the first is kept where several are (see `more_links`).
    more_links : (lanes,)
        Whether further predecessors or successors are named.
    width, border : curves per lane
        Records of ``<width>`` and ``<border>``, s local to the section.
    height : (lanes, 2)
        The first ``<height>``'s inner and outer; 0 without one.
    speed : (lanes,)
        m/s; NaN where unsaid.
    mark : texts
        Type of the first road mark; empty without one.
    mark_color : texts
    line : (lanes,)
    direction : texts
        As written in 1.8 (``standard``, ``reversed``, ``both``); empty where unsaid.
    """

    start: IntArray
    section: IntArray
    id: IntArray
    type: tuple[str, ...]
    predecessor: IntArray
    successor: IntArray
    more_links: BoolArray
    width: CubicProfile
    border: CubicProfile
    height: FloatArray
    speed: FloatArray
    mark: tuple[str, ...]
    mark_color: tuple[str, ...]
    line: IntArray
    direction: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class JunctionTable(_Frozen):
    """``<junction>`` elements.

    Parameters
    ----------
    id, name, type : n texts
    start : (n + 1,)
        Into the connections.
    priorities
        (index of the junction, id of the high road, id of the low road) as written.
    controllers
        (index of the junction, id of the controller) as written.
    line : (n,)
    """

    id: tuple[str, ...]
    name: tuple[str, ...]
    type: tuple[str, ...]
    start: IntArray
    priorities: tuple[tuple[int, str, str], ...]
    controllers: tuple[tuple[int, str], ...]
    line: IntArray


@dataclass(frozen=True, eq=False)
class ConnectionTable(_Frozen):
    """``<connection>`` elements of all junctions.

    Parameters
    ----------
    junction : (n,)
        Index of the junction.
    id, incoming_id, connecting_id : n texts
        As written; empty where missing.
    incoming, connecting : (n,)
        Indices of roads; `ABSENT` where not in the file. ``linkedRoad`` of direct junctions stands as connecting.
    contact : (n,)
        `End` of the connecting road.
    link_start : (n + 1,)
        Into the lane links.
    link_from, link_to : (links,)
        Lane ids; `ABSENT` where no number.
    line : (n,)
    """

    junction: IntArray
    id: tuple[str, ...]
    incoming_id: tuple[str, ...]
    connecting_id: tuple[str, ...]
    incoming: IntArray
    connecting: IntArray
    contact: IntArray
    link_start: IntArray
    link_from: IntArray
    link_to: IntArray
    line: IntArray


@dataclass(frozen=True)
class Furniture:
    """A ``<signal>`` or ``<object>``, a reference to one, a ``<bridge>`` or a ``<tunnel>``.

    Parameters
    ----------
    kind
        The element's name: ``signal``, ``signalReference``, ``object``, ``objectReference``, ``bridge``, ``tunnel``.
    road
        Index of the road.
    attributes
        As written.
    s, t, z_offset, hdg, length, width, height
        As numbers; NaN where missing.
    outlines
        Corners of each outline: rows of s, t, dz, height for ``<cornerRoad>``, u, v, z, height for ``<cornerLocal>``.
    local_outlines
        Whether each outline is of the latter kind.
    validity
        Pairs of fromLane and toLane.
    line
        Of the file.
    old_outline
        Corners of an ``<outline>`` that stands in the object itself, as up to 1.4; `outlines` has it only where there
        is no ``<outlines>``.
    radius
        As a number; NaN where missing.
    repeats
        s, length, distance, tStart, tEnd, widthStart of each ``<repeat>``.
    """

    kind: str
    road: int
    attributes: Mapping[str, str]
    s: float
    t: float
    z_offset: float
    hdg: float
    length: float
    width: float
    height: float
    outlines: tuple[tuple[tuple[float, float, float, float], ...], ...]
    local_outlines: tuple[bool, ...]
    validity: tuple[tuple[int, int], ...]
    line: int
    old_outline: tuple[tuple[float, float, float, float], ...] = ()
    radius: float = np.nan
    repeats: tuple[tuple[float, float, float, float, float, float], ...] = ()


@dataclass(frozen=True)
class Controller:
    """A ``<controller>`` and the signals it controls."""

    id: str
    name: str
    signal_ids: tuple[str, ...]
    line: int


@dataclass(frozen=True)
class Misfit:
    """Something that the reader could not take in as OpenDRIVE means it.

    Parameters
    ----------
    rule
        Short name of the kind: ``missing-attribute``, ``bad-number``, ``unknown-element``, ``misplaced-element`` …
    line
        Of the file.
    road
        Index of the road that it stands in, or -1.
    text
        A sentence.
    """

    rule: str
    line: int
    road: int
    text: str


@dataclass(frozen=True, eq=False)
class OpenDrive(_Frozen):
    """A file of OpenDRIVE.

    Parameters
    ----------
    path
        The file.
    header
        Its header.
    roads, types, plan_view, sections, lanes, junctions, connections
        Tables.
    elevation, superelevation, crossfall_shape, lane_offset
        Piecewise cubics per road, as written (the first record need not begin at 0); ``<shape>`` records are only
        counted per road in `crossfall_shape`, (roads,).
    record_lines
        Line of the file of each record of ``elevation``, ``superelevation``, ``lane_offset``, ``width``, ``border``
        and ``type``, by that name.
    furniture
        Signals and objects, in the order of the file.
    controllers
        The top-level ones.
    provenance
        Values of ``userData`` by (road index, code); those of the header have the index -1.
    misfits
        What could not be read.
    """

    path: Path
    header: Header
    roads: RoadTable
    types: TypeTable
    plan_view: GeometryTable
    elevation: CubicProfile
    superelevation: CubicProfile
    crossfall_shape: IntArray
    lane_offset: CubicProfile
    sections: SectionTable
    lanes: LaneTable
    junctions: JunctionTable
    connections: ConnectionTable
    record_lines: Mapping[str, IntArray]
    furniture: tuple[Furniture, ...]
    controllers: tuple[Controller, ...]
    provenance: Mapping[tuple[int, str], str]
    misfits: tuple[Misfit, ...]
