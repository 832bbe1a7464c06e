"""The checker of ASAM, who make the standard, finds nothing."""

from __future__ import annotations

from pathlib import Path

import pytest
from real_readers import qc_result
from scene_files import SCENES, Conversions, Scene

# What may be skipped: the only checker whose rule starts with OpenDRIVE 1.8.
ONLY_FOR_1_8 = 1


@pytest.mark.parametrize("scene", SCENES, ids=str)
def test_no_issue_and_no_checker_fails(scene: Scene, conversions: Conversions, tmp_path: Path) -> None:
    result = qc_result(conversions.of(scene).path, tmp_path)
    assert result.issues == []
    assert "error" not in result.checkers
    assert len(result.checkers.get("skipped", [])) <= ONLY_FOR_1_8
    assert len(result.checkers["completed"]) > 10


def test_it_does_find_faults(conversions: Conversions, tmp_path: Path) -> None:
    text = conversions.of(SCENES[0]).path.read_text(encoding="utf-8")
    broken = tmp_path / "broken.xodr"
    broken.write_text(text.replace('contactPoint="start"', 'contactPoint="end"', 1), encoding="utf-8")
    assert qc_result(broken, tmp_path).issues != []
