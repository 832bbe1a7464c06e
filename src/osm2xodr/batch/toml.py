"""Files in TOML that people write, and what is said of keys that are unknown in them."""

from __future__ import annotations

import difflib
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
        document: dict[str, Any] = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"{path} is not TOML: {error}; see https://toml.io") from error
    return document


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
