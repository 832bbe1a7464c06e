"""What a conversion is, and how it is written."""

from __future__ import annotations

from pathlib import Path

import pytest
from lxml import etree
from small_area import write_area, write_dem

import osm2xodr


@pytest.fixture
def area(tmp_path: Path) -> Path:
    return write_area(tmp_path)


@pytest.fixture
def dem(tmp_path: Path) -> Path:
    return write_dem(tmp_path)


def test_files_can_be_written_at_once_or_later(area: Path, dem: Path, tmp_path: Path) -> None:
    at_once, later = tmp_path / "a.xodr", tmp_path / "b.xodr"
    network = osm2xodr.convert(str(area), [str(dem)], str(at_once), name="A & B", date="2024-05-01")
    assert network.write(later).path == later
    assert at_once.read_bytes() == later.read_bytes()
    network.write(later, name="Another", version="1.6")
    header = etree.parse(later).find("header")
    assert header is not None
    assert (header.get("name"), header.get("revMinor"), header.get("date")) == ("Another", "6", "2024-05-01")


def test_what_a_version_cannot_say_is_said_of_the_file(area: Path, tmp_path: Path) -> None:
    network = osm2xodr.convert(area, left_hand=True)
    before = len(network.diagnostics)
    codes = [item.code for item in network.write(tmp_path / "old.xodr", xodr_version="1.4").diagnostics]
    assert len(codes) > before == len(network.diagnostics)
    at_once = osm2xodr.convert(area, output=tmp_path / "old.xodr", left_hand=True, xodr_version="1.4")
    assert [item.code for item in at_once.diagnostics] == codes


def test_versions_that_cannot_be_written(area: Path, tmp_path: Path) -> None:
    network = osm2xodr.convert(area)
    with pytest.raises(osm2xodr.OptionError, match="date: 'yesterday' is not a date; write one such as 2024-05-01"):
        network.write(tmp_path / "x.xodr", date="yesterday")
    with pytest.raises(osm2xodr.OptionError, match=r"xodr_version: OpenDRIVE 1\.5 cannot be written"):
        network.write(tmp_path / "x.xodr", xodr_version="1.5")
    assert not (tmp_path / "x.xodr").exists()


def test_a_conversion_shows_what_it_is(area: Path) -> None:
    network = osm2xodr.convert(area, name="<b>Us & them</b>")
    assert repr(network).startswith(
        "<Conversion '<b>Us & them</b>': 3 roads of 0.5 km, 9 connecting roads in 1 junct"
    )
    page = network._repr_html_()
    assert "&lt;b&gt;Us &amp; them&lt;/b&gt;" in page
    assert "<b>" not in page
    table = etree.fromstring(page)
    assert [row.findtext("th") for row in table.iter("tr")][:4] == [
        "roads",
        "length",
        "connecting roads",
        "junctions",
    ]
