"""Rules of single readers of OpenDRIVE: what they need beyond the standard, or read in a way of their own."""

from __future__ import annotations

from functools import partial
from typing import Final

from osm2xodr.checking import defaults
from osm2xodr.checking.rules import rule
from osm2xodr.checking.rules.rule import Limit

_error = partial(rule.error, standard=False)
_warning = partial(rule.warning, standard=False)
_note = partial(rule.note, standard=False)

READER_RULES: Final = (
    # CARLA 0.9.16: text, negative ids and ids above 2^32 were tried.
    _error(
        "road-id-not-number",
        "The id of a road is not a whole number from 0 to 2147483647.",
        "the road's id {other} is not a whole number from 0 to 2147483647",
        "Number roads from 1.",
        "CARLA merges all such roads into one.",
        ("carla",),
    ),
    _error(
        "negative-road-id",
        "The id of a road is negative.",
        "the road's id {other} is negative",
        "Number roads from 1.",
        "netconvert loses connections.",
        ("sumo",),
    ),
    _error(
        "junction-id-not-number",
        "The id of a junction is not a whole number from 1 to 2147483647.",
        "junction {other}: the id is not a whole number from 1 to 2147483647",
        "Number junctions from 1, with small numbers.",
        "CARLA's topology is wrong with the id 0 (18 edges instead of 15) and loses edges with 3e9.",
        ("carla",),
    ),
    _error(
        "junction-id-of-road",
        "A junction and a road have the same id.",
        "junction {other}: a road has the same id",
        "Do not use a number for both a road and a junction.",
        "CARLA lost 6 of the 15 edges of its topology.",
        ("carla",),
    ),
    _warning(
        "no-georeference",
        "The file has no geoReference, or an empty one.",
        "there is no geoReference",
        "Write +proj=tmerc with +lat_0 and +lon_0 near the data.",
        "CARLA uses 42 N 2 E as the origin; netconvert has no projection, and rejects an empty one.",
        ("carla", "sumo"),
    ),
    _warning(
        "georeference-without-origin",
        "The geoReference has no +lat_0 and +lon_0.",
        "the geoReference has no +lat_0 and +lon_0",
        "Write +proj=tmerc with +lat_0 and +lon_0 near the data.",
        "CARLA uses 42 N 2 E as the origin.",
        ("carla",),
    ),
    _warning(
        "georeference-not-proj",
        "The geoReference is a code or WKT instead of a PROJ string.",
        "the geoReference is not a PROJ string",
        "Write +proj=….",
        "netconvert has no projection.",
        ("sumo",),
    ),
    _note(
        "georeference-words",
        "The geoReference has words that esmini does not know, or several lines.",
        "esmini logs an error about {other} in the geoReference",
        "Write it on one line, without +no_defs and +type.",
        "An error is logged that does no harm.",
        ("esmini",),
    ),
    _warning(
        "header-offset",
        "The header has an <offset>.",
        "the header's offset is {other}",
        "Write coordinates without an offset.",
        "esmini adds it to every coordinate, CARLA and libOpenDRIVE ignore it: they disagree on where roads lie.",
        ("carla", "esmini", "libopendrive"),
    ),
    _warning(
        "border-lanes",
        "A lane has a <border> instead of a width.",
        "the lane has a border instead of a width",
        "Write widths.",
        "CARLA, esmini and libOpenDRIVE give it the width 0.",
        ("carla", "esmini", "libopendrive"),
    ),
    _error(
        "user-data-in-geometry",
        "There is <userData> inside <geometry>.",
        "userData stands inside <geometry>",
        "Move it to the road.",
        "esmini loses the geometry.",
        ("esmini",),
    ),
    _error(
        "user-data-in-elevation",
        "There is <userData> inside <elevationProfile>.",
        "userData stands inside <elevationProfile>",
        "Move it to the road.",
        "esmini reads it as an elevation of 0.",
        ("esmini",),
    ),
    rule.error(
        "signal-off-road",
        "A signal or object stands before the start or after the end of its road.",
        "it stands {value} off the road",
        "Put it on the road.",
        "esmini crashes on a signal after the end.",
        ("esmini",),
        Limit(defaults.SAME_S, "m"),
    ),
    rule.error(
        "signal-not-dynamic",
        "A signal does not say whether it is dynamic.",
        "signal {other} has no attribute dynamic",
        "Write dynamic yes or no.",
        "netconvert writes no network; esmini reports an error.",
        ("esmini", "sumo"),
    ),
    _note(
        "superelevation-ignored",
        "Roads are banked.",
        "{other} with superelevation, this one most",
        "Expect the roads to be level across in CARLA.",
        "CARLA's waypoints ignore superelevation.",
        ("carla",),
    ),
    _note(
        "lane-height-ignored",
        "Lanes have heights.",
        "{other} with heights, this one first",
        "Expect the lanes to lie on the road in CARLA.",
        "CARLA's waypoints ignore the heights of lanes.",
        ("carla",),
    ),
    _note(
        "left-hand-ignored",
        "Traffic drives on the left.",
        "traffic drives on the left",
        "Run netconvert with --lefthand.",
        "netconvert and libOpenDRIVE's routing ignore the rule attribute.",
        ("sumo", "libopendrive"),
    ),
    _warning(
        "large-coordinates",
        "Coordinates are so large that single precision does not resolve 1 cm.",
        "coordinates reach {value}",
        "Put the origin near the data.",
        "CARLA was wrong by up to 0.57 m at 5.7e6 m.",
        ("carla",),
        # 2**17 m at a resolution of 2**-6 m; a round number below.
        Limit(1e5, "m", "24 bits of a float"),
    ),
    _warning(
        "outlines-unseen",
        "The <outline> of a crosswalk stands only inside <outlines>.",
        "the crosswalk's outline stands only inside <outlines>",
        "Write <outline> directly into the object if CARLA is to see it.",
        "CARLA sees no crosswalk.",
        ("carla",),
    ),
    _warning(
        "crosswalk-open",
        "The outline of a crosswalk does not end with its first corner.",
        "the outline of crosswalk {other} does not end with its first corner",
        "Repeat the first corner at the end.",
        "CARLA lists the corners of all crosswalks in one row; nothing else shows where one ends.",
        ("carla",),
    ),
    _warning(
        "signal-without-lanes",
        "Signals for one direction have no <validity>.",
        "{other} for one direction without <validity>, this one first",
        "Name the lanes that a signal is for.",
        "CARLA takes lanes above 0 for +, below 0 for -: those of the other direction where traffic drives right.",
        ("carla",),
    ),
    _note(
        "version-unread",
        "The version is not 1.4, 1.5 or 1.6.",
        "the version is {other}",
        "Write 1.6 or 1.4.",
        "The Driving Scenario Designer of MATLAB documents these versions only.",
        ("roadrunner",),
    ),
)
