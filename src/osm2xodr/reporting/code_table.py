"""What the codes of diagnostics mean, what to do about them, and which of them need attention."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

from osm2xodr.diagnostics import Kind


@dataclass(frozen=True, slots=True)
class Code:
    """What one code means; ``codes.ini`` says what the fields are."""

    kinds: tuple[Kind, ...]
    meaning: str
    remedy: str
    harm: int | None  # None where it needs no attention
    osm: tuple[Kind, ...]  # Kinds of it that stand for mistakes in OSM
    correction: str  # Key and value of a correction, as an example; empty where none helps

    def line_for(self, osm_id: str) -> str:
        """Return a line for a file of corrections about an element, such as ``way.1.lanes = 2``; empty for none."""
        kind, _, number = osm_id.partition("/")
        return f"{kind}.{number}.{self.correction}" if self.correction and number else ""


@cache
def codes() -> Mapping[str, Code]:
    """Return all codes of diagnostics, by name."""
    # Here, so that commands that need none of it start at once.
    from configparser import ConfigParser
    from importlib import resources

    parser = ConfigParser(delimiters="=", interpolation=None)
    parser.read_string(resources.files("osm2xodr.reporting").joinpath("codes.ini").read_text(encoding="utf-8"))
    found = {}
    for name in parser.sections():
        item = parser[name]
        kinds = tuple(Kind(word) for word in item["kinds"].split(", "))
        meaning, remedy = (" ".join(item[key].split()) for key in ("meaning", "remedy"))
        osm = tuple(Kind(word) for word in item.get("osm", "").split(", ") if word)
        found[name] = Code(kinds, meaning, remedy, item.getint("harm"), osm, item.get("correction", ""))
    return MappingProxyType(found)
