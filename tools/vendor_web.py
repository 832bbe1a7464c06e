#!/usr/bin/env python3
"""Update the libraries of the report from packages that npm fetched, and check their sums. Run by hand.

    npm pack leaflet@1.9.4 uplot@1.6.32 three@0.183.2
    tools/vendor_web.py .            # takes the files from the packages in this folder
    tools/vendor_web.py --check      # only compares the files with SHA256SUMS

For other versions change `PACKAGES` (and the README beside the files), and give `--accept` to write new sums.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import tarfile
from pathlib import Path

TARGET = Path(__file__).resolve().parent.parent / "src/osm2xodr/viewing/page/vendor"
SUMS = TARGET / "SHA256SUMS"

# Package, version, and its files by the names that they get.
PACKAGES: tuple[tuple[str, str, dict[str, str]], ...] = (
    (
        "leaflet",
        "1.9.4",
        {"leaflet.js": "dist/leaflet.js", "leaflet.css": "dist/leaflet.css", "leaflet.LICENSE": "LICENSE"},
    ),
    (
        "uplot",
        "1.6.32",
        {"uplot.js": "dist/uPlot.iife.min.js", "uplot.css": "dist/uPlot.min.css", "uplot.LICENSE": "LICENSE"},
    ),
    (
        "three",
        "0.183.2",
        {
            "three.core.js": "build/three.core.min.js",
            "three.module.js": "build/three.module.min.js",
            "three.orbit_controls.js": "examples/jsm/controls/OrbitControls.js",
            "three.LICENSE": "LICENSE",
        },
    ),
)


def read_packages(folder: Path) -> dict[str, bytes]:
    """Return the files of all packages in a folder, by the names that they get."""
    found: dict[str, bytes] = {}
    for package, version, files in PACKAGES:
        with tarfile.open(folder / f"{package}-{version}.tgz") as archive:
            for name, member in files.items():
                stream = archive.extractfile(f"package/{member}")
                if stream is None:
                    raise FileNotFoundError(f"{package}-{version}.tgz has no file {member}")
                found[name] = stream.read()
    return found


def sum_lines(files: dict[str, bytes]) -> str:
    """Return the sums of files as ``sha256sum`` writes them."""
    return "".join(f"{hashlib.sha256(files[name]).hexdigest()}  {name}\n" for name in sorted(files))


def main() -> int:
    """Update or check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, help="where the packages are")
    parser.add_argument("--check", action="store_true", help="only compare the files with their sums")
    parser.add_argument("--accept", action="store_true", help="accept the packages as they are: new versions")
    arguments = parser.parse_args()
    if arguments.check == (arguments.folder is not None):
        parser.error("give either a folder with packages or --check")
    if arguments.check:
        names = [name for _, _, files in PACKAGES for name in files]
        files = {name: (TARGET / name).read_bytes() for name in names}
    else:
        files = read_packages(arguments.folder)
    sums = sum_lines(files)
    if not arguments.accept and sums != SUMS.read_text(encoding="ascii"):
        wrong = sorted(set(sums.splitlines()) ^ set(SUMS.read_text(encoding="ascii").splitlines()))
        print("these differ from SHA256SUMS:", *sorted({line.split()[1] for line in wrong}), file=sys.stderr)
        return 1
    if not arguments.check:
        for name, data in files.items():
            (TARGET / name).write_bytes(data)
        SUMS.write_text(sums, encoding="ascii")
    return 0


if __name__ == "__main__":
    sys.exit(main())
