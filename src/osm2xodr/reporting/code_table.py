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
        found[name] = Code(kinds, meaning, remedy, item.getint("harm"))
    return MappingProxyType(found)
