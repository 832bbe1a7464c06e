"""Folders that are written as a whole or not at all."""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path

from osm2xodr.errors import OutputError


@contextlib.contextmanager
def atomic_folder(path: Path, mark: str) -> Iterator[Path]:
    """Yield an empty folder that becomes `path` when the block ends without an exception.

    What is there must be an empty folder, or one with a file named `mark`, by which folders of that kind are known:
    it is replaced as a whole. `OutputError` says why a folder cannot be written.
    """
    check_folder(path, mark)
    target = path.resolve()
    new, old = (target.with_name(f".osm2xodr-{secrets.token_hex(8)}.part") for _ in range(2))
    try:
        new.mkdir()
        try:
            yield new
            for item in new.iterdir():
                _sync(item)
            if target.is_dir():
                target.rename(old)
            new.rename(target)
        finally:
            if old.is_dir() and not target.exists():
                old.rename(target)
            for rest in (new, old):
                shutil.rmtree(rest, ignore_errors=True)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise OutputError(f"cannot write the folder {path}: {reason}; choose another place") from error


def check_folder(path: Path, mark: str) -> None:
    """Raise `OutputError` if a folder cannot be written, as far as that can be known before any work is done."""
    parent = path.resolve().parent
    if path.exists() and not path.is_dir():
        raise OutputError(f"{path} is a file, where a folder should be; choose another place")
    if path.is_dir() and any(path.iterdir()) and not (path / mark).is_file():
        raise OutputError(f"{path} has other files than those of a scene; choose another folder")
    if not parent.is_dir():
        raise OutputError(f"cannot write {path}: there is no directory {parent}; make it first")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise OutputError(f"cannot write {path}: no permission to make files in {parent}; choose another place")


def _sync(path: Path) -> None:
    """Bring a file to the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
