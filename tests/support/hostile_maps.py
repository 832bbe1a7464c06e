"""Small random OSM files: degenerate geometry, absurd tags, extreme places."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from typing import Final
from xml.sax.saxutils import quoteattr

from random_networks import random_network

# What any key may carry: lists, units, words of other countries, other scripts, markup, and sheer size.
# Stands for a value as long as is wanted; the reader of OSM refuses more than 1024 bytes.
LONG: Final = "long"
VALUES: Final = (
    *("", " ", "yes", "no", "none", "both", "left", "right", "forward", "backward", "-1", "0", "1", "2", "3", "12"),
    *("2;3", "1.5", "-2", "99999999999999999999", "1e9", "nan", "inf", "NaN", "0x10", "½", "٣", "三", "1,5", "+4"),
    *("RO:urban", "DE:zone30", "50 mph", "30 knots", "walk", "signals", "variable", "50;30", "none;none", "mph"),
    *("3'6\"", "10'", "3 m", "2.5 km", "'", '"', "-1;0", "1;-1;x", "layer", "|||", "left|through;right|none|", "|"),
    *("left;reverse;;", "through|" * 40, "lane", "track", "separate", "opposite_lane", "exclusive", "no|yes|", "up"),
    *("10%", "-8 %", "45°", "1:12", "traffic_signals", "crossing", "stop", "give_way", "all", "minor", "DE:274-30"),
    *("DE:274[50],DE:1020", "US:R1-1;US:R1-3P", "city_limit", "maxspeed", ",;,;", "FR:AB4", "parallel", "diagonal"),
    *(
        "right_of:1",
        "middle_of:-4",
        "left_of:99",
        "transition",
        "designated",
        "no @ (Mo-Fr 07:00-09:00)",
        "roundabout",
    ),
    *(
        "<script>alert(1)</script>",
        "&amp;",
        "]]>",
        "../../etc/passwd",
        "\u202e",
        "\u0000".replace("\u0000", "\ufffd"),
    ),
    *(LONG, "日本語の通り", "شارع", "🚗", "a\nb\tc", "%s%n{0}", "\\", "only_left", "not_right", "raised"),
)
KEYS: Final = (
    *("lanes", "lanes:forward", "lanes:backward", "lanes:both_ways", "lanes:psv", "turn:lanes", "turn:lanes:forward"),
    *("turn:lanes:backward", "turn", "change:lanes", "width", "width:lanes", "est_width", "maxspeed", "name", "ref"),
    *(
        "maxspeed:forward",
        "maxspeed:type",
        "source:maxspeed",
        "oneway",
        "oneway:bicycle",
        "junction",
        "layer",
        "bridge",
    ),
    *("bridge", "tunnel", "incline", "placement", "placement:forward", "access", "vehicle", "service", "ele"),
    *("cycleway", "cycleway:left", "cycleway:both", "cycleway:right:oneway", "busway", "sidewalk", "sidewalk:left"),
    *("sidewalk:both:width", "parking:lane:both", "parking:left", "parking:right:orientation", "shoulder", "kerb"),
    *(
        "shoulder:width",
        "verge",
        "overtaking",
        "lane_markings",
        "divider",
        "surface",
        "traffic_sign",
        "priority_road",
    ),
    *(
        "driving_side",
        "embedded_rails",
        "lit",
        "bicycle:lanes",
        "bus:lanes",
        "access:lanes",
        "motor_vehicle:backward",
    ),
)
NODE_KEYS: Final = (
    *("highway", "crossing", "crossing:island", "crossing:markings", "traffic_signals", "traffic_signals:direction"),
    *("direction", "stop", "traffic_sign", "traffic_sign:direction", "traffic_calming", "barrier", "maxspeed", "ele"),
    *("public_transport", "bus_bay", "kerb", "diameter", "railway", "name", "natural", "height"),
)
HIGHWAYS: Final = (
    *("motorway", "motorway_link", "trunk", "primary", "secondary", "tertiary", "unclassified", "residential"),
    *("service", "living_street", "footway", "cycleway", "path", "construction", "track", "steps", "nonsense"),
)
_NODE_HIGHWAYS: Final = (
    *("traffic_signals", "stop", "give_way", "crossing", "bus_stop", "turning_circle", "street_lamp"),
    *("mini_roundabout", "turning_loop", "motorway_junction"),
)
# What stands or runs beside streets.
_NODE_THINGS: Final = (
    *(("barrier", "bollard"), ("natural", "tree"), ("public_transport", "platform"), ("railway", "tram_stop")),
    *(("traffic_sign", "DE:274-30"), ("traffic_sign", "city_limit"), ("traffic_calming", "table")),
    *(("public_transport", "stop_position"), ("traffic_calming", "bump"), ("barrier", "lift_gate")),
)
_WAY_THINGS: Final = (
    *(("barrier", "guard_rail"), ("barrier", "kerb"), ("barrier", "wall"), ("railway", "tram")),
    *(("highway", "footway"), ("highway", "cycleway"), ("highway", "footway"), ("public_transport", "platform")),
)
_PLACES: Final = ((48.0, 11.0), (51.5, -0.1), (-33.9, 151.2), (0.0, 180.0), (64.1, -179.9999), (83.9, 10.0))
_RELATIONS: Final = ("no_left_turn", "only_straight_on", "no_u_turn", "no_entry", "nonsense", "")


def random_map(dice: random.Random, longest: int) -> str:
    """Return an OSM file of a few streets, with values of up to a number of characters."""
    lat, lon = dice.choice(_PLACES)
    spread = dice.choice([1e-7, 1e-5, 3e-4, 2e-3, 2e-2])
    count = dice.randint(2, 30)
    lines = ["<?xml version='1.0' encoding='UTF-8'?>", "<osm version='0.6'>"]
    places: list[tuple[float, float]] = []
    for number in range(1, count + 1):
        if places and dice.random() < 0.1:
            place = dice.choice(places)
        else:
            place = lat + dice.uniform(-spread, spread), _wrapped(lon + dice.uniform(-spread, spread))
        places.append(place)
        tags = _tags(dice, NODE_KEYS, 0.25)
        if dice.random() < 0.2:
            tags["highway"] = dice.choice(_NODE_HIGHWAYS)
        elif dice.random() < 0.1:
            tags.update([dice.choice(_NODE_THINGS)])
        lines.append(_element("node", f'id="{number}" lat="{place[0]:.9f}" lon="{place[1]:.9f}"', tags))
    ways = dice.randint(1, 12)
    for number in range(1, ways + 1):
        refs = [dice.randint(1, count + (dice.random() < 0.05)) for _ in range(dice.randint(0, 8))]
        if refs and dice.random() < 0.1:
            refs.append(refs[0])
        tags = {"highway": dice.choice(HIGHWAYS), **_tags(dice, KEYS, 0.7)}
        if dice.random() < 0.15:
            tags = {**_tags(dice, KEYS, 0.4), **dict([dice.choice(_WAY_THINGS)])}
        inner = "".join(f'<nd ref="{ref}"/>' for ref in refs)
        lines.append(_element("way", f'id="{number}"', tags, inner))
    for number in range(1, dice.randint(0, 3) + 1):
        members = "".join(
            f'<member type="{kind}" ref="{dice.randint(1, ways if kind == "way" else count)}" role="{role}"/>'
            for kind, role in (("way", "from"), (dice.choice(("node", "way")), "via"), ("way", "to"))
            if dice.random() < 0.9
        )
        tags = {"type": dice.choice(("restriction", "connectivity")), "restriction": dice.choice(_RELATIONS)}
        lines.append(_element("relation", f'id="{number}"', {**tags, "connectivity": dice.choice(VALUES)}, members))
    if dice.random() < 0.1:
        # Editors number what is new downwards from -1, some files have several versions of an element.
        lines = [re.sub(r'(id|ref)="(\d+)"', r'\1="-\2"', line) for line in lines]
    if dice.random() < 0.1:
        again = dice.choice(lines[2:])
        lines += [again.replace(' id="', f' version="{dice.randint(0, 3)}" id="', 1)]
    if dice.random() < 0.1:
        lines[2:] = dice.sample(lines[2:], len(lines) - 2)
    return _written_out(lines, longest)


def odd_network(dice: random.Random, longest: int) -> str:
    """Return an OSM file of streets that are laid out as such, with absurd tags on a few, and things beside them."""
    network = random_network(dice.getrandbits(32))
    nodes = {k: (x, y, {**tags, **_tags(dice, NODE_KEYS, 0.1)}) for k, (x, y, tags) in network.nodes.items()}
    ways = {
        k: (refs, tags if dice.random() < 0.6 else {**tags, **_tags(dice, KEYS, 1.0)})
        for k, (refs, tags) in network.ways.items()
    }
    for number, (refs, _) in enumerate(list(ways.values()), start=5001):
        if dice.random() < 0.5:
            # At about the width of a carriageway from the street, in OSM's steps.
            aside = dice.randint(200, 1200), dice.randint(200, 1200)
            beside = []
            for k, ref in enumerate(refs):
                x, y, _ = nodes[ref]
                tags = dict([dice.choice(_NODE_THINGS)]) if dice.random() < 0.4 else {}
                beside.append(100 * number + k)
                nodes[beside[-1]] = x + aside[0], y + aside[1], tags
            across = [beside[0], refs[0]] if dice.random() < 0.3 else []
            ways[number] = (*beside[::-1], *across[1:]), dict([dice.choice(_WAY_THINGS)])
    return _written_out(replace(network, nodes=nodes, ways=ways).osm().split("\n"), longest)


def _written_out(lines: list[str], longest: int) -> str:
    """Return the file, with the value that stands for a long one made as long as is wanted."""
    text = "\n".join(lines if lines[-1] == "</osm>" else [*lines, "</osm>"])
    return text.replace(f"'{LONG}'", "'" + "x" * longest + "'").replace(f'"{LONG}"', '"' + "x" * longest + '"')


def _wrapped(lon: float) -> float:
    return (lon + 180.0) % 360.0 - 180.0


def _tags(dice: random.Random, keys: tuple[str, ...], share: float) -> dict[str, str]:
    if dice.random() > share:
        return {}
    return {dice.choice(keys): dice.choice(VALUES) for _ in range(dice.randint(1, 6))}


def _element(kind: str, head: str, tags: dict[str, str], inner: str = "") -> str:
    text = "".join(f"<tag k={quoteattr(key)} v={quoteattr(value)}/>" for key, value in tags.items())
    return f"<{kind} {head}>{inner}{text}</{kind}>"
