from __future__ import annotations

import base64
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from osm2xodr.model import FloatArray
from osm2xodr.surface.survey import DemComparison, Patch, SurfaceComparison, compare_grid
from osm2xodr.viewing.surface_report import surface_page


def comparison(z: FloatArray, name: str = "dem.tif", patches: int = 1) -> SurfaceComparison:
    rows, cols = z.shape
    parts = [Patch(k * cols, 0, z) for k in range(patches)]
    model = DemComparison(
        Path(name), "GTiff", "WGS 84 <b>", "float64", "metre", 10.0, (cols * patches, rows), z.size * patches,
        int(np.isnan(z).sum()), 3, 0.5, True, compare_grid(parts, (10.0, 10.0)),
    )  # fmt: skip
    return SurfaceComparison((11.0, 49.0, 12.0, 50.0), (model,))


def page_of(given: SurfaceComparison) -> str:
    return surface_page(given).decode()


def bowl(rows: int = 41, cols: int = 61) -> FloatArray:
    row, col = np.mgrid[:rows, :cols].astype(np.float64)
    z: FloatArray = 200 + 0.02 * (col - 30) ** 2 + 0.03 * (row - 20) ** 2
    return z


class Reader(HTMLParser):
    """Notes elements, whether they nest, and the cells of tables."""

    VOID = frozenset({"meta", "link", "img", "stop", "rect"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[tuple[str, dict[str, str | None]]] = []
        self.cells: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "td":
            self.cells.append(data)


def read(page: str) -> Reader:
    reader = Reader()
    reader.feed(page)
    reader.close()
    assert reader.open == []
    return reader


def test_the_page_is_whole_and_needs_nothing_else() -> None:
    page = page_of(comparison(bowl()))
    reader = read(page)
    assert page.startswith("<!doctype html>")
    tags = [tag for tag, _ in reader.seen]
    assert tags.count("img") == 1 + 3 + 4
    assert not {"script", "iframe", "object"} & set(tags)
    assert [attributes["href"] for tag, attributes in reader.seen if tag == "link"] == ["data:,"]
    sources = [attributes["src"] for tag, attributes in reader.seen if tag == "img"]
    assert all(source is not None and source.startswith("data:image/png;base64,iVBOR") for source in sources)
    assert re.findall(r"https?://|url\((?!#)", re.sub(r'base64,[^"]+', "", page)) == []


def test_figures_are_in_the_tables() -> None:
    given = comparison(bowl())
    cells = read(page_of(given)).cells
    grid = given.models[0].grid
    bilinear = grid.interpolations[1]
    begin = cells.index("bilinear")
    assert cells[begin + 1 : begin + 5] == [f"{bilinear.rms:.3f}", "0.050", "0.05", f"{bilinear.bias:+.3f}"]
    assert cells[begin + 7] == f"{41 * 61 - 21 * 31:,}"
    assert [cells[k] for k in range(24, len(cells), 8)] == ["2", "3", "4", "5"]
    page = page_of(given)
    assert "11, 49, 12, 50 degrees" in page
    assert "3 of them heights that are not the ground" in page
    assert "a surface model (canopy and roofs)" in page
    assert "On these heights bicubic, which convert uses by default, has the smallest error." in page


def test_a_better_method_is_named() -> None:
    x, y = np.meshgrid(np.arange(61.0), np.arange(41.0))
    noisy = 0.1 * x + np.random.default_rng(1).normal(0.0, 1.0, x.shape) + 0.0 * y
    page = page_of(comparison(noisy))
    found = re.search(r"On these heights (\w+) has the smallest error, (\d+) % below that of bicubic", page)
    assert found is not None
    assert found[1] == "bilinear"
    assert "<code>--surface bilinear</code> chooses it" in page


def test_names_are_escaped() -> None:
    page = page_of(comparison(bowl(), '<script>alert("x")</script> & more.tif'))
    assert "<script>" not in page
    assert "&lt;script&gt;alert(&quot;x&quot;)&lt;/script&gt; &amp; more.tif" in page
    assert "WGS 84 &lt;b&gt;" in page


def test_patches_are_reported() -> None:
    assert "9 patches of 61 x 41 cells were examined" in page_of(comparison(bowl(), patches=9))
    assert "patches" not in page_of(comparison(bowl()))


@pytest.mark.parametrize("make", ["level", "voids", "next to nothing"])
def test_odd_heights(make: str) -> None:
    z = np.full((41, 61), 5.0)
    if make == "voids":
        z[::2, ::2] = np.nan
    if make == "next to nothing":
        z[:, 3:] = np.nan
    page = page_of(comparison(z))
    read(page)
    assert ("There is nothing to compare" in page) == (make == "voids")
    assert "nan" not in re.sub(r'base64,[^"]+', "", page)


def test_the_pictures_show_what_is_there() -> None:
    page = page_of(comparison(bowl()))
    found = re.findall(r'alt="([^"]+)" width="(\d+)" height="(\d+)" src="data:image/png;base64,([^"]+)"', page)
    assert [name for name, *_ in found][:4] == ["Heights", "Errors, nearest", "Errors, bilinear", "Errors, bicubic"]
    assert found[0][1:3] == ("460", "309")
    assert all(base64.b64decode(data)[:8] == b"\x89PNG\r\n\x1a\n" for *_, data in found)
