"""Chooses the ways that become streets, and says which do not although cars might drive on them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Final

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.osmParsing.file import OsmFile, OtherWays, RawRelation, RawWay, count_contents, read_ways
from osm2xodr.osmParsing.options import HIGHWAYS, ParseOptions
from osm2xodr.osmParsing.roadside import ways_beside
from osm2xodr.osmParsing.tags import WAY_TAGS, reason_left_out

# Values of ``highway`` for roads that are not there yet; reported, because maps show them.
_UNBUILT: Final = frozenset({"construction", "proposed", "planned"})
# Values that no car drives on, by the OSM wiki (Key:highway): for people on foot, bicycles and horses, outlines of
# places, stops, and what is no longer there. Whatever else a way has is named in the report.
_NOT_FOR_CARS: Final = frozenset(
    {
        *("footway", "path", "cycleway", "bridleway", "steps", "corridor", "elevator", "escalator", "ladder"),
        *("via_ferrata", "crossing", "platform", "bus_stop", "services", "rest_area", "traffic_island", "no"),
        *("abandoned", "razed", "demolished", "dismantled", "removed"),
    }
)
# Of ``barrier`` and ``railway`` of nodes on streets: what nobody has to stop at, and what crosses the road.
_OPEN_BARRIERS: Final = frozenset({"no", "entrance", "kerb"})
_TRACK_CROSSINGS: Final = frozenset({"level_crossing", "tram_level_crossing"})
_WORD_MAX: Final = 40


def read_chosen_ways(
    file: OsmFile, options: ParseOptions, extra: frozenset[str], diagnostics: Diagnostics
) -> tuple[list[RawWay], list[RawWay], list[RawRelation], list[RawWay]]:
    """Read the ways that become streets, and what lies beside them.

    Parameters
    ----------
    file
        Where from.
    options
        Which ways are asked for.
    extra
        What is read beside streets only on request.
    diagnostics
        Gets the ways that are left out although cars might drive on them.

    Returns
    -------
    carried, beside, relations
        Ways that become streets, other ways that are of use, and relations; each in ascending id.
    asked
        Ways of the kinds that were asked for, those that are left out among them.
    """
    asked = options.ways.highways | _UNBUILT
    beside = ways_beside(asked, extra) if options.furniture else OtherWays({}, frozenset(), lambda _: False)
    others = OtherWays(
        beside.values,
        beside.keys | {"highway", "area"},
        lambda tags: _may_be_driven_on(tags) or beside.wanted(tags),
        frozenset({"highway"}),
    )
    read, relations = read_ways(file, asked, WAY_TAGS, others)
    found = [way for way in read if way.tags.get("highway") in asked]
    rest = [way for way in read if way.tags.get("highway") not in asked]
    carried = _carried(found, options, diagnostics)
    _tell_rest(rest, diagnostics)
    return carried, [way for way in rest if beside.wanted(way.tags)], relations, found


def _may_be_driven_on(tags: Mapping[str, str]) -> bool:
    """Say whether a way is to be told when it is left out; areas are none, whatever they are called."""
    return tags.get("highway", "no") not in _NOT_FOR_CARS and tags.get("area") != "yes"


def _carried(found: Sequence[RawWay], options: ParseOptions, diagnostics: Diagnostics) -> list[RawWay]:
    """Choose among the ways of the kinds that were asked for."""
    ways: list[RawWay] = []
    not_asked_for: dict[str, list[str]] = {}
    for way in found:
        name, highway = f"way/{way.id}", way.tags["highway"]
        if highway in _UNBUILT:
            diagnostics.dropped("not-built", name, f"highway={highway} is not there yet and is left out")
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
    _tell_counts(not_asked_for, diagnostics)
    return ways


def _tell_rest(rest: Sequence[RawWay], diagnostics: Diagnostics) -> None:
    """Say which other ways cars might drive on: kinds that can be asked for by number, all others one by one."""
    not_asked_for: dict[str, list[str]] = {}
    for way in rest:
        if not _may_be_driven_on(way.tags):
            continue
        highway = way.tags["highway"]
        if highway in HIGHWAYS:
            words = f"highway={highway} is not among the ways asked for"
            not_asked_for.setdefault(words, []).append(f"way/{way.id}")
        else:
            words = f"highway={_short(highway)} is no class of roads that can be carried, it is left out"
            diagnostics.dropped("highway-class", f"way/{way.id}", words)
    _tell_counts(not_asked_for, diagnostics)


def _tell_counts(not_asked_for: Mapping[str, Sequence[str]], diagnostics: Diagnostics) -> None:
    for words, ways in sorted(not_asked_for.items()):
        diagnostics.count(Kind.NOTE, "way-selection", ways, "way", f"left out: {words}")


def _short(value: str) -> str:
    """Return a tag's value fit for a sentence."""
    return value if len(value) <= _WORD_MAX else f"{value[: _WORD_MAX - 3]}..."


def tell_unused_nodes(node_tags: Mapping[int, Mapping[str, str]], diagnostics: Diagnostics) -> None:
    """Say which nodes of streets have something on the road that is not carried.

    Parameters
    ----------
    node_tags
        Tags of nodes on streets by id.
    diagnostics
        Gets one line for each.
    """
    for number, tags in node_tags.items():
        barrier, railway = tags.get("barrier", "no"), tags.get("railway", "")
        found = []
        if barrier not in _OPEN_BARRIERS:
            found.append(f"barrier={_short(barrier)} on the road is not carried, the street is open there")
        if railway in _TRACK_CROSSINGS:
            found.append(f"railway={railway} is not carried, the street is open there")
        if tags.get("highway") == "mini_roundabout":
            found.append("highway=mini_roundabout is taken as a plain junction")
        for words in found:
            diagnostics.dropped("street-node", f"node/{number}", words)


def nothing_to_drive_on(file: OsmFile, asked: Sequence[RawWay], options: ParseOptions) -> str:
    """Say why there is no street, in one sentence.

    Parameters
    ----------
    file
        That was read.
    asked
        Ways of the kinds that were asked for.
    options
        Which ways are asked for.
    """
    nodes, highways = count_contents(file)
    if not nodes and not highways:
        return f"{file.path} has no nodes and no ways; check the area that it covers"
    if not highways:
        return f"{file.path} has no ways with highway=*; export the area with its roads"
    reasons = Counter(
        reason[0] for way in asked if (reason := reason_left_out(way.tags, options.ways, options.include_private))
    )
    remedies = ["--ways all reads more kinds of ways"]
    if reasons["closed"] and not options.include_private:
        remedies.append(f"--include-private reads the {reasons['closed']} that are closed to cars")
    return (
        f"{file.path} has no way to drive on, all {highways} ways with highway=* are left out; {', '.join(remedies)}"
    )
