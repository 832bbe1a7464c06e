"""Lists of files as people type them."""

from __future__ import annotations

import glob
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from osm2xodr.errors import InputError

# What a folder of elevation models is searched for.
_ENDINGS: Final = (".tif", ".tiff", ".hgt", ".vrt")


def expand(patterns: Sequence[str]) -> tuple[Path, ...]:
    """Return the files that are meant, each once.

    Parameters
    ----------
    patterns
        Paths, patterns with ``*``, ``?``, ``[...]`` and ``**``, and folders, which stand for the elevation models in
        them. What one of them means comes in the order of names.

    Raises
    ------
    InputError
        A pattern or folder has no file. That a path leads nowhere is for whoever reads it to say.
    """
    found: dict[Path, None] = {}
    for pattern in patterns:
        path = Path(pattern)
        if path.is_dir():
            files = sorted(item for item in path.iterdir() if item.suffix.lower() in _ENDINGS)
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
