"""Closing OSM files that were written."""

from __future__ import annotations

import ctypes
from typing import Any


def close_writer(writer: Any) -> None:
    """Close one of osmium's writers; RuntimeError or OSError if the file is not whole.

    A writer that could not be closed is kept for ever: its destructor would try again, and the exception in it would
    abort the process (seen with pyosmium 4.3).
    """
    try:
        writer.close()
    except (RuntimeError, OSError):
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(writer))
        raise
