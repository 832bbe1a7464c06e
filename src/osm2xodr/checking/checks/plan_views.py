"""Plan views: gaps and kinks between records, lengths that are not those of the curves."""

from __future__ import annotations

import numpy as np

from osm2xodr.checking.checks.places import degrees, joints, owners, record_poses
from osm2xodr.checking.findings import Findings, Place
from osm2xodr.checking.rules import RULES
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import OpenDrive, Shape, record_lengths

_POLYNOMIALS = (Shape.POLY3, Shape.PARAM_POLY3)


def above(rule: str, value: FloatArray) -> BoolArray:
    """Whether values are above a rule's limit; never where they are unknown."""
    limit = RULES[rule].limit
    assert limit is not None
    return np.asarray(np.nan_to_num(value, nan=-np.inf) > limit)


def check_plan_views(drive: OpenDrive, findings: Findings) -> None:
    """Look at the plan views of all roads."""
    _check_lengths(drive, findings)
    _check_joints(drive, findings)
    _check_curves(drive, findings)


def _add(rule: str, drive: OpenDrive, row: IntArray, value: FloatArray, findings: Findings, other: str = "") -> None:
    """Take in findings about records whose values are above the limit."""
    bad = np.flatnonzero(above(rule, value))
    plan = drive.plan_view
    at = row[bad]
    findings.add(
        rule,
        road=owners(plan.start)[at],
        s=plan.s[at],
        value=value[bad],
        line=plan.line[at],
        other=lambda _: other,
    )


def _check_lengths(drive: OpenDrive, findings: Findings) -> None:
    """Look at lengths of roads and of their records."""
    plan, roads = drive.plan_view, drive.roads
    bare = np.flatnonzero(np.diff(plan.start) == 0)
    findings.add("no-plan-view", road=bare, line=roads.line[bare])
    every = np.arange(len(plan.s))
    owner = owners(plan.start)
    for short, rule in ((plan.length <= 0, "zero-length"), (_tiny(plan.length), "short-record")):
        at = np.flatnonzero(short)
        findings.add(
            rule,
            road=owner[at],
            s=plan.s[at],
            value=plan.length[at],
            line=plan.line[at],
            other=lambda _: "the record",
        )
    for short, rule in ((roads.length <= 0, "zero-length"), (_tiny(roads.length), "short-record")):
        at = np.flatnonzero(short)
        place: Place = {"road": at, "s": np.zeros(len(at)), "line": roads.line[at]}
        findings.add(rule, value=roads.length[at], other=lambda _: "the road", **place)
    total = np.bincount(owner, weights=plan.length, minlength=len(roads.id))
    off = np.abs(total - roads.length)
    wrong = np.flatnonzero(above("road-length", off) & (np.diff(plan.start) > 0))
    findings.add("road-length", road=wrong, s=roads.length[wrong], value=off[wrong], line=roads.line[wrong])
    _add("record-length", drive, every, np.abs(record_lengths(drive) - plan.length), findings)


def _tiny(length: FloatArray) -> BoolArray:
    """Whether lengths are short, but not without length."""
    limit = RULES["short-record"].limit
    assert limit is not None
    return np.asarray((length > 0) & (length < limit))


def _check_joints(drive: OpenDrive, findings: Findings) -> None:
    """Look where one record ends and the next begins."""
    plan = drive.plan_view
    row = joints(plan.start)
    before = row - 1
    first = plan.start[:-1][np.diff(plan.start) > 0]
    _add("record-s", drive, first, np.abs(plan.s[first]), findings)
    _add("record-s", drive, row, np.abs(plan.s[row] - plan.s[before] - plan.length[before]), findings)
    x, y, hdg = record_poses(drive, before, plan.length[before])
    at_x, at_y, at_hdg = record_poses(drive, row, np.zeros(len(row)))
    _add("record-gap", drive, row, np.hypot(at_x - x, at_y - y), findings)
    _add("record-kink", drive, row, degrees(at_hdg - hdg), findings)


def _check_curves(drive: OpenDrive, findings: Findings) -> None:
    """Look at shapes by themselves."""
    plan = drive.plan_view
    unknown = np.flatnonzero(plan.shape == Shape.UNKNOWN)
    findings.add("unknown-shape", road=owners(plan.start)[unknown], s=plan.s[unknown], line=plan.line[unknown])
    row = np.flatnonzero(np.isin(plan.shape, _POLYNOMIALS))
    _, _, hdg = record_poses(drive, row, np.zeros(len(row)))
    _add("start-tangent", drive, row, degrees(hdg - plan.hdg[row]), findings)
