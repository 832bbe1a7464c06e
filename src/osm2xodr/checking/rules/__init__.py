"""The rules that a road network is checked against, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from osm2xodr.checking.rules.geometry import GEOMETRY_RULES
from osm2xodr.checking.rules.junctions import JUNCTION_RULES
from osm2xodr.checking.rules.readers import READER_RULES
from osm2xodr.checking.rules.rule import DEFAULT_READERS, READERS, Limit, Rule, Severity
from osm2xodr.checking.rules.structure import STRUCTURE_RULES

__all__ = ["DEFAULT_READERS", "READERS", "RULES", "Limit", "Rule", "Severity"]

RULES: Final[Mapping[str, Rule]] = MappingProxyType(
    {rule.name: rule for rule in (*STRUCTURE_RULES, *JUNCTION_RULES, *GEOMETRY_RULES, *READER_RULES)}
)
