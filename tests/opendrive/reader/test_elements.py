"""Elements are read kind by kind, and mean what they do where they stand."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from same_tables import assert_same
from sample_road_maps import furnished_crossing
from xodr_text import LINE, cubics, document, geometry, lane, read_text, road, section

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.opendrive.reader import nodes, read_xodr
from osm2xodr.xodrWriter import WriteOptions, write_xodr


@pytest.mark.parametrize("size", [1, 97, 4096])
def test_what_is_read_at_once_does_not_matter(size: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stream, path = io.BytesIO(), tmp_path / "a.xodr"
    write_xodr(furnished_crossing(), stream, WriteOptions(), Diagnostics())
    wrong = road("77", length=float("nan"), elevation=cubics("elevation", (5.0, 1.0), (0.0, 2.0)), more="<unknown/>")
    path.write_bytes(stream.getvalue().replace(b"</OpenDRIVE>", f"{wrong}</OpenDRIVE>".encode()))
    whole = read_xodr(path)
    assert {item.rule for item in whole.misfits} == {"bad-number", "unknown-element", "unsorted-records"}
    monkeypatch.setattr(nodes, "_CHUNK", size)
    assert_same(read_xodr(path), whole)


def test_elements_mean_what_they_do_where_they_stand(tmp_path: Path) -> None:
    # A <speed> is one of a type or of a lane, and one within <userData> is neither; so are links.
    more = (
        '<type s="0" type="town"><speed max="10"/></type>'
        '<userData code="a" value="b"><speed max="5"/><lane id="7"/><geometry s="0"/></userData>'
    )
    lanes = section(
        0.0, "", lane(-1, (0, 3.5), more='<link><successor id="-3"/></link><speed sOffset="0" max="20"/>')
    )
    link = '<successor elementType="road" elementId="9" contactPoint="end"/>'
    file = read_text(tmp_path, document(road(link=link, more=more, lanes=lanes)))
    assert file.misfits == ()
    assert file.types.speed.tolist() == [10]
    assert file.lanes.speed[1:].tolist() == [20]
    assert file.lanes.id.tolist() == [0, -1]
    assert file.lanes.successor[1] == -3
    assert file.roads.link_id == (("", "9"),)
    assert len(file.plan_view.s) == 1


def test_what_a_road_has_twice_is_left_out_with_all_that_is_in_it(tmp_path: Path) -> None:
    again = f"<planView>{geometry(LINE, 50.0)}<wheel/></planView>"
    file = read_text(tmp_path, document(road("1"), road("2", more=again)))
    assert [(item.rule, item.road) for item in file.misfits] == [("repeated-element", 1)]
    assert file.plan_view.start.tolist() == [0, 1, 2]
    assert file.plan_view.length.tolist() == [100, 100]


def test_a_prefix_does_not_change_what_an_element_is(tmp_path: Path) -> None:
    text = document(road()).replace("<OpenDRIVE>", '<OpenDRIVE xmlns:q="u">')
    plain = read_text(tmp_path, text)
    for name in ("geometry", "lane"):
        text = text.replace(f"<{name} ", f"<q:{name} ").replace(f"</{name}>", f"</q:{name}>")
    assert "<q:lane " in text
    assert_same(read_text(tmp_path, text), plain)


def test_reports_of_one_line_stand_in_the_order_of_the_file(tmp_path: Path) -> None:
    plan, elevation = geometry("<line/><line/>", 100.0), '<elevation s="0" b="0" c="0" d="0"/>'
    one = road(plan=plan, elevation=elevation, lanes=section(0.0, centre=""), more="<wheel/>")
    file = read_text(tmp_path, document(one, one).replace("\n", ""))
    assert {item.line for item in file.misfits} == {1}
    expected = ["repeated-element", "missing-attribute", "missing-element", "unknown-element"]
    assert [(item.road, item.rule) for item in file.misfits] == [(k, rule) for k in (0, 1) for rule in expected]
