"""Diagnostics and rules are explained on the command line."""

from __future__ import annotations

import pytest

from osm2xodr.checking import RULES
from osm2xodr.cli import main
from osm2xodr.reporting import codes


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
