"""Compiled modules: made of what stands there, and with the same results as without compilation."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from pathlib import Path

import hatch_build
import pytest
import uncompiled

from golden import write_hills
from osm2xodr.cli import main

GOLDEN = Path(__file__).parents[1] / "golden"
SCENES = ("dual_carriageways_cross", "parking_and_cycle_lanes", "roundabout", "stacked_bridges", "trunk_ramps")


def test_both_forms_write_the_same_bytes(tmp_path: Path) -> None:
    maps = [GOLDEN / f"{name}.osm" for name in SCENES]
    models = [write_hills(osm, tmp_path / f"{osm.stem}.tif") for osm in maps]
    given = [str(path) for pair in zip(maps, models, strict=True) for path in pair]
    subprocess.run([sys.executable, uncompiled.__file__, str(tmp_path), *given], check=True)
    for osm, dem in zip(maps, models, strict=True):
        out = tmp_path / "compiled.xodr"
        assert main(["convert", str(osm), "--dem", str(dem), "-o", str(out), "-q", "--overwrite", "--jobs", "1"]) == 0
        assert out.read_bytes() == (tmp_path / f"{osm.stem}.xodr").read_bytes()


@pytest.mark.parametrize("module", hatch_build.modules(), ids=lambda path: path.stem)
def test_the_compiled_form_is_what_is_tested(module: Path) -> None:
    name = ".".join(module.relative_to(hatch_build.SOURCE).with_suffix("").parts)
    found = importlib.import_module(name).__file__
    assert found == str(hatch_build.compiled(module) if hatch_build.has_compiler() else module)


@pytest.fixture
def project(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A module to be compiled, in a project of its own."""
    (tmp_path / "halves.py").write_text("def half(x: float) -> float:\n    return 0.5 * x\n", encoding="utf-8")
    (tmp_path / "halves.pxd").write_text("cpdef double half(double x) noexcept nogil\n", encoding="utf-8")
    monkeypatch.setattr(hatch_build, "SOURCE", tmp_path)
    return tmp_path / "halves.py"


@pytest.mark.skipif(not hatch_build.has_compiler(), reason="nothing to compile with")
def test_a_change_of_a_module_is_noticed(project: Path) -> None:
    assert hatch_build.build() is None
    assert hatch_build.up_to_date(project)
    code = "import halves; print(halves.half(3), halves.__file__)"
    said = subprocess.check_output([sys.executable, "-c", code], cwd=project.parent, text=True)
    assert said.split() == ["1.5", str(hatch_build.compiled(project))]
    made = hatch_build.made_of(project)
    os.utime(project, ns=(made + 1000, made + 1000))
    assert not hatch_build.up_to_date(project)


def test_without_a_compiler_no_old_form_stays(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hatch_build.compiled(project).write_bytes(b"")
    os.utime(hatch_build.compiled(project), ns=(0, 0))
    monkeypatch.setenv("CC", str(project.parent / "no_compiler"))
    reason = hatch_build.build()
    assert reason is not None
    assert "no_compiler" in reason
    assert not hatch_build.compiled(project).exists()
