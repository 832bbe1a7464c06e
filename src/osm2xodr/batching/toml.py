"""Files in TOML that people write, and what is said of keys that are unknown in them."""

from __future__ import annotations

import difflib
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from osm2xodr.errors import InputError


def parse_toml(path: Path, text: str) -> dict[str, Any]:
    """Return the contents of a TOML file; `InputError` says where it is none."""
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        document: dict[str, Any] = _within_64_bits(tomllib.loads(text))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is not TOML: {error}; see https://toml.io") from error
    return document


def _within_64_bits(value: Any) -> Any:
    """Return a value with infinity in place of whole numbers of more than the 64 bits that TOML has for them."""
    if isinstance(value, dict):
        return {key: _within_64_bits(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_within_64_bits(item) for item in value]
    if isinstance(value, int) and not -(1 << 63) <= value < 1 << 63:
        return math.inf if value > 0 else -math.inf
    return value


def decoded(path: Path, contents: bytes) -> str:
    """Return the text of a file; `InputError` says where it is not UTF-8."""
    try:
        return contents.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path} is not in UTF-8 ({error.reason} at byte {error.start}); save it as UTF-8"
        ) from error


def unknown_key(key: str, known: Sequence[str]) -> str:
    """Say that a key is unknown, and which one may be meant."""
    near = difflib.get_close_matches(key.replace("_", "-").lstrip("-").lower(), known, 1)
    return f"{key!r} is unknown" + (f"; do you mean {near[0]!r}?" if near else f"; known are {', '.join(known)}")
