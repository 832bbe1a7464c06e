"""Checks files of OpenDRIVE of any writer: against the standard, and against what readers stumble over."""

from __future__ import annotations

from osm2xodr.checking.checker import (
    CheckOptions as CheckOptions,
    CheckResult as CheckResult,
    check_drive as check_drive,
    check_file as check_file,
)
from osm2xodr.checking.checks import lane_index as lane_index
from osm2xodr.checking.driving import Driving as Driving, contacts_of as contacts_of, driving_of as driving_of
from osm2xodr.checking.findings import (
    DEFAULT_READERS as DEFAULT_READERS,
    READERS as READERS,
    RULES as RULES,
    Count as Count,
    Finding as Finding,
    Rule as Rule,
    Severity as Severity,
)
from osm2xodr.checking.formats import FORMATS as FORMATS
