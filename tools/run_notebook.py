"""Runs the notebook docs/notebook.ipynb, and keeps what its cells print and draw in it: ``tools/run_notebook.py``.

Cells run one after the other in this process, in the folder of the notebook, as in Jupyter, which is not needed.
"""

from __future__ import annotations

import ast
import base64
import contextlib
import io
import json
import os
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("agg")
from matplotlib import pyplot as plt

TARGET = Path(__file__).parents[1] / "docs" / "notebook.ipynb"


def run(path: Path) -> dict[str, Any]:
    """Return a notebook with what its cells print and draw today."""
    notebook: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    # A module's name, for classes of cells.
    names: dict[str, Any] = {"__name__": "__main__"}
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    with contextlib.chdir(path.parent) if hasattr(contextlib, "chdir") else _inside(path.parent):
        for count, cell in enumerate(cells, 1):
            cell["execution_count"] = count
            cell["outputs"] = _run_cell("".join(cell["source"]), names, count)
    return notebook


@contextlib.contextmanager
def _inside(folder: Path) -> Any:
    """Work in a folder, as `contextlib.chdir` of Python 3.11 does."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def _run_cell(source: str, names: dict[str, Any], count: int) -> list[dict[str, Any]]:
    """Run a cell, and return its outputs: what is printed, the value of its last line, pictures."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed, value = io.StringIO(), None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, f"<cell {count}>", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), f"<cell {count}>", "eval"), names)
    if source.endswith(";"):
        # As in Jupyter: the value is not shown.
        value = None
    outputs: list[dict[str, Any]] = []
    if printed.getvalue():
        outputs.append({"output_type": "stream", "name": "stdout", "text": printed.getvalue().splitlines(True)})
    for number in plt.get_fignums():
        picture = io.BytesIO()
        plt.figure(number).savefig(picture, dpi=80, metadata={"Software": None})
        plt.close(number)
        text = base64.b64encode(picture.getvalue()).decode()
        outputs.append({"output_type": "display_data", "metadata": {}, "data": {"image/png": text}})
    if value is not None:
        shown = {"text/plain": repr(value).splitlines(True)}
        outputs.append({"output_type": "execute_result", "execution_count": count, "metadata": {}, "data": shown})
    return outputs


if __name__ == "__main__":
    TARGET.write_text(json.dumps(run(TARGET), ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
