"""A summary has ten lines at most, and the worst comes first."""

from __future__ import annotations

import dataclasses

import pytest
from small_area import write_area, write_dem

import osm2xodr
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import ElevationReport, StructureRecord
from osm2xodr.reporting import Conversion, Style, codes, kinds_of_findings, summary


@pytest.fixture(scope="module")
def network(tmp_path_factory: pytest.TempPathFactory) -> Conversion:
    folder = tmp_path_factory.mktemp("area")
    return osm2xodr.convert(write_area(folder), write_dem(folder))


def found(**numbers: int) -> Diagnostics:
    """Return diagnostics of each of some codes (kind_code) so many times."""
    out = Diagnostics()
    for name, number in numbers.items():
        kind, _, code = name.partition("_")
        for k in range(number):
            getattr(out, kind)(code.replace("_", "-"), f"way/{k}", f"about {code} {k}.")
    return out


def test_what_was_made_comes_first(network: Conversion) -> None:
    lines = [line.text for line in summary(network, Diagnostics(), has_heights=True).lines()]
    assert lines == [
        "  0.5 km of road, 1 junction; AD, 0.3 x 0.2 km, traffic on the right",
        lines[1],
        "0 guesses, 0 dropped, 0 repaired: --report-json, -v",
    ]
    assert lines[1].startswith("  heights from 1,0")
    assert "measured on 100 % of the roads; 95 % of the ground within 0." in lines[1]


def test_a_flat_world_and_lights_are_said(network: Conversion) -> None:
    lit = dataclasses.replace(network.statistics, further={"traffic_lights": 12.0}, dem_coverage=None)
    level = dataclasses.replace(network.road_map, elevation_report=None)
    flat_world = dataclasses.replace(network, road_map=level, statistics=lit)
    lines = summary(flat_world, Diagnostics(), has_heights=False).lines()
    assert lines[0].text.startswith("  0.5 km of road, 1 junction, 12 traffic lights; ")
    flat = "  flat at height 0: there is no elevation model"
    assert lines[1].text == flat
    report = ElevationReport(0.0, 0.0, 0.0, (), (), (), ())
    raised = dataclasses.replace(network.road_map, elevation_report=report)
    heights = dataclasses.replace(network.statistics, lowest=-4.26, highest=5.2)
    crossed = dataclasses.replace(network, road_map=raised, statistics=heights)
    second = summary(crossed, Diagnostics(), has_heights=False).lines()[1].text
    assert second == f"{flat}; bridges and tunnels, with their ramps, from -4.3 to 5.2 m"


def test_bridges_and_tunnels_are_counted(network: Conversion) -> None:
    bridge = StructureRecord("bridge", (1,), (2,), 30.0, 6.0, 4.0, 3, 0.02, 0.1)
    found = ElevationReport(0.021, 1.5, 3.0, (), (), (bridge, bridge), ())
    built = dataclasses.replace(network, road_map=dataclasses.replace(network.road_map, elevation_report=found))
    assert "1 junction, 2 bridges; " in summary(built, Diagnostics(), has_heights=True).made[0]


def test_what_needs_attention_stands_in_order_of_harm(network: Conversion) -> None:
    log = found(guessed_speed=30, note_clearance=1, guessed_lane_count=1, dropped_restriction=2, guessed_no_height=1)
    about = summary(network, log, has_heights=True)
    lines = about.lines(findings=3)
    # What the law or the class gives is a guess, and nothing to act on.
    assert [line.text for line in lines] == [
        "needs attention (osm2xodr explain CODE says more):",
        "  no-height: about no_height 0 (way/0)",
        "  clearance: about clearance 0 (way/0)",
        "  check: 3 findings, listed above",
        "  restriction: about restriction 0 (way/0, and 1 more)",
        *(f"  {text}" for text in about.made),
        "32 guesses, 2 dropped, 0 repaired: --report-json, -v",
    ]
    styles = [line.style for line in lines]
    assert styles == [Style.HEADING] + [Style.ATTENTION] * 4 + [Style.PLAIN] * 3


def test_there_are_never_more_than_ten_lines(network: Conversion) -> None:
    log = Diagnostics()
    harmful = [name for name, item in codes().items() if item.harm is not None]
    for name in harmful:
        log.add(codes()[name].kinds[0], name, "way/1", "x" * 300)
    for used in (1, 3):
        lines = [line.text for line in summary(network, log, has_heights=True).lines(1, used)]
        assert used + len(lines) == 10
        left = len(harmful) + 1 - (len(lines) - 5)
        assert lines[-4] == f"  and {left} kinds more: -v"
        assert lines[1].startswith("  partial-map: xxx")
        # However long a message is, the element that it is about can be read.
        assert lines[1].endswith("x… (way/1)")
        assert max(map(len, lines)) < 160


def test_kinds_of_findings() -> None:
    log = found(note_late=1, guessed_lane_count=1500, guessed_lane_width=2)
    log.dropped("bad-node", "node/7", "node/7 has no position")
    assert kinds_of_findings(log) == [
        "  guessed     1,500  lane-count: about lane_count 0 (way/0, and 1,499 more)",
        "  guessed         2  lane-width: about lane_width 0 (way/0, and 1 more)",
        "  dropped         1  bad-node: node/7 has no position",
        "  note            1  late: about late 0 (way/0)",
    ]
