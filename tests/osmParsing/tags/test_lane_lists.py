import pytest
from osm_builder import tags_of

from osm2xodr.diagnostics import Kind
from osm2xodr.model import Access, LaneType
from osm2xodr.osmParsing.tags.lane_lists import Slot, motor_lanes, read_slots, read_turns
from osm2xodr.osmParsing.tags.values import Findings

LETTERS = {
    LaneType.DRIVING: "d",
    LaneType.BUS: "b",
    LaneType.TAXI: "t",
    LaneType.BIKING: "c",
    LaneType.NONE: "-",
}


def types(slots: tuple[Slot, ...]) -> str:
    return "".join(LETTERS[slot.type] for slot in slots)


@pytest.mark.parametrize(
    ("tags", "tagged", "expected"),
    [
        ("", 2, ""),
        ("turn:lanes=left|through|right", 0, "ddd"),
        ("turn:lanes=left|", 2, "dd"),
        ("change:lanes=no|no", 0, "dd"),
        # Bicycle lanes: https://www.openstreetmap.org/way/251106575 and /way/69340957
        ("access:lanes=yes|yes|yes|no|yes bicycle:lanes=yes|yes|yes|designated|yes", 4, "dddcd"),
        ("motor_vehicle:lanes=yes|no bicycle:lanes=yes|designated", 2, "dc"),
        ("vehicle:lanes=yes|no bicycle:lanes=yes|yes", 1, "dc"),
        ("bicycle:lanes=yes|designated", 1, "dc"),
        # Nothing keeps cars out, and both lanes are counted as lanes for cars.
        ("bicycle:lanes=yes|designated", 2, "dd"),
        ("bicycle:lanes=use_sidepath|use_sidepath|designated", 0, "ddc"),
        # Bus lanes: https://www.openstreetmap.org/way/33097750, /way/225787417 and /way/60741687
        ("access:lanes=yes|yes|no bus:lanes=yes|yes|designated", 3, "ddb"),
        ("access:lanes=psv|yes|yes", 3, "bdd"),
        ("access:lanes=no|yes|yes psv:lanes=designated|yes|yes", 3, "bdd"),
        ("bus:lanes=unknown|designated", 2, "db"),
        ("motor_vehicle:lanes=yes|no taxi:lanes=yes|designated", 2, "dt"),
        # A lane for both is a bus lane first.
        ("access:lanes=yes|no bus:lanes=yes|designated bicycle:lanes=yes|designated", 2, "db"),
        # Cars may use it, too.
        ("motorcar:lanes=yes|yes bus:lanes=yes|designated", 2, "dd"),
        ("access:lanes=yes|no", 1, "d-"),
        ("access:lanes=no|yes motor_vehicle:lanes=yes|yes", 2, "dd"),
    ],
)
def test_who_lanes_are_for(tags: str, tagged: int, expected: str) -> None:
    findings: Findings = []
    assert types(read_slots(tags_of(tags), ("",), tagged, findings)) == expected
    assert findings == []


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        ("hov:lanes=designated|yes|yes", "H--"),
        ("motor_vehicle:lanes=no|yes|yes hov:lanes=yes|yes|yes", "H--"),
        ("access:lanes=yes|hov", "-H"),
        # A lane that buses share with them.
        ("motor_vehicle:lanes=no|yes hov:lanes=designated|no bus:lanes=designated|yes", "H-"),
        ("hov:lanes=no|yes", "--"),
    ],
)
def test_lanes_for_cars_with_several_people(tags: str, expected: str) -> None:
    findings: Findings = []
    slots = read_slots(tags_of(tags), ("",), 0, findings)
    assert types(slots) == "d" * len(expected)
    assert ["H" if slot.access is Access.HOV else "-" for slot in slots] == list(expected)
    assert findings == []


def test_arrows_are_given_to_all_lanes_or_to_those_for_cars() -> None:
    users = "access:lanes=yes|no|yes bicycle:lanes=yes|designated|yes"
    findings: Findings = []
    whole = read_slots(tags_of(f"{users} turn:lanes=through|none|slight_right;right"), ("",), 2, findings)
    cars = read_slots(tags_of(f"{users} turn:lanes=through|slight_right;right"), ("",), 2, findings)
    assert whole == cars
    assert [sorted(slot.turns) for slot in cars] == [["through"], [], ["right", "slight_right"]]
    assert findings == []


def test_widths_of_lanes() -> None:
    findings: Findings = []
    slots = read_slots(tags_of("width:lanes=3.5|11'|wide||30"), ("",), 5, findings)
    assert [slot.width for slot in slots] == [3.5, pytest.approx(3.3528), None, None, None]
    assert [(kind, code) for kind, code, _ in findings] == [(Kind.DROPPED, "lane-width")] * 2


def test_surplus_narrow_widths_are_bicycle_lanes() -> None:
    findings: Findings = []
    assert types(read_slots(tags_of("width:lanes=4|2"), ("",), 1, findings)) == "dc"
    assert [(kind, code) for kind, code, _ in findings] == [(Kind.GUESSED, "lane-lists")]
    assert types(read_slots(tags_of("width:lanes=3|3"), ("",), 1, findings)) == "dd"


def test_lists_that_do_not_fit_are_ignored() -> None:
    findings: Findings = []
    slots = read_slots(
        tags_of("access:lanes=yes|yes|no bus:lanes=yes|yes|designated turn:lanes=left"), ("",), 3, findings
    )
    assert types(slots) == "ddb"
    assert motor_lanes(slots) == 3
    assert findings == [(Kind.DROPPED, "lane-lists", "turn:lanes=left does not fit 3 lanes, ignored")]


def test_lists_of_more_lanes_than_any_road_has_are_ignored() -> None:
    findings: Findings = []
    assert read_slots({"turn:lanes": "through|" * 25}, ("",), 2, findings) == ()
    words = "turn:lanes names 26 lanes, more than any road has, ignored"
    assert findings == [(Kind.DROPPED, "lane-lists", words)]
    assert len(read_slots({"turn:lanes": "through|" * 24}, ("",), 0, [])) == 25


def test_the_first_direction_that_is_there_counts() -> None:
    tags = tags_of("turn:lanes=left|right turn:lanes:forward=through|through|through turn:backward=left|through")
    assert len(read_slots(tags, ("", ":forward"), 0, [])) == 2
    assert len(read_slots(tags, (":forward",), 0, [])) == 3
    # ``turn`` with bars is meant as ``turn:lanes``.
    assert [sorted(slot.turns) for slot in read_slots(tags, (":backward",), 0, [])] == [["left"], ["through"]]


def test_unknown_arrows_are_dropped_and_said() -> None:
    findings: Findings = []
    assert read_turns("left; through;none;banana", findings) == {"left", "through"}
    assert findings == [(Kind.DROPPED, "turn", "'banana' is not a direction of a turn and is ignored")]
