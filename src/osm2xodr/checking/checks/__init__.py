"""The checks of a road network."""

from __future__ import annotations

from osm2xodr.checking.checks.common import lane_index as lane_index
from osm2xodr.checking.checks.links import check_links, check_ways_on, transitions as transitions
from osm2xodr.checking.checks.phases import check_phases
from osm2xodr.checking.checks.readers import check_misfits, check_readers
from osm2xodr.checking.checks.references import check_references
from osm2xodr.checking.checks.roads import check_lanes, check_plan_views, check_profiles
from osm2xodr.checking.checks.schema import Violation as Violation, schema_violations as schema_violations
from osm2xodr.checking.checks.surfaces import check_clearances, check_surfaces
from osm2xodr.checking.findings import Findings
from osm2xodr.opendrive import OpenDrive
from osm2xodr.system import advance


def check_tables(drive: OpenDrive, head: str, findings: Findings) -> None:
    """Check everything that was read of a file; `head` is its text up to the first road, as written."""
    lanes = lane_index(drive)
    check_misfits(drive, findings)
    check_references(drive, lanes, findings)
    check_readers(drive, lanes, head, findings)
    check_plan_views(drive, findings)
    check_profiles(drive, lanes, findings)
    check_lanes(drive, lanes, findings)
    advance(0.2)
    steps = transitions(drive, lanes, findings)
    check_links(drive, lanes, steps, findings)
    check_ways_on(drive, lanes, steps, findings)
    advance(0.25)
    check_surfaces(drive, lanes, findings)
    advance(0.75)
    check_clearances(drive, lanes, findings)
    check_phases(drive, lanes, findings)
