"""All rules by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from osm2xodr.checking.geometry_rules import GEOMETRY_RULES
from osm2xodr.checking.junction_rules import JUNCTION_RULES
from osm2xodr.checking.reader_rules import READER_RULES
from osm2xodr.checking.rules import Rule
from osm2xodr.checking.structure_rules import STRUCTURE_RULES

RULES: Final[Mapping[str, Rule]] = MappingProxyType(
    {rule.name: rule for rule in (*STRUCTURE_RULES, *JUNCTION_RULES, *GEOMETRY_RULES, *READER_RULES)}
)
