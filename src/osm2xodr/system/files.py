"""Files that are written as a whole or not at all.

A file is written under another name beside its target, synced to the disk, and renamed. If anything goes wrong before
that (disk full, a signal, an error of the conversion), the target stays as it was and nothing else is left.
"""

from __future__ import annotations

import contextlib
import errno
import functools
import importlib
import json
import os
import secrets
import stat
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, Final, Protocol

from osm2xodr.errors import OutputError

# How often a lock is tried that another process holds, where the system cannot wait for it, s.
_LOCK_CHECK: Final = 0.2
# Digits of the largest whole number of 64 bits, such as times in ns have today.
_DIGITS: Final = 19


class ByteSink(Protocol):
    """Takes bytes, as binary files do."""

    def write(self, data: bytes, /) -> object:
        """Take all of `data`."""


def check_target(path: Path) -> None:
    """Raise `OutputError` if a file cannot be written, as far as that can be known before any work is done."""
    try:
        folder = path.resolve().parent
    except (OSError, RuntimeError):
        what = f"cannot write {path}: it is a symbolic link that leads back to itself"
        raise OutputError(f"{what}; choose another place") from None
    if path.is_dir():
        raise OutputError(f"{path} is a directory; name a file in it, such as {path / 'map.xodr'}")
    # Folders that are missing are made.
    folder = next(above for above in (folder, *folder.parents) if above.exists())
    if not folder.is_dir():
        raise OutputError(f"cannot write {path}: {folder} is a file, where a folder should be; choose another place")
    if not is_special(path) and not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(f"cannot write {path}: no permission to make files in {folder}; choose another place")


def is_special(path: Path) -> bool:
    """Return whether a path is a device, a pipe or a socket, which is written to directly and never replaced."""
    return path.exists() and not path.is_file() and not path.is_dir()


@contextlib.contextmanager
def atomic_output(path: Path) -> Iterator[BinaryIO]:
    """Yield a stream whose bytes become the file `path` when the block ends without an exception.

    Folders that are missing are made. A symbolic link is followed and stays. A file that is replaced hands on its
    permissions, and its owner where the system allows; a new one has those that the process gives new files. Devices
    and pipes are written to directly. `OutputError` says why a file cannot be written, or not in full.
    """
    target = path.resolve()
    try:
        if is_special(target):
            with target.open("wb") as stream:
                yield stream
            return
        target.parent.mkdir(parents=True, exist_ok=True)
        with _temporary(target) as (stream, name):
            yield stream
            settle(stream)
            # Windows renames no file that is open.
            stream.close()
            name.replace(target)
        _sync_folder(target.parent)
    except OSError as error:
        raise OutputError(_reason(path, error)) from error


def settle(stream: BinaryIO) -> None:
    """Bring all that was written to a stream to where it belongs: to the disk, if it is a file.

    It raises OSError if that cannot be, as when the disk is full.
    """
    stream.flush()
    if stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
        os.fsync(stream.fileno())


@contextlib.contextmanager
def appended(part: Path) -> Iterator[BinaryIO]:
    """Yield a stream that adds to a file which is not complete yet, and stays as it is if anything goes wrong.

    `OutputError` says why it cannot be written. When it is complete, `complete` gives it its name.
    """
    try:
        with part.open("ab") as stream:
            try:
                yield stream
            finally:
                settle(stream)
    except OSError as error:
        raise OutputError(_reason(part, error)) from error


def complete(part: Path, path: Path) -> None:
    """Give a file that is complete, and on the disk, its name; `OutputError` says why that cannot be."""
    try:
        part.replace(path)
        _sync_folder(path.parent)
    except OSError as error:
        raise OutputError(_reason(path, error)) from error


def remove_made(path: Path, head: bytes) -> None:
    """Remove a file that begins with the bytes by which it is known; others, and what is no file, stay.

    `OutputError` says why that cannot be.
    """
    try:
        if not path.is_file():
            return
        with path.open("rb") as stream:
            made = stream.read(len(head)) == head
        if made:
            path.unlink()
    except OSError as error:
        raise OutputError(
            f"cannot remove {path}, which belonged to a file that is replaced: {error.strerror}"
        ) from error


def lock(descriptor: int, *, wait: bool) -> bool:
    """Lock an open file until it is closed, and return whether that could be: another process may hold it.

    With `wait` it waits for the other process. Where the system has no locks, standard error says so, once, and it is
    as if nobody held one.
    """
    # Here, because only some systems have them.
    try:
        import fcntl
    except ImportError:
        return _lock_on_windows(descriptor, wait=wait)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        return False
    return True


def _lock_on_windows(descriptor: int, *, wait: bool) -> bool:
    """Lock the first byte of a file; see `lock`."""
    try:
        msvcrt: Any = importlib.import_module("msvcrt")
    except ImportError:
        _say_unlocked()
        return True
    while True:
        try:
            os.lseek(descriptor, 0, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            if not wait:
                return False
            time.sleep(_LOCK_CHECK)
        else:
            return True


@functools.cache
def _say_unlocked() -> None:
    """Say once that nothing keeps two runs apart."""
    sys.stderr.write("osm2xodr: this system cannot lock files; let no two runs work on the same folder at once\n")


def parse_json(data: bytes | str) -> Any:
    """Return what JSON says; ValueError for what is none, or nested too deeply.

    Whole numbers of more than 64 bits are read as floating-point ones, as other readers do (RFC 8259, 6).
    """
    try:
        return json.loads(data, parse_int=_whole)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def _whole(text: str) -> int | float:
    return int(text) if len(text) <= _DIGITS else float(text)


def make_folder(path: Path) -> None:
    """Make a folder and those above it where they are missing; `OutputError` says why that cannot be."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise OutputError(f"{path} is a file, where a folder should be; choose another place") from None
    except OSError as error:
        raise OutputError(_reason(path, error)) from error


@contextlib.contextmanager
def _temporary(target: Path) -> Iterator[tuple[BinaryIO, Path]]:
    """Make a file of a new name beside the target; the name is gone afterwards."""
    name = target.with_name(f".osm2xodr-{secrets.token_hex(8)}.part")
    try:
        # Not by `tempfile`, whose files only their owner may read: a new file obeys the process's umask. Inside the
        # block, so that no signal comes between making the file and the promise to remove it.
        descriptor = os.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        with os.fdopen(descriptor, "wb") as stream:
            _copy_permissions(target, descriptor)
            yield stream, name
    finally:
        name.unlink(missing_ok=True)


def _copy_permissions(target: Path, descriptor: int) -> None:
    """Give a new file the owner and the permissions of the one that it replaces."""
    # Windows has neither.
    if not hasattr(os, "fchown"):
        return
    with contextlib.suppress(FileNotFoundError):
        old = target.stat()
        with contextlib.suppress(PermissionError):
            os.fchown(descriptor, old.st_uid, old.st_gid)
        os.fchmod(descriptor, stat.S_IMODE(old.st_mode))


def _sync_folder(folder: Path) -> None:
    """Sync a directory, so that a rename in it survives a power cut; not every file system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _reason(path: Path, error: OSError) -> str:
    """Say why a file could not be written, and what to do."""
    elsewhere, room = "; choose another place", "; free some space or choose another place"
    remedy = {
        errno.ENOSPC: room,
        errno.EDQUOT: room,
        errno.EFBIG: "; the file is larger than allowed there, choose another place",
        errno.EACCES: f"{elsewhere} or change its permissions",
        errno.EPERM: f"{elsewhere} or change its permissions",
        errno.EROFS: elsewhere,
    }
    return f"cannot write {path}: {(error.strerror or str(error)).lower()}{remedy.get(error.errno or 0, '')}"


STANDARD_OUTPUT: Final = Path("-")


@contextlib.contextmanager
def stream_to(path: Path) -> Iterator[BinaryIO]:
    """Yield a stream to a file, as `atomic_output` does, or to standard output."""
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
    """Discard what is still buffered, so that the interpreter does not fail over it when it ends."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def label(path: Path) -> str:
    """Return the name of an output for people."""
    return "standard output" if path == STANDARD_OUTPUT else str(path)
