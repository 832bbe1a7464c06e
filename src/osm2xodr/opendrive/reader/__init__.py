"""Reads OpenDRIVE 1.4 to 1.8 of any writer into tables, strictly: what is wrong is reported, never repaired.

Files are refused that claim what no road network has: a small one would take hours and gigabytes.
"""

from __future__ import annotations

import contextlib
import gc
import os
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from osm2xodr.curves import owners
from osm2xodr.defaults import NEGATED_LANES
from osm2xodr.errors import InputError
from osm2xodr.model import CubicProfile, FloatArray, IntArray
from osm2xodr.opendrive.reader.elements import TEXT, Elements, Node, Role
from osm2xodr.opendrive.reader.junctions_and_signals import JunctionReader, read_controller, read_furniture
from osm2xodr.opendrive.reader.lanes import LaneReader
from osm2xodr.opendrive.reader.nodes import ElementReader, Part, find_parts
from osm2xodr.opendrive.reader.roads import RoadReader, first_index as first_index
from osm2xodr.opendrive.reader.values import NAN, Values
from osm2xodr.opendrive.tables import Controller, Furniture, HasTables, Header, OpenDrive, Shape
from osm2xodr.system import Task, available_jobs, stage

_ROOT: Final = "OpenDRIVE"
_ROOT_UNREAD: Final = frozenset({"junctionGroup", "station"})
_HEADER_UNREAD: Final = frozenset({"license", "defaultRegulations"})
_NO_HEADER: Final = Header((-1, -1), MappingProxyType({}), None, None)
# Longest road, m. A choice: no drivable way is as long as this without a junction.
_LONGEST: Final = 1e6
# Most lanes of a section, a choice: ten times those of a wide toll plaza.
_LANES: Final = 500
# How wide lanes are at most, and how far their middle lies beside the line of their road, m. A choice: several times
# the widest toll plaza.
_FARTHEST: Final = 500.0
# Most that a record of the plan view turns, rad, a choice: 160 full circles, where ramps of car parks have a dozen.
_TURN: Final = 1e3
# Most records of the plan view that are alike, a choice: a few roads may share one. Their overlaps grow with the
# square of their number.
_ALIKE: Final = 200
# Most length for each record of the plan view, m, in files of more than the length below, m. Choices: of 24 files the
# records measure 9 to 26 m in the mean.
_PER_RECORD: Final = 1e3
_COUNTRY: Final = 3e6


def tables_of(file: HasTables | str | os.PathLike[str]) -> OpenDrive:
    """Return a file that was read already, or read it; see `read_xodr`."""
    return read_xodr(Path(file)) if isinstance(file, (str, os.PathLike)) else file.tables


def read_xodr(path: Path) -> OpenDrive:
    """Read a file of OpenDRIVE, plain or compressed by gzip; ``-`` is standard input.

    Numbers that are missing or unreadable become NaN, references to what is not in the file `ABSENT`; each becomes a
    `Misfit` with the line of the file. Where ids are used twice, references lead to the first of them. Records of one
    owner stand in ascending s (lanes from left to right), whatever their order in the file. Lane ids that were
    negated for SUMO (`osm2xodr.defaults.NEGATED_LANES`) are read as they are on the road.

    Raises
    ------
    InputError
        If it cannot be read, is not XML, is not OpenDRIVE, or claims more than any road has (`check_bounds`).
    """
    stage(f"reading {path}")
    with _no_collection():
        document, root = _in_parts(path, find_parts(path, available_jobs())) or _read(path)
    if root is None or root.tag != _ROOT:
        tag = "" if root is None else f": its root is <{root.tag}>"
        raise InputError(f"{path} is XML, but not OpenDRIVE{tag}; give a file of OpenDRIVE (.xodr)")
    if "xmlns" in root.attributes:
        document.values.report("namespace", root, f"<{_ROOT}> has the namespace {root.attributes['xmlns']!r}")
    file = document.tables(path, root)
    check_bounds(file)
    return file


def _read(path: Path, part: Part | None = None, negated: bool = False) -> tuple[_Document, Node | None]:
    """Read a file, or a part of it: its elements, and its root, if it has one."""
    reader, document = ElementReader(path, part), _Document(negated)
    for elements in reader.elements():
        if reader.root is not None and reader.root.tag != _ROOT:
            break
        document.add(elements)
    return document, reader.root


def _in_parts(path: Path, parts: tuple[Part, ...]) -> tuple[_Document, Node | None] | None:
    """Read a file by parts, side by side; None if it has to be read as a whole, to say what is wrong with it."""
    if len(parts) < 2:
        return None
    with contextlib.ExitStack() as stack:
        try:
            negated = _has_negated_lanes(path, parts[0])
            work = [partial(_further, path, part, negated) for part in parts[1:]]
            others = [stack.enter_context(Task(item, apart=True)) for item in work]
            document, root = _read(path, parts[0])
            for other in others:
                document.extend(other.result())
        except (InputError, _NotAPartError):
            return None
    return document, root


def _further(path: Path, part: Part, negated: bool) -> _Document:
    """Read a part of a file behind the first one."""
    document, _ = _read(path, part, negated)
    if document.has_header:
        raise _NotAPartError
    return document


def _has_negated_lanes(path: Path, part: Part) -> bool:
    """Say whether the header, in the first part of a file, says that lane ids were negated."""
    document = _Document()
    for elements in ElementReader(path, part).elements():
        document.add(elements)
        if document.has_header or len(elements.of(Role.ROAD)):
            break
    return document.values.negated


@contextlib.contextmanager
def _no_collection() -> Iterator[None]:
    """Suspend the collection of cyclic garbage: there is none, and looking for it costs a third of the time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


class _NotAPartError(Exception):
    """What was taken for a part of a file has a header."""


class _Document:
    """Collects the elements of the root one by one; `negated` says whether lane ids are, before the header does."""

    def __init__(self, negated: bool = False) -> None:
        self.values = Values(negated)
        self._header: Header | None = None
        self._roads = RoadReader(self.values)
        self._lanes = LaneReader(self.values)
        self._junctions = JunctionReader(self.values)
        self._furniture: list[Furniture] = []
        self._controllers: list[Controller] = []
        self._provenance: dict[tuple[int, str], str] = {}

    def add(self, elements: Elements) -> None:
        """Read some children of the root."""
        values = self.values
        for row in elements.of(Role.TREE).tolist():
            self._tree(elements.tree(row))
        roads, sections = elements.of(Role.ROAD), elements.of(Role.SECTION)
        for row in np.setdiff1d(roads, elements.parent[elements.parent[sections]]).tolist():
            text = "<road> has no <lanes> with a <laneSection>"
            values.report("missing-element", elements.node(row), text)
        self._roads.add(elements, roads)
        self._lanes.add(elements, roads)
        self._parts_of_roads(elements)
        for row in elements.repeated:
            node = elements.node(row)
            values.repeated(node, elements.node(int(elements.parent[row])))
        for row in elements.of(Role.UNKNOWN).tolist():
            values.check_known(elements.node(row), elements.node(int(elements.parent[row])))
        values.settle()

    def _tree(self, node: Node) -> None:
        """Read a child of the root that is no road."""
        if node.tag == "junction":
            self._junctions.junction(node)
        elif node.tag == "controller":
            self._controllers.append(read_controller(self.values, node))
        elif node.tag == "header":
            if self._header is None:
                self._header = self._read_header(node)
            else:
                self.values.report("repeated-element", node, "the file has more than one <header>; the first is used")
        else:
            self.values.check_known(node, Node(_ROOT, {}, node.line), _ROOT_UNREAD)

    @property
    def has_header(self) -> bool:
        """Whether there was a header."""
        return self._header is not None

    def extend(self, other: _Document) -> None:
        """Add what a further part of the file has."""
        first = len(self._roads.ids)
        self.values.extend(other.values, first)
        self._roads.extend(other._roads)
        self._lanes.extend(other._lanes)
        self._junctions.extend(other._junctions)
        self._furniture.extend(replace(item, road=first + item.road) for item in other._furniture)
        self._controllers.extend(other._controllers)
        self._provenance.update({(first + road, code): value for (road, code), value in other._provenance.items()})

    def _parts_of_roads(self, elements: Elements) -> None:
        """Read signals, objects and user data of roads."""
        furniture = np.sort(np.concatenate([elements.of(Role.OBJECTS), elements.of(Role.SIGNALS)]))
        for row in furniture.tolist():
            self._furniture.extend(read_furniture(self.values, elements.tree(row)))
        for row in elements.of(Role.USER_DATA).tolist():
            self._user_data(elements.node(row))

    def _user_data(self, node: Node) -> None:
        """Keep the first ``<userData>`` of each code of a road or of the header."""
        self._provenance.setdefault((node.road, node.get("code")), node.get("value"))

    def _read_header(self, node: Node) -> Header:
        """Read the header."""
        values = self.values
        found: dict[str, Node | None] = {"geoReference": None, "offset": None}
        for child in node.children:
            if child.tag in found:
                if found[child.tag] is None:
                    found[child.tag] = child
                else:
                    values.repeated(child, node)
            elif child.tag == "userData":
                self._user_data(child)
                values.negated |= (child.get("code"), child.get("value")) == NEGATED_LANES
            else:
                values.check_known(child, node, _HEADER_UNREAD)
        numbers = (values.number(node, "revMajor"), values.number(node, "revMinor"))
        major, minor = (int(value) if value.is_integer() else -1 for value in numbers)
        shift, reference = None, found["geoReference"]
        if offset := found["offset"]:
            x, y, z, hdg = (values.optional(offset, name, NAN) for name in ("x", "y", "z", "hdg"))
            shift = (x, y, z, hdg)
        text = None if reference is None else reference.attributes.get(TEXT, "").strip()
        return Header((major, minor), MappingProxyType(node.attributes), text, shift)

    def tables(self, path: Path, root: Node) -> OpenDrive:
        """Return all tables."""
        if self._header is None:
            self.values.report("missing-element", root, "the file has no <header>")
        road_index, junction_index = first_index(self._roads.ids), first_index(self._junctions.ids)
        # Records out of order are known when the tables are made.
        plan_view = self._roads.plan()
        types, type_lines = self._roads.types()
        profiles, lines = zip(*self._roads.profiles(), strict=True)
        road_lines = dict(zip(("elevation", "superelevation", "lane_offset"), lines, strict=True))
        sections, lanes, lane_lines, lane_misfits = self._lanes.tables(self._roads.lengths)
        junctions, connections = self._junctions.tables(road_index)
        self.values.settle()
        misfits = [*self.values.misfits, *self._roads.misfits(), *lane_misfits]
        return OpenDrive(
            path=path,
            header=self._header or _NO_HEADER,
            roads=self._roads.roads(junction_index),
            types=types,
            plan_view=plan_view,
            elevation=profiles[0],
            superelevation=profiles[1],
            crossfall_shape=self._roads.shapes(),
            lane_offset=profiles[2],
            sections=sections,
            lanes=lanes,
            junctions=junctions,
            connections=connections,
            record_lines=MappingProxyType({**road_lines, **lane_lines, "type": type_lines}),
            furniture=tuple(self._furniture),
            controllers=tuple(self._controllers),
            provenance=MappingProxyType(self._provenance),
            misfits=tuple(sorted(misfits, key=lambda item: item.line)),
        )


def check_bounds(file: OpenDrive) -> None:
    """Raise `InputError`, with the road, if a file has roads that are too long, too wide or too bent to be true."""
    roads, plan = file.roads, file.plan_view
    with np.errstate(invalid="ignore", over="ignore"):
        _refuse(file, np.arange(len(roads.length)), roads.length, _LONGEST, "is {:g} m long")
        of = owners(plan.start)
        _refuse(file, of, plan.length, _LONGEST, "has a <geometry> of {:g} m")
        bent = np.where(np.isin(plan.shape, (Shape.ARC, Shape.SPIRAL)), 1.0, 0.0)
        sharpest = np.fmax(np.abs(plan.parameters[:, 0]), np.abs(plan.parameters[:, 1]))
        _refuse(file, of, bent * np.abs(sharpest * plan.length), _TURN, "has a <geometry> that turns by {:g} rad")
        if np.nansum(plan.length) > max(_COUNTRY, _PER_RECORD * len(of)):
            _refuse(file, of, plan.length, _PER_RECORD, "has, as others, a <geometry> of {:g} m")
        records = np.column_stack([plan.x, plan.y, plan.hdg, plan.length, np.nan_to_num(plan.parameters)])
        _, alike, counts = np.unique(records, axis=0, return_inverse=True, return_counts=True)
    _refuse(file, of, counts[alike.ravel()].astype(np.float64), _ALIKE, "has a <geometry> that {:,.0f} roads have")
    lanes = np.diff(file.lanes.start).astype(np.float64)
    _refuse(file, file.sections.road, lanes, _LANES, "has a <laneSection> of {:,.0f} lanes")
    _check_widths(file)


def _check_widths(file: OpenDrive) -> None:
    """Raise `InputError`, with the road, if lanes are too wide, or too far beside their road, to be true."""
    sections, lanes = file.sections, file.lanes
    whole = file.roads.length[sections.road] - sections.s
    goes_on = sections.road[1:] == sections.road[:-1]
    whole[:-1][goes_on] = np.diff(sections.s)[goes_on]
    along = whole[lanes.section]
    with np.errstate(invalid="ignore", over="ignore"):
        for profile, length, road, words in (
            (file.lane_offset, file.roads.length, np.arange(len(file.roads.length)), "has a <laneOffset> of {:g} m"),
            (lanes.width, along, sections.road[lanes.section], "has a <lane> {:g} m wide"),
            (lanes.border, along, sections.road[lanes.section], "has a <border> at {:g} m"),
        ):
            _refuse(file, road[owners(profile.start)], _largest(profile, length), _FARTHEST, words)


def _largest(profile: CubicProfile, length: FloatArray) -> FloatArray:
    """Return the largest size of records of curves of a length, m, at their ends and twice between, (records,)."""
    owner = owners(profile.start)
    end, goes_on = length[owner], owner[1:] == owner[:-1]
    end[:-1][goes_on] = profile.s[1:][goes_on]
    whole = np.maximum(end - profile.s, 0.0)
    out = np.abs(profile.a)
    for share in (1 / 3, 2 / 3, 1.0):
        ds = share * whole
        out = np.fmax(out, np.abs(profile.a + ds * (profile.b + ds * (profile.c + ds * profile.d))))
    return out


def _refuse(file: OpenDrive, road: IntArray, value: FloatArray, most: float, words: str) -> None:
    """Refuse the first road with a value above a bound."""
    over = np.flatnonzero(value > most)
    if len(over):
        k = int(over[0])
        place = f"road {file.roads.id[int(road[k])]!r} (line {file.roads.line[int(road[k])]})"
        what = words.format(float(value[k]))
        raise InputError(f"{file.path}: {place} {what}; a sound file can have {most:g} at most")
