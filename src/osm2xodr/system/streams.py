"""Standard streams that are closed, or that take no more, do no harm to what is written elsewhere."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from typing import Final, TextIO

# Numbers of the standard streams and how their substitutes are opened: each the wrong way for what it is there for,
# so that what needs the stream learns that it is closed. What is told on standard error may be lost.
_SUBSTITUTES: Final = ((0, os.O_WRONLY), (1, os.O_RDONLY), (2, os.O_WRONLY))


class _Patient(io.TextIOBase):
    """Standard error of which a full disk or a closed pipe cannot stop the work that it tells of."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Take all of `text`, and lose what cannot be written."""
        with contextlib.suppress(OSError, ValueError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Write what is held back, or lose it."""
        # Called once more as the interpreter ends, when modules are gone.
        try:  # noqa: SIM105
            self._stream.flush()
        except (OSError, ValueError):
            pass

    def isatty(self) -> bool:
        """Say whether people look at it."""
        return self._stream.isatty()

    def fileno(self) -> int:
        """Return the number that the system knows it by."""
        return self._stream.fileno()

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Name of the encoding of what is written."""
        return self._stream.encoding

    @property
    def errors(self) -> str | None:  # type: ignore[override]
        """What becomes of letters that the encoding has not."""
        return self._stream.errors


def occupy_closed_streams() -> None:
    """Give each closed standard stream a substitute.

    A file opened later would get the free number, and so take in all that libraries print: into the result.
    """
    for number, flags in _SUBSTITUTES:
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, flags)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
    # Python has none where the number was closed when it started.
    if sys.stdin is None:
        sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stdout is None:
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(2, "w", encoding="utf-8", errors="backslashreplace", closefd=False)  # noqa: SIM115


@contextlib.contextmanager
def patient_standard_error() -> Iterator[None]:
    """Let nothing that is told on standard error stop the work inside."""
    before = sys.stderr
    sys.stderr = _Patient(before)
    try:
        yield
    finally:
        sys.stderr = before
