"""Large files are read by parts side by side, and give the tables that they give as a whole."""

from __future__ import annotations

import gzip
import io
from dataclasses import replace
from pathlib import Path

import pytest
from same_tables import assert_same
from sample_road_maps import furnished_crossing
from xodr_text import HEADER, cubics, document, road

from osm2xodr.conventions import TARGETS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.model import Rule
from osm2xodr.opendrive import reader as reading
from osm2xodr.opendrive.reader import nodes, read_xodr
from osm2xodr.opendrive.reader.nodes import find_parts
from osm2xodr.xodrWriter import WriteOptions, write_xodr

NAMES = ("generic", "sumo")


@pytest.fixture(autouse=True)
def small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Divide small files, too, for four cores."""
    monkeypatch.setattr(nodes, "_LEAST_PART", 500)
    monkeypatch.setattr(reading, "available_jobs", lambda: 4)


def assert_read_alike(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compare what is read by parts with what is read as a whole."""
    assert len(find_parts(path, 4)) > 1
    by_parts = read_xodr(path)
    monkeypatch.setattr(reading, "available_jobs", lambda: 1)
    assert_same(by_parts, read_xodr(path))


@pytest.mark.parametrize("target", NAMES)
def test_files_of_our_writer(target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stream, path = io.BytesIO(), tmp_path / "a.xodr"
    # For SUMO, lane ids have the other sign, as the header says.
    write_xodr(
        replace(furnished_crossing(), rule=Rule.LEFT_HAND),
        stream,
        WriteOptions(target=TARGETS[target]),
        Diagnostics(),
    )
    path.write_bytes(stream.getvalue())
    assert_read_alike(path, monkeypatch)
    file = read_xodr(path)
    assert file.lanes.id.tolist()[:3] == [1, 0, -1]
    assert {item.road for item in file.furniture} > {0}
    assert file.misfits == ()


# A road of which something is wrong: its length, a record out of order, and an element that is not known.
WRONG = road(length=float("nan"), elevation=cubics("elevation", (5.0, 1.0), (0.0, 2.0)), more="<unknown/>")
JUNCTION = (
    '<junction id="7"><connection id="0" incomingRoad="1" connectingRoad="1" contactPoint="start">'
    '<laneLink from="-1" to="-1"/></connection><priority high="1" low="1"/></junction>'
)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_what_is_wrong_has_its_line_and_road(end: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.xodr"
    text = document(*[WRONG, JUNCTION] * 12).replace("\n", end)
    path.write_bytes(text.encode())
    assert_read_alike(path, monkeypatch)
    file = read_xodr(path)
    behind = [item for item in file.misfits if item.rule == "unsorted-records"]
    assert [item.road for item in behind] == list(range(12))
    # The first road begins in line 4, and each takes four lines, one of them of its junction.
    assert [item.line for item in behind] == [5 + 4 * k for k in range(12)]
    assert file.connections.junction.tolist() == list(range(12))
    assert [index for index, _, _ in file.junctions.priorities] == list(range(12))


def test_what_looks_like_a_road_but_is_none_begins_no_part(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.xodr"
    hidden = f"<!-- {'<road >' * 400} -->"
    path.write_text(document(road("1"), hidden, road("2")), encoding="utf-8")
    assert_read_alike(path, monkeypatch)
    assert read_xodr(path).roads.id == ("1", "2")


def test_a_second_header_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.xodr"
    path.write_text(document(*[road()] * 20, HEADER), encoding="utf-8")
    assert_read_alike(path, monkeypatch)
    assert [item.rule for item in read_xodr(path).misfits] == ["repeated-element"]


def test_errors_name_the_line_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "a.xodr"
    path.write_text(document(*[road()] * 30, "</road>"), encoding="utf-8")
    assert len(find_parts(path, 4)) == 4
    # Two lines before the header, and three of each road.
    with pytest.raises(InputError, match="mismatched tag in line 94"):
        read_xodr(path)


def test_other_files_are_read_as_a_whole(tmp_path: Path) -> None:
    text = document(*[road()] * 30)
    whole = {
        "packed.xodr": gzip.compress(text.encode()),
        "latin.xodr": text.replace("UTF-8", "ISO-8859-1").encode("latin-1"),
        "lone.xodr": text.replace("\n", "\r").encode(),
        "small.xodr": document(road()).encode(),
    }
    for name, data in whole.items():
        (tmp_path / name).write_bytes(data)
        assert find_parts(tmp_path / name, 4) == ()
        assert read_xodr(tmp_path / name).roads.id[0] == "1"
    assert find_parts(Path("-"), 4) == ()
