"""Standard streams that are closed or full must not spoil what is written elsewhere."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from typing import Final, TextIO

# Numbers of the standard streams and the modes of their substitutes: input for writing and output for reading, so
# that whoever needs the stream gets an error. Messages on standard error may be lost.
_SUBSTITUTES: Final = ((0, os.O_WRONLY), (1, os.O_RDONLY), (2, os.O_WRONLY))


class _Patient(io.TextIOBase):
    """Standard error that loses text on a full disk or a closed pipe instead of raising an error."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write `text`, or lose it."""
        with contextlib.suppress(OSError, ValueError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Write what is buffered, or lose it."""
        # Called once more as the interpreter ends, when modules are gone.
        try:  # noqa: SIM105
            self._stream.flush()
        except (OSError, ValueError):
            pass

    def isatty(self) -> bool:
        """Return whether it is a terminal."""
        return self._stream.isatty()

    def fileno(self) -> int:
        """Return the file descriptor."""
        return self._stream.fileno()

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Name of the encoding."""
        return self._stream.encoding

    @property
    def errors(self) -> str | None:  # type: ignore[override]
        """How letters are treated that the encoding lacks."""
        return self._stream.errors


def occupy_closed_streams() -> None:
    """Open a substitute for each standard stream that is closed.

    Otherwise the next file that is opened gets its number, and all that libraries print goes into that file.
    """
    for number, flags in _SUBSTITUTES:
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, flags)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
    # Python sets the streams to None that were closed when it started.
    if sys.stdin is None:
        sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stdout is None:
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(2, "w", encoding="utf-8", errors="backslashreplace", closefd=False)  # noqa: SIM115


@contextlib.contextmanager
def patient_standard_error() -> Iterator[None]:
    """Let no failing message on standard error stop the work in the block."""
    before = sys.stderr
    sys.stderr = _Patient(before)
    try:
        yield
    finally:
        sys.stderr = before
