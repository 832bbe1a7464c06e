"""Converts maps with all modules run as Python, the compiled ones too: ``python uncompiled.py FOLDER MAP DEM …``."""

from __future__ import annotations

import sys
from importlib.machinery import SOURCE_SUFFIXES, FileFinder, SourceFileLoader
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "src" / "osm2xodr"


def sources_only(path: str) -> FileFinder:
    """Return what finds modules in a folder of the package: no extensions."""
    if not Path(path).is_relative_to(PACKAGE):
        raise ImportError
    return FileFinder(path, (SourceFileLoader, SOURCE_SUFFIXES))


def run(folder: Path, maps: list[str]) -> None:
    """Convert maps, each followed by its elevation model, to files of the same names in a folder."""
    from osm2xodr.cli import main

    for osm, dem in zip(maps[::2], maps[1::2], strict=True):
        out = folder / f"{Path(osm).stem}.xodr"
        if main(["convert", osm, "--dem", dem, "-o", str(out), "-q", "--jobs", "1"]):
            sys.exit(f"{osm} cannot be converted")
    ours = [module for name, module in sys.modules.items() if name.startswith("osm2xodr")]
    if any(not str(module.__file__).endswith(".py") for module in ours):
        sys.exit("modules of the package are compiled")


if __name__ == "__main__":
    sys.path_hooks.insert(0, sources_only)
    run(Path(sys.argv[1]), sys.argv[2:])
