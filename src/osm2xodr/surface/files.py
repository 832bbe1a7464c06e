"""Which files are meant by the paths, patterns and folders that name elevation models. Imports nothing heavy."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from osm2xodr.errors import InputError

# Endings of elevation models in a folder, in small letters.
DEM_ENDINGS: Final = (".tif", ".tiff", ".hgt", ".vrt", ".asc", ".img", ".zip")


def expand(patterns: Iterable[str | os.PathLike[str]]) -> tuple[Path, ...]:
    """Return the files that are meant, each once; those of one pattern in the order of their names.

    `patterns` are paths, which need not exist; patterns with ``*``, ``?``, ``[...]`` and ``**``; folders, which stand
    for the elevation models in them. Raises `InputError` where a pattern or folder has no file.
    """
    found: dict[Path, None] = {}
    for given in patterns:
        path, pattern = Path(given), os.fspath(given)
        if path.is_dir():
            files = sorted(item for item in path.iterdir() if item.suffix.lower() in DEM_ENDINGS)
            if not files:
                raise InputError(f"there are no elevation models in the folder {pattern}; name their files")
        elif path.exists() or not glob.has_magic(pattern):
            files = [path]
        else:
            files = sorted(item for item in map(Path, glob.glob(pattern, recursive=True)) if item.is_file())
            if not files:
                raise InputError(f"no file is called like {pattern}; check the pattern")
        found.update(dict.fromkeys(files))
    return tuple(found)
