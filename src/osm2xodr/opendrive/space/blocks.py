"""Evaluates many places block by block, so that what is needed on the way stays small beside the result."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, Final, TypeVar, cast

import numpy as np

# Places of a block: what is needed on the way to their results, some twenty numbers each, stays in caches of 2 MB.
BLOCK: Final = 1 << 14

_Function = TypeVar("_Function", bound=Callable[..., Any])


def in_blocks(function: _Function) -> _Function:
    """Evaluate a function of a file, rows (n,) and s (n,) in blocks; it returns an array (n,), or several of them."""

    @functools.wraps(function)
    def evaluated(file: Any, rows: Any, s: Any, **options: Any) -> Any:
        if len(s) <= BLOCK:
            return function(file, rows, s, **options)
        out: list[Any] = []
        single = False
        for first in range(0, len(s), BLOCK):
            at = slice(first, first + BLOCK)
            found = function(file, rows[at], s[at], **options)
            single = not isinstance(found, tuple)
            columns = (found,) if single else found
            out = out or [np.empty(len(s), column.dtype) for column in columns]
            for whole, column in zip(out, columns, strict=True):
                whole[at] = column
        return out[0] if single else tuple(out)

    return cast("_Function", evaluated)
