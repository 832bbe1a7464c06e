"""The checks of a road network."""

from __future__ import annotations

from osm2xodr.checking.checks.index import LaneIndex, lane_index
from osm2xodr.checking.checks.lane_transitions import transitions
from osm2xodr.checking.checks.lanes import check_lanes
from osm2xodr.checking.checks.links import check_links, check_ways_on
from osm2xodr.checking.checks.phases import check_phases
from osm2xodr.checking.checks.plan_views import check_plan_views
from osm2xodr.checking.checks.profiles import check_profiles
from osm2xodr.checking.checks.readers import check_misfits, check_readers
from osm2xodr.checking.checks.references import check_references
from osm2xodr.checking.checks.schema import schema_violations
from osm2xodr.checking.checks.surfaces import check_surfaces

__all__ = [
    "LaneIndex",
    "check_lanes",
    "check_links",
    "check_misfits",
    "check_phases",
    "check_plan_views",
    "check_profiles",
    "check_readers",
    "check_references",
    "check_surfaces",
    "check_ways_on",
    "lane_index",
    "schema_violations",
    "transitions",
]
