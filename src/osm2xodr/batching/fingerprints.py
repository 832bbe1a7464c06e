"""What each area was made of, so that a batch that is started again leaves alone what has not changed."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from osm2xodr import __version__
from osm2xodr.system import parse_json, stream_to

# Version of the layout of states; a file of another version counts as no state.
_FORMAT: Final = 1


@dataclass(frozen=True, slots=True)
class Mark:
    """A file at some time: its size, bytes, time of change, ns since 1970, and SHA-256."""

    path: str
    size: int
    mtime_ns: int
    sha256: str


@dataclass(frozen=True, slots=True)
class State:
    """What an area was made of, and what was made of it."""

    arguments: tuple[str, ...]  # Of ``osm2xodr``, without bounds on memory and time
    inputs: tuple[Mark, ...]  # Files that were read, apart from the cut
    # The map that the area was cut out of, and the SHA-256 of outline and frame; None and empty without a cut
    cut_from: Mark | None = None
    cut_how: str = ""
    cut: Mark | None = None  # What was cut out
    outputs: tuple[Mark, ...] = ()  # Files that were made; none where there is nothing to drive on
    version: str = __version__  # Of osm2xodr


class Marks:
    """Marks of files; a file is only read again if its size or time of change differ."""

    def __init__(self) -> None:
        self._known: dict[str, Mark] = {}

    def learn(self, states: Iterable[State]) -> None:
        """Take over the marks of earlier runs."""
        for state in states:
            for mark in (*state.inputs, *state.outputs, state.cut_from):
                if mark is not None:
                    self._known[mark.path] = mark

    def of(self, path: Path) -> Mark | None:
        """Return the mark of a file; None if it cannot be read."""
        key = str(path)
        try:
            found = path.stat()
            known = self._known.get(key)
            if known is None or (known.size, known.mtime_ns) != (found.st_size, found.st_mtime_ns):
                known = Mark(key, found.st_size, found.st_mtime_ns, _sha256(path))
                self._known[key] = known
        except OSError:
            return None
        return known

    def of_all(self, paths: Sequence[Path]) -> tuple[Mark, ...] | None:
        """Return the marks of files; None if one of them cannot be read."""
        marks = [self.of(path) for path in paths]
        found = tuple(mark for mark in marks if mark is not None)
        return found if len(found) == len(marks) else None

    def same(self, mark: Mark | None) -> bool:
        """Return whether a file still has the contents of its mark."""
        now = None if mark is None else self.of(Path(mark.path))
        return now is not None and mark is not None and now.sha256 == mark.sha256


def contents(marks: Iterable[Mark]) -> list[tuple[str, str]]:
    """Return paths and SHA-256, without times of change."""
    return [(mark.path, mark.sha256) for mark in marks]


def load_state(path: Path) -> State | None:
    """Read a state; None if there is none, or none of this layout."""
    try:
        data: Any = parse_json(path.read_bytes())
        if data.pop("format") != _FORMAT:
            return None
        data["arguments"] = tuple(data["arguments"])
        for name in ("inputs", "outputs"):
            data[name] = tuple(Mark(**item) for item in data[name])
        for name in ("cut_from", "cut"):
            data[name] = Mark(**data[name]) if data[name] is not None else None
        return State(**data)
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        return None


def save_state(path: Path, state: State) -> None:
    """Write a state, as a whole or not at all."""
    text = json.dumps({"format": _FORMAT, **dataclasses.asdict(state)}, indent=1)
    with stream_to(path) as stream:
        stream.write(text.encode("ascii") + b"\n")


def remove(*paths: Path) -> None:
    """Remove files, those of them that exist."""
    for path in paths:
        path.unlink(missing_ok=True)


def _sha256(path: Path) -> str:
    digest = hashlib.sha256()
    with path.open("rb") as stream:
        while block := stream.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()
