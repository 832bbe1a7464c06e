"""Elevation models in zip archives, which need not be unpacked.

A raster in an archive has the path of the archive with its own behind it: ``dem.zip/tile.tif``.
"""

from __future__ import annotations

import contextlib
import functools
import lzma
import stat
import zipfile
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from osm2xodr.errors import InputError

_ARCHIVE: Final = ".zip"
# Endings of rasters in archives, in small letters. Virtual rasters are not among them: what they refer to is checked
# on disk alone.
_RASTERS: Final = (".tif", ".tiff", ".asc", ".img", ".hgt")
# Most rasters of one archive; a choice, far above what agencies put into one.
_RASTERS_MAX: Final = 10_000
# What tells grids of text from others, bytes at the beginning of a file: they have no zero byte there.
_HEAD: Final = 512
_CHUNK: Final = 1 << 20


def rasters_in(path: Path) -> list[Path]:
    """Return the rasters of a zip archive, by name; any other path is returned as it is.

    `InputError` if the archive is damaged or has no rasters.
    """
    if path.suffix.lower() != _ARCHIVE or not path.is_file():
        if (archive := archive_of(path)) is not None:
            _check_texts(archive, [path.relative_to(archive).as_posix()])
        return [path]
    found = [name for name in sorted(_members(path)) if Path(name).suffix.lower() in _RASTERS]
    if not found:
        known = ", ".join(_RASTERS)
        raise InputError(
            f"{path}: there is no elevation model in the archive ({known}); unpack it, and name the file"
        )
    if len(found) > _RASTERS_MAX:
        raise InputError(
            f"{path}: there are {len(found):,} rasters in the archive; unpack it, and name those you need"
        )
    _check_texts(path, found)
    return [path / name for name in found]


def _check_texts(path: Path, names: Iterable[str]) -> None:
    """Raise `InputError` if a grid of text is damaged in its archive: GDAL would read on and on behind the damage."""
    try:
        with zipfile.ZipFile(path) as archive:
            for name in names:
                # How some are packed Python cannot read.
                with contextlib.suppress(NotImplementedError, RuntimeError, KeyError), archive.open(name) as member:
                    if b"\0" not in member.read(_HEAD):
                        while member.read(_CHUNK):
                            pass
    except (zipfile.BadZipFile, OSError, ValueError, EOFError, zlib.error, lzma.LZMAError):
        raise _damaged(path) from None


def _members(path: Path) -> frozenset[str]:
    """Return the names of the files in an archive."""
    try:
        of = path.stat()
        return _members_of(path, of.st_mtime_ns, of.st_size)
    except OSError as error:
        raise InputError(f"{path}: the archive cannot be read ({error.strerror}); check its permissions") from None
    except (zipfile.BadZipFile, ValueError, NotImplementedError):
        raise _damaged(path) from None


def _damaged(path: Path) -> InputError:
    return InputError(f"{path}: the archive is damaged or cut short; get it whole")


@functools.lru_cache(maxsize=4)
def _members_of(path: Path, changed: int, size: int) -> frozenset[str]:
    """Return what `_members` does; it is asked for each raster of an archive."""
    with zipfile.ZipFile(path) as archive:
        return frozenset(item.filename for item in archive.infolist() if not item.is_dir())


def beside(path: Path, names: Iterable[str]) -> list[Path]:
    """Return the files of some names that lie beside a raster, on disk or in its archive.

    `InputError` if one is no regular file: whoever reads it may wait for ever.
    """
    archive = archive_of(path)
    if archive is None:
        return [item for item in map(path.with_name, names) if _is_regular(path, item)]
    folder, members = path.parent.relative_to(archive).as_posix(), _members(archive)
    within = "" if folder == "." else f"{folder}/"
    return [path.with_name(name) for name in names if within + name in members]


def _is_regular(path: Path, beside: Path) -> bool:
    """Whether there is a regular file beside a raster."""
    try:
        mode = beside.stat().st_mode
    except OSError:
        return False
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise InputError(f"{path}: {beside.name}, which is read with it, is no regular file; remove it")
    return stat.S_ISREG(mode)


def archive_of(path: Path) -> Path | None:
    """Return the archive that a raster is in; None if it is a file by itself."""
    for parent in path.parents:
        if parent.suffix.lower() == _ARCHIVE and parent.is_file():
            return parent
    return None


def gdal_name(path: Path) -> str:
    """Return what GDAL opens a raster by."""
    archive = archive_of(path)
    if archive is None:
        return str(path.absolute())
    # In braces archives may have any name.
    return f"/vsizip/{{{archive.absolute()}}}/{path.relative_to(archive).as_posix()}"
