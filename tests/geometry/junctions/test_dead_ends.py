"""Dead ends on or behind the carriageway of a street that they do not meet."""

from __future__ import annotations

import math

import pytest
from street_cases import Case, Stages

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import SHORTEST_ROAD
from osm2xodr.geometry.junctions import JunctionLayout, cut_back_ends_on_streets, ends_on_streets
from osm2xodr.geometry.plan_view.streets import fit_streets

STREET = "highway=secondary width=8"


def laid_out(stages: Stages, diagnostics: Diagnostics) -> JunctionLayout:
    """Return the junctions with dead ends on streets cut back."""
    found = ends_on_streets(fit_streets(stages.network, Diagnostics()), stages.ends)
    return cut_back_ends_on_streets(stages.network, stages.ends, stages.layout, found, diagnostics)


def cut_back(end: tuple[float, float], *, tags: str = "highway=service width=4", way: str = "c d") -> float:
    """Return by how much a street that ends there is cut back, beside one along x that is 8 m wide, m."""
    nodes = {"a": (-100.0, 0.0), "b": (100.0, 0.0), "c": (0.0, 60.0), "d": end}
    stages = Case(nodes, {1: ("a b", STREET), 2: (way, tags)}).stages()
    diagnostics = Diagnostics()
    after = laid_out(stages, diagnostics)
    gone = after.trim - stages.layout.trim
    assert [(item.code, item.osm_id) for item in diagnostics] == [("lies-on-another", "way/2")] * int(gone.any())
    return float(gone.sum())


@pytest.mark.parametrize("way", ["c d", "d c"])
@pytest.mark.parametrize(
    ("y", "gone"), [(5.0, 0.0), (3.0, 1.3), (0.0, 4.3), (-3.5, 7.8), (-10.0, 14.3), (-12.0, 0.0)]
)
def test_an_end_on_a_street_or_behind_it_is_cut_back_to_its_edge(y: float, gone: float, way: str) -> None:
    assert cut_back((0.0, y), way=way) == pytest.approx(gone, abs=0.5)


def test_at_a_slant_the_farther_edge_counts() -> None:
    # It comes at 45 degrees, 2 m wide on either side.
    apart = (4.0 + 0.3 + 2.0 * math.cos(math.pi / 4)) / math.sin(math.pi / 4)
    assert cut_back((60.0, 0.0)) == pytest.approx(apart, abs=0.6)


@pytest.mark.parametrize(
    ("y", "gone"), [(4.5, (4.0 + 0.3 + 2.0 * math.sqrt(0.5) - 4.5) * math.sqrt(2.0)), (5.6, 0.0)]
)
def test_an_end_with_a_corner_on_a_street_is_cut_back(y: float, gone: float) -> None:
    # At 45 degrees its nearer corner lies 1.4 m closer to the street, whose edge is at y = 4, than its middle.
    assert cut_back((60.0 - y, y)) == pytest.approx(gone, abs=0.5)


def test_what_passes_the_street_or_runs_along_it_keeps_its_length() -> None:
    assert cut_back((0.0, -20.0)) == 0.0
    nodes = {"a": (-100.0, 0.0), "b": (100.0, 0.0), "c": (-60.0, 1.0), "d": (60.0, 1.0)}
    stages = Case(nodes, {1: ("a b", STREET), 2: ("c d", "highway=service")}).stages()
    after = laid_out(stages, Diagnostics())
    assert after.trim.tolist() == stages.layout.trim.tolist()


@pytest.mark.parametrize("tags", ["bridge=yes layer=1", "tunnel=yes layer=-1", "layer=-2", "bridge=yes layer=0"])
def test_ends_above_and_below_a_street_keep_their_length(tags: str) -> None:
    assert cut_back((0.0, 0.0), tags=f"highway=service width=4 {tags}") == 0.0


def test_stubs_of_the_street_itself_are_arms() -> None:
    nodes = {"a": (-100.0, 0.0), "b": (100.0, 0.0), "c": (0.0, 0.0), "d": (2.0, 3.0)}
    stages = Case(nodes, {1: ("a c b", STREET), 2: ("c d", "highway=service width=4")}).stages()
    after = laid_out(stages, Diagnostics())
    assert after.trim.tolist() == stages.layout.trim.tolist()


@pytest.mark.parametrize(("y", "cut"), [(26.0, True), (16.0, False)])
def test_what_the_junction_at_its_other_end_takes_is_left_to_it(y: float, cut: bool) -> None:
    nodes = {"a": (-100.0, 0.0), "b": (100.0, 0.0), "e": (-100.0, y), "c": (0.0, y), "f": (100.0, y), "d": (0.0, 1.0)}
    ways = {
        1: ("a b", STREET),
        2: ("c d", "highway=service width=4"),
        3: ("e c f", "highway=primary lanes=2 width:lanes:forward=8 width:lanes:backward=8"),
    }
    stages = Case(nodes, ways).stages()
    before = stages.layout
    after = laid_out(stages, Diagnostics())
    (street,) = [k for k, item in enumerate(stages.network.streets) if item.pieces[0][1].osm_way_id == 2]
    ends = slice(2 * street, 2 * street + 2)
    gone = after.trim[ends] - before.trim[ends]
    assert gone.tolist() == [0.0, pytest.approx(3.5 if cut else 0.0, abs=0.5)]
    # What is left is a street, however far the arm at the junction is set back.
    assert after.trim[2 * street + 1] + after.most[2 * street] <= y - 1.0 - SHORTEST_ROAD + 1e-9
