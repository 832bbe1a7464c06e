"""Memory that the process no longer needs."""

from __future__ import annotations


def release_memory() -> None:
    """Give memory that is no longer used back to the system, where that can be asked for.

    Threads that decode an OSM file keep theirs apart, where nothing else would ever use it again; and what many small
    objects leave behind lies scattered, of little use to the large arrays of the next stage.
    """
    # Here, because many imports of this package need nothing of it.
    import ctypes

    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
