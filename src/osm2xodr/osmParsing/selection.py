"""Selection of the ways that become streets; others that cars might drive on are reported."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence, Set
from dataclasses import replace
from typing import Final

from osm2xodr.diagnostics import Diagnostics, Kind, counted
from osm2xodr.osmParsing.corrections import correct_relations, correct_ways, keep_way, kept_ways
from osm2xodr.osmParsing.file import (
    OsmFile,
    OtherWays,
    RawRelation,
    RawWay,
    class_of,
    count_contents,
    read_ways,
)
from osm2xodr.osmParsing.options import HIGHWAYS, ParseOptions
from osm2xodr.osmParsing.roadside import kerbs_beside, ways_beside
from osm2xodr.osmParsing.tags import WAY_TAGS, reason_left_out

# Values of ``highway`` for roads that do not exist yet; reported because maps show them.
_UNBUILT: Final = frozenset({"construction", "proposed", "planned"})
# Values that no car drives on, by the OSM wiki (Key:highway): ways for people on foot, bicycles and horses, outlines
# of places, stops, and roads that no longer exist. Ways with any other value are reported.
_NOT_FOR_CARS: Final = frozenset(
    {
        *("footway", "path", "cycleway", "bridleway", "steps", "corridor", "elevator", "escalator", "ladder"),
        *("via_ferrata", "crossing", "platform", "bus_stop", "services", "rest_area", "traffic_island", "no"),
        *("abandoned", "razed", "demolished", "dismantled", "removed"),
    }
)
# Values of ``barrier`` and ``railway`` of nodes on streets: barriers without effect on cars, and trams that cross.
_OPEN_BARRIERS: Final = frozenset({"no", "entrance", "kerb"})
_TRAM_CROSSING: Final = "tram_level_crossing"
# Longest value of a tag quoted in a message, characters.
_QUOTED_MAX: Final = 40
# Kinds of ways that are named where none of them becomes a street; the rest of a map are less.
_KINDS_NAMED: Final = 5


def read_selected_ways(
    file: OsmFile, options: ParseOptions, extra: frozenset[str], diagnostics: Diagnostics
) -> tuple[list[RawWay], list[RawWay], list[RawRelation], list[RawWay]]:
    """Read the ways that become streets, those beside them, relations, and all ways of the kinds asked for.

    Each is in ascending id. Ways that are left out although cars might drive on them go to the diagnostics. `extra`
    are the kinds of things read beside streets on request.
    """
    asked = options.ways.highways | _UNBUILT
    beside = ways_beside(asked, extra, options.guessed_parking) if options.furniture else kerbs_beside()
    others = OtherWays(
        beside.values,
        beside.keys | {"highway", "area"},
        beside.wanted,
        beside.every | {"highway"},
        _may_be_driven_on,
    )
    corrections = options.corrections
    read, relations = read_ways(file, asked, WAY_TAGS, others, corrections.kept_ways())
    read = [_with_one_class(way, asked, diagnostics) for way in read]
    corrected = correct_ways(read, corrections, diagnostics)
    relations = correct_relations(relations, corrections, diagnostics)
    kept = kept_ways(corrected.ways, corrections, diagnostics)
    found = [way for way in corrected.ways if way.tags.get("highway") in asked or way.id in kept]
    rest = [way for way in corrected.ways if way.tags.get("highway") not in asked and way.id not in kept]
    carried = _carried(found, kept, options, diagnostics)
    corrected.report(corrections, carried, diagnostics)
    _report_others(rest, diagnostics)
    return carried, [way for way in rest if len(way.refs)], relations, found


def _with_one_class(way: RawWay, asked: Set[str], diagnostics: Diagnostics) -> RawWay:
    """Return a way of several classes with the first of these, if that is asked for."""
    value, first = way.tags.get("highway", ""), class_of(way.tags)
    if value == first or first not in asked:
        return way
    words = f"highway={_short(value)} has several classes, the first is taken"
    diagnostics.guessed("highway-class", f"way/{way.id}", words)
    return replace(way, tags={**way.tags, "highway": first})


def _may_be_driven_on(tags: Mapping[str, str]) -> bool:
    """Whether a way is reported if it is left out; areas are not."""
    return tags.get("highway", "no") not in _NOT_FOR_CARS and tags.get("area") != "yes"


def _carried(
    found: Sequence[RawWay], kept: Set[int], options: ParseOptions, diagnostics: Diagnostics
) -> list[RawWay]:
    """Return those of the ways of the kinds asked for that become streets; `kept` (ids) do so in any case."""
    ways: list[RawWay] = []
    not_asked_for: dict[str, list[str]] = {}
    for way in found:
        if way.id in kept:
            known = options.corrections.ways[way.id]
            ways.append(keep_way(way, known, options.ways, options.include_private, diagnostics))
            continue
        name, highway = f"way/{way.id}", way.tags["highway"]
        if highway in _UNBUILT:
            diagnostics.dropped("not-built", name, f"highway={highway} does not exist yet and is left out")
            continue
        reason = reason_left_out(way.tags, options.ways, options.include_private)
        if reason is None:
            ways.append(way)
            if highway == "road":
                diagnostics.guessed("highway-class", name, "highway=road has no known class, taken as unclassified")
        elif reason[0] == "way-selection":
            not_asked_for.setdefault(reason[1], []).append(name)
        else:
            diagnostics.dropped(reason[0], name, reason[1])
    _report_counts(not_asked_for, diagnostics)
    return ways


def _report_others(rest: Sequence[RawWay], diagnostics: Diagnostics) -> None:
    """Report other ways that cars might drive on: counted if their kind can be asked for, else one by one."""
    not_asked_for: dict[str, list[str]] = {}
    for way in rest:
        if not _may_be_driven_on(way.tags):
            continue
        highway = way.tags["highway"]
        if highway in HIGHWAYS:
            words = f"highway={highway} is not among the ways asked for"
            not_asked_for.setdefault(words, []).append(f"way/{way.id}")
        else:
            words = f"highway={_short(highway)} is not a class of roads that can be carried, it is left out"
            diagnostics.dropped("highway-class", f"way/{way.id}", words)
    _report_counts(not_asked_for, diagnostics)


def _report_counts(not_asked_for: Mapping[str, Sequence[str]], diagnostics: Diagnostics) -> None:
    for words, ways in sorted(not_asked_for.items()):
        diagnostics.count(Kind.NOTE, "way-selection", ways, "way", f"left out: {words}")


def _short(value: str) -> str:
    """Return a tag's value, shortened for a message."""
    return value if len(value) <= _QUOTED_MAX else f"{value[: _QUOTED_MAX - 3]}..."


def report_unused_nodes(node_tags: Mapping[int, Mapping[str, str]], diagnostics: Diagnostics) -> None:
    """Report nodes of streets (tags by id) with something on the road that is not carried."""
    for number, tags in node_tags.items():
        barrier, railway = tags.get("barrier", "no"), tags.get("railway", "")
        found = []
        if barrier not in _OPEN_BARRIERS:
            found.append(f"barrier={_short(barrier)} on the road is not carried, the street is open there")
        if railway == _TRAM_CROSSING:
            found.append(f"railway={railway} is not carried, the street is open there")
        for words in found:
            diagnostics.dropped("street-node", f"node/{number}", words)


def report_file(file: OsmFile, diagnostics: Diagnostics) -> None:
    """Report what is wrong with a file as a whole, and what stands in it more than once."""
    if file.remark:
        diagnostics.dropped("partial-map", "", f"{file.path} is not whole, as its server says ({file.remark})")
    content = file.content
    if content.odd:
        words = f"{file.path} is not written as OSM's files are ({content.odd}); what streets need of it is read"
        diagnostics.note("file-form", "", words)
    for osm_id, what in sorted(content.repeated.items()):
        diagnostics.dropped("repeated-element", osm_id, f"it stands in the file more than once, {what}")
    words = "in several versions: the newest is taken"
    diagnostics.count(Kind.NOTE, "repeated-element", sorted(content.several_versions), "element", words)


def why_no_streets(file: OsmFile, asked: Sequence[RawWay], options: ParseOptions) -> str:
    """Return one sentence on why there is no street; `asked` are all ways of the kinds asked for."""
    contents = count_contents(file)
    if contents.lanelets:
        return (
            f"{file.path} is a map of Lanelet2 ({counted(contents.lanelets, 'lanelet')}), which has lanes already "
            "and no streets; osm2xodr reads OpenStreetMap's own data"
        )
    if not contents.nodes and not contents.highways:
        message = f", and its server says: {file.remark}" if file.remark else ""
        return f"{file.path} has no nodes and no ways{message}; check the area that it covers"
    if not contents.highways:
        return f"{file.path} has no ways with highway=*; export the area with its roads"
    kinds = sorted(contents.highways.items(), key=lambda item: (-item[1], item[0]))
    named = ", ".join(f"{count:,} {_short(kind)}" for kind, count in kinds[:_KINDS_NAMED])
    left_out = f"{file.path} has no way to drive on: {named}{', ...' if kinds[_KINDS_NAMED:] else ''} left out"
    reasons = Counter(
        reason[0] for way in asked if (reason := reason_left_out(way.tags, options.ways, options.include_private))
    )
    more = sorted(kind for kind in contents.highways if kind in HIGHWAYS - options.ways.highways)
    remedies = [f"--ways {','.join(more)} reads more of them"] if more else []
    if reasons["way-selection"]:
        remedies.append("--ways all reads more of them")
    if reasons["closed"] and not options.include_private:
        remedies.append(f"--include-private reads the {reasons['closed']} that are closed to cars")
    return f"{left_out}; {' and '.join(remedies) or 'give an area with streets'}"
