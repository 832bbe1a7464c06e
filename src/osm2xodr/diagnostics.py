"""What the stages guessed, dropped or repaired."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Set as AbstractSet
from enum import Enum

from osm2xodr.system import record


class Kind(str, Enum):
    """What was done about a defect or a gap of the input."""

    GUESSED = "guessed"
    DROPPED = "dropped"
    REPAIRED = "repaired"
    NOTE = "note"


@record
class Diagnostic:
    """One finding of a stage, and what was done about it."""

    kind: Kind  # What was done
    code: str  # Short stable name of the finding in kebab-case, such as ``"lane-count"``
    osm_id: str  # ``"way/123"``, ``"node/4"``, ``"relation/5"``; empty where it is about no single element
    message: str  # What was found and what was done, one sentence


@record
class _Count:
    """The same finding about several elements."""

    kind: Kind
    code: str
    osm_ids: tuple[str, ...]
    noun: str
    finding: str

    def summed_up(self) -> Diagnostic:
        return Diagnostic(self.kind, self.code, "", f"{counted(len(self.osm_ids), self.noun)} {self.finding}")


def counted(count: int, noun: str) -> str:
    """Return a number and what it counts, such as ``1 bus stop`` or ``1,200 bus stops``."""
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


class Diagnostics:
    """What was guessed, dropped and repaired, in the order in which it was found.

    Iterating over it yields each `Diagnostic`: its kind, its code, the OSM element that it is about, and a sentence.

    Examples
    --------
    >>> found = Diagnostics()
    >>> found.guessed("lane-count", "way/1", "it has 2 lanes, as most residential streets")
    >>> [item.osm_id for item in found]
    ['way/1']
    >>> found.counts()
    {(<Kind.GUESSED: 'guessed'>, 'lane-count'): 1}
    """

    def __init__(self) -> None:
        self._items: list[Diagnostic | _Count] = []

    def copy(self) -> Diagnostics:
        """Return new diagnostics with all findings so far."""
        out = Diagnostics()
        out._items = list(self._items)
        return out

    def later_than(self, count: int) -> Diagnostics:
        """Return new diagnostics with all findings but the first ones."""
        out = Diagnostics()
        out._items = self._items[count:]
        return out

    def extend(self, other: Diagnostics) -> None:
        """Record all findings of others, in their order."""
        self._items += other._items

    def add(self, kind: Kind, code: str, osm_id: str, message: str) -> None:
        """Record one finding."""
        self._items.append(Diagnostic(kind, code, osm_id, message))

    def count(self, kind: Kind, code: str, osm_ids: Iterable[str], noun: str, finding: str) -> None:
        """Record one finding about several elements, if there are any: their number, the noun and the finding.

        The noun names one of them, such as ``bus stop``; the finding reads the same in the singular and the plural.
        """
        found = tuple(osm_ids)
        if found:
            self._items.append(_Count(kind, code, found, noun, finding))

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

    def osm_ids(self) -> set[str]:
        """Return all elements with a finding."""
        found = {item.osm_id for item in self._items if isinstance(item, Diagnostic)}
        return found.union(*(item.osm_ids for item in self._items if isinstance(item, _Count))) - {""}

    def forget(self, osm_ids: AbstractSet[str]) -> None:
        """Take back all findings about some elements."""
        items, self._items = self._items, []
        for item in items:
            if isinstance(item, _Count):
                left = (name for name in item.osm_ids if name not in osm_ids)
                self.count(item.kind, item.code, left, item.noun, item.finding)
            elif item.osm_id not in osm_ids:
                self._items.append(item)

    def forget_code(self, code: str) -> None:
        """Take back all findings of a code."""
        self._items = [item for item in self._items if item.code != code]

    def __iter__(self) -> Iterator[Diagnostic]:
        return (item if isinstance(item, Diagnostic) else item.summed_up() for item in self._items)

    def __len__(self) -> int:
        return len(self._items)

    def counts(self) -> dict[tuple[Kind, str], int]:
        """Return how often each (kind, code) was recorded, in order of kind and code."""
        found = Counter((item.kind, item.code) for item in self._items)
        return dict(sorted(found.items(), key=lambda entry: (entry[0][0].value, entry[0][1])))

    def guessed_about(self, prefix: str) -> dict[int, frozenset[str]]:
        """Return the codes of guesses by the number of the element, for names with a prefix such as ``"way/"``."""
        found: dict[int, set[str]] = {}
        for item in self:
            if item.kind is Kind.GUESSED and item.osm_id.startswith(prefix):
                found.setdefault(int(item.osm_id[len(prefix) :]), set()).add(item.code)
        # Most elements share one of a few sets.
        shared: dict[frozenset[str], frozenset[str]] = {}
        return {
            number: shared.setdefault(codes, codes)
            for number, codes in zip(found, map(frozenset, found.values()), strict=True)
        }
