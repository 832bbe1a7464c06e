"""What comes with the program: manual page, completion, documents in a wheel, a recipe for a container."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from osm2xodr.cli import main

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
COMMANDS = (
    "batch",
    "check",
    "completion",
    "convert",
    "crop",
    "explain",
    "export",
    "fetch",
    "locate",
    "merge",
    "render",
    "report",
    "surface",
)


def test_the_manual_page_is_that_of_the_program() -> None:
    text = (ROOT / "docs" / "osm2xodr.1").read_text(encoding="utf-8")
    # In a process of its own: commands remember how they were called first. Versions of click break lines
    # differently.
    command = [sys.executable, "-c", "import man_page; print(man_page.page())"]
    made = subprocess.run(command, cwd=ROOT / "tools", capture_output=True, text=True, check=True).stdout
    assert text.split() == made.split()
    for name in COMMANDS:
        assert f'.SS "osm2xodr {name} ' in text
    assert "\\-\\-report\\-json FILE" in text


@pytest.mark.skipif(shutil.which("groff") is None, reason="groff is not installed")
def test_the_manual_page_is_set_without_a_warning() -> None:
    command = ["groff", "-man", "-Tutf8", "-ww", str(ROOT / "docs" / "osm2xodr.1")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert len(done.stdout.splitlines()) > 200


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_says_what_its_exit_status_means(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "--help"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert re.search(r"Exit status: 0 [^.]*, 2 [^.]*, 130 interrupted\.", said)


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_shells_complete_commands(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert f"_OSM2XODR_COMPLETE={shell}_complete" in script
    asked = {"COMP_WORDS": "osm2xodr con", "COMP_CWORD": "con" if shell == "fish" else "1"}
    environment = {**os.environ, **asked, "_OSM2XODR_COMPLETE": f"{shell}_complete"}
    done = subprocess.run(
        [sys.executable, "-c", "from osm2xodr.cli import main; main([])"],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "convert" in done.stdout
    assert "render" not in done.stdout


def test_schemas_are_checked_without_extras() -> None:
    names = {re.split(r"[^\w-]", item)[0] for item in PROJECT["project"]["dependencies"]}
    assert "lxml" in names
    extra = {re.split(r"[^\w-]", item)[0] for item in PROJECT["project"]["optional-dependencies"]["check"]}
    assert extra == {"asam-qc-opendrive", "xmlschema"}


def test_documents_come_with_a_wheel() -> None:
    shared = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["shared-data"]
    assert shared == {"docs": "share/doc/osm2xodr", "docs/osm2xodr.1": "share/man/man1/osm2xodr.1"}
    assert all((ROOT / name).exists() for name in shared)


def test_the_help_says_where_the_documents_are(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    _, _, folder = capsys.readouterr().out.partition("Documents (docs):")
    assert (Path("".join(folder.split())) / "check.md").is_file()


def test_documents_that_messages_name_are_there() -> None:
    named = set()
    for path in (ROOT / "src" / "osm2xodr").rglob("*.py"):
        named |= set(re.findall(r"docs/[\w/]+\.md", path.read_text(encoding="utf-8")))
    assert named
    assert [name for name in sorted(named) if not (ROOT / name).is_file()] == []


def test_the_container_is_made_of_files_that_are_there() -> None:
    recipe = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    kept = (ROOT / ".dockerignore").read_text(encoding="utf-8").split()
    copied = [word for line in re.findall(r"^COPY ([^-].*) \S+$", recipe, re.MULTILINE) for word in line.split()]
    # What the package is built of.
    assert {"pyproject.toml", "hatch_build.py", "src", "docs", "README.md", "LICENSE"} == set(copied)
    for name in copied:
        assert (ROOT / name).exists()
        assert f"!{name}" in kept
    extras = re.search(r"\.whl\)\[([\w,]+)\]", recipe)
    assert extras is not None
    assert set(extras[1].split(",")) <= PROJECT["project"]["optional-dependencies"].keys()
    assert 'ENTRYPOINT ["osm2xodr"]' in recipe


def test_the_readme_says_how_to_get_what_is_not_installed_at_first() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for extra in ("batch", "check"):
        assert extra in PROJECT["project"]["optional-dependencies"]
        assert f"'.[{extra}]'" in text
    assert "osm2xodr completion bash" in text
    assert "docker build" in text
