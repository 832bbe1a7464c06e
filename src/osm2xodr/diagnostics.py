"""The one place where stages say what they guessed, dropped or repaired."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum


class Kind(str, Enum):
    """What was done about a defect or a gap in the input."""

    GUESSED = "guessed"
    DROPPED = "dropped"
    REPAIRED = "repaired"
    NOTE = "note"


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One thing that a stage found and what it did about it.

    Parameters
    ----------
    kind
        What was done.
    code
        Short stable name of the finding in kebab-case, e.g. ``"lane-count"``.
    osm_id
        ``"way/123"``, ``"node/4"``, ``"relation/5"``, or empty where no element is to blame.
    message
        What was found and what was done, one sentence.
    """

    kind: Kind
    code: str
    osm_id: str
    message: str


class Diagnostics:
    """Collects diagnostics in the order in which they are found."""

    def __init__(self) -> None:
        self._items: list[Diagnostic] = []

    def add(self, kind: Kind, code: str, osm_id: str, message: str) -> None:
        """Record one finding."""
        self._items.append(Diagnostic(kind, code, osm_id, message))

    def guessed(self, code: str, osm_id: str, message: str) -> None:
        """Record a value that the input does not give."""
        self.add(Kind.GUESSED, code, osm_id, message)

    def dropped(self, code: str, osm_id: str, message: str) -> None:
        """Record something of the input that the output does not have."""
        self.add(Kind.DROPPED, code, osm_id, message)

    def repaired(self, code: str, osm_id: str, message: str) -> None:
        """Record a defect of the input that was mended."""
        self.add(Kind.REPAIRED, code, osm_id, message)

    def note(self, code: str, osm_id: str, message: str) -> None:
        """Record something that the user should know."""
        self.add(Kind.NOTE, code, osm_id, message)

    def __iter__(self) -> Iterator[Diagnostic]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def counts(self) -> dict[tuple[Kind, str], int]:
        """How often each (kind, code) was recorded, in order of kind and code."""
        found = Counter((item.kind, item.code) for item in self._items)
        return dict(sorted(found.items(), key=lambda entry: (entry[0][0].value, entry[0][1])))

    def guessed_about(self, prefix: str) -> dict[int, frozenset[str]]:
        """Return the codes of guesses by the number of the element that they are about.

        Parameters
        ----------
        prefix
            Of the elements' names, such as ``"way/"``.
        """
        found: dict[int, set[str]] = {}
        for item in self._items:
            if item.kind is Kind.GUESSED and item.osm_id.startswith(prefix):
                found.setdefault(int(item.osm_id[len(prefix) :]), set()).add(item.code)
        # Most elements share one of a few sets.
        shared: dict[frozenset[str], frozenset[str]] = {}
        return {
            number: shared.setdefault(codes, codes)
            for number, codes in zip(found, map(frozenset, found.values()), strict=True)
        }
