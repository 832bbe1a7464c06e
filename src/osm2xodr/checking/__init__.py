"""Checks files of OpenDRIVE of any writer: against the standard, and against what readers stumble over."""

from __future__ import annotations

from osm2xodr.checking.checker import CheckOptions, CheckResult, check_drive, check_file
from osm2xodr.checking.checks import lane_index
from osm2xodr.checking.driving import Driving, contacts_of, driving_of
from osm2xodr.checking.findings import DEFAULT_READERS, READERS, RULES, Count, Finding, Rule, Severity
from osm2xodr.checking.formats import FORMATS

__all__ = [
    "DEFAULT_READERS",
    "FORMATS",
    "READERS",
    "RULES",
    "CheckOptions",
    "CheckResult",
    "Count",
    "Driving",
    "Finding",
    "Rule",
    "Severity",
    "check_drive",
    "check_file",
    "contacts_of",
    "driving_of",
    "lane_index",
]
