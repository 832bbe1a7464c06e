"""The summary of a batch: the table to the letter, and what stands in the page.

Where areas lie on the map of the page.
"""

from __future__ import annotations

import csv
import io
import json
import math
import os
import re
from pathlib import Path
from typing import Any

import pytest
from batch_results import Ring, leave_files, rectangle, report, result
from lxml import html

from osm2xodr.batching.model import Result, Status
from osm2xodr.batching.summary import COLUMNS, RADIUS, Map, Shape, make_map, number, write_summary
from osm2xodr.errors import OutputError
from osm2xodr.reporting import REPORT_FORMAT


def written(out_dir: Path, results: list[Result]) -> tuple[list[dict[str, str]], Any]:
    """Write a summary; return the rows of the table, and the page."""
    write_summary(out_dir, results)
    table = (out_dir / "summary.csv").read_bytes().decode("utf-8")
    page = (out_dir / "index.html").read_text(encoding="utf-8")
    return list(csv.DictReader(io.StringIO(table, newline=""))), html.fromstring(page)


def test_the_table_has_every_figure_of_the_report(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_bytes(report())
    (tmp_path / "a.xodr").write_bytes(b"-")
    rows, _ = written(tmp_path, [result("a")])
    assert rows == [
        {
            "name": "a",
            "status": "done",
            "message": "",
            "seconds": "12.35",
            "memory_mb": "600.0",
            "xodr": "a.xodr",
            "report": "a.json",
            "page": "",
            "xodr_bytes": "1234567",
            "roads": "12",
            "connecting_roads": "34",
            "junctions": "5",
            "road_km": "6.789",
            "connecting_road_km": "0.432",
            "dem_coverage": "0.9877",
            "lowest_m": "-3.26",
            "highest_m": "1234.50",
            "steepest_grade": "0.1234",
            "guessed": "42",
            "dropped": "3",
            "repaired": "0",
            "notes": "1",
            "xodr_version": "1.7",
            "osm2xodr": "9.8.7",
        }
    ]


def test_the_table_is_rfc_4180_in_order_of_names(tmp_path: Path) -> None:
    results = [result("b", Status.EMPTY, 'No "way", none'), result("a", Status.FAILED, "It failed.", outline_deg=())]
    write_summary(tmp_path, results)
    lines = (tmp_path / "summary.csv").read_bytes().split(b"\r\n")
    assert lines[0].decode() == ",".join(COLUMNS)
    assert lines[1] == b"a,failed,It failed.,12.35,600.0" + b"," * (len(COLUMNS) - 5)
    assert lines[2].startswith(b'b,empty,"No ""way"", none",12.35,600.0,')
    assert lines[3:] == [b""]


def test_the_same_results_give_the_same_bytes_in_any_order(tmp_path: Path) -> None:
    results = [result(f"t{k}", outline_deg=rectangle(7.0 + 0.1 * k, 43.0, 0.1, 0.1)) for k in range(12)]
    leave_files(tmp_path, results)
    found = set()
    for order in (results, results[::-1], results[5:] + results[:5]):
        write_summary(tmp_path, order)
        found.add((tmp_path / "summary.csv").read_bytes() + (tmp_path / "index.html").read_bytes())
    assert len(found) == 1


@pytest.mark.parametrize(
    "content",
    [
        None,
        b"",
        b"[1]",
        b"\xff\xfe",
        b"[" * 100_000,
        report()[:-30],
        json.dumps({"format": REPORT_FORMAT + 1}).encode(),
    ],
)
def test_a_report_that_cannot_be_read_is_reported_and_stops_nothing(tmp_path: Path, content: bytes | None) -> None:
    if content is not None:
        (tmp_path / "a.json").write_bytes(content)
    (tmp_path / "b.json").write_bytes(report())
    rows, page = written(tmp_path, [result("a"), result("b")])
    assert rows[0]["message"] == "There are no figures: its report a.json is missing or cannot be read."
    assert {rows[0][name] for name in COLUMNS[9:]} == {""}
    assert rows[1]["road_km"] == "6.789"
    assert rows[0]["message"] in page.get_element_by_id("areas").text_content()


def test_numbers_of_strangers_are_left_out(tmp_path: Path) -> None:
    text = report(roads="=1+1", junctions=True, highest=None, further=[1], dem_coverage=None).decode()
    (tmp_path / "a.json").write_text(text.replace("-3.26", "NaN").replace('"count": 40', '"count": "40"'))
    rows, _ = written(tmp_path, [result("a")])
    unknown = ("roads", "junctions", "highest_m", "steepest_grade", "dem_coverage", "lowest_m")
    assert {rows[0][name] for name in unknown} == {""}
    assert rows[0]["guessed"] == "2"


def test_what_lies_there_of_an_area_that_failed_is_not_taken_for_its_result(tmp_path: Path) -> None:
    leave_files(tmp_path, [result("a")])
    rows, page = written(tmp_path, [result("a", Status.FAILED, "It failed.")])
    assert (rows[0]["xodr"], rows[0]["report"], rows[0]["roads"]) == ("", "", "")
    assert page.xpath("//tbody//a") == []


@pytest.mark.parametrize("name", ["=1+1", "+1", "-1", "@sum", "\uff1d1", " =1"])
def test_names_are_no_formulas(tmp_path: Path, name: str) -> None:
    rows, _ = written(tmp_path, [result(name, Status.FAILED, f"{name} is bad.")])
    assert rows[0]["name"] == f"'{name}"
    assert rows[0]["message"] == f"'{name.strip()} is bad."


def test_line_breaks_and_what_turns_lines_round_are_not_in_the_table(tmp_path: Path) -> None:
    message = "one\r\n=two\x00\u2028three\u202efour \udcff"
    write_summary(tmp_path, [result("a", Status.FAILED, message)])
    lines = (tmp_path / "summary.csv").read_bytes().split(b"\r\n")
    assert lines[1].startswith("a,failed,one =two threefour \ufffd,".encode())


def test_the_page_counts_and_adds_up(tmp_path: Path) -> None:
    states = [Status.DONE] * 3 + [Status.UNCHANGED] * 2 + [Status.EMPTY] + [Status.FAILED] * 2
    results = [result(f"n{k}", status, "Because." if k > 4 else "") for k, status in enumerate(states)]
    leave_files(tmp_path, results)
    _, page = written(tmp_path, results)
    buttons = [" ".join(item.text_content().split()) for item in page.xpath("//*[@id='statuses']/button")]
    assert buttons == ["2 failed", "1 empty", "3 done", "2 unchanged"]
    figures = {div[0].text: div[1].text for div in page.xpath("//header/dl/div")}
    assert figures["km of road"] == "15.0"
    assert figures["roads"] == "60"
    assert figures["of conversions"] == "74.1 s"
    assert figures["most memory"] == "600 MB"
    # Those that failed come first, then what is empty.
    assert page.xpath("//tbody/tr/th/bdi/text()") == ["n6", "n7", "n5", "n0", "n1", "n2", "n3", "n4"]
    assert [item.text_content() for item in page.xpath("//*[@id='failures']//li")] == ["n6 Because.", "n7 Because."]


def test_numbers_in_names_count_by_their_value(tmp_path: Path) -> None:
    _, page = written(tmp_path, [result(name, Status.EMPTY) for name in ("t10", "t9", "T2", "\u00b2", "t2", "")])
    assert page.xpath("//tbody/tr/th/bdi")[0].text is None
    assert page.xpath("//tbody/tr/th/bdi/text()") == ["T2", "t2", "t9", "t10", "\u00b2"]


def test_links_lead_to_the_files_that_are_there(tmp_path: Path) -> None:
    name = 'a b&"c"#1?<%>é:'
    results = [result(name), result("plain")]
    leave_files(tmp_path, results[:1], (".xodr", ".json", ".html"))
    leave_files(tmp_path, results[1:])
    _, page = written(tmp_path, results)
    links = page.xpath("//tbody/tr[1]//a")
    assert [link.text for link in links] == ["xodr", "report", "page"]
    assert links[0].get("href") == "./a%20b%26%22c%22%231%3F%3C%25%3E%C3%A9%3A.xodr"
    assert [link.get("href") for link in page.xpath("//tbody/tr[2]//a")] == ["./plain.xodr", "./plain.json"]


def test_areas_of_unknown_place_are_reported(tmp_path: Path) -> None:
    results = [result("a", outline_deg=rectangle(7, 43, 1, 1)), result("b", Status.FAILED, "It failed.")]
    _, page = written(tmp_path, results)
    below = page.get_element_by_id("below").text_content()
    assert "1 of 2 areas is of unknown place, and not on the map." in below
    assert len(page.xpath("//*[@id='map']/a")) == 1
    assert page.get_element_by_id("top").get("class") is None
    _, page = written(tmp_path, results[1:])
    assert page.get_element_by_id("top").get("class") == "nowhere"


def test_nothing_of_names_becomes_markup(tmp_path: Path) -> None:
    name = "</script><script>window.owned=1</script><img src=x onerror='window.owned=2'>\"&amp;"
    results = [
        result(name, Status.FAILED, name, outline_deg=rectangle(7, 43, 1, 1)),
        result("@rows@ @script@", Status.DONE, outline_deg=rectangle(8, 43, 1, 1)),
    ]
    _, page = written(tmp_path, results)
    assert len(page.xpath("//script")) == 2
    assert page.xpath("//img") == []
    assert page.xpath("//tbody/tr/th/bdi/text()") == [name, "@rows@ @script@"]
    assert page.xpath("//@style") == []


def test_the_page_asks_for_no_network(tmp_path: Path) -> None:
    write_summary(tmp_path, [result("a", outline_deg=rectangle(7, 43, 1, 1))])
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    page: Any = html.fromstring(text)
    policy = page.xpath("//meta[@http-equiv='Content-Security-Policy']/@content")[0]
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    assert "unsafe" not in policy
    addresses = page.xpath("//@src") + page.xpath("//link/@href")
    assert addresses == ["data:,"]


def test_a_folder_that_cannot_be_written_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder", encoding="utf-8")
    with pytest.raises(OutputError, match=r"summary\.csv|file"):
        write_summary(tmp_path / "file" / "below", [result("a", Status.EMPTY)])


def test_two_thousand_tiles_make_a_small_page(tmp_path: Path) -> None:
    results = [
        result(
            f"tile_{k % 50:03}_{k // 50:03}",
            outline_deg=rectangle(9 + k % 50 * 0.06, 46 + k // 50 * 0.04, 0.06, 0.04),
        )
        for k in range(2000)
    ]
    leave_files(tmp_path, results)
    rows, page = written(tmp_path, results)
    assert len(rows) == len(page.xpath("//tbody/tr")) == len(page.xpath("//*[@id='map']/a")) == 2000
    assert (tmp_path / "index.html").stat().st_size < 1_600_000


ROAD = """<road length="9" id="1" junction="-1"><planView>
<geometry s="0" x="0" y="0" hdg="0" length="{length}"><line/></geometry></planView></road>"""


def test_rows_have_pictures_of_their_networks(tmp_path: Path) -> None:
    (tmp_path / ".state").mkdir()
    results = [result("a"), result("b"), result("c", Status.EMPTY)]
    for name in "ac":
        (tmp_path / f"{name}.xodr").write_text(ROAD.format(length=90), encoding="utf-8")
    (tmp_path / "b.xodr").write_bytes(b"-")

    def pictures() -> dict[str, str]:
        _, page = written(tmp_path, results)
        found = {row.findtext("th/bdi"): row.find("th/img") for row in page.findall(".//tbody/tr")}
        return {name: image.get("src") for name, image in found.items() if image is not None}

    before = pictures()
    assert list(before) == ["a"]
    assert before["a"].startswith("data:image/png;base64,")
    kept = tmp_path / ".state" / "a.png"
    kept.write_bytes(b"kept")
    assert pictures() == {"a": "data:image/png;base64,a2VwdA=="}
    # One of an older network is drawn anew.
    os.utime(kept, ns=(1, 1))
    assert pictures() == before
    assert kept.read_bytes()[:4] == b"\x89PNG"


def place(chart: Map, shape: Shape | None) -> tuple[float, float]:
    """Return longitude and latitude of a shape's middle, degrees."""
    assert shape is not None
    x, y = chart.left + shape.x * chart.unit, chart.top - shape.y * chart.unit
    return math.degrees(x / RADIUS), math.degrees(math.atan(math.sinh(y / RADIUS)))


def test_places_come_back_as_they_were() -> None:
    chart = make_map([rectangle(11.3, 48.0, 0.04, 0.02), rectangle(11.9, 48.3, 0.04, 0.02), ()])
    assert place(chart, chart.shapes[0]) == pytest.approx((11.32, 48.01), abs=1e-5)
    assert place(chart, chart.shapes[1]) == pytest.approx((11.92, 48.31), abs=1e-5)
    assert chart.shapes[2] is None


@pytest.mark.parametrize("lat", [-60.0, 0.0, 47.0, 70.0])
def test_squares_stay_square(lat: float) -> None:
    width = 0.02 / math.cos(math.radians(lat))
    chart = make_map([rectangle(20.0, lat - 0.01, width, 0.02), rectangle(21.0, lat, width, 0.02)])
    shape = chart.shapes[0]
    assert shape is not None
    assert shape.width / shape.height == pytest.approx(1.0, rel=1e-3)


def test_everything_is_inside() -> None:
    outlines = [rectangle(-122.4, 47.5, 0.1, 0.1), rectangle(115.7, -32.1, 0.1, 0.1), rectangle(18.9, 69.6, 0.1, 0.1)]
    chart = make_map(outlines)
    for shape in chart.shapes:
        assert shape is not None
        assert shape.width / 2 <= shape.x <= chart.width - shape.width / 2
        assert shape.height / 2 <= shape.y <= chart.height - shape.height / 2


def test_areas_on_both_sides_of_the_date_line_are_neighbours() -> None:
    across: tuple[Ring] = (((179.9, -17.0), (-179.9, -17.0), (-179.9, -16.9), (179.9, -16.9)),)
    chart = make_map([rectangle(179.6, -17.0, 0.2, 0.1), across, rectangle(-179.8, -17.0, 0.2, 0.1)])
    assert chart.unit * chart.width < 100_000.0
    xs = [shape.x for shape in chart.shapes if shape]
    assert xs == sorted(xs)
    middle = chart.shapes[1]
    assert middle is not None
    assert middle.width * chart.unit == pytest.approx(math.radians(0.2) * RADIUS, rel=1e-6)


def test_holes_and_parts_are_in_one_path() -> None:
    outline = (*rectangle(7.0, 43.0, 0.3, 0.3), *rectangle(7.1, 43.1, 0.1, 0.1))
    shape = make_map([outline]).shapes[0]
    assert shape is not None
    assert re.fullmatch(r"(M[\d.]+ [\d.]+(L[\d.]+ [\d.]+){3}Z){2}", shape.path)


def test_a_point_has_a_place_but_no_outline() -> None:
    chart = make_map([(((7.0, 43.0),),)])
    shape = chart.shapes[0]
    assert shape is not None
    assert shape.path == ""
    assert place(chart, shape) == pytest.approx((7.0, 43.0), abs=1e-6)
    assert 300.0 <= chart.unit * chart.width < 330.0


def test_the_map_ends_before_the_poles() -> None:
    chart = make_map([rectangle(-180.0, -90.0, 360.0, 180.0)])
    shape = chart.shapes[0]
    assert shape is not None
    assert math.isfinite(chart.height)
    assert shape.height == pytest.approx(shape.width, rel=0.01)


@pytest.mark.parametrize(
    ("value", "text"), [(1.0, "1"), (0.1239, "0.124"), (-0.0001, "0"), (-2.5, "-2.5"), (100.0, "100")]
)
def test_numbers_are_short(value: float, text: str) -> None:
    assert number(value) == text
