"""Elevation models in zip archives, which need not be unpacked.

A raster in an archive has the path of the archive with its own behind it: ``dem.zip/tile.tif``.
"""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Final

from osm2xodr.errors import InputError

_ARCHIVE: Final = ".zip"
# Endings of rasters in archives, in small letters. Virtual rasters are not among them: what they refer to is checked
# on disk alone.
_RASTERS: Final = (".tif", ".tiff", ".asc", ".img", ".hgt")
# Most rasters of one archive; a choice, far above what agencies put into one.
_RASTERS_MAX: Final = 10_000


def rasters_in(path: Path) -> list[Path]:
    """Return the rasters of a zip archive, by name; any other path is returned as it is.

    `InputError` if the archive is damaged or has no rasters.
    """
    if path.suffix.lower() != _ARCHIVE or not path.is_file():
        return [path]
    try:
        with zipfile.ZipFile(path) as archive:
            members = sorted(item.filename for item in archive.infolist() if not item.is_dir())
    except OSError as error:
        raise InputError(f"{path}: the archive cannot be read ({error.strerror}); check its permissions") from None
    except (zipfile.BadZipFile, ValueError, NotImplementedError):
        raise InputError(f"{path}: the archive is damaged or cut short; get it whole") from None
    found = [name for name in members if Path(name).suffix.lower() in _RASTERS]
    if not found:
        known = ", ".join(_RASTERS)
        raise InputError(
            f"{path}: there is no elevation model in the archive ({known}); unpack it, and name the file"
        )
    if len(found) > _RASTERS_MAX:
        raise InputError(
            f"{path}: there are {len(found):,} rasters in the archive; unpack it, and name those you need"
        )
    return [path / name for name in found]


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
