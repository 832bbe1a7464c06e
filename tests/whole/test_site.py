"""The site of the documents: it builds without a warning, no link leads nowhere, and it brings all that it shows."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import urllib.parse
from collections.abc import Callable
from pathlib import Path

import click
import numpy as np
import pytest
from lxml import html
from PIL import Image

from osm2xodr.cli.program import cli

pytest.importorskip("sphinx")
import draw_junction
import draw_stages
import make_site

ROOT = Path(__file__).parents[2]
# The largest picture, bytes.
PICTURE_MAX = 150_000
# How much pictures may differ, of 255, on average: versions of matplotlib draw text differently.
DIFFERENCE_MAX = 6.0


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site") / "site"
    done = subprocess.run(
        [sys.executable, str(ROOT / "tools" / "make_site.py"), "-o", str(folder)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return folder


def test_every_link_leads_somewhere(site: Path) -> None:
    pages = {path: html.parse(path) for path in site.rglob("*.html")}
    anchors = {path: set(page.xpath("//@id")) | {""} for path, page in pages.items()}
    checked, wrong = 0, []
    for path, page in pages.items():
        for target in page.xpath("//@href | //@src"):
            parts = urllib.parse.urlsplit(target)
            if parts.scheme:
                continue
            checked += 1
            file = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            found = file.is_file() and (file not in anchors or parts.fragment in anchors[file])
            if not found:
                wrong.append(f"{path.name}: {target}")
    assert wrong == []
    assert checked > 1000


def test_addresses_elsewhere_are_encrypted_ones(site: Path) -> None:
    elsewhere = {item for path in site.rglob("*.html") for item in html.parse(path).xpath("//a/@href") if ":" in item}
    assert len(elsewhere) > 5
    plain = [item for item in elsewhere if not item.startswith("https://") and ".html#" not in item]
    assert plain == []


def test_it_brings_all_that_it_shows(site: Path) -> None:
    for path in site.rglob("*.html"):
        page = html.parse(path)
        shown = page.xpath("//link[@rel='stylesheet']/@href | //script/@src | //img/@src | //iframe/@src")
        assert [item for item in shown if "//" in item] == []
    for path in site.rglob("*.css"):
        assert not re.search(r"url\(['\"]?(https?:)?//|@import", path.read_text(encoding="utf-8")), path.name


def test_generated_pages_have_all_options_and_functions(site: Path) -> None:
    options = (site / "options.html").read_text(encoding="utf-8")
    for name, command in cli.commands.items():
        assert f'<section id="{name}">' in options
        for item in command.params:
            shown = isinstance(item, click.Option) and not item.hidden
            assert not shown or f'<span class="pre">{item.opts[-1]}' in options, item.opts
    python = (site / "python.html").read_text(encoding="utf-8")
    for name in ("convert", "read", "check", "Locator", "Osm2xodrError"):
        assert f'id="osm2xodr.{name}"' in python


def test_notebooks_become_pages(tmp_path: Path) -> None:
    drawn, printed = {"data": {"image/png": "iVBORw0K", "text/plain": ["<Figure>"]}}, {"text": ["a\n", "b"]}
    cells = [
        {"cell_type": "markdown", "source": ["# Roads\n", "of a *network*"]},
        {"cell_type": "code", "source": ["print(1)"], "outputs": [printed, drawn]},
    ]
    (tmp_path / "roads.ipynb").write_text(json.dumps({"cells": cells}), encoding="utf-8")
    (tmp_path / "images").mkdir()
    make_site.write_notebook(tmp_path / "roads.ipynb", tmp_path)
    assert (tmp_path / "roads.md").read_text(encoding="utf-8").split("\n\n") == [
        "# Roads\nof a *network*",
        "```python\nprint(1)\n```",
        "```text\na\nb\n```",
        "![What cell 2 draws](images/roads_1_1.png)",
        "{download}`As a notebook <roads.ipynb>`\n",
    ]
    assert (tmp_path / "images" / "roads_1_1.png").read_bytes() == b"\x89PNG\r\n"


def test_formulas_are_drawn_by_the_browser_itself(site: Path) -> None:
    text = (site / "method" / "heights.html").read_text(encoding="utf-8")
    assert text.count("<math ") > 150
    assert not re.search(r"\\[a-z]{3}", re.sub(r"<code.*?</code>", "", text))


@pytest.mark.parametrize(
    ("draw", "folder", "document"),
    [(draw_stages.draw, "stages", "how_it_works.md"), (draw_junction.draw, "junction", "method/junctions.md")],
)
def test_the_pictures_of_the_steps_are_those_of_today(
    draw: Callable[[Path], None], folder: str, document: str, tmp_path: Path
) -> None:
    draw(tmp_path)
    pictures = ROOT / "docs" / "images" / folder
    made = sorted(path.name for path in tmp_path.iterdir())
    assert made == sorted(path.name for path in pictures.iterdir())
    assert len(made) == 10
    text = (ROOT / "docs" / document).read_text(encoding="utf-8")
    assert re.findall(rf"images/{folder}/([\w.]+)\)", text) == made
    for name in made:
        assert (pictures / name).stat().st_size < PICTURE_MAX
        kept, new = (np.asarray(Image.open(place / name).convert("RGB"), float) for place in (pictures, tmp_path))
        assert kept.shape == new.shape, name
        assert np.abs(kept - new).mean() < DIFFERENCE_MAX, f"{name} shows what was; renew it: make pictures"
