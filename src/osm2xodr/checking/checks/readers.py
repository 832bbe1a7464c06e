"""What single readers of OpenDRIVE fail on, and what the reader of this package could not read."""

from __future__ import annotations

import re
from typing import Final

import numpy as np

from osm2xodr.checking.checks.common import LaneIndex, above, add_furniture, lane_place, road_place
from osm2xodr.checking.findings import Findings
from osm2xodr.curves import owners, sorted_unique
from osm2xodr.defaults import NEGATED_LANES
from osm2xodr.diagnostics import counted
from osm2xodr.opendrive import OpenDrive

# The rule that each kind of the reader's misfits breaks; the rule is `unreadable` for all others.
_MISFIT_RULES: Final = {
    "bad-number": "not-a-number",
    "unsorted-records": "record-order",
    "unknown-element": "misplaced",
    "misplaced-element": "misplaced",
    "repeated-element": "misplaced",
    "include": "misplaced",
    "namespace": "namespace",
}
# Misfits that other rules describe better.
_STATED_BETTER: Final = re.compile(
    r"<connection> has no attribute (id|incomingRoad|connectingRoad|linkedRoad|contactPoint)"
    r"|<(road|laneSection)> has no (<lanes>|<planView>|centre lane)"
    r"|<geometry> has no shape"
    r"|<laneSection> has no centre lane"
)
# Largest id in a signed integer of 32 bits. Junction ids of 3e9 fail in CARLA, whose own limit was not searched for.
_LARGEST_ID: Final = 2**31 - 1
# Words of PROJ strings that esmini does not know; it logs an error.
_ESMINI_UNKNOWN: Final = re.compile(r"\+(no_defs|type)\b")
_ROADRUNNER_VERSIONS: Final = frozenset({(1, 4), (1, 5), (1, 6)})
_CENTRE: Final = 0
_SIGNALS: Final = frozenset({"signal", "signalReference"})
_DIRECTIONS: Final = frozenset({"+", "-"})
# OpenDRIVE's code of the lights for cars.
_LIGHT: Final = "1000001"


def check_misfits(drive: OpenDrive, findings: Findings) -> None:
    """Report what the reader could not read."""
    for item in drive.misfits:
        if _STATED_BETTER.match(item.text):
            continue
        rule = _MISFIT_RULES.get(item.rule, "unreadable")
        if item.rule == "misplaced-user-data":
            rule = "user-data-in-geometry" if "<geometry>" in item.text else "user-data-in-elevation"
        findings.add(rule, road=[item.road], line=[item.line], other=[item.text])


def check_readers(drive: OpenDrive, lanes: LaneIndex, head: str, findings: Findings) -> None:
    """Check for what single readers fail on; `head` is the text of the file up to its first road, as written."""
    _check_ids(drive, findings)
    _check_header(drive, head, findings)
    _check_side(drive, head, findings)
    _check_signals(drive, findings)
    _check_lanes(drive, lanes, findings)
    _check_coordinates(drive, findings)


def _fits(text: str, least: int) -> bool:
    """Whether an id is a whole number that readers can keep."""
    return text.isascii() and text.isdigit() and least <= int(text) <= _LARGEST_ID


def _check_ids(drive: OpenDrive, findings: Findings) -> None:
    """Check the ids of roads and junctions."""
    roads, junctions = drive.roads, drive.junctions
    bad = [k for k, name in enumerate(roads.id) if not _fits(name, 0)]
    findings.add("road-id-not-number", road=bad, line=roads.line[bad], other=[repr(roads.id[k]) for k in bad])
    below = [k for k, name in enumerate(roads.id) if re.fullmatch(r"-\d+", name)]
    findings.add("negative-road-id", road=below, line=roads.line[below], other=[roads.id[k] for k in below])
    bad = [k for k, name in enumerate(junctions.id) if not _fits(name, 1)]
    findings.add("junction-id-not-number", line=junctions.line[bad], other=[junctions.id[k] for k in bad])
    road_ids = set(roads.id)
    shared = [k for k, name in enumerate(junctions.id) if name in road_ids]
    findings.add("junction-id-of-road", line=junctions.line[shared], other=[junctions.id[k] for k in shared])


def _check_header(drive: OpenDrive, head: str, findings: Findings) -> None:
    """Check the header."""
    header = drive.header
    line = [_line_of(head, "<geoReference") or _line_of(head, "<header")]
    text = header.geo_reference
    if not text:
        findings.add("no-georeference", line=line)
    else:
        if "+lat_0=" not in text or "+lon_0=" not in text:
            findings.add("georeference-without-origin", line=line)
        if "+proj" not in text:
            findings.add("georeference-not-proj", line=line)
        words = [match.group() for match in _ESMINI_UNKNOWN.finditer(text)]
        found = re.search(r"<geoReference[^>]*>(.*?)</geoReference>", head, re.DOTALL)
        if found and "\n" in found.group(1):
            words.append("a line break")
        if words:
            findings.add("georeference-words", line=line, other=[", ".join(words)])
    if header.offset is not None and any(header.offset):
        message = ", ".join(
            f"{name} {value:g}" for name, value in zip(("x", "y", "z", "hdg"), header.offset, strict=True) if value
        )
        findings.add("header-offset", line=[_line_of(head, "<offset")], other=[message])
    if header.revision not in _ROADRUNNER_VERSIONS:
        version = ".".join(str(part) for part in header.revision) if min(header.revision) >= 0 else "not stated"
        findings.add("version-unread", line=[_line_of(head, "<header")], other=[version])


def _check_side(drive: OpenDrive, head: str, findings: Findings) -> None:
    """Check for traffic on the left, which some readers have to be told of."""
    code, value = NEGATED_LANES
    if drive.provenance.get((-1, code)) == value:
        findings.add("left-hand-negated", line=[_line_of(head, f'code="{code}"')])
    else:
        findings.add("left-hand-ignored", **road_place(drive, np.flatnonzero(drive.roads.left_hand)[:1]))


def _line_of(text: str, what: str) -> int:
    """Return the line in which a text stands first; 0 where it does not."""
    at = text.find(what)
    return text.count("\n", 0, at) + 1 if at >= 0 else 0


def _check_signals(drive: OpenDrive, findings: Findings) -> None:
    """Check signals and objects."""
    # Only what names a road of the file and an s can be off that road.
    here = [item for item in drive.furniture if item.road >= 0 and item.s == item.s]
    s = np.array([item.s for item in here])
    off = np.maximum(-s, s - drive.roads.length[[item.road for item in here]]) if here else s
    beyond = np.flatnonzero(above("signal-off-road", off))
    add_furniture("signal-off-road", [here[k] for k in beyond], findings, value=off[beyond].tolist())
    static = [item for item in drive.furniture if item.kind == "signal" and "dynamic" not in item.attributes]
    add_furniture("signal-not-dynamic", static, findings, [item.attributes.get("id", "") for item in static])
    directed = [
        item
        for item in drive.furniture
        if item.kind in _SIGNALS and not item.validity and item.attributes.get("orientation") in _DIRECTIONS
    ]
    # Reported once: a file that leaves one out leaves all out.
    first = directed[:1]
    add_furniture("signal-without-lanes", first, findings, [counted(len(directed), "signal")] * len(first))
    _check_controllers(drive, findings)
    _check_crosswalks(drive, findings)


def _check_controllers(drive: OpenDrive, findings: Findings) -> None:
    """Check whether CARLA switches the lights of all controllers."""
    signals = (item.attributes for item in drive.furniture if item.kind == "signal")
    lights = {item.get("id") for item in signals if item.get("type") == _LIGHT}
    named = {name for _, name in drive.junctions.controllers}
    apart = [item for item in drive.controllers if item.id not in named and not lights.isdisjoint(item.signal_ids)]
    findings.add("controller-apart", line=[item.line for item in apart], other=[item.id for item in apart])


def _check_crosswalks(drive: OpenDrive, findings: Findings) -> None:
    """Check whether CARLA sees the outlines of crosswalks and can separate them."""
    crosswalks = [item for item in drive.furniture if item.attributes.get("type") == "crosswalk" and item.outlines]
    unseen = [item for item in crosswalks if not item.old_outline]
    add_furniture("outlines-unseen", unseen, findings)
    seen = [item for item in crosswalks if item.old_outline]
    endless = [item for item in seen if item.old_outline[0][:2] != item.old_outline[-1][:2]]
    add_furniture("crosswalk-open", endless, findings, [item.attributes.get("id", "") for item in endless])


def _check_lanes(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check lanes and cross sections."""
    table = drive.lanes
    has_border = table.border.start[1:] > table.border.start[:-1]
    has_width = table.width.start[1:] > table.width.start[:-1]
    row = np.flatnonzero(has_border & ~has_width & (table.id != _CENTRE))
    findings.add("border-lanes", **lane_place(drive, lanes, row))
    row = np.flatnonzero(~has_border & ~has_width & (table.id != _CENTRE))
    findings.add("lane-without-width", **lane_place(drive, lanes, row))
    # What follows is reported once for the file: all its roads have it for one reason.
    row = np.flatnonzero((table.height != 0).any(1))
    findings.add("lane-height-ignored", **lane_place(drive, lanes, row[:1]), other=[counted(len(row), "lane")])
    bank = drive.superelevation
    tilted = (bank.a != 0) | (bank.b != 0) | (bank.c != 0) | (bank.d != 0)
    owner = owners(bank.start)
    banked = sorted_unique(owner[tilted])
    if len(banked):
        steepest = int(owner[tilted][np.argmax(np.abs(np.nan_to_num(bank.a[tilted])))])
        place = road_place(drive, np.array([steepest]))
        findings.add("superelevation-ignored", other=[counted(len(banked), "road")], **place)


def _check_coordinates(drive: OpenDrive, findings: Findings) -> None:
    """Check how far from the origin roads lie."""
    plan = drive.plan_view
    size = np.fmax(np.abs(plan.x), np.abs(plan.y))
    if np.isfinite(size).any():
        far = int(np.nanargmax(size))
        if above("large-coordinates", size[far]):
            road = int(owners(plan.start)[far])
            line = [int(plan.line[far])]
            findings.add("large-coordinates", road=[road], s=[float(plan.s[far])], value=[size[far]], line=line)
