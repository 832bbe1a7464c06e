"""What the documents say is so."""

from __future__ import annotations

import importlib.metadata
import re
import shlex
import subprocess
import sys
from pathlib import Path

from lxml import etree
from scene_files import Conversions, scene_named

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
SAMPLE = ROOT / "data" / "samples" / "andorra_ordino"


def block_after(text: str) -> str:
    """Return the first code block of the README after a text."""
    found = re.search(r"```\w*\n(.*?)```", README[README.index(text) :], re.DOTALL)
    assert found is not None
    return found[1]


def test_the_run_in_the_readme_works(tmp_path: Path) -> None:
    command = shlex.split(block_after("## One run"))
    assert command[0] == "osm2xodr"
    files = {"area.osm": str(SAMPLE / "area.osm"), "dem.tif": str(SAMPLE / "dem.tif")}
    arguments = [files.get(item, item) for item in command[1:]]
    done = subprocess.run(
        [sys.executable, "-m", "osm2xodr", *arguments], cwd=tmp_path, check=False, stderr=subprocess.PIPE
    )
    assert done.returncode == 0, done.stderr.decode()
    assert len(etree.parse(tmp_path / "area.xodr").findall("road")) > 300


def test_the_python_in_the_readme_works(tmp_path: Path) -> None:
    for name in ("area.osm", "dem.tif"):
        (tmp_path / name).symlink_to(SAMPLE / name)
    code = block_after("## From Python")
    assert len([line for line in code.splitlines() if line]) <= 5
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], cwd=tmp_path, check=True, capture_output=True, text=True
    )
    own, checked, longest = done.stdout.splitlines()
    assert longest == "CS-340"
    assert own.startswith("<Conversion 'My area': ")
    assert checked.startswith("area.xodr: 0 errors, ")
    header = etree.parse(tmp_path / "area.xodr").find("header")
    assert header is not None
    assert header.get("name") == "My area"


def test_the_readme_lists_what_is_written(conversions: Conversions) -> None:
    """Every element of a written file stands in the table, but for the folders that hold them."""
    target = conversions.of(scene_named("andorra_ordino")).path
    table = (ROOT / "docs" / "what_is_written.md").read_text(encoding="utf-8").partition("Not written:")[0]
    named = {word for text in re.findall(r"`([^`]+)`", table) for word in text.split()}
    folders = {
        "OpenDRIVE",
        "signals",
        "objects",
        "link",
        "predecessor",
        "successor",
        "geometry",
        "elevation",
        "lanes",
    }
    written = {element.tag for element in etree.parse(target).iter() if isinstance(element.tag, str)}
    assert written - named - folders - {"left", "center", "right"} == set()


def test_links_between_documents_lead_somewhere() -> None:
    for path in (ROOT / "README.md", ROOT / "CONTRIBUTING.md"):
        for name in re.findall(r"`((?:[\w.-]+/)*[\w-]+\.(?:md|py|toml))`", path.read_text(encoding="utf-8")):
            found = [ROOT / name, ROOT / "src" / "osm2xodr" / name]
            assert any(item.exists() for item in found), f"{path.name} names {name}"


def test_the_changelog_knows_this_version() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"## {importlib.metadata.version('osm2xodr')}" in text


def test_the_licence_is_the_gpl_in_full() -> None:
    text = (ROOT / "LICENSE").read_text(encoding="utf-8")
    assert "GNU GENERAL PUBLIC LICENSE" in text
    assert "Version 3, 29 June 2007" in text
    assert "END OF TERMS AND CONDITIONS" in text
    assert importlib.metadata.metadata("osm2xodr")["License-Expression"] == "GPL-3.0-or-later"


def test_every_sample_says_where_it_comes_from() -> None:
    samples = [path for path in (ROOT / "data" / "samples").iterdir() if path.is_dir()]
    assert samples != []
    for sample in samples:
        text = (sample / "SOURCES.md").read_text(encoding="utf-8")
        for path in sample.iterdir():
            assert path.name == "SOURCES.md" or f"`{path.name}`" in text
        assert "OpenStreetMap contributors" in text


def test_names_of_numbers_in_documents_are_those_of_the_code() -> None:
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / "src").rglob("*.py")]
    known = {name for text in texts for name in re.findall(r"^ *(\w+)(?:: [^=\n]+)? = ", text, re.MULTILINE)}
    for path in sorted((ROOT / "docs" / "method").glob("*.md")):
        text = path.read_text(encoding="utf-8")
        named = set(re.findall(r"`(_?[A-Z][A-Z0-9]*_[A-Z0-9_]+|_[A-Z]+)`", text))
        assert named - known == set(), path.name


def test_links_in_documents_lead_somewhere() -> None:
    for path in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")):
        for target in re.findall(r"\]\(([\w./]+\.(?:md|png|jpg))\)", path.read_text(encoding="utf-8")):
            assert (path.parent / target).is_file(), f"{path.name} -> {target}"
