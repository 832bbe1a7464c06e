"""Kinds of damage that are done to a sound OpenDRIVE file, one change each, and the rule that names it."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass

from lxml import etree
from t_junction import Tree, one, road

Change = Callable[[Tree], None]


@dataclass(frozen=True)
class Damage:
    """One change to the sound file.

    Parameters
    ----------
    name
        Of the change.
    rule
        What `check` must say; empty where all readers were seen to take no harm, so that nothing may be said that is
        worse than a note.
    change
        Does it.
    """

    name: str
    rule: str
    change: Change


DAMAGES: list[Damage] = []


def damage(name: str, rule: str) -> Callable[[Change], Change]:
    """Register a change."""

    def register(change: Change) -> Change:
        DAMAGES.append(Damage(name, rule, change))
        return change

    return register


def put(name: str, rule: str, path: str, **attributes: str | None) -> None:
    """Register a change of attributes; None removes one."""

    def change(tree: Tree) -> None:
        element = one(tree, path)
        for key, value in attributes.items():
            key = key.rstrip("_")
            if value is None:
                del element.attrib[key]
            else:
                element.set(key, value)

    DAMAGES.append(Damage(name, rule, change))


def drop(name: str, rule: str, path: str, *, every: bool = False) -> None:
    """Register the removal of an element, or of all at a path."""

    def change(tree: Tree) -> None:
        for element in tree.findall(path) if every else [one(tree, path)]:
            parent = element.getparent()
            assert parent is not None
            parent.remove(element)

    DAMAGES.append(Damage(name, rule, change))


def add(name: str, rule: str, path: str, text: str, at: int | None = None) -> None:
    """Register a new element inside of another, last or at a place."""

    def change(tree: Tree) -> None:
        parent = one(tree, path)
        parent.insert(len(parent) if at is None else at, etree.fromstring(text))

    DAMAGES.append(Damage(name, rule, change))


def georeference(name: str, rule: str, text: str | None) -> None:
    """Register another geoReference; None leaves it out."""

    def change(tree: Tree) -> None:
        element = one(tree, "header/geoReference")
        if text is None:
            one(tree, "header").remove(element)
        else:
            element.text = etree.CDATA(text) if text else text

    DAMAGES.append(Damage(name, rule, change))


def replaced(tree: Tree, path: str, *texts: str) -> None:
    """Put elements in place of one."""
    element = one(tree, path)
    parent = element.getparent()
    assert parent is not None
    at = parent.index(element)
    parent.remove(element)
    for k, text in enumerate(texts):
        parent.insert(at + k, etree.fromstring(text))


def swap(name: str, rule: str, path: str, *texts: str) -> None:
    """Register other elements in place of one."""
    DAMAGES.append(Damage(name, rule, lambda tree: replaced(tree, path, *texts)))


def rename_road(tree: Tree, number: str, name: str) -> None:
    """Give a road another id, and name it so wherever it is named."""
    road(tree, int(number)).set("id", name)
    for element in tree.iter("predecessor", "successor"):
        if element.get("elementType") == "road" and element.get("elementId") == number:
            element.set("elementId", name)
    for element in tree.iter("connection"):
        for key in ("incomingRoad", "connectingRoad"):
            if element.get(key) == number:
                element.set(key, name)
    for element in tree.iter("priority"):
        for key in ("high", "low"):
            if element.get(key) == number:
                element.set(key, name)


def rename_junction(tree: Tree, name: str) -> None:
    """Give the junction another id, and name it so wherever it is named."""
    one(tree, "junction").set("id", name)
    for element in tree.iter("road"):
        if element.get("junction") == "100":
            element.set("junction", name)
    for element in tree.iter("predecessor", "successor"):
        if element.get("elementType") == "junction":
            element.set("elementId", name)


# ---------------------------------------------------------------- header

_TMERC = "+proj=tmerc +lat_0=49 +lon_0=11 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m"
_WKT = 'PROJCS["x",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]]]]'
georeference("no geoReference", "no-georeference", None)
georeference("empty geoReference", "no-georeference", "")
georeference("UTM", "georeference-without-origin", "+proj=utm +zone=32 +datum=WGS84 +units=m")
georeference("EPSG code", "georeference-not-proj", "EPSG:32632")
georeference("WKT", "georeference-not-proj", _WKT)
georeference("no_defs", "georeference-words", f"{_TMERC} +no_defs")
georeference("type=crs", "georeference-words", f"{_TMERC} +type=crs")
georeference("line breaks in the CDATA", "georeference-words", f"\n{_TMERC}\n")
add("header offset in x and y", "header-offset", "header", '<offset x="100" y="50" z="0" hdg="0"/>')
add("header offset in z", "header-offset", "header", '<offset x="0" y="0" z="30" hdg="0"/>')
add("header offset in heading", "header-offset", "header", '<offset x="0" y="0" z="0" hdg="0.5"/>')
drop("no header", "unreadable", "header")
put("version without a schema", "", "header", revMinor="9")


@damage("default namespace", "namespace")
def _namespace(tree: Tree) -> None:
    tree.set("xmlns", "http://code.asam.net/simulation/standard/opendrive_schema")


# ---------------------------------------------------------------- what may be missing

drop("no elevation profiles", "link-grade-step-not", "road/elevationProfile", every=True)
drop("no lateral profiles", "", "road/lateralProfile", every=True)
drop("no lane offsets", "", "road/lanes/laneOffset", every=True)
drop("no road types", "", "road/type", every=True)
drop("no road marks", "", ".//roadMark", every=True)
drop("no objects", "", "road/objects", every=True)
DAMAGES[-6:] = [Damage(d.name, "" if "-not" in d.rule else d.rule, d.change) for d in DAMAGES[-6:]]

# ---------------------------------------------------------------- records that begin late

put("first elevation at s > 0", "late-elevation", "road[@id='2']/elevationProfile/elevation", s="5")
put("first width at sOffset > 0", "late-width", "road[@id='2']/lanes/laneSection/right/lane/width", sOffset="2")
put("first lane offset at s > 0", "late-record", "road[@id='2']/lanes/laneOffset", s="5")
put("first superelevation at s > 0", "late-record", "road[@id='2']/lateralProfile/superelevation", s="5")
put("first lane section at s > 0", "section-order", "road[@id='3']/lanes/laneSection", s="5")
put("first geometry at s > 0", "record-s", "road[@id='2']/planView/geometry", s="5")

# ---------------------------------------------------------------- roads without what they need

drop("no centre lane", "no-centre-lane", "road[@id='3']/lanes/laneSection/center")
drop("no lane section", "no-lane-section", "road[@id='3']/lanes/laneSection")
drop("no lanes", "no-lane-section", "road[@id='3']/lanes")
drop("no plan view", "no-plan-view", "road[@id='3']/planView")
drop("empty plan view", "no-plan-view", "road[@id='3']/planView/geometry")
drop("geometry without a shape", "unknown-shape", "road[@id='3']/planView/geometry/line")


@damage("road of length 0", "zero-length")
def _no_length(tree: Tree) -> None:
    for element in (road(tree, 4), one(tree, "road[@id='4']/planView/geometry")):
        element.set("length", "0")


@damage("connecting road of length 0", "zero-length")
def _no_connecting_length(tree: Tree) -> None:
    for element in (road(tree, 10), one(tree, "road[@id='10']/planView/geometry")):
        element.set("length", "0")


@damage("record of length 0", "zero-length")
def _no_record(tree: Tree) -> None:
    plan = one(tree, "road[@id='1']/planView")
    element = copy.deepcopy(plan[1])
    element.set("length", "0")
    plan.insert(1, element)


@damage("record of 5 mm", "short-record")
def _short_record(tree: Tree) -> None:
    first, second = one(tree, "road[@id='1']/planView")
    for element, values in ((first, ("29.995", None, None)), (second, ("20.005", "29.995", "-30.005"))):
        for key, value in zip(("length", "s", "x"), values, strict=True):
            if value is not None:
                element.set(key, value)
    extra = copy.deepcopy(second)
    extra.set("length", "0.005")
    one(tree, "road[@id='1']/planView").insert(1, extra)
    second.set("s", "30")
    second.set("x", "-30")
    second.set("length", "20")


# ---------------------------------------------------------------- lanes

_RIGHT = "road[@id='3']/lanes/laneSection/right/lane"
_LEFT = "road[@id='3']/lanes/laneSection/left/lane"
put("hole in the lane ids on the right", "lane-id-hole", _RIGHT, id="-2")
put("hole in the lane ids on the left", "lane-id-hole", _LEFT, id="2")
put("lane id used twice", "duplicate-lane-id", "road[@id='3']/lanes/laneSection/left/lane", id="-1")
put("lane id that is no number", "not-a-number", _RIGHT, id="first")
_INNER = "road[@id='2']/lanes/laneSection/right/lane/link/"
put("lane successor that does not exist", "lane-link", f"{_INNER}successor", id="-7")
put(
    "lane predecessor that does not exist",
    "lane-link",
    "road[@id='4']/lanes/laneSection/right/lane/link/predecessor",
    id="-7",
)
put(
    "successor of a connecting road's lane that does not exist",
    "lane-link",
    "road[@id='10']/lanes/laneSection/right/lane/link/successor",
    id="-7",
)
put(
    "lane linked against traffic",
    "lane-link-other-way",
    "road[@id='10']/lanes/laneSection/right/lane/link/successor",
    id="1",
)
drop("lane without a successor", "lane-ends", "road[@id='10']/lanes/laneSection/right/lane/link/successor")
drop("lane without a width", "lane-without-width", f"{_RIGHT}/width")
swap(
    "border in place of width", "border-lanes", f"{_RIGHT}/width", '<border sOffset="0" a="-3.5" b="0" c="0" d="0"/>'
)
put("negative width", "negative-width", f"{_RIGHT}/width", b="-0.1")
put(
    "width that steps at a section", "section-gap", "road[@id='2']/lanes/laneSection[@s='25']/right/lane/width", a="3"
)
swap(
    "width that steps within a section",
    "width-step",
    f"{_RIGHT}/width",
    '<width sOffset="0" a="3" b="0" c="0" d="0"/>',
    '<width sOffset="20" a="3.5" b="0" c="0" d="0"/>',
)
put("width that steps at a link", "lane-edge-gap", "road[@id='4']/lanes/laneSection/right/lane/width", a="3.2")
put("lane beside its successor", "lane-gap", "road[@id='4']/lanes/laneOffset", a="0.3")
swap(
    "lane offset that steps",
    "lane-offset-step",
    "road[@id='3']/lanes/laneOffset",
    '<laneOffset s="0" a="0.5" b="0" c="0" d="0"/>',
    '<laneOffset s="20" a="0" b="0" c="0" d="0"/>',
)
swap(
    "widths out of order",
    "record-order",
    f"{_RIGHT}/width",
    '<width sOffset="20" a="3.5" b="0" c="0" d="0"/>',
    '<width sOffset="0" a="3.5" b="0" c="0" d="0"/>',
)
put("lane speed without a unit", "", _RIGHT)
add("lane height", "lane-height-ignored", _RIGHT, '<height sOffset="0" inner="0.12" outer="0.12"/>')
DAMAGES[-2] = Damage(
    "lane speed without a unit",
    "",
    lambda tree: one(tree, _RIGHT).append(etree.fromstring('<speed sOffset="0" max="13"/>')),
)


@damage("two lane sections 5 mm before the end", "")
def _late_section(tree: Tree) -> None:
    lanes = one(tree, "road[@id='3']/lanes")
    section = copy.deepcopy(one(tree, "road[@id='3']/lanes/laneSection"))
    section.set("s", "49.995")
    for before, after in zip(
        one(tree, "road[@id='3']/lanes/laneSection").iter("lane"), section.iter("lane"), strict=True
    ):
        if before.get("id") != "0":
            one(before, "link").append(etree.fromstring(f'<successor id="{before.get("id")}"/>'))
            one(after, "link").append(etree.fromstring(f'<predecessor id="{before.get("id")}"/>'))
    lanes.append(section)


@damage("lane sections in one place", "section-order")
def _twice(tree: Tree) -> None:
    lanes = one(tree, "road[@id='3']/lanes")
    lanes.append(copy.deepcopy(lanes[-1]))


put("lane section behind the road's end", "section-order", "road[@id='2']/lanes/laneSection[@s='25']", s="75")


@damage("lane sections out of order", "record-order")
def _sections_out_of_order(tree: Tree) -> None:
    lanes = one(tree, "road[@id='2']/lanes")
    lanes.append(lanes[1])


# ---------------------------------------------------------------- junctions

_CONNECTION = "junction/connection"
put("no connectingRoad", "connecting-road", _CONNECTION, connectingRoad=None)
put("connectingRoad that is not there", "connecting-road", _CONNECTION, connectingRoad="77")
put("no incomingRoad", "incoming-road", _CONNECTION, incomingRoad=None)
put("incomingRoad that is not there", "incoming-road", _CONNECTION, incomingRoad="77")
put("incomingRoad that does not end there", "incoming-elsewhere", _CONNECTION, incomingRoad="4")
put("connectingRoad of no junction", "connecting-elsewhere", "road[@id='10']", junction="-1")
put("road of a junction that is not there", "road-junction", "road[@id='10']", junction="101")
put("connection without id", "connection-without-id", _CONNECTION, id=None)
put("connection id used twice", "duplicate-connection-id", _CONNECTION, id="3")
put("connection without contactPoint", "no-contact-point", _CONNECTION, contactPoint=None)
put("connection with the wrong contactPoint", "wrong-contact-point", _CONNECTION, contactPoint="end")
drop("laneLink missing", "connection-without-lanes", f"{_CONNECTION}/laneLink")
put("laneLink from a lane that is not there", "connection-lane", f"{_CONNECTION}/laneLink", from_="-5")
put("laneLink to a lane that is not there", "connection-lane", f"{_CONNECTION}/laneLink", to="-5")
drop("junction without connections", "junction-empty", _CONNECTION, every=True)
drop("no junction", "junction-link", "junction")
drop("connecting road that leads nowhere", "open-connecting-road", "road[@id='10']/link/successor")
put("priority of a road that is not there", "priority-road", "junction/priority", high="77")
put("junction's controller that is not there", "junction-controller", "junction/controller", id="77")
drop("controller that no junction names", "controller-apart", "junction/controller")
put("controller's signal that is not there", "controller-signal", "controller/control", signalId="77")


@damage("lane without a way on", "dead-lane")
def _dead_lane(tree: Tree) -> None:
    junction = one(tree, "junction")
    for element in junction.findall("connection[@incomingRoad='3']"):
        junction.remove(element)


@damage("lane without a way in", "unfed-lane")
def _unfed_lane(tree: Tree) -> None:
    junction = one(tree, "junction")
    for number in ("12", "15"):
        junction.remove(one(tree, f"junction/connection[@connectingRoad='{number}']"))
        tree.remove(road(tree, int(number)))


# ---------------------------------------------------------------- ids

for _name, _id, _rule in (
    ("road id that is a text", "north", "road-id-not-number"),
    ("negative road id", "-4", "negative-road-id"),
    ("road id above 2^32", "5000000000", "road-id-not-number"),
):
    DAMAGES.append(Damage(_name, _rule, lambda tree, name=_id: rename_road(tree, "4", name)))  # type: ignore[misc]
for _name, _id, _rule in (
    ("junction id that is a text", "cross", "junction-id-not-number"),
    ("junction id 0", "0", "junction-id-not-number"),
    ("junction id 3e9", "3000000000", "junction-id-not-number"),
    ("junction id of a road", "2", "junction-id-of-road"),
):
    DAMAGES.append(Damage(_name, _rule, lambda tree, name=_id: rename_junction(tree, name)))  # type: ignore[misc]
put("road id used twice", "duplicate-road-id", "road[@id='4']", id="3")
put("road without id", "unreadable", "road[@id='4']", id=None)


@damage("junction id used twice", "duplicate-junction-id")
def _junction_twice(tree: Tree) -> None:
    tree.append(copy.deepcopy(one(tree, "junction")))


@damage("controller id used twice", "duplicate-controller-id")
def _controller_twice(tree: Tree) -> None:
    element = one(tree, "controller")
    element.addnext(copy.deepcopy(element))


@damage("signal id used twice", "duplicate-signal-id")
def _signal_twice(tree: Tree) -> None:
    element = one(tree, ".//signal")
    element.addnext(copy.deepcopy(element))


@damage("object id used twice", "duplicate-object-id")
def _object_twice(tree: Tree) -> None:
    element = one(tree, ".//object")
    element.addnext(copy.deepcopy(element))


@damage("signal of two controllers", "signal-of-two-controllers")
def _controlled_twice(tree: Tree) -> None:
    element = one(tree, "controller")
    other = copy.deepcopy(element)
    other.set("id", "801")
    element.addnext(other)


# ---------------------------------------------------------------- links of roads

_LINK = "road[@id='2']/link/successor"
put("successor that is not there", "road-link", _LINK, elementId="77")
put("junction that is not there", "junction-link", "road[@id='2']/link/predecessor", elementId="77")
put("link that is not returned", "link-not-returned", "road[@id='4']/link/predecessor", elementId="3")
drop("link without a return", "link-not-returned", "road[@id='4']/link/predecessor")
put("link without contactPoint", "no-contact-point", _LINK, contactPoint=None)
put("link with the wrong contactPoint", "wrong-contact-point", _LINK, contactPoint="end")
put("link of an unknown kind", "unreadable", _LINK, elementType="lane")
put(
    "connecting road that comes from elsewhere",
    "connection-without-link",
    "road[@id='10']/link/predecessor",
    elementId="3",
)

# ---------------------------------------------------------------- signals and objects

put("signal behind the road's end", "signal-off-road", ".//signal", s="55")
put("signal before the road's start", "signal-off-road", ".//signal", s="-3")
put("signal without dynamic", "signal-not-dynamic", ".//signal", dynamic=None)
put("signal for lanes that are not there", "signal-lane", ".//validity", toLane="-4")
add(
    "reference to a signal that is not there",
    "signal-reference",
    ".//signals",
    '<signalReference id="77" s="10" t="0" orientation="+"/>',
)
put("object behind the road's end", "signal-off-road", ".//object", s="55")


@damage("controller that lets ways that cross go", "conflicting-phase")
def _green_at_once(tree: Tree) -> None:
    signals = copy.deepcopy(one(tree, "road[@id='1']/signals"))
    one(signals, "signal").set("id", "902")
    road(tree, 3).append(signals)
    controller = one(tree, "controller")
    controller.append(copy.deepcopy(one(controller, "control")))
    controller[-1].set("signalId", "902")


drop("signal without lanes", "signal-without-lanes", ".//validity")
drop("crosswalk without an end", "crosswalk-open", ".//cornerLocal[last()]")


@damage("an outline and outlines", "")
def _both_outlines(tree: Tree) -> None:
    outline = one(tree, ".//outline")
    outlines = etree.Element("outlines")
    outlines.append(copy.deepcopy(outline))
    outline.addnext(outlines)


@damage("outlines", "outlines-unseen")
def _outlines(tree: Tree) -> None:
    outline = one(tree, ".//outline")
    parent = outline.getparent()
    assert parent is not None
    outlines = etree.SubElement(parent, "outlines")
    outlines.append(outline)


# ---------------------------------------------------------------- what is one's own, in the wrong place

_OWN = '<userData code="x" value="y"/>'
add("userData inside of geometry", "user-data-in-geometry", "road[@id='3']/planView/geometry", _OWN)
add("userData inside of elevationProfile", "user-data-in-elevation", "road[@id='3']/elevationProfile", _OWN)
add("userData inside of a road", "", "road[@id='3']", _OWN)
add("unknown element", "misplaced", "road[@id='3']", "<bump/>", at=1)
add("second plan view", "misplaced", "road[@id='3']", "<planView/>", at=3)
add("elements in the wrong order", "schema", "road[@id='3']", '<type s="0" type="town"/>', at=5)

# ---------------------------------------------------------------- numbers

put("nan in x", "not-a-number", "road[@id='3']/planView/geometry", x="nan")
put("nan in hdg", "not-a-number", "road[@id='3']/planView/geometry", hdg="nan")
put("inf in an elevation", "not-a-number", "road[@id='3']/elevationProfile/elevation", b="inf")
put("nan in a width", "not-a-number", f"{_RIGHT}/width", a="nan")
put("nan in a length", "not-a-number", "road[@id='3']", length="nan")
put("attribute that is missing", "unreadable", "road[@id='3']/planView/geometry", hdg=None)
put("comma in a number", "not-a-number", "road[@id='3']/elevationProfile/elevation", a="10,5")
put("speed without a limit", "", "road[@id='3']/type/speed", max="no limit")


@damage("coordinates of UTM", "large-coordinates")
def _far(tree: Tree) -> None:
    for element in tree.iter("geometry"):
        element.set("x", repr(float(element.attrib["x"]) + 500000.0))
        element.set("y", repr(float(element.attrib["y"]) + 5700000.0))


@damage("traffic on the left", "left-hand-ignored")
def _left_hand(tree: Tree) -> None:
    for element in tree.iter("road"):
        element.set("rule", "LHT")


@damage("lane ids negated for SUMO", "left-hand-negated")
def _negated(tree: Tree) -> None:
    _left_hand(tree)
    etree.SubElement(one(tree, "header"), "userData", code="lanes", value="negated")


# ---------------------------------------------------------------- plan view

put("wrong length of a road", "road-length", "road[@id='3']", length="50.5")
put("wrong length of a record", "road-length", "road[@id='3']/planView/geometry", length="49.5")
put("gap between records", "record-gap", "road[@id='1']/planView/geometry[@s='30.0']", y="0.5")
put("kink between records", "record-kink", "road[@id='1']/planView/geometry[@s='30.0']", hdg="0.1")
put("hole in s", "record-s", "road[@id='1']/planView/geometry[@s='30.0']", s="31")


@damage("geometries out of order", "record-order")
def _plan_out_of_order(tree: Tree) -> None:
    plan = next(item for item in tree.iter("planView") if len(item) > 1)
    plan.append(plan[0])


_CURVE = '<paramPoly3 aU="0" bU="{b}" cU="0" dU="0" aV="0" bV="{v}" cV="0" dV="0" pRange="{p}"/>'
_SHAPE = "road[@id='3']/planView/geometry/line"
swap(
    "normalized paramPoly3 that is longer than stated",
    "record-length",
    _SHAPE,
    _CURVE.format(b=50.5, v=0, p="normalized"),
)
swap(
    "normalized paramPoly3 that is shorter than stated",
    "record-length",
    _SHAPE,
    _CURVE.format(b=49.5, v=0, p="normalized"),
)
swap("paramPoly3 by length that runs too fast", "record-length", _SHAPE, _CURVE.format(b=1.01, v=0, p="arcLength"))
swap("paramPoly3 aside of its heading", "start-tangent", _SHAPE, _CURVE.format(b=0.8, v=0.6, p="arcLength"))
swap("sound paramPoly3", "", _SHAPE, _CURVE.format(b=50, v=0, p="normalized"))
swap("sound spiral", "", _SHAPE, '<spiral curvStart="0" curvEnd="0"/>')
swap("curve tighter than its lanes", "folded-lane", _SHAPE, '<arc curvature="0.5"/>')
swap("curve that no car takes", "tight-curve", "road[@id='4']/planView/geometry/line", '<arc curvature="0.24"/>')


@damage("road beside its neighbour", "lane-gap")
def _aside(tree: Tree) -> None:
    one(tree, "road[@id='4']/planView/geometry").set("y", "0.4")


@damage("road that leads off at an angle", "link-kink")
def _at_an_angle(tree: Tree) -> None:
    one(tree, "road[@id='4']/planView/geometry").set("hdg", "0.1")


# ---------------------------------------------------------------- heights

_HEIGHT = "road[@id='1']/elevationProfile/elevation[@s='25']"
put("step of height", "height-step", _HEIGHT, a="11.5")
put("step of grade", "grade-step", _HEIGHT, b="-0.1")
put("step of height where roads meet", "lane-height-step", "road[@id='4']/elevationProfile/elevation", a="10.3")
put("step of grade where roads meet", "link-grade-step", "road[@id='4']/elevationProfile/elevation", b="0.1")
put("step of height at a junction", "lane-height-step", "road[@id='10']/elevationProfile/elevation", a="10.3")
put("connecting roads at two heights", "junction-surface", "road[@id='10']/elevationProfile/elevation", a="10.3")
put("wall", "grade-excess", "road[@id='4']/elevationProfile/elevation", b="1.5")
put("hill", "grade-steep", "road[@id='4']/elevationProfile/elevation", c="0.003")
put("bank", "superelevation-ignored", "road[@id='4']/lateralProfile/superelevation", a="0.02")
swap(
    "step of the bank",
    "superelevation-step",
    "road[@id='4']/lateralProfile/superelevation",
    '<superelevation s="0" a="0" b="0" c="0" d="0"/>',
    '<superelevation s="20" a="0.1" b="0" c="0" d="0"/>',
)


@damage("elevations out of order", "record-order")
def _elevations_out_of_order(tree: Tree) -> None:
    profile = one(tree, "road[@id='1']/elevationProfile")
    profile.append(profile[0])


@damage("road that lies on another", "overlap")
def _overlap(tree: Tree) -> None:
    geometry = one(tree, "road[@id='4']/planView/geometry")
    for key, value in (("x", "-60"), ("y", "2")):
        geometry.set(key, value)


def add_bridge(tree: Tree, height: float, x: float = 40.0) -> None:
    """Add road 5, which crosses at x, m, so high above a level of 10 m, m."""
    bridge = copy.deepcopy(road(tree, 3))
    bridge.set("id", "5")
    bridge.remove(one(bridge, "link"))
    one(bridge, "planView/geometry").set("x", str(x))
    one(bridge, "planView/geometry").set("y", "-25")
    one(bridge, "elevationProfile/elevation").set("a", str(10.0 + height))
    tree.insert(5, bridge)


@damage("road that crosses 5 m above another", "")
def _bridge(tree: Tree) -> None:
    add_bridge(tree, 5.0)


@damage("road that crosses 3 m above another", "clearance")
def _low_bridge(tree: Tree) -> None:
    add_bridge(tree, 3.0)


@damage("street that ends where only one-way streets come in", "dead-end-junction")
def _dead_end(tree: Tree) -> None:
    # Nothing leads out but road 1: roads 2 and 3 lose their lanes away from the junction.
    junction = one(tree, "junction")
    for number in ("10", "12", "13", "15"):
        junction.remove(one(tree, f"junction/connection[@connectingRoad='{number}']"))
        tree.remove(road(tree, int(number)))
    tree.remove(road(tree, 4))
    one(tree, "road[@id='2']/link").remove(one(tree, "road[@id='2']/link/successor"))
    for path in ("road[@id='2']/lanes/laneSection", "road[@id='3']/lanes/laneSection"):
        for section in tree.findall(path):
            side = one(section, "right" if "2" in path else "left")
            section.remove(side)
