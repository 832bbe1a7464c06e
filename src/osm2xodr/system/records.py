"""Records: frozen dataclasses that are made by the hundred thousand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, FrozenInstanceError, dataclass, fields
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar, overload

_Class = TypeVar("_Class")

if TYPE_CHECKING:
    from typing_extensions import dataclass_transform
else:  # Python has it from 3.11 on, and only type checkers need it.

    def dataclass_transform(**_: bool) -> Callable[[_Class], _Class]:
        """Do nothing."""
        return lambda function: function


@overload
def record(cls: type[_Class], /) -> type[_Class]: ...
@overload
def record(*, eq: bool) -> Callable[[type[_Class]], type[_Class]]: ...
@dataclass_transform(frozen_default=True)
def record(cls: type[Any] | None = None, /, *, eq: bool = True) -> Any:
    """Make a class a dataclass as `dataclass(frozen=True, slots=True, eq=eq)` does.

    One of five fields is made in 0.4 of the time (Python 3.11: 0.6 instead of 1.5 µs), as fields are set by their
    slots, not by name; the class itself in two thirds, as all share what keeps them frozen.
    """
    return _record(cls, eq) if cls is not None else lambda each: _record(each, eq)


def _record(cls: type[Any], eq: bool) -> type[Any]:
    hashed = eq and "__hash__" not in cls.__dict__
    made: Any = dataclass(init=False, repr=False, eq=eq, unsafe_hash=hashed, slots=True)(cls)
    made.__init__, made.__repr__ = _init_of(made), _repr
    made.__setattr__ = made.__delattr__ = _refuse
    made.__reduce__ = _reduce
    return made  # type: ignore[no-any-return]


def _init_of(cls: Any) -> Any:
    """Return the ``__init__`` of a dataclass with slots."""
    names: dict[str, Any] = {}
    parameters, lines = ["self"], []
    for field in fields(cls):
        name = value = field.name
        names[f"_set_{name}"] = getattr(cls, name).__set__
        if field.default_factory is not MISSING:
            names[f"_default_{name}"], names["_MISSING"] = MISSING, MISSING
            names[f"_make_{name}"] = field.default_factory
            value = f"_make_{name}() if {name} is _MISSING else {name}"
        elif field.default is not MISSING:
            names[f"_default_{name}"] = field.default
        parameters.append(f"{name}=_default_{name}" if f"_default_{name}" in names else name)
        lines.append(f" _set_{name}(self, {value})\n")
    if hasattr(cls, "__post_init__"):
        lines.append(" self.__post_init__()\n")
    exec(f"def __init__({', '.join(parameters)}):\n{''.join(lines) or ' pass'}", names)
    made = names["__init__"]
    made.__qualname__ = f"{cls.__qualname__}.__init__"
    made.__annotations__ = {field.name: field.type for field in fields(cls)}
    return made


def _repr(self: Any) -> str:
    values = (f"{field.name}={getattr(self, field.name)!r}" for field in fields(self))
    return f"{type(self).__qualname__}({', '.join(values)})"


def _refuse(self: object, name: str, *_: object) -> NoReturn:
    raise FrozenInstanceError(f"{type(self).__name__} is frozen: cannot change {name!r}")


def _reduce(self: Any) -> tuple[Any, ...]:
    """Return how copies of processes make it again; those with slots have no ``__dict__`` to fill."""
    return type(self), tuple([getattr(self, field.name) for field in fields(self)])
