"""From the tags of ways, and those of the ways that continue a street, to the attributes of streets."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import field, replace
from functools import lru_cache, partial
from types import MappingProxyType
from typing import Final

from osm2xodr.conventions import GENERIC, Country
from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import Direction, LaneSpec, Rule, StreetAttributes, WayCorrection, applied, unused
from osm2xodr.osmParsing.file import RawWay
from osm2xodr.osmParsing.tags.access import ACCESS_TAGS, changes_direction, closed_direction, is_roundabout, oneway
from osm2xodr.osmParsing.tags.beside_lanes import BESIDE_TAGS
from osm2xodr.osmParsing.tags.cross_sections import (
    NO_FACTS,
    SECTION_TAGS,
    CrossSection,
    StreetFacts,
    cross_section,
)
from osm2xodr.osmParsing.tags.lane_counts import COUNT_TAGS, USER_TAGS
from osm2xodr.osmParsing.tags.lane_lists import DIRECTIONS, LIST_TAGS
from osm2xodr.osmParsing.tags.legal_speeds import BUILT_UP_TAGS, is_town_street, legal_speed, speed_guess
from osm2xodr.osmParsing.tags.margins import seen_backwards
from osm2xodr.osmParsing.tags.neighbours import lanes_of_neighbours, widths_of_neighbours
from osm2xodr.osmParsing.tags.values import Findings, Tags, lowest_speed, parse_grade, parse_speed
from osm2xodr.osmParsing.tags.way_facts import (
    MARK_TAGS,
    STRUCTURE_TAGS,
    has_tram,
    lanes_marked,
    layer_of,
    max_height,
    no_overtaking,
    opposite_directions,
    reversed_divider,
    speed_is_signed,
    structure_of,
    structure_tags,
)
from osm2xodr.system import record

# Kinds of roads whose limit does not depend on the zone around them.
_OUT_OF_ZONE: Final = frozenset({"motorway", "motorway_link", "living_street", "pedestrian", "track"})
# Tags that no road of the result can carry, because of who or what they hold for. OSM's wiki has one scheme for them
# (Conditional restrictions): ``key[:vehicle][:direction][:conditional]``, with the vehicles of Key:access, and pages
# for some more keys (Key:maxspeed, Key:lanes:psv, Lanes).
# OSM wiki, Key:access: who travels on land.
_VEHICLES: Final = (
    *("foot", "vehicle", "bicycle", "carriage", "trailer", "caravan", "motor_vehicle", "motorcycle", "moped", "mofa"),
    *("speed_pedelec", "motorcar", "motorhome", "tourist_bus", "coach", "goods", "hgv", "hgv_articulated", "bdouble"),
    *("agricultural", "golf_cart", "atv", "ohv", "snowmobile", "psv", "bus", "taxi", "minibus", "share_taxi", "hov"),
    *("carpool", "car_sharing", "emergency", "hazmat", "disabled", "tram"),
)
_AT_TIMES: Final = "holds at certain times only and is not carried"
_SOME: Final = "holds for some vehicles only and is not carried"
# Tags whose condition is told for roads as a whole.
_OTHER_CONDITIONAL: Final = ("access", "vehicle", "motor_vehicle", "motorcar", "overtaking")
# OSM wiki, Key:source:maxspeed: tags that stand in for ``maxspeed`` where it is absent, the surest first.
_IMPLIED_SPEED: Final = ("maxspeed:type", "source:maxspeed", "zone:maxspeed", "zone:traffic")
_SPEED_TAGS: Final = ("maxspeed", "maxspeed:forward", "maxspeed:backward", *_IMPLIED_SPEED)
_READ: Final = frozenset((*ACCESS_TAGS, *BESIDE_TAGS, *COUNT_TAGS, *USER_TAGS, *LIST_TAGS, *_SPEED_TAGS))


def _by_scheme() -> Iterator[tuple[str, str]]:
    """Yield the keys of the scheme, read or not, with what is said of them."""
    for key in ("lanes", "oneway", "maxspeed"):
        for vehicle in ("", *(f":{name}" for name in (*_VEHICLES, "bicycles"))):
            for way in DIRECTIONS:
                yield f"{key}{vehicle}{way}", _SOME
                yield f"{key}{vehicle}{way}:conditional", _AT_TIMES


_NOT_CARRIED: Final[Mapping[str, str]] = MappingProxyType(
    {
        key: words
        for key, words in (
            *_by_scheme(),
            *((f"{key}:conditional", _AT_TIMES) for key in (*_OTHER_CONDITIONAL, *LIST_TAGS)),
            *((f"lanes:{user}:times", _AT_TIMES) for user in ("psv", "bus")),
            *(
                (f"{key}:variable", "says that signs change it, which is not carried")
                for key in ("maxspeed", "lanes")
            ),
            *((f"maxspeed:advisory{way}", "is advice, no limit, and is not carried") for way in DIRECTIONS),
            *((f"maxspeed:{how}", "is no limit and is not carried") for how in ("practical", "recommended")),
            *((f"maxspeed:{when}", _AT_TIMES) for when in ("wet", "seasonal", "night", "children_present")),
            ("maxspeed:signed", "says whether there is a sign, which is not carried"),
            ("maxspeed:towing", _SOME),
        )
        if key not in _READ
    }
)
# OSM wiki, Key:priority_road: signed or otherwise known to be one.
_PRIORITY: Final = frozenset({"designated", "yes_unposted", "yes"})
_OTHER_TAGS: Final = ("highway", "name", "ref", "incline", "driving_side", "priority_road")
WAY_TAGS: Final = frozenset(
    (
        *(*ACCESS_TAGS, *_OTHER_TAGS, *_SPEED_TAGS, *_NOT_CARRIED),
        *(*SECTION_TAGS, *MARK_TAGS, *BUILT_UP_TAGS, *STRUCTURE_TAGS),
    )
)

# Nothing is known of any way.
_NO_FACTS: Final[Mapping[int, StreetFacts]] = MappingProxyType({})
# No correction of any way.
_NO_CORRECTIONS: Final[Mapping[int, WayCorrection]] = MappingProxyType({})
_SECTION_TAGS: Final = frozenset(SECTION_TAGS)
_NAMES: Final = frozenset({"name", "ref"})


def way_attributes(
    ways: Sequence[RawWay],
    rule: Rule,
    default_lane_width: float | None,
    diagnostics: Diagnostics,
    country: Country = GENERIC,
    *,
    default_speeds: bool = True,
    dense: Set[int] = frozenset(),
    corrections: Mapping[int, WayCorrection] = _NO_CORRECTIONS,
    facts: Mapping[int, StreetFacts] = _NO_FACTS,
) -> tuple[list[StreetAttributes], list[int]]:
    """Read the tags `WAY_TAGS` of ways: the attributes of each, seen along its nodes, and its direction of traffic.

    The direction is 1 or -1 where the way is one-way for cars along or against its order of nodes, else 0. `rule` is
    the side that traffic drives on, `default_lane_width` (m) that of lanes without a tagged one (None takes one by
    the class of the road); limits and usual widths are those of `country`, whose law stands in for limits that are
    not tagged if `default_speeds` says so; `dense` are the ids of the ways among residential streets. Of the
    `corrections`, by id, widths of lanes and clearances are applied; others are in the tags already. `facts` are
    those of some ways, by index. What is guessed, repaired or ignored goes to the diagnostics.
    """
    reader = _Reader(rule, default_lane_width, country, default_speeds, diagnostics)
    # Many ways of a city differ in their names alone.
    known: dict[tuple[object, ...], _Meaning] = {}
    attributes: list[StreetAttributes] = []
    directions: list[int] = []
    lanes = lanes_of_neighbours(ways)
    # A width that the user chose for lanes comes before those of the neighbours.
    street_widths = {} if default_lane_width else widths_of_neighbours(ways, facts)
    for index, way in enumerate(ways):
        tags, around = way.tags, facts.get(index, NO_FACTS)
        if index in street_widths:
            around = replace(around, width=street_widths[index])
        place = lanes.get(index), way.id in dense, around
        named_apart = way.id if way.id in corrections else None
        key = (*place, named_apart, *[item for item in tags.items() if item[0] not in _NAMES])
        if key not in known:
            known[key] = reader.read(way, *place, corrections.get(way.id))
        meaning = known[key]
        attributes.append(meaning.make(osm_way_id=way.id, name=tags.get("name", ""), ref=tags.get("ref", "")))
        directions.append(meaning.direction)
        for kind, code, words in meaning.findings:
            diagnostics.add(kind, code, f"way/{way.id}", words)
    return attributes, directions


@record
class _Meaning:
    """What ways say whose tags differ in their names alone."""

    make: partial[StreetAttributes]  # Makes the attributes of a way from its id, name and number
    direction: int  # That of traffic, as of `way_attributes`
    findings: Findings


@record
class _Reader:
    """Reads the tags of ways; the first arguments of `way_attributes`."""

    rule: Rule
    default_lane_width: float | None
    country: Country
    default_speeds: bool
    diagnostics: Diagnostics
    # Most ways of a city share a few cross sections.
    sections: dict[tuple[object, ...], CrossSection] = field(default_factory=dict)

    def read(
        self, way: RawWay, lanes: int | None, dense: bool, facts: StreetFacts, correction: WayCorrection | None
    ) -> _Meaning:
        """Read a way with the number of `lanes` on the same street, if it has none itself, and what else is known."""
        tags = way.tags
        direction, certain = oneway(tags)
        closed, closing_tag = (closed_direction(tags) if direction == 0 else None) or (0, "")
        section = self._section(way, direction, closed, lanes, is_town_street(tags, dense), facts, correction)
        findings = list(section.findings)
        if not certain:
            findings.append(_unknown_oneway(tags, direction))
        if lanes is not None:
            words = f"no lanes given, lanes={lanes} as on the same street on both sides"
            findings.append((Kind.GUESSED, "lane-count", words))
        if closed:
            words = f"{closing_tag} closes one direction to cars, for them it is one-way"
            findings.append((Kind.NOTE, "oneway", words))
        findings += [
            (Kind.DROPPED, "conditional", f"{item}={tags[item]} {_NOT_CARRIED[item]}")
            for item in sorted(tags.keys() & _NOT_CARRIED.keys())
        ]
        clearance = None if correction is None else correction.clearance
        make = _attributes(tags, section, direction or -closed, clearance, findings)
        if self.default_speeds:
            make = _with_legal_speed(make, tags, self.country, findings)
        return _Meaning(make, direction or -closed, findings)

    def _section(
        self,
        way: RawWay,
        direction: int,
        closed: int,
        lanes: int | None,
        town: bool,
        facts: StreetFacts,
        correction: WayCorrection | None,
    ) -> CrossSection:
        """Return the cross section of a way; its corrected widths are reported."""
        lane_tags = {key: value for key, value in way.tags.items() if key in _SECTION_TAGS}
        if lanes is not None:
            lane_tags["lanes"] = str(lanes)
        highway = way.tags["highway"]
        key = (highway, direction, closed, town, facts, *lane_tags.items())
        lane_tags["highway"] = highway
        make = partial(
            cross_section,
            *(lane_tags, direction, self.rule, self.default_lane_width, closed, self.country),
            in_town=town,
            facts=facts,
        )
        if key not in self.sections:
            self.sections[key] = make()
        section = self.sections[key]
        if correction is None or not correction.lane_width:
            return section
        corrected = make(known_widths=correction.lane_width)
        _report_widths(way.id, section, corrected, correction.lane_width, self.diagnostics)
        return corrected


def _report_widths(
    way: int, before: CrossSection, after: CrossSection, known: Mapping[int, float], diagnostics: Diagnostics
) -> None:
    """Report whether corrections of the widths of lanes have an effect on a way."""
    lanes = len(after.lanes_ltr)
    old, new = (", ".join(f"{lane.width:g}" for lane in item.lanes_ltr) for item in (before, after))
    if max(known) > lanes:
        unused(diagnostics, f"way/{way}", "lane-width", f"it has no lane {max(known)}, only {lanes} of them")
    elif old == new:
        unused(diagnostics, f"way/{way}", "lane-width", f"its lanes are {new} m wide without it")
    else:
        applied(diagnostics, f"way/{way}", "lane-width", f"{new} m in place of {old} m, from the left")


def without_margins(attributes: StreetAttributes) -> StreetAttributes:
    """Return a way's attributes without the strips beside its carriageway."""
    if not attributes.margin_left and not attributes.margin_right:
        return attributes
    return replace(attributes, margin_left=(), margin_right=())


def turned_round(attributes: StreetAttributes) -> StreetAttributes:
    """Return a way's attributes as seen in the opposite direction."""
    return replace(
        attributes,
        reversed=not attributes.reversed,
        lanes_ltr=_mirrored(attributes.lanes_ltr),
        middle_offset=-attributes.middle_offset if attributes.middle_offset else 0.0,
        speed_forward=attributes.speed_backward,
        speed_backward=attributes.speed_forward,
        grade=-attributes.grade if attributes.grade else attributes.grade,
        margin_left=seen_backwards(attributes.margin_right),
        margin_right=seen_backwards(attributes.margin_left),
        no_overtaking=opposite_directions(attributes.no_overtaking),
        divider=reversed_divider(attributes.divider),
    )


@lru_cache(maxsize=4096)
def _mirrored(lanes_ltr: tuple[LaneSpec, ...]) -> tuple[LaneSpec, ...]:
    return tuple(replace(lane, direction=Direction(-lane.direction)) for lane in reversed(lanes_ltr))


def _unknown_oneway(tags: Tags, direction: int) -> tuple[Kind, str, str]:
    taken = "two-way" if direction == 0 else "one-way along its nodes"
    if changes_direction(tags):
        return Kind.GUESSED, "oneway", f"oneway={tags['oneway']} has no fixed direction, taken as {taken}"
    return Kind.DROPPED, "oneway", f"oneway={tags['oneway']} is not known and is ignored, taken as {taken}"


def _attributes(
    tags: Tags, section: CrossSection, direction: int, clearance: float | None, findings: Findings
) -> partial[StreetAttributes]:
    """Return what makes the attributes of ways with these tags from their ids, names and numbers."""
    both = _speed(tags, "maxspeed", findings) if "maxspeed" in tags else _implied_speed(tags)
    forward = _speed(tags, "maxspeed:forward", findings)
    backward = _speed(tags, "maxspeed:backward", findings)
    structure = structure_of(tags)
    return partial(
        StreetAttributes,
        reversed=False,
        highway=tags["highway"],
        lanes_ltr=section.lanes_ltr,
        middle_offset=section.middle_offset,
        speed_forward=both if forward is None else forward,
        speed_backward=both if backward is None else backward,
        structure=structure,
        layer=layer_of(tags, structure, findings),
        grade=_grade(tags, findings),
        roundabout=is_roundabout(tags),
        priority_road=tags.get("priority_road") in _PRIORITY,
        margin_left=section.margin_left,
        margin_right=section.margin_right,
        speed_signed=speed_is_signed(tags),
        no_overtaking=no_overtaking(tags, direction, findings),
        marked=lanes_marked(tags, findings),
        divider=tags.get("divider", ""),
        surface=tags.get("surface", ""),
        traffic_sign=tags.get("traffic_sign", ""),
        tram=has_tram(tags),
        structure_tags=structure_tags(tags),
        max_height=max_height(tags, findings),
        clearance=clearance,
    )


def _with_legal_speed(
    make: partial[StreetAttributes], tags: Tags, country: Country, findings: Findings
) -> partial[StreetAttributes]:
    """Give ways without any limit the one that the law surely sets for them."""
    if make.keywords["speed_forward"] is not None or make.keywords["speed_backward"] is not None:
        return make
    speed = legal_speed(tags, country)
    if speed is None:
        return make
    findings.append((Kind.GUESSED, "speed", speed_guess(speed, country)))
    return partial(make, speed_forward=speed, speed_backward=speed)


_speed_of = lru_cache(maxsize=1024)(parse_speed)
_lowest_of = lru_cache(maxsize=1024)(lowest_speed)


def _speed(tags: Tags, key: str, findings: Findings) -> float | None:
    text = tags.get(key)
    if text is None:
        return None
    speed, exact = _lowest_of(text)
    if speed is not None and not exact:
        findings.append((Kind.GUESSED, "speed", f"{key}={text} has several limits, the lowest is taken"))
    if speed is None:
        findings.append((Kind.DROPPED, "speed", f"{key}={text} gives no fixed speed and is ignored"))
    return speed


def _implied_speed(tags: Tags) -> float | None:
    """Return the legal limit of a tagged zone or kind of road, such as ``source:maxspeed=DE:urban``, m/s."""
    for key in _IMPLIED_SPEED:
        # Other values tell where the limit was read, not its value.
        if ":" not in tags.get(key, "") or (key == "zone:traffic" and tags["highway"] in _OUT_OF_ZONE):
            continue
        if (speed := _speed_of(tags[key])) is not None:
            return speed
    return None


def _grade(tags: Tags, findings: Findings) -> float | None:
    text = tags.get("incline")
    if text is None or text in {"up", "down", "yes", "no"}:
        return None
    grade = parse_grade(text)
    if grade is None:
        findings.append((Kind.DROPPED, "incline", f"incline={text} is not the grade of a road and is ignored"))
    return grade
