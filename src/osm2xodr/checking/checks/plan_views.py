"""Plan views: gaps and kinks between records, lengths that are not those of the curves."""

from __future__ import annotations

import numpy as np

from osm2xodr.checking.checks.common import above, degrees, first_rows, followers, record_poses, road_place
from osm2xodr.checking.findings import Findings, Place
from osm2xodr.checking.rules import RULES
from osm2xodr.curves import owners
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import OpenDrive, Shape, record_lengths

_POLYNOMIALS = (Shape.POLY3, Shape.PARAM_POLY3)


def check_plan_views(drive: OpenDrive, findings: Findings) -> None:
    """Check the plan views of all roads."""
    _check_lengths(drive, findings)
    _check_followers(drive, findings)
    _check_shapes(drive, findings)


def _place(drive: OpenDrive, row: IntArray) -> Place:
    """Return where records are, for findings."""
    plan = drive.plan_view
    return {"road": owners(plan.start)[row], "s": plan.s[row], "line": plan.line[row]}


def _add(rule: str, drive: OpenDrive, row: IntArray, value: FloatArray, findings: Findings) -> None:
    """Add findings about records whose values are above the limit."""
    bad = np.flatnonzero(above(rule, value))
    findings.add(rule, value=value[bad], **_place(drive, row[bad]))


def _check_lengths(drive: OpenDrive, findings: Findings) -> None:
    """Check the lengths of roads and of their records."""
    plan, roads = drive.plan_view, drive.roads
    findings.add("no-plan-view", **road_place(drive, np.flatnonzero(np.diff(plan.start) == 0)))
    for rule, find in (("zero-length", lambda length: length <= 0), ("short-record", _is_short)):
        row = np.flatnonzero(find(plan.length))
        findings.add(rule, value=plan.length[row], other=lambda _: "the record", **_place(drive, row))
        road = np.flatnonzero(find(roads.length))
        place = road_place(drive, road, np.zeros(len(road)))
        findings.add(rule, value=roads.length[road], other=lambda _: "the road", **place)
    total = np.bincount(owners(plan.start), weights=plan.length, minlength=len(roads.id))
    off = np.abs(total - roads.length)
    wrong = np.flatnonzero(above("road-length", off) & (np.diff(plan.start) > 0))
    findings.add("road-length", value=off[wrong], **road_place(drive, wrong, roads.length[wrong]))
    _add("record-length", drive, np.arange(len(plan.s)), np.abs(record_lengths(drive) - plan.length), findings)


def _is_short(length: FloatArray) -> BoolArray:
    """Whether lengths are short, but not 0."""
    limit = RULES["short-record"].limit
    assert limit is not None
    return np.asarray((length > 0) & (length < limit.value))


def _check_followers(drive: OpenDrive, findings: Findings) -> None:
    """Check whether each record begins where the previous one ends."""
    plan = drive.plan_view
    row = followers(plan.start)
    before = row - 1
    first = first_rows(plan.start)
    _add("record-s", drive, first, np.abs(plan.s[first]), findings)
    _add("record-s", drive, row, np.abs(plan.s[row] - plan.s[before] - plan.length[before]), findings)
    x, y, hdg = record_poses(drive, before, plan.length[before])
    at_x, at_y, at_hdg = record_poses(drive, row, np.zeros(len(row)))
    _add("record-gap", drive, row, np.hypot(at_x - x, at_y - y), findings)
    _add("record-kink", drive, row, degrees(at_hdg - hdg), findings)


def _check_shapes(drive: OpenDrive, findings: Findings) -> None:
    """Check each shape by itself."""
    plan = drive.plan_view
    findings.add("unknown-shape", **_place(drive, np.flatnonzero(plan.shape == Shape.UNKNOWN)))
    row = np.flatnonzero(np.isin(plan.shape, _POLYNOMIALS))
    _, _, hdg = record_poses(drive, row, np.zeros(len(row)))
    _add("start-tangent", drive, row, degrees(hdg - plan.hdg[row]), findings)
