"""Linear algebra on one thread.

A sum over several threads is rounded otherwise than one by a single thread: heights of large areas would depend on
the number of cores. What can run at once runs in processes (`osm2xodr.system.parallel`).
"""

from __future__ import annotations

import contextlib
import ctypes
import sys
import threading
from collections.abc import Callable, Iterator
from functools import partial
from types import MappingProxyType
from typing import ClassVar, Final

# What keeps the libraries of a process that is yet to start from making threads at all.
_VARIABLES: Final = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
ONE_THREAD_ENVIRONMENT: Final = MappingProxyType(dict.fromkeys(_VARIABLES, "1"))
# Modules of NumPy and SciPy that are linked with a library of linear algebra; each package may bring its own.
_LINKED: Final = ("numpy.linalg._umath_linalg", "scipy.linalg._fblas", "scipy.sparse.linalg._dsolve._superlu")
# Functions that get and set the number of threads: of OpenBLAS by the names that its builds give them, MKL and BLIS.
_CALLS: Final = (
    *(
        (f"{prefix}openblas_get_num_threads{suffix}", f"{prefix}openblas_set_num_threads{suffix}")
        for prefix in ("scipy_", "")
        for suffix in ("64_", "")
    ),
    ("MKL_Get_Max_Threads", "MKL_Set_Num_Threads"),
    ("bli_thread_get_num_threads", "bli_thread_set_num_threads"),
)


class _Hold:
    """How many want one thread, and what undoes it for the last of them."""

    lock = threading.Lock()
    count = 0
    undo: ClassVar[list[Callable[[], object]]] = []


@contextlib.contextmanager
def one_thread() -> Iterator[None]:
    """Keep the linear algebra of this process to one thread, and give it back its threads afterwards.

    It holds for NumPy and SciPy as far as they are loaded, in all threads of the program, from the first block that
    is entered to the last that is left.
    """
    with _Hold.lock:
        if not _Hold.count:
            _Hold.undo = _limit()
        _Hold.count += 1
    try:
        yield
    finally:
        with _Hold.lock:
            _Hold.count -= 1
            while not _Hold.count and _Hold.undo:
                _Hold.undo.pop()()


def _limit() -> list[Callable[[], object]]:
    """Set all libraries to one thread, and return what undoes it."""
    undo: list[Callable[[], object]] = []
    for module in _LINKED:
        path = getattr(sys.modules.get(module), "__file__", None)
        if path is None:
            continue
        # A name is looked up in the module and all that it is linked with.
        library = ctypes.CDLL(path)
        for getter, setter in _CALLS:
            get, put = getattr(library, getter, None), getattr(library, setter, None)
            if get is not None and put is not None and (count := int(get())) > 1:
                put(1)
                undo.append(partial(put, count))
    return undo
