"""Lanes within roads: ids, sections, edges that jump, lanes that fold over themselves in curves."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.checking import rules
from osm2xodr.checking.checks.common import LaneIndex, above, first_rows, followers, lane_place, road_place, worst_of
from osm2xodr.checking.findings import Findings, Place
from osm2xodr.curves import owners, repeated, runs, sorted_unique
from osm2xodr.defaults import CONNECTING_RADIUS
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, End, OpenDrive, Shape, curvature, lane_borders, section_at

# Where curves are examined, as shares of their records; at the very ends the neighbouring records hold as well.
_SHARES: Final = (1e-6, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1 - 1e-6)
# Records of plan views whose lanes are examined at once; more would take much memory.
_BLOCK: Final = 1 << 13
# Straighter curves are neither tight nor fold any lane, 1/m: no carriageway reaches 200 m to one side.
_STRAIGHT: Final = 0.005


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
    twice = follows[sections.s[follows] - sections.s[follows - 1] <= rules.SAME_S]
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
    middle, wide = (inner + outer) / 2, np.abs(outer - inner) > rules.TAPERED_WIDTH
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
