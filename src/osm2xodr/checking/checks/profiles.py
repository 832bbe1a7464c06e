"""Heights, cross slopes, lane offsets and widths: steps from record to record, grades, negative widths."""

from __future__ import annotations

import numpy as np

from osm2xodr.checking import defaults
from osm2xodr.checking.checks.index import LaneIndex
from osm2xodr.checking.checks.places import degrees, joints, owners, record_ends, spans, worst_of
from osm2xodr.checking.checks.plan_views import above
from osm2xodr.checking.findings import Findings
from osm2xodr.model import BoolArray, CubicProfile, FloatArray, IntArray
from osm2xodr.opendrive import OpenDrive

_PERCENT = 100.0


def check_profiles(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Look at all piecewise cubics."""
    _check_starts(drive, findings)
    _check_heights(drive, findings)
    _check_grades(drive, findings)
    _check_lane_offsets(drive, findings)
    _check_widths(drive, lanes, findings)


def _check_starts(drive: OpenDrive, findings: Findings) -> None:
    """Look whether first records begin at the road's start."""
    for rule, name, word in (
        ("late-elevation", "elevation", "elevation"),
        ("late-record", "superelevation", "superelevation"),
        ("late-record", "lane_offset", "lane offset"),
    ):
        profile: CubicProfile = getattr(drive, name)
        row = profile.start[:-1][np.diff(profile.start) > 0]
        row = row[above(rule, profile.s[row])]
        findings.add(
            rule,
            road=owners(profile.start)[row],
            s=profile.s[row],
            value=profile.s[row],
            line=drive.record_lines[name][row],
            other=lambda _, word=word: word,  # type: ignore[misc]
        )


def _add(rule: str, drive: OpenDrive, name: str, row: IntArray, value: FloatArray, findings: Findings) -> None:
    """Take in findings about records of a profile of roads whose values are above the limit."""
    bad = np.flatnonzero(above(rule, value))
    profile: CubicProfile = getattr(drive, name)
    at = row[bad]
    findings.add(
        rule,
        road=owners(profile.start)[at],
        s=profile.s[at],
        value=value[bad],
        line=drive.record_lines[name][at],
    )


def _check_heights(drive: OpenDrive, findings: Findings) -> None:
    """Look for steps of height, grade and cross slope."""
    row = joints(drive.elevation.start)
    value, slope = record_ends(drive.elevation, row - 1)
    _add("height-step", drive, "elevation", row, np.abs(drive.elevation.a[row] - value), findings)
    _add("grade-step", drive, "elevation", row, _PERCENT * np.abs(drive.elevation.b[row] - slope), findings)
    row = joints(drive.superelevation.start)
    value, _ = record_ends(drive.superelevation, row - 1)
    _add("superelevation-step", drive, "superelevation", row, degrees(drive.superelevation.a[row] - value), findings)


def _check_grades(drive: OpenDrive, findings: Findings) -> None:
    """Look for roads that are too steep: one finding for each, at its steepest place."""
    profile = drive.elevation
    span = spans(profile, drive.roads.length)
    with np.errstate(divide="ignore", invalid="ignore"):
        # Where the grade's derivative 2c + 6d·ds is 0.
        turn = np.clip(np.nan_to_num(-profile.c / (3 * profile.d)), 0.0, span)
    at = np.stack([np.zeros_like(span), turn, span])
    grade = np.abs(profile.b + at * (2 * profile.c + 3 * at * profile.d))
    # A record that holds nowhere is none.
    grade[:, span <= 0] = 0.0
    which = grade.argmax(0)
    rows = np.arange(len(span))
    steepest = _PERCENT * np.nan_to_num(grade[which, rows])
    worst = worst_of(owners(profile.start), steepest)
    excess = above("grade-excess", steepest[worst])
    for rule, wanted in (("grade-excess", excess), ("grade-steep", above("grade-steep", steepest[worst]) & ~excess)):
        row = worst[wanted]
        findings.add(
            rule,
            road=owners(profile.start)[row],
            s=profile.s[row] + at[which[row], row],
            value=steepest[row],
            line=drive.record_lines["elevation"][row],
        )


def _check_lane_offsets(drive: OpenDrive, findings: Findings) -> None:
    """Look for steps of the lane offset; where a lane section begins they may be meant, and borders tell."""
    profile = drive.lane_offset
    row = joints(profile.start)
    value, _ = record_ends(profile, row - 1)
    road = owners(profile.start)[row]
    inside = ~_at_section(drive, road, profile.s[row])
    row, value = row[inside], value[inside]
    _add("lane-offset-step", drive, "lane_offset", row, np.abs(profile.a[row] - value), findings)


def _at_section(drive: OpenDrive, road: IntArray, s: FloatArray) -> BoolArray:
    """Whether a lane section of a road begins at s."""
    sections = drive.sections
    keys = np.sort(_place_keys(sections.road, sections.s))
    sought = _place_keys(road, s)
    if not len(keys):
        return np.zeros(len(sought), bool)
    near = np.minimum(np.searchsorted(keys, sought - 1), len(keys) - 1)
    return np.asarray(np.abs(keys[near] - sought) <= 1)


def _place_keys(road: IntArray, s: FloatArray) -> IntArray:
    """Return whole numbers that tell places of roads apart."""
    step = np.rint(np.nan_to_num(s) / defaults.CHECK_SAME_S).astype(np.int64)
    return np.asarray(road * (1 << 44) + np.clip(step, 0, (1 << 43) - 1))


def _check_widths(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Look at the widths of lanes."""
    width, table = drive.lanes.width, drive.lanes
    owner = owners(width.start)
    begin = drive.sections.s[table.section]
    lines = drive.record_lines["width"]

    def add(rule: str, row: IntArray, value: FloatArray, ds: FloatArray | float = 0.0) -> None:
        lane = owner[row]
        findings.add(
            rule,
            road=lanes.road[lane],
            lane=table.id[lane],
            s=begin[lane] + width.s[row] + ds,
            value=value,
            line=lines[row],
        )

    first = width.start[:-1][np.diff(width.start) > 0]
    # The centre lane needs no width, but many give it one.
    first = first[above("late-width", width.s[first]) & (table.id[owner[first]] != 0)]
    add("late-width", first, width.s[first])
    row = joints(width.start)
    value, _ = record_ends(width, row - 1)
    step = np.abs(width.a[row] - value)
    bad = above("width-step", step)
    add("width-step", row[bad], step[bad])
    least, at = _least(width, spans(width, drive.sections.end[table.section] - begin))
    worst = worst_of(owner, -least)
    worst = worst[above("negative-width", -least[worst])]
    add("negative-width", worst, -least[worst], at[worst])


def _least(profile: CubicProfile, span: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the smallest value of each record, and where, both (records,)."""
    a, b, c, d = profile.a, profile.b, profile.c, profile.d
    with np.errstate(divide="ignore", invalid="ignore"):
        # Where b + 2c·ds + 3d·ds² is 0; the second form holds where d is 0.
        root = np.sqrt(np.maximum(c * c - 3 * b * d, 0.0))
        places = [np.zeros_like(span), span, (-c + root) / (3 * d), (-c - root) / (3 * d), -b / (2 * c)]
    at = np.clip(np.nan_to_num(np.stack(places), posinf=0.0, neginf=0.0), 0.0, span)
    value = np.nan_to_num(a + at * (b + at * (c + at * d)), nan=np.inf)
    which = value.argmin(0)
    rows = np.arange(len(span))
    least = np.where(span > 0, value[which, rows], np.inf)
    return np.where(np.isinf(least), 0.0, least), at[which, rows]
