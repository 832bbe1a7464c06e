"""Records: what `osm2xodr.system.record` makes is what a frozen dataclass with slots is."""

from __future__ import annotations

import copy
import inspect
import pickle
from dataclasses import FrozenInstanceError, asdict, dataclass, field, fields, replace
from typing import ClassVar

import pytest

from osm2xodr.system import record


@record
class _Point:
    """A place."""

    x: float
    y: float = 2.0
    tags: list[str] = field(default_factory=list)
    DIMENSIONS: ClassVar[int] = 2


@record
class _Longer(_Point):
    """A place that doubles one of its fields."""

    length: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "length", 2.0 * self.length)


@record(eq=False)
class _Other:
    """Something that equals itself alone."""

    x: float


@dataclass(frozen=True, slots=True)
class _Plain:
    """What a record of one number is compared with."""

    x: float


@record
class _Quick:
    """The same as a record."""

    x: float


def test_fields_are_set_in_their_order_with_defaults() -> None:
    one, other = _Point(1.0), _Point(x=1.0, y=3.0, tags=["a"])
    assert (one.x, one.y, one.tags) == (1.0, 2.0, [])
    assert one.tags is not _Point(1.0).tags
    assert repr(other) == "_Point(x=1.0, y=3.0, tags=['a'])"
    assert asdict(other) == {"x": 1.0, "y": 3.0, "tags": ["a"]}
    assert [item.name for item in fields(_Longer)] == ["x", "y", "tags", "length"]
    assert _Longer(0.0, length=2.0).length == 4.0
    assert str(inspect.signature(_Longer)).startswith("(x: 'float', y: 'float' = 2.0, tags: 'list[str]' = <")
    with pytest.raises(TypeError, match="'x'"):
        _Point()  # type: ignore[call-arg]


def test_nothing_changes_a_record() -> None:
    one = _Point(1.0)
    with pytest.raises(FrozenInstanceError, match="_Point is frozen: cannot change 'x'"):
        one.x = 2.0  # type: ignore[misc]
    with pytest.raises(FrozenInstanceError, match="cannot change 'y'"):
        del one.y
    assert not hasattr(one, "__dict__")
    assert replace(one, x=5.0) == _Point(5.0)
    assert one == _Point(1.0)


def test_equal_records_are_one_key_but_for_those_compared_by_identity() -> None:
    assert hash(_Quick(0.5)) == hash(_Plain(0.5)) == hash((0.5,))
    plain: object = _Plain(0.5)
    assert _Quick(0.5) != plain
    assert len({_Quick(0.5), _Quick(0.5)}) == 1
    assert len({_Other(0.5), _Other(0.5)}) == 2


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))])
def test_copies_are_equal(copied: type[_Point]) -> None:
    assert copied(_Point(1.0, 3.0, ["a"])) == _Point(1.0, 3.0, ["a"])  # type: ignore[arg-type]
