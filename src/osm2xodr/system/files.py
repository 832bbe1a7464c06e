"""Files, and folders of files that belong together: written as a whole or not at all, among files of others."""

from __future__ import annotations

import contextlib
import errno
import functools
import importlib
import json
import os
import secrets
import shutil
import stat
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO, Final, Protocol

from osm2xodr.errors import OutputError
from osm2xodr.system.limits import uninterrupted

# How often a lock is tried that another process holds, where the system cannot wait for it, s.
_LOCK_CHECK: Final = 0.2
# Digits of the largest whole number of 64 bits, such as times in ns have today.
_DIGITS: Final = 19

# Key of the list of files in the file that describes the folder.
FILES_KEY: Final = "files"
_PART: Final = ".osm2xodr-{}.part"


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


@contextlib.contextmanager
def atomic_folder(path: Path, index: str, inputs: Iterable[Path] = ()) -> Iterator[Path]:
    """Yield an empty folder whose files become those of `path` when the block ends without an exception.

    One of them, `index`, is a JSON object that lists all others by `FILES_KEY`, those in folders below as
    ``folder/name``. Of what is in the folder `path` those files are replaced or removed that its own index lists; all
    others stay. Files are moved into the folder one by
    one: a process that is killed at that moment leaves an index of old and new ones with ``"incomplete": true``.
    `OutputError` says why a folder cannot be written.
    """
    check_folder(path, index, inputs)
    target = path.resolve()
    name = _PART.format(secrets.token_hex(8))
    # Within a folder that is there: another file system may be mounted on it.
    new = target / name if target.is_dir() else target.with_name(name)
    try:
        try:
            new.mkdir()
            yield new
            for name in _files(new):
                _sync(new / name)
            with uninterrupted():
                if target.exists():
                    _move(new, target, index)
                else:
                    new.rename(target)
        finally:
            shutil.rmtree(new, ignore_errors=True)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise OutputError(f"cannot write the folder {path}: {reason}; choose another place") from error


def check_folder(path: Path, index: str, inputs: Iterable[Path] = ()) -> None:
    """Raise `OutputError` if a folder cannot be written, as far as that can be known before any work is done.

    It must not be where one of the `inputs` lies, nor hold files without an index (see `atomic_folder`).
    """
    try:
        target = path.resolve()
        if path.exists() and not path.is_dir():
            raise OutputError(f"{path} is a file, where a folder should be; choose another place")
        for item in inputs:
            if target in item.resolve().parents:
                raise OutputError(f"the input {item} lies in the folder {path}; choose another folder")
        if path.is_dir():
            if _has_files(target) and not (target / index).is_file():
                raise OutputError(f"{path} has other files than what is written there; choose another folder")
            _listed(target, index)
            folder = target
        else:
            folder = target.parent
        if not folder.is_dir():
            raise OutputError(f"cannot write {path}: there is no directory {folder}; make it first")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise OutputError(f"cannot write {path}: no permission to make files in {folder}; choose another place")
    except (OSError, RuntimeError) as error:
        # A RuntimeError means a symbolic link that leads back to itself.
        reason = (getattr(error, "strerror", None) or "a symbolic link leads back to itself").lower()
        raise OutputError(f"cannot write the folder {path}: {reason}; choose another place") from None


def _files(folder: Path) -> list[str]:
    """Return the names of all files in a folder and in those below it, in order."""
    return sorted(item.relative_to(folder).as_posix() for item in folder.rglob("*") if not item.is_dir())


def _between(folder: Path, name: str) -> list[Path]:
    """Return the folders between a folder and a file below it, the innermost first."""
    return [folder / item for item in PurePosixPath(name).parents[:-1]]


def _is_own(folder: Path) -> bool:
    """Return whether a path is a folder and does not lead elsewhere."""
    return folder.is_dir() and not folder.is_symlink()


def _has_files(folder: Path) -> bool:
    """Return whether a folder has anything but what killed processes may have left."""
    return any(not item.match(_PART.format("*")) for item in folder.iterdir())


def _listed(folder: Path, index: str) -> set[str]:
    """Return the names of the files that a folder's index lists, itself among them; none without one."""
    path = folder / index
    if not path.is_file():
        return set()
    try:
        document = parse_json(path.read_bytes())
    except ValueError:
        document = None
    names = document.get(FILES_KEY) if isinstance(document, dict) else None
    if not isinstance(names, list) or not all(isinstance(name, str) and _is_plain(name) for name in names):
        raise OutputError(f"{path} does not list the files that belong to it; choose another folder")
    return {*names, index}


def _is_plain(name: str) -> bool:
    """Return whether a name is that of a file in the folder or below it, whatever the system separates names with."""
    return all(part not in ("", ".", "..") and not set(part) & {"\\", ":", "\0"} for part in name.split("/"))


def _move(new: Path, target: Path, index: str) -> None:
    """Replace the files that a folder's index lists by new ones."""
    with _alone(target):
        names, old = set(_files(new)), _listed(target, index)
        for name in sorted(names):
            place = target / name
            astray = any(os.path.lexists(item) and not _is_own(item) for item in _between(target, name))
            if astray or place.is_dir() or (os.path.lexists(place) and name not in old):
                raise OutputError(f"{place} is not of what was written there before; choose another folder")
        between = new / f"{index}.between"
        known = {"incomplete": True, FILES_KEY: sorted((names | old) - {index})}
        between.write_text(json.dumps(known), encoding="utf-8")
        _sync(between)
        between.replace(target / index)
        for name in sorted(names - {index}):
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            (new / name).replace(target / name)
        for name in sorted(old - names):
            if all(map(_is_own, _between(target, name))) and not (target / name).is_dir():
                (target / name).unlink(missing_ok=True)
            for folder in _between(target, name):
                # Not empty, if others have files in it.
                with contextlib.suppress(OSError):
                    folder.rmdir()
        (new / index).replace(target / index)


@contextlib.contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Let no other process move files into a folder meanwhile, where the system can lock folders."""
    try:
        held = os.open(folder, os.O_RDONLY)
    except OSError:
        yield
        return
    try:
        with contextlib.suppress(OSError):
            lock(held, wait=True)
        yield
    finally:
        os.close(held)


def _sync(path: Path) -> None:
    """Bring a file to the disk."""
    with path.open("r+b") as stream:
        os.fsync(stream.fileno())
