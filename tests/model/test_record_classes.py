"""Records compare, hash, copy and travel between processes as frozen dataclasses do."""

from __future__ import annotations

import pickle
from dataclasses import dataclass, replace

from osm2xodr.model import record


@record(frozen=True, slots=True)
class Place:
    """A place on a road."""

    road: int
    s: float = 0.0


@dataclass(frozen=True, slots=True)
class FrozenPlace:
    """The same, frozen."""

    road: int
    s: float = 0.0


def test_records_are_values() -> None:
    place = Place(3, 1.5)
    assert place == Place(3, 1.5)
    assert place != Place(3)
    assert hash(place) == hash(FrozenPlace(3, 1.5))
    assert {place: "here"}[Place(3, 1.5)] == "here"
    assert replace(place, s=0.0) == Place(3)
    assert pickle.loads(pickle.dumps(place)) == place


def test_records_have_slots() -> None:
    assert not hasattr(Place(3), "__dict__")
