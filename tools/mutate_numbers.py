"""Change the numbers of a wing of the geometry, one at a time, and see whether its tests notice.

    python tools/mutate_numbers.py heights lanes junctions

Every number in the wing's ``defaults.py`` and at the top of its modules becomes 0, and ten times itself; the tests of
the wing alone should then fail. Changes of code are mutmut's part (``make mutants`` does both). Prints what survives.
"""

from __future__ import annotations

import contextlib
import importlib
import math
import os
import pkgutil
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType, ModuleType

import pytest

ROOT = Path(__file__).resolve().parent.parent
FACTORS = (0.0, 10.0)
KILLED = 0.9


@dataclass(frozen=True)
class Number:
    """A number, or a table of numbers, at the top of a module."""

    module: str
    name: str


def is_number(value: object) -> bool:
    """Whether a value can be scaled."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and value != 0 and math.isfinite(value)


def scaled(value: object, factor: float) -> object:
    """Return a number, or a mapping or tuple of numbers, times a factor."""
    if isinstance(value, Mapping):
        return MappingProxyType({key: scaled(item, factor) for key, item in value.items()})
    if isinstance(value, tuple):
        return tuple(scaled(item, factor) for item in value)
    return type(value)(value * factor) if isinstance(value, (int, float)) and is_number(value) else value


def can_be_scaled(value: object) -> bool:
    """Whether a value is a number or holds one."""
    if isinstance(value, Mapping):
        return any(map(can_be_scaled, value.values()))
    return any(map(can_be_scaled, value)) if isinstance(value, tuple) else is_number(value)


def modules_of(wing: str) -> list[ModuleType]:
    """Import a wing and return its modules."""
    package = importlib.import_module(f"osm2xodr.geometry.{wing}")
    names = [item.name for item in pkgutil.iter_modules(package.__path__)]
    return [importlib.import_module(f"osm2xodr.geometry.{wing}.{name}") for name in names]


def numbers_of(wing: str) -> Iterator[Number]:
    """Return the numbers that are defined, not imported, in a wing."""
    for module in modules_of(wing):
        source = Path(str(module.__file__)).read_text(encoding="utf-8")
        for name, value in vars(module).items():
            defined = any(line.startswith((f"{name}:", f"{name} =")) for line in source.splitlines())
            if name.lstrip("_").isupper() and defined and can_be_scaled(value):
                yield Number(module.__name__, name)


def survives(number: Number, factor: float, tests: Path) -> bool:
    """Run the tests in a copy of this process in which the number is changed; whether they pass."""
    child = os.fork()
    if child == 0:
        old = getattr(sys.modules[number.module], number.name)
        new = scaled(old, factor)
        for name, module in list(sys.modules.items()):
            if name.startswith("osm2xodr") and getattr(module, number.name, None) is old:
                setattr(module, number.name, new)
        with open(os.devnull, "w", encoding="utf-8") as nowhere, contextlib.redirect_stdout(nowhere):
            status = pytest.main([str(tests), "-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist"])
        os._exit(int(status))
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def main(wings: list[str]) -> int:
    """Try all numbers of the wings; 1 where fewer than nine in ten changes are noticed."""
    # Loaded once, for all copies.
    importlib.import_module("osm2xodr.pipeline")
    status = 0
    for wing in wings:
        tests = ROOT / "tests" / "geometry" / wing
        changes = [(number, factor) for number in numbers_of(wing) for factor in FACTORS]
        left = []
        for number, factor in changes:
            if survives(number, factor, tests):
                left.append(f"{number.module}.{number.name} x {factor:g}")
                sys.stdout.write(f"survives: {left[-1]}\n")
                sys.stdout.flush()
        share = 1.0 - len(left) / len(changes)
        sys.stdout.write(f"{wing}: {share:.1%} of {len(changes)} changed numbers are noticed\n")
        status |= share < KILLED
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:] or ["heights", "lanes", "junctions"]))
