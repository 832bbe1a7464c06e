"""What a road network must not have, by rule."""

from __future__ import annotations

from osm2xodr.checking.rules.rule import DEFAULT_READERS, READERS, Rule, Severity
from osm2xodr.checking.rules.table import RULES

__all__ = ["DEFAULT_READERS", "READERS", "RULES", "Rule", "Severity"]
