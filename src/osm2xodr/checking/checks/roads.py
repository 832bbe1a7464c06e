"""Roads, each by itself: records and lanes along it that do not fit each other.

Gaps, kinks and steps between records, lengths unlike those of curves, widths and grades; ids of lanes, sections,
edges that jump, lanes that fold over themselves in curves.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.checking.checks.common import (
    LaneIndex,
    above,
    degrees,
    first_rows,
    followers,
    lane_place,
    record_ends,
    record_poses,
    road_place,
    spans,
    worst_of,
)
from osm2xodr.checking.findings import RULES, SAME_S, TAPERED_WIDTH, Findings, Place
from osm2xodr.curves import owners, repeated, runs, sorted_unique
from osm2xodr.defaults import CONNECTING_RADIUS
from osm2xodr.model import BoolArray, CubicProfile, FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, End, OpenDrive, Shape, curvature, lane_borders, record_lengths, section_at

_POLYNOMIALS = (Shape.POLY3, Shape.PARAM_POLY3)

_PERCENT = 100.0
# Stations that fit into a key of 64 bits beside the road's index.
_STATIONS = 1 << 44

# Where curves are examined, as shares of their records; at the very ends the neighbouring records hold as well.
_SHARES: Final = (1e-6, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1 - 1e-6)
# Records of plan views whose lanes are examined at once; more would take much memory.
_BLOCK: Final = 1 << 13
# Straighter curves are neither tight nor fold any lane, 1/m: no carriageway reaches 200 m to one side.
_STRAIGHT: Final = 0.005


def check_plan_views(drive: OpenDrive, findings: Findings) -> None:
    """Check the plan views of all roads."""
    _check_lengths(drive, findings)
    _check_followers(drive, findings)
    _check_shapes(drive, findings)


def _place_of_geometry(drive: OpenDrive, row: IntArray) -> Place:
    """Return where records are, for findings."""
    plan = drive.plan_view
    return {"road": owners(plan.start)[row], "s": plan.s[row], "line": plan.line[row]}


def _add_geometry(rule: str, drive: OpenDrive, row: IntArray, value: FloatArray, findings: Findings) -> None:
    """Add findings about records whose values are above the limit."""
    bad = np.flatnonzero(above(rule, value))
    findings.add(rule, value=value[bad], **_place_of_geometry(drive, row[bad]))


def _check_lengths(drive: OpenDrive, findings: Findings) -> None:
    """Check the lengths of roads and of their records."""
    plan, roads = drive.plan_view, drive.roads
    findings.add("no-plan-view", **road_place(drive, np.flatnonzero(np.diff(plan.start) == 0)))
    for rule, find in (("zero-length", lambda length: length <= 0), ("short-record", _is_short)):
        row = np.flatnonzero(find(plan.length))
        findings.add(rule, value=plan.length[row], other=lambda _: "the record", **_place_of_geometry(drive, row))
        road = np.flatnonzero(find(roads.length))
        place = road_place(drive, road, np.zeros(len(road)))
        findings.add(rule, value=roads.length[road], other=lambda _: "the road", **place)
    total = np.bincount(owners(plan.start), weights=plan.length, minlength=len(roads.id))
    off = np.abs(total - roads.length)
    wrong = np.flatnonzero(above("road-length", off) & (np.diff(plan.start) > 0))
    findings.add("road-length", value=off[wrong], **road_place(drive, wrong, roads.length[wrong]))
    _add_geometry(
        "record-length", drive, np.arange(len(plan.s)), np.abs(record_lengths(drive) - plan.length), findings
    )


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
    _add_geometry("record-s", drive, first, np.abs(plan.s[first]), findings)
    _add_geometry("record-s", drive, row, np.abs(plan.s[row] - plan.s[before] - plan.length[before]), findings)
    x, y, hdg = record_poses(drive, before, plan.length[before])
    at_x, at_y, at_hdg = record_poses(drive, row, np.zeros(len(row)))
    _add_geometry("record-gap", drive, row, np.hypot(at_x - x, at_y - y), findings)
    _add_geometry("record-kink", drive, row, degrees(at_hdg - hdg), findings)


def _check_shapes(drive: OpenDrive, findings: Findings) -> None:
    """Check each shape by itself."""
    plan = drive.plan_view
    findings.add("unknown-shape", **_place_of_geometry(drive, np.flatnonzero(plan.shape == Shape.UNKNOWN)))
    row = np.flatnonzero(np.isin(plan.shape, _POLYNOMIALS))
    _, _, hdg = record_poses(drive, row, np.zeros(len(row)))
    _add_geometry("start-tangent", drive, row, degrees(hdg - plan.hdg[row]), findings)


def check_profiles(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check all piecewise cubics."""
    _check_starts(drive, findings)
    _check_heights(drive, findings)
    _check_grades(drive, findings)
    _check_lane_offsets(drive, findings)
    _check_widths(drive, lanes, findings)


def _place_of_profile(drive: OpenDrive, name: str, row: IntArray) -> Place:
    """Return where records of a profile of roads are, for findings."""
    profile: CubicProfile = getattr(drive, name)
    return {"road": owners(profile.start)[row], "s": profile.s[row], "line": drive.record_lines[name][row]}


def _add_profile(
    rule: str, drive: OpenDrive, name: str, row: IntArray, value: FloatArray, findings: Findings
) -> None:
    """Add findings about records of a profile of roads whose values are above the limit."""
    bad = np.flatnonzero(above(rule, value))
    findings.add(rule, value=value[bad], **_place_of_profile(drive, name, row[bad]))


def _check_starts(drive: OpenDrive, findings: Findings) -> None:
    """Check whether first records begin at the start of the road."""
    for rule, name in (
        ("late-elevation", "elevation"),
        ("late-record", "superelevation"),
        ("late-record", "lane_offset"),
    ):
        profile: CubicProfile = getattr(drive, name)
        row = first_rows(profile.start)
        row = row[above(rule, profile.s[row])]
        words = [name.replace("_", " ")] * len(row)
        findings.add(rule, value=profile.s[row], other=words, **_place_of_profile(drive, name, row))


def _check_heights(drive: OpenDrive, findings: Findings) -> None:
    """Check for steps of height, grade and superelevation."""
    profile = drive.elevation
    row = followers(profile.start)
    value, slope = record_ends(profile, row - 1)
    _add_profile("height-step", drive, "elevation", row, np.abs(profile.a[row] - value), findings)
    _add_profile("grade-step", drive, "elevation", row, _PERCENT * np.abs(profile.b[row] - slope), findings)
    profile = drive.superelevation
    row = followers(profile.start)
    value, _ = record_ends(profile, row - 1)
    _add_profile("superelevation-step", drive, "superelevation", row, degrees(profile.a[row] - value), findings)


def _check_grades(drive: OpenDrive, findings: Findings) -> None:
    """Check for roads that are too steep: one finding for each, at its steepest place."""
    profile = drive.elevation
    span = spans(profile, drive.roads.length)
    with np.errstate(divide="ignore", invalid="ignore"):
        # Where the grade's derivative 2c + 6d·ds is 0.
        turn = np.clip(np.nan_to_num(-profile.c / (3 * profile.d)), 0.0, span)
    at = np.stack([np.zeros_like(span), turn, span])
    grade = np.abs(profile.b + at * (2 * profile.c + 3 * at * profile.d))
    # A record that holds nowhere does not count.
    grade[:, span <= 0] = 0.0
    which = grade.argmax(0)
    rows = np.arange(len(span))
    steepest = _PERCENT * np.nan_to_num(grade[which, rows])
    worst = worst_of(owners(profile.start), steepest)
    excess = above("grade-excess", steepest[worst])
    for rule, wanted in (("grade-excess", excess), ("grade-steep", above("grade-steep", steepest[worst]) & ~excess)):
        row = worst[wanted]
        place = _place_of_profile(drive, "elevation", row)
        place["s"] = place["s"] + at[which[row], row]
        findings.add(rule, value=steepest[row], **place)


def _check_lane_offsets(drive: OpenDrive, findings: Findings) -> None:
    """Check for steps of the lane offset; at the start of a lane section lanes may make up for them."""
    profile = drive.lane_offset
    row = followers(profile.start)
    row = row[~_at_section(drive, owners(profile.start)[row], profile.s[row])]
    value, _ = record_ends(profile, row - 1)
    _add_profile("lane-offset-step", drive, "lane_offset", row, np.abs(profile.a[row] - value), findings)


def _at_section(drive: OpenDrive, road: IntArray, s: FloatArray) -> BoolArray:
    """Whether a lane section of a road begins at s, (n,)."""
    sections = drive.sections
    keys = np.sort(_station_keys(sections.road, sections.s))
    sought = _station_keys(road, s)
    if not len(keys):
        return np.zeros(len(sought), bool)
    near = np.minimum(np.searchsorted(keys, sought - 1), len(keys) - 1)
    return np.asarray(np.abs(keys[near] - sought) <= 1)


def _station_keys(road: IntArray, s: FloatArray) -> IntArray:
    """Return one whole number for a road and a station; those of neighbouring stations differ by 1."""
    step = np.rint(np.nan_to_num(s) / SAME_S).astype(np.int64)
    return np.asarray(road * _STATIONS + np.clip(step, 0, _STATIONS // 2 - 1))


def _check_widths(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check the widths of lanes."""
    width, table = drive.lanes.width, drive.lanes
    owner = owners(width.start)
    begin = drive.sections.s[table.section]

    def add(rule: str, row: IntArray, value: FloatArray, ds: FloatArray | float = 0.0) -> None:
        lane = owner[row]
        s = begin[lane] + width.s[row] + ds
        line = drive.record_lines["width"][row]
        findings.add(rule, road=lanes.road[lane], lane=table.id[lane], s=s, value=value, line=line)

    first = first_rows(width.start)
    # The centre lane needs no width, but many writers give it one.
    first = first[above("late-width", width.s[first]) & (table.id[owner[first]] != 0)]
    add("late-width", first, width.s[first])
    row = followers(width.start)
    value, _ = record_ends(width, row - 1)
    step = np.abs(width.a[row] - value)
    bad = above("width-step", step)
    add("width-step", row[bad], step[bad])
    least, at = _minima(width, spans(width, drive.sections.end[table.section] - begin))
    worst = worst_of(owner, -least)
    worst = worst[above("negative-width", -least[worst])]
    add("negative-width", worst, -least[worst], at[worst])


def _minima(profile: CubicProfile, span: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the smallest value of each record, and at which ds, both (records,)."""
    a, b, c, d = profile.a, profile.b, profile.c, profile.d
    with np.errstate(divide="ignore", invalid="ignore"):
        # Where b + 2c·ds + 3d·ds² is 0; the last form holds where d is 0.
        root = np.sqrt(np.maximum(c * c - 3 * b * d, 0.0))
        places = [np.zeros_like(span), span, (-c + root) / (3 * d), (-c - root) / (3 * d), -b / (2 * c)]
    at = np.clip(np.nan_to_num(np.stack(places), posinf=0.0, neginf=0.0), 0.0, span)
    value = np.nan_to_num(a + at * (b + at * (c + at * d)), nan=np.inf)
    which = value.argmin(0)
    rows = np.arange(len(span))
    least = np.where(span > 0, value[which, rows], np.inf)
    return np.where(np.isinf(least), 0.0, least), at[which, rows]


def check_lanes(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check lanes and their sections."""
    _check_sections(drive, findings)
    _check_ids(drive, lanes, findings)
    _check_section_gaps(drive, lanes, findings)
    if findings.wants("folded-lane", "tight-curve"):
        _check_curves(drive, lanes, findings)


def _check_sections(drive: OpenDrive, findings: Findings) -> None:
    """Check where lane sections begin."""
    sections, roads = drive.sections, drive.roads
    findings.add("no-lane-section", **road_place(drive, np.flatnonzero(np.diff(sections.start) == 0)))
    first = first_rows(sections.start)
    late = first[above("section-order", np.abs(sections.s[first]))]
    beyond = np.flatnonzero((sections.s >= roads.length[sections.road]) & (sections.s > 0))
    follows = followers(sections.start)
    twice = follows[sections.s[follows] - sections.s[follows - 1] <= SAME_S]
    for row, text in (
        (late, "the first lane section does not begin at s = 0"),
        (beyond, "the lane section begins after the end of the road"),
        (twice, "two lane sections begin at the same place, or in descending order"),
    ):
        place: Place = {"road": sections.road[row], "s": sections.s[row], "line": sections.line[row]}
        findings.add("section-order", other=[text] * len(row), **place)


def _check_ids(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check the ids of lanes, which are stored from left to right."""
    table, sections = drive.lanes, drive.sections
    centres = np.bincount(table.section[table.id == 0], minlength=len(sections.s))
    bare = np.flatnonzero(centres == 0)
    findings.add("no-centre-lane", road=sections.road[bare], s=sections.s[bare], line=sections.line[bare])
    row = followers(table.start)
    row = row[(table.id[row] != ABSENT) & (table.id[row - 1] != ABSENT)]
    fall = table.id[row - 1] - table.id[row]
    same = row[fall == 0]
    findings.add("duplicate-lane-id", other=lambda k: str(table.id[same[k]]), **lane_place(drive, lanes, same))
    # Without a centre lane 1 and -1 are neighbours.
    across = (table.id[row - 1] > 0) & (table.id[row] < 0)
    hole = row[(fall > 1) & ~(across & (fall == 2))]
    findings.add("lane-id-hole", other=lambda k: str(table.id[hole[k]] + 1), **lane_place(drive, lanes, hole))
    # A side without its first lane.
    first = first_rows(table.start)
    last = table.start[1:][np.diff(table.start) > 0] - 1
    for end, missing in ((first, -1), (last, 1)):
        lone = end[(table.id[end] * missing > 0) & (np.abs(table.id[end]) > 1) & (table.id[end] != ABSENT)]
        findings.add("lane-id-hole", other=[str(missing)] * len(lone), **lane_place(drive, lanes, lone))


def _check_section_gaps(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check whether edges continue from section to section."""
    table, sections = drive.lanes, drive.sections
    row = np.flatnonzero(~lanes.is_outermost(table.section, End.END) & (table.successor != ABSENT))
    to = lanes.find(table.section[row] + 1, table.successor[row])
    row, to = row[to >= 0], to[to >= 0]
    s = sections.end[table.section[row]]
    here = lane_borders(drive, row, s, before=True)
    there = lane_borders(drive, to, s)
    gap = np.maximum(np.abs(here[0] - there[0]), np.abs(here[1] - there[1]))
    bad = np.flatnonzero(above("section-gap", gap))
    findings.add(
        "section-gap",
        value=gap[bad],
        other=lambda k: str(table.id[to[bad[k]]]),
        **lane_place(drive, lanes, row[bad], s[bad]),
    )


def _check_curves(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check lanes in curves: one finding for each lane, where it is worst."""
    bent = np.flatnonzero((drive.plan_view.shape != Shape.LINE) & (drive.plan_view.length > 0))
    owner = owners(drive.plan_view.start)
    # A lane is judged in one go: blocks end where roads do.
    begins = np.searchsorted(owner[bent], sorted_unique(owner[bent[::_BLOCK]]))
    for block in np.split(bent, begins[1:]):
        _check_bent(drive, lanes, findings, block, owner)


def _check_bent(drive: OpenDrive, lanes: LaneIndex, findings: Findings, bent: IntArray, owner: IntArray) -> None:
    """Check the lanes in some curves, records of the plan view; `owner` holds the road of each record."""
    plan, table = drive.plan_view, drive.lanes
    record = np.repeat(bent, len(_SHARES))
    s = plan.s[record] + plan.length[record] * np.tile(_SHARES, len(bent))
    road = owner[record]
    bend = curvature(drive, road, s)
    section = section_at(drive, road, s)
    kept = np.flatnonzero((np.abs(np.nan_to_num(bend)) > _STRAIGHT) & (section != ABSENT))
    s, bend, section, record = s[kept], bend[kept], section[kept], record[kept]
    count = np.diff(table.start)[section]
    place = repeated(count)
    lane = runs(table.start[section], count)
    # Only lanes on the inner side of a curve can fold, but any lane can be tight.
    inner, outer = lane_borders(drive, lane, s[place])
    middle, wide = (inner + outer) / 2, np.abs(outer - inner) > TAPERED_WIDTH
    reach = np.maximum(inner * bend[place], outer * bend[place]) - 1
    beyond = reach / np.abs(bend[place])

    def add(rule: str, row: IntArray, value: FloatArray) -> None:
        at, found = place[row], lane[row]
        line = plan.line[record[at]]
        findings.add(rule, road=lanes.road[found], lane=table.id[found], s=s[at], value=value[row], line=line)

    real = wide & (table.id[lane] != 0)
    fold = worst_of(lane, np.where(real, beyond, -np.inf))
    fold = fold[above("folded-lane", beyond[fold]) & real[fold]]
    add("folded-lane", fold, beyond)
    radius = np.abs(1 - middle * bend[place]) / np.abs(bend[place])
    # A lane that folds is not reported as tight as well.
    driven = wide & lanes.driving[lane] & ~np.isin(lane, lane[fold])
    tight = worst_of(lane, np.where(driven, -radius, -np.inf))
    add("tight-curve", tight[(radius[tight] < CONNECTING_RADIUS) & driven[tight]], radius)
