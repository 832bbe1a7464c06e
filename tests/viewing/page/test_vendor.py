"""The libraries of the page are those that their README names, unchanged, with their licences."""

from __future__ import annotations

import hashlib
import re
import subprocess
import sys
from pathlib import Path

import osm2xodr

ROOT = Path(osm2xodr.__file__).parents[2]
VENDOR = Path(osm2xodr.__file__).parent / "viewing" / "page" / "vendor"


def test_files_are_those_of_the_sums() -> None:
    lines = (VENDOR / "SHA256SUMS").read_text(encoding="ascii").splitlines()
    sums = {name: digest for digest, name in (line.split("  ") for line in lines)}
    assert {path.name for path in VENDOR.iterdir()} == {*sums, "SHA256SUMS", "README.md"}
    for name, digest in sums.items():
        assert hashlib.sha256((VENDOR / name).read_bytes()).hexdigest() == digest, name


def test_the_tool_agrees() -> None:
    done = subprocess.run([sys.executable, str(ROOT / "tools" / "vendor_web.py"), "--check"], check=False)
    assert done.returncode == 0


def test_the_readme_names_the_versions_that_the_files_have() -> None:
    named = dict(
        re.findall(r"^\| (\w+) \| ([\d.]+) \|", (VENDOR / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
    )
    assert set(named) == {"leaflet", "uplot", "three"}
    assert f"Leaflet {named['leaflet']}" in (VENDOR / "leaflet.js").read_text(encoding="utf-8")[:200]
    assert f"v{named['uplot']}" in (VENDOR / "uplot.js").read_text(encoding="utf-8")[:200]
    revision = named["three"].split(".")[1]
    assert f'"{revision}"' in (VENDOR / "three.core.js").read_text(encoding="utf-8")[:20_000]


def test_licences_may_be_combined_with_the_gpl() -> None:
    assert "MIT License" in (VENDOR / "three.LICENSE").read_text(encoding="utf-8")
    assert "MIT License" in (VENDOR / "uplot.LICENSE").read_text(encoding="utf-8")
    bsd = (VENDOR / "leaflet.LICENSE").read_text(encoding="utf-8")
    assert bsd.startswith("BSD 2-Clause License")
