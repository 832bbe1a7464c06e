"""Folders of files that belong together, written as a whole or not at all, among files of others."""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePosixPath
from typing import Final

from osm2xodr.errors import OutputError
from osm2xodr.system.files import lock, parse_json
from osm2xodr.system.limits import uninterrupted

# Key of the list of files in the file that describes the folder.
FILES_KEY: Final = "files"
_PART: Final = ".osm2xodr-{}.part"


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
