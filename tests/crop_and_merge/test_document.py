"""Records along s, cut to a stretch."""

from __future__ import annotations

import pytest
from lxml import etree

from osm2xodr.crop_and_merge.document import clip, cut_records


def records(*rows: str) -> etree._Element:
    return etree.fromstring(f"<road>{''.join(rows)}</road>")


def values(root: etree._Element, *names: str) -> list[tuple[float, ...]]:
    return [tuple(float(item.get(name, "nan")) for name in names) for item in root]


def test_what_holds_before_holds_from_the_begin() -> None:
    root = records('<type s="0"/>', '<type s="30"/>', '<type s="60"/>', '<type s="90"/>')
    cut_records(list(root), 40.0, 90.0)
    assert values(root, "s") == [(0,), (20,)]


def test_cubics_are_the_same_curve() -> None:
    root = records('<elevation s="10" a="1" b="2" c="3" d="4"/>')
    cut_records(list(root), 12.0, 20.0, cubic=True)
    ((s, a, b, c, d),) = values(root, "s", "a", "b", "c", "d")
    assert s == 0
    for ds in (0.0, 0.5, 3.0):
        u = ds + 2
        assert a + ds * (b + ds * (c + ds * d)) == pytest.approx(1 + u * (2 + u * (3 + u * 4)))


def test_several_records_at_one_s() -> None:
    rows = ('<speed s="0" max="1"/>', '<speed s="5" max="2"/>', '<speed s="5" max="3"/>')
    root = records(*rows)
    cut_records(list(root), 6.0, 9.0)
    assert values(root, "s", "max") == [(0, 2), (0, 3)]
    # Of cubics the last one holds.
    root = records('<w s="5" a="2" b="0" c="0" d="0"/>', '<w s="5" a="3" b="0" c="0" d="0"/>')
    cut_records(list(root), 6.0, 9.0, cubic=True)
    assert values(root, "s", "a") == [(0, 3)]


def test_records_that_begin_at_the_cut_do_not_change() -> None:
    root = records('<type s="30" a="0.10"/>', '<type s="60"/>')
    cut_records(list(root), 30.0, 60.0)
    assert values(root, "s", "a") == [(0, 0.1)]
    root = records('<type s="0.0"/>', '<type s="60"/>')
    cut_records(list(root), 0.0, 50.0)
    assert [item.get("s") for item in root] == ["0.0"]


@pytest.mark.parametrize(
    ("s", "length", "kept"),
    [("10", "30", ("0", "20")), ("35", "5", ("15", "5")), ("70", "30", ("50", "10")), ("0", "15", None)],
)
def test_what_lies_along_a_road_is_clipped(s: str, length: str, kept: tuple[str, str] | None) -> None:
    item = etree.fromstring(f'<bridge s="{s}" length="{length}"/>')
    assert clip(item, 20.0, 80.0) == (kept is not None)
    if kept is not None:
        assert (item.get("s"), item.get("length")) == kept
