"""The notebook of the documentation runs, and shows what it prints and draws today."""

from __future__ import annotations

import base64
import io
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

# Left out with the oldest libraries, which do without what only draws.
pytest.importorskip("matplotlib")

ROOT = Path(__file__).parents[2]
NOTEBOOK = ROOT / "docs" / "notebook.ipynb"
NUMBER = r"\d[\d,]*\.?\d*"


def outputs(notebook: dict[str, Any], kind: str) -> list[str]:
    """Return the outputs of a kind of all cells."""
    found = [item for cell in notebook["cells"] for item in cell.get("outputs", ())]
    return ["".join(part[kind]) for item in found for part in (item, item.get("data", {})) if kind in part]


def _said(notebook: dict[str, Any]) -> list[str]:
    return outputs(notebook, "text") + outputs(notebook, "text/plain")


def picture(text: str) -> np.ndarray[Any, Any]:
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(text))).convert("RGB"), float)


def test_the_notebook_runs_and_shows_what_it_does() -> None:
    """In a process of its own, warnings as errors."""
    code = "import json, run_notebook; print(json.dumps(run_notebook.run(run_notebook.TARGET)))"
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], cwd=ROOT / "tools", check=True, capture_output=True, text=True
    )
    kept, made = json.loads(NOTEBOOK.read_text(encoding="utf-8")), json.loads(done.stdout)
    printed = outputs(kept, "text")
    assert len(printed) == 3
    assert printed[2].endswith(" lanes:\nCarretera de Montaup, CG-2\n")
    # Numbers change a little with every change of the mathematics; then the notebook need not be run anew.
    for was, now in zip(_said(kept), _said(made), strict=True):
        assert re.sub(NUMBER, "#", was) == re.sub(NUMBER, "#", now)
        before, today = ([float(item.replace(",", "")) for item in re.findall(NUMBER, text)] for text in (was, now))
        assert today == pytest.approx(before, rel=0.1, abs=3.0)
    pictures = outputs(kept, "image/png")
    assert len(pictures) == 2
    for one, other in zip(pictures, outputs(made, "image/png"), strict=True):
        # Versions of matplotlib set letters differently.
        a, b = picture(one), picture(other)
        assert np.abs(np.array(a.shape) - b.shape).max() <= 2
        low, width = np.minimum(a.shape, b.shape)[:2]
        assert np.abs(a[:low, :width] - b[:low, :width]).mean() < 10.0
        assert np.ptp(a) > 200.0
