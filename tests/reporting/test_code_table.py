"""What diagnostics mean: every code that the program uses is explained, and docs/diagnostics.md says the same."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from raised_codes import raised_codes

from osm2xodr.diagnostics import Kind
from osm2xodr.reporting import codes

ROOT = Path(__file__).parents[2]


def test_every_code_in_the_source_is_explained_with_its_kinds() -> None:
    raised = raised_codes()
    assert len(raised) > 100
    assert {"lane-count": {"guessed", "dropped", "repaired"}, "flat": {"note"}}.items() <= raised.items()
    known = {name: {kind.value for kind in item.kinds} for name, item in codes().items()}
    assert known == raised


def test_codes_are_in_order_and_say_what_to_do() -> None:
    assert list(codes()) == sorted(codes())
    for name, item in codes().items():
        assert item.meaning.endswith("."), name
        assert item.remedy.endswith("."), name
        assert list(item.kinds) == [kind for kind in Kind if kind in item.kinds], name


def test_no_two_codes_do_the_same_harm() -> None:
    harms = [item.harm for item in codes().values() if item.harm is not None]
    assert len(set(harms)) == len(harms) > 10
    # Heights that nobody measured do most harm.
    order = ["dem-gap", "no-height", "clearance", "speed", "restriction"]
    assert sorted(order, key=lambda name: codes()[name].harm or 0) == order


def test_the_document_is_in_step() -> None:
    spec = importlib.util.spec_from_file_location("diagnostics_table", ROOT / "tools" / "diagnostics_table.py")
    assert spec is not None
    assert spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    assert (ROOT / "docs" / "diagnostics.md").read_text(encoding="utf-8") == tool.page()
    assert all(f"\n| `{name}` | " in tool.page() for name in codes())
