"""What stages say, counted and taken back."""

from __future__ import annotations

from osm2xodr.diagnostics import Diagnostic, Diagnostics, Kind


def filled() -> Diagnostics:
    out = Diagnostics()
    out.note("flat", "", "all is flat")
    out.count(Kind.NOTE, "way-selection", ["way/1", "way/2", "way/3"], "way", "left out")
    out.guessed("speed", "way/1", "taken as 50")
    out.guessed("speed", "way/4", "taken as 30")
    return out


def test_elements_of_which_the_same_is_said_are_counted() -> None:
    found = filled()
    assert list(found)[1] == Diagnostic(Kind.NOTE, "way-selection", "", "3 ways left out")
    assert len(found) == 4
    assert found.counts() == {
        (Kind.GUESSED, "speed"): 2,
        (Kind.NOTE, "flat"): 1,
        (Kind.NOTE, "way-selection"): 1,
    }
    assert found.osm_ids() == {"way/1", "way/2", "way/3", "way/4"}
    assert found.guessed_about("way/") == {1: frozenset({"speed"}), 4: frozenset({"speed"})}


def test_of_none_nothing_is_said() -> None:
    found = Diagnostics()
    found.count(Kind.DROPPED, "roadside-left-out", [], "bus stop", "left out")
    assert list(found) == []


def test_what_was_found_of_elements_is_taken_back() -> None:
    found = filled()
    found.forget({"way/1", "way/9"})
    assert [item.message for item in found] == ["all is flat", "2 ways left out", "taken as 30"]
    found.forget({"way/2", "way/3", "way/4"})
    assert [item.message for item in found] == ["all is flat"]


def test_findings_of_a_copy_are_added_behind_those_that_it_knew() -> None:
    found = filled()
    copy = found.copy()
    copy.note("later", "", "found apart")
    found.note("meanwhile", "", "found here")
    found.extend(copy.later_than(4))
    assert [item.message for item in found][-3:] == ["taken as 30", "found here", "found apart"]
    assert list(found.copy().later_than(6)) == []
