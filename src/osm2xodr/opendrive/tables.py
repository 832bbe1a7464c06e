"""A file of OpenDRIVE as tables: what `check`, `report`, `render`, `locate` and `export` share.

Nothing is repaired here: missing and unreadable numbers are NaN, ids of other elements stay text, and every record
knows its line in the file. Rows stand in the order of the file; records of one owner that are out of order there
stand in ascending s, unreadable ones last, and a misfit says so. A column `start` of n + 1 entries says where the
rows of each owner begin: rows start[k] to start[k + 1] belong to the k-th.

Units are OpenDRIVE's own: m, rad, 1/m; speeds are converted to m/s.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from enum import IntEnum
from pathlib import Path
from typing import Final, Protocol

import numpy as np

from osm2xodr.model import BoolArray, CubicProfile, FloatArray, IntArray, freeze_arrays
from osm2xodr.system import record

# An index or lane id that does not exist: no lane, no road, no junction.
ABSENT = np.iinfo(np.int64).min
# Code of the user data with the ids of OSM's ways, separated by spaces.
_WAY_IDS: Final = "osm_way_ids"


class Shape(IntEnum):
    """Kinds of plan-view records."""

    UNKNOWN = -1
    LINE = 0
    ARC = 1
    SPIRAL = 2
    POLY3 = 3
    PARAM_POLY3 = 4


class End(IntEnum):
    """Which end of a road touches, if the file says."""

    UNSAID = -1
    START = 0
    END = 1


class LinkKind(IntEnum):
    """What the predecessor or successor of a road is."""

    NONE = 0
    ROAD = 1
    JUNCTION = 2
    UNKNOWN = 3


class _Frozen:
    """Makes the arrays of dataclasses read-only."""

    def __post_init__(self) -> None:
        freeze_arrays(self)


@record(eq=False)
class Header(_Frozen):
    """The header."""

    revision: tuple[int, int]  # Major and minor number, -1 where missing
    attributes: Mapping[str, str]  # As written
    geo_reference: str | None  # Text of ``<geoReference>``, stripped; None without one
    offset: tuple[float, float, float, float] | None  # x, y, z, hdg of ``<offset>``; None without one


@record(eq=False)
class GeometryTable(_Frozen):
    """``<planView>`` records of all roads."""

    start: IntArray  # (roads + 1,)
    # (records,) As written
    s: FloatArray
    x: FloatArray
    y: FloatArray
    hdg: FloatArray
    length: FloatArray
    shape: IntArray  # (records,) `Shape`
    # (records, 8) Arc: curvature. Spiral: curvStart, curvEnd. Poly3: a, b, c, d. ParamPoly3: aU, bU, cU, dU, aV, bV,
    # cV, dV. The rest is NaN.
    parameters: FloatArray
    normalized: BoolArray  # (records,) Whether a ParamPoly3's p runs from 0 to 1 instead of to the length
    line: IntArray  # (records,)


@record(eq=False)
class RoadTable(_Frozen):
    """``<road>`` elements."""

    # n texts
    id: tuple[str, ...]
    name: tuple[str, ...]
    length: FloatArray  # (n,) As written
    # (n,) Index of the junction that the road belongs to; -1: none; `ABSENT`: a junction that is not in the file
    junction: IntArray
    junction_id: tuple[str, ...]  # n texts as written
    left_hand: BoolArray  # (n,) Whether ``rule`` is LHT
    link_kind: IntArray  # (n, 2) `LinkKind` of predecessor and successor
    # (n, 2) Index of the road or junction there; `ABSENT` where it is not in the file or there is none
    link: IntArray
    link_id: tuple[tuple[str, str], ...]  # n pairs of texts as written; empty where there is none
    contact: IntArray  # (n, 2) `End` of the other road that touches
    line: IntArray  # (n,)


@record(eq=False)
class TypeTable(_Frozen):
    """``<type>`` records of all roads; ``<speed>`` in m/s is NaN where it is missing, infinite without a limit."""

    start: IntArray  # (roads + 1,)
    # (records,)
    s: FloatArray
    speed: FloatArray
    type: tuple[str, ...]  # texts


@record(eq=False)
class SectionTable(_Frozen):
    """``<laneSection>`` elements of all roads."""

    start: IntArray  # (roads + 1,)
    road: IntArray  # (sections,) Index of the road
    # (sections,) Where it begins (as written), and where the next one begins or the road ends
    s: FloatArray
    end: FloatArray
    line: IntArray  # (sections,)


@record(eq=False)
class MarkTable(_Frozen):
    """``<roadMark>`` elements of all lanes, in the order of the file."""

    start: IntArray  # (lanes + 1,)
    s: FloatArray  # (marks,) Local to the section; 0 where it is missing
    # Texts as written; empty where they are missing
    type: tuple[str, ...]
    lane_change: tuple[str, ...]


@record(eq=False)
class LaneTable(_Frozen):
    """``<lane>`` elements of all sections, with the centre lanes, from left to right: the highest id first."""

    start: IntArray  # (sections + 1,)
    section: IntArray  # (lanes,) Index of the section
    id: IntArray  # (lanes,) `ABSENT` where it is not a number
    type: tuple[str, ...]  # texts
    # (lanes,) Lane ids, the first of several; `ABSENT` without one
    predecessor: IntArray
    successor: IntArray
    # Curves per lane: ``<width>`` and ``<border>``, s local to the section
    width: CubicProfile
    border: CubicProfile
    height: FloatArray  # (lanes, 2) Inner and outer of the first ``<height>`` but 0; 0 without one
    speed: FloatArray  # (lanes,) m/s; NaN where it is missing
    # Type and colour of the first road mark of each lane; empty without one
    mark: tuple[str, ...]
    mark_color: tuple[str, ...]
    marks: MarkTable  # All road marks
    line: IntArray  # (lanes,)
    # As written in 1.8 (``standard``, ``reversed``, ``both``); empty where it is missing
    direction: tuple[str, ...] = ()


@record(eq=False)
class JunctionTable(_Frozen):
    """``<junction>`` elements."""

    # n texts
    id: tuple[str, ...]
    name: tuple[str, ...]
    type: tuple[str, ...]
    start: IntArray  # (n + 1,) Into the connections
    # (index of the junction, id of the high road, id of the low road) as written
    priorities: tuple[tuple[int, str, str], ...]
    controllers: tuple[tuple[int, str], ...]  # (index of the junction, id of the controller) as written
    line: IntArray  # (n,)


@record(eq=False)
class ConnectionTable(_Frozen):
    """``<connection>`` elements of all junctions."""

    junction: IntArray  # (n,) Index of the junction
    # n texts as written; empty where missing
    id: tuple[str, ...]
    incoming_id: tuple[str, ...]
    connecting_id: tuple[str, ...]
    # (n,) Indices of roads; `ABSENT` where not in the file. ``linkedRoad`` of direct junctions counts as connecting.
    incoming: IntArray
    connecting: IntArray
    contact: IntArray  # (n,) `End` of the connecting road
    link_start: IntArray  # (n + 1,) Into the lane links
    # (links,) Lane ids; `ABSENT` where they are not numbers
    link_from: IntArray
    link_to: IntArray
    line: IntArray  # (n,)


@record
class Furniture:
    """A ``<signal>`` or ``<object>``, a reference to one, a ``<bridge>`` or a ``<tunnel>``."""

    kind: str  # Name of the element
    road: int  # Index of the road
    attributes: Mapping[str, str]  # As written
    # As numbers; NaN where missing
    s: float
    t: float
    z_offset: float
    hdg: float
    length: float
    width: float
    height: float
    # Corners of each outline: rows of s, t, dz, height for ``<cornerRoad>``, u, v, z, height for ``<cornerLocal>``
    outlines: tuple[tuple[tuple[float, float, float, float], ...], ...]
    local_outlines: tuple[bool, ...]  # Whether each outline is of the latter kind
    validity: tuple[tuple[int, int], ...]  # Pairs of fromLane and toLane
    line: int  # Of the file
    # Corners of an ``<outline>`` that stands in the object itself, as up to 1.4; `outlines` has it only where there
    # is no ``<outlines>``.
    old_outline: tuple[tuple[float, float, float, float], ...] = ()
    radius: float = np.nan  # As a number; NaN where missing
    # s, length, distance, tStart, tEnd, widthStart of each ``<repeat>``
    repeats: tuple[tuple[float, float, float, float, float, float], ...] = ()


@record
class Controller:
    """A ``<controller>`` and the signals it controls."""

    id: str
    name: str
    signal_ids: tuple[str, ...]
    line: int


@record
class Misfit:
    """Something in the file that is not as OpenDRIVE defines it."""

    # Short name of the kind: ``missing-attribute``, ``bad-number``, ``unknown-element``, ``misplaced-element`` …
    rule: str
    line: int  # Of the file
    road: int  # Index of the road that it stands in, or -1
    text: str  # A sentence


@record(eq=False)
class OpenDrive(_Frozen):
    """A file of OpenDRIVE."""

    path: Path
    header: Header
    roads: RoadTable
    types: TypeTable
    plan_view: GeometryTable
    # Piecewise cubics per road, as written: the first record need not begin at 0
    elevation: CubicProfile
    superelevation: CubicProfile
    crossfall_shape: IntArray  # (roads,) Number of ``<shape>`` records, which are not read
    lane_offset: CubicProfile
    sections: SectionTable
    lanes: LaneTable
    junctions: JunctionTable
    connections: ConnectionTable
    # Line of the file of each record of ``elevation``, ``superelevation``, ``lane_offset``, ``width``, ``border`` and
    # ``type``, by that name.
    record_lines: Mapping[str, IntArray]
    furniture: tuple[Furniture, ...]  # Signals and objects, in the order of the file
    controllers: tuple[Controller, ...]  # The top-level ones
    # Values of ``userData`` by (road index, code); those of the header have the index -1
    provenance: Mapping[tuple[int, str], str]
    misfits: tuple[Misfit, ...]  # What could not be read as OpenDRIVE, in the order of the file

    @property
    def tables(self) -> OpenDrive:
        """The file itself: it stands for itself."""
        return self

    def osm_ways(self, road: int) -> tuple[int, ...]:
        """Return the ids of OpenStreetMap's ways that a road is made of; none where the file does not say them."""
        words = self.provenance.get((road, _WAY_IDS), "").split()
        return tuple(int(word) for word in words if re.fullmatch(r"-?[0-9]{1,19}", word))


class HasTables(Protocol):
    """What stands for a file, such as `osm2xodr.RoadNetwork`."""

    @property
    def tables(self) -> OpenDrive:
        """The file as tables."""
