"""Files that are there as a whole or not at all.

A file is written under another name beside its target, synced to the disk, and renamed. Whatever goes wrong before
(disk full, a signal, an error of the conversion), the target is as it was and nothing else is left.
"""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import stat
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final, Protocol

from osm2xodr.errors import OutputError


class ByteSink(Protocol):
    """Takes bytes, as binary files do."""

    def write(self, data: bytes, /) -> object:
        """Take all of `data`."""


def check_target(path: Path) -> None:
    """Find out before any work is done whether a file can be written, as far as that can be known.

    Raises
    ------
    OutputError
        If the path is a directory, or lies in none, or in one that takes no files.
    """
    try:
        folder = path.resolve().parent
    except (OSError, RuntimeError):
        msg = f"cannot write {path}: it is a symbolic link that leads back to itself; choose another place"
        raise OutputError(msg) from None
    if path.is_dir():
        msg = f"{path} is a directory; name a file in it, such as {path / 'map.xodr'}"
        raise OutputError(msg)
    if not folder.is_dir():
        msg = f"cannot write {path}: there is no directory {folder}; make it first"
        raise OutputError(msg)
    if is_special(path):
        return
    if not os.access(folder, os.W_OK | os.X_OK):
        msg = f"cannot write {path}: no permission to make files in {folder}; choose another place"
        raise OutputError(msg)


def is_special(path: Path) -> bool:
    """Whether a path is a device, a pipe or a socket: written to directly, never replaced by a file."""
    return path.exists() and not path.is_file() and not path.is_dir()


@contextlib.contextmanager
def atomic_output(path: Path) -> Iterator[BinaryIO]:
    """Give a stream whose bytes become the file `path` when the block ends without an exception.

    A symbolic link is followed and stays. A file that is replaced hands on its permissions, and its owner where the
    system allows; a new one has those that the process gives new files. Devices and pipes are written to directly.

    Parameters
    ----------
    path
        The target.

    Raises
    ------
    OutputError
        If the file cannot be written, or not in full.
    """
    target = path.resolve()
    try:
        if is_special(target):
            with target.open("wb") as stream:
                yield stream
            return
        with _temporary(target) as (stream, name):
            yield stream
            settle(stream)
            name.replace(target)
        _sync_folder(target.parent)
    except OSError as error:
        raise OutputError(_reason(path, error)) from error


def settle(stream: BinaryIO) -> None:
    """See that all that was written to a stream is where it belongs: on the disk, if it is a file.

    Raises
    ------
    OSError
        If it is not, as when the disk is full.
    """
    stream.flush()
    if stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
        os.fsync(stream.fileno())


@contextlib.contextmanager
def _temporary(target: Path) -> Iterator[tuple[BinaryIO, Path]]:
    """Make a file of a new name beside the target, and see that the name is gone afterwards."""
    name = target.with_name(f".osm2xodr-{secrets.token_hex(8)}.part")
    try:
        # Not `tempfile`, whose files only their owner may read: a new file obeys the process's umask. Within the
        # block, so that no signal comes between making the file and taking care of it.
        descriptor = os.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        with os.fdopen(descriptor, "wb") as stream:
            _take_over_permissions(target, descriptor)
            yield stream, name
    finally:
        name.unlink(missing_ok=True)


def _take_over_permissions(target: Path, descriptor: int) -> None:
    """Give a new file the owner and the permissions of the one that it replaces."""
    with contextlib.suppress(FileNotFoundError):
        old = target.stat()
        with contextlib.suppress(PermissionError):
            os.fchown(descriptor, old.st_uid, old.st_gid)
        os.fchmod(descriptor, stat.S_IMODE(old.st_mode))


def _sync_folder(folder: Path) -> None:
    """Sync a directory, so that a rename in it outlives a power cut; not every file system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _reason(path: Path, error: OSError) -> str:
    """Say why a file could not be written, and what to do."""
    remedy = {
        errno.ENOSPC: "; free some space or choose another place",
        errno.EDQUOT: "; free some space or choose another place",
        errno.EFBIG: "; the file is larger than allowed there, choose another place",
        errno.EACCES: "; choose another place or change its permissions",
        errno.EPERM: "; choose another place or change its permissions",
        errno.EROFS: "; choose another place",
    }
    return f"cannot write {path}: {(error.strerror or str(error)).lower()}{remedy.get(error.errno or 0, '')}"


STANDARD_OUTPUT: Final = Path("-")


@contextlib.contextmanager
def stream_to(path: Path) -> Iterator[BinaryIO]:
    """Give a stream to a file or to standard output."""
    if path != STANDARD_OUTPUT:
        with atomic_output(path) as stream:
            yield stream
        return
    try:
        yield sys.stdout.buffer
        sys.stdout.buffer.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        silence_standard_output()
        raise OutputError(f"cannot write standard output: {(error.strerror or str(error)).lower()}") from error


def silence_standard_output() -> None:
    """Let what is still buffered go nowhere, lest the interpreter stumbles over it when it ends."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def label(path: Path) -> str:
    """Name an output for people."""
    return "standard output" if path == STANDARD_OUTPUT else str(path)
