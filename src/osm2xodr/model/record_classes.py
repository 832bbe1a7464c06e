"""Dataclasses that are made in their hundred thousands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

__all__ = ["record"]

if TYPE_CHECKING:
    # They are frozen, as the type checker sees them.
    from dataclasses import dataclass as record
else:

    def record(*, frozen: bool, slots: bool) -> Callable[[type[Any]], type[Any]]:
        """Make a class a dataclass that nobody changes, with hashes as of frozen ones.

        At run time it is none that refuses changes: those take four times as long to make.
        """
        return dataclass(slots=slots, unsafe_hash=frozen)
