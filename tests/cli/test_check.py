"""The command `check` as users meet it: exit status and what is written where.

Diagnostics and rules are explained on the command line.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from real_readers import need
from t_junction import sound_map

from osm2xodr import checking
from osm2xodr.checking import RULES
from osm2xodr.cli import check as cli_check, main
from osm2xodr.reporting import codes


@pytest.fixture
def sound(tmp_path: Path) -> Path:
    path = tmp_path / "sound.xodr"
    path.write_text(sound_map(), encoding="utf-8")
    return path


@pytest.fixture
def damaged(tmp_path: Path) -> Path:
    """One warning."""
    path = tmp_path / "damaged.xodr"
    path.write_text(sound_map().replace('high="1"', 'high="77"'), encoding="utf-8")
    return path


def run(*arguments: object) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, "-m", "osm2xodr", "check", *map(str, arguments)],
        capture_output=True,
        check=False,
        timeout=120,
    )


def test_a_sound_file_is_clean(sound: Path) -> None:
    need("qc_opendrive", "the ASAM checker (asam-qc-opendrive)")
    done = run(sound)
    assert done.returncode == 0
    text = done.stdout.decode()
    assert text == f"{sound}: 0 errors, 0 warnings, 0 notes (OpenDRIVE 1.6, 10 roads, 1 junction, 0.3 km)\n"
    assert done.stderr == b""


def test_findings_make_the_exit_status_1(damaged: Path) -> None:
    done = run(damaged)
    assert done.returncode == 1
    assert b"a priority names road 77" in done.stdout


@pytest.mark.parametrize(("least", "status"), [("error", 0), ("warning", 1), ("info", 1)])
def test_which_findings_count_can_be_said(
    least: str, status: int, damaged: Path, capsysbinary: pytest.CaptureFixture[bytes]
) -> None:
    assert main(["check", str(damaged), "--fail-on", least]) == status
    assert b"1 warning" in capsysbinary.readouterr().out


def test_rules_can_be_ignored(damaged: Path, capsysbinary: pytest.CaptureFixture[bytes]) -> None:
    assert main(["check", str(damaged), "--ignore", "priority-road"]) == 0
    assert main(["check", str(damaged), "--only", "road-length", "--only", "schema"]) == 0
    assert main(["check", str(damaged), "--for", "standard"]) == 1
    out = capsysbinary.readouterr().out
    assert out.count(b"0 errors, 0 warnings") == 2


@pytest.mark.parametrize("form", cli_check.FORMATS)
def test_formats_go_to_a_file(form: str, damaged: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "out" / "result"
    target.parent.mkdir()
    assert main(["check", str(damaged), "--format", form, "-o", str(target)]) == 1
    assert "priority-road" in target.read_text(encoding="utf-8")
    said = capsys.readouterr()
    assert said.out == ""
    assert "0 errors, 1 warning, 0 notes" in said.err
    assert main(["check", str(damaged), "-o", str(target)]) == 2
    assert main(["check", str(damaged), "-o", str(target), "--overwrite", "-q"]) == 1
    assert "exists" in capsys.readouterr().err


def test_several_files(damaged: Path, capsysbinary: pytest.CaptureFixture[bytes]) -> None:
    assert main(["check", str(damaged), str(damaged), "--format", "github", "-q"]) == 1
    assert capsysbinary.readouterr().out.count(b"::warning file=") == 2


def test_standard_input_can_be_checked(damaged: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "osm2xodr", "check", "-", "--format", "json"],
        input=damaged.read_bytes(),
        capture_output=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 1, done.stderr
    document = json.loads(done.stdout)
    assert document["counts"] == [{"rule": "priority-road", "severity": "warning", "findings": 1}]
    assert document["not_checked"] == ["the schema was not checked: standard input can be read only once"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["--for", "carla,matlab"],
        ["--only", "gap"],
        ["--ignore", "gap"],
        ["--format", "xml"],
        ["--max-findings", "-1"],
    ],
)
def test_wrong_usage(arguments: list[str], sound: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(sound), *arguments]) == 2
    assert "Error: " in capsys.readouterr().err


def test_the_file_itself_is_not_overwritten(sound: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = sound.read_bytes()
    assert main(["check", str(sound), "-o", str(sound), "--overwrite"]) == 2
    assert sound.read_bytes() == before
    assert "is one of the inputs" in capsys.readouterr().err


def test_what_cannot_be_read_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(tmp_path / "absent.xodr")]) == 1
    said = capsys.readouterr().err
    assert said.startswith("osm2xodr: error: ")
    assert said.count("\n") == 1


def test_words_of_the_options_are_those_of_the_checker() -> None:
    assert tuple(checking.FORMATS) == cli_check.FORMATS
    assert cli_check.READERS == checking.READERS
    assert tuple(cli_check.DEFAULT_READERS.split(",")) == checking.DEFAULT_READERS
    assert set(cli_check.SEVERITIES) == {item.word for item in checking.Severity}


@pytest.mark.parametrize(
    ("rule", "note", "lights", "option"),
    [
        ("RHT", "", False, "--opendrive.internal-shapes"),
        ("RHT", "", True, "--opendrive.internal-shapes"),
        ("LHT", '<userData code="lanes" value="negated"/>', False, "--lefthand"),
        # No command makes netconvert read it right.
        ("LHT", "", False, ""),
    ],
)
def test_the_command_for_sumo_is_said(
    rule: str, note: str, lights: bool, option: str, sound: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = sound_map().replace('rule="RHT"', f'rule="{rule}"').replace("</header>", f"{note}</header>")
    sound.write_text(text, encoding="utf-8")
    stem = str(sound.with_suffix(""))
    if lights:
        Path(f"{stem}.tll.xml").write_text("", encoding="utf-8")
    main(["check", str(sound), "--for", "sumo"])
    programmes = f" --tllogic-files {stem}.tll.xml" if lights else ""
    command = (
        f"netconvert {option} --junctions.endpoint-shape --opendrive-files {sound}{programmes} -o {stem}.net.xml"
    )
    assert capsys.readouterr().err == (f"osm2xodr: SUMO loads it with: {command}\n" if option else "")
    # Who did not ask for SUMO is not told.
    main(["check", str(sound)])
    assert capsys.readouterr().err == ""


def test_a_diagnostic(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "Area"]) == 0
    assert capsys.readouterr().out == (
        "area (diagnostic of convert: dropped)\n"
        "  A way with area=yes is a surface such as a square, which has no line to follow.\n"
        "  What to do: Nothing, unless traffic crosses it: then map the way that vehicles take as a line.\n"
    )


def test_a_rule(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "overlap"]) == 0
    head, *rest = capsys.readouterr().out.splitlines()
    assert head == "overlap (rule of check: warning)"
    assert rest[0] == f"  {RULES['overlap'].meaning}"
    assert rest[1].startswith("  Who is affected: carla, esmini: ")


def test_all_of_them_can_be_explained(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", *codes(), *RULES]) == 0
    said = capsys.readouterr().out
    heads = [line for line in said.splitlines() if line and not line.startswith(" ")]
    assert len(heads) >= len(codes()) + len(RULES)


def test_an_unknown_code_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "clearence"]) == 2
    assert "'clearence' is no diagnostic and no rule of check; do you mean clearance?" in capsys.readouterr().err


def test_rules_can_be_listed_without_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "--list-rules"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(RULES)
    assert lines[0].split(maxsplit=2)[1:] == ["error", RULES[lines[0].split()[0]].meaning]
