"""The tables of the page: accuracy, coverage, findings, and the messages of the conversion."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from osm2xodr.defaults import GRADE_LIMIT
from osm2xodr.diagnostics import counted
from osm2xodr.model import FloatArray
from osm2xodr.reporting import codes
from osm2xodr.viewing.colours import strip_classes
from osm2xodr.viewing.page.accuracy import height_errors, worst_stations
from osm2xodr.viewing.page.data import Subject, on_structure, origin_of
from osm2xodr.viewing.page.packing import rounded

if TYPE_CHECKING:
    from osm2xodr.checking import CheckResult

# Roads that a table of the worst ones lists, and ways with gaps, at most; choices.
_MOST_ROADS: Final = 25
_MOST_GAPS: Final = 2000
# Least length without a road of a way that is listed as missing, m.
_LEAST_GAP: Final = 15.0
_OSM_ID = re.compile(r"(?:way|node|relation)/-?\d+")


def accuracy(subject: Subject, models: Sequence[str]) -> dict[str, Any] | None:
    """Return how far roads are above or below the elevation model; None if no height is known."""
    scene, file = subject.scene, subject.file
    if not np.isfinite(scene.ground).any():
        return None
    everything = np.ones(len(scene.s), np.bool_)
    outside = file.roads.junction[scene.station_road] == -1
    bridged = on_structure(subject)
    names, class_of = strip_classes(file, scene)
    station_class = class_of[scene.station_strip]
    groups = [("all roads", everything)]
    ground = ~bridged
    if bridged.any():
        groups += [("on the ground", ground), ("bridges and tunnels", bridged)]
        known = "bridges and tunnels are those that the file or OpenStreetMap names"
    else:
        known = "which roads are bridges or tunnels is unknown, so all roads count"
    groups += [("outside of junctions", ground & outside), ("in junctions", ground & ~outside)]
    groups += [(f"class {name}", ground & (station_class == k)) for k, name in enumerate(names)]
    error = scene.z - scene.ground
    worst = worst_stations(error, scene, ground, _MOST_ROADS)
    steep = worst_stations(scene.grade, scene, outside, _MOST_ROADS)
    roads = scene.station_road
    road_rms = {int(road): _rms(error[(roads == road) & ground & np.isfinite(error)]) for road in roads[worst]}
    return {
        "text": f"Height of the reference lines above the elevation model ({', '.join(models)}); {known}.",
        "rows": [
            [item.label, *map(rounded, (item.length / 1000.0, item.mean, item.rms, item.p95, item.largest))]
            for item in height_errors(scene, groups)
        ],
        "worst": [
            [int(roads[k]), rounded(scene.s[k], 1), rounded(error[k]), rounded(road_rms[int(roads[k])])]
            for k in worst
        ],
        "steep": [[int(roads[k]), rounded(scene.s[k], 1), rounded(scene.grade[k], 4)] for k in steep],
    }


def _rms(values: FloatArray) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")


def coverage(subject: Subject) -> dict[str, Any] | None:
    """Return how much of OSM's ways lies on carriageways, and which parts do not; None without an OSM file."""
    if subject.covers is None:
        return None
    x0, y0 = origin_of(subject.scene)
    # Length and covered length by class, m.
    classes: dict[str, list[float]] = {"all": [0.0, 0.0]}
    for item in subject.covers:
        for key in ("all", item.highway):
            row = classes.setdefault(key, [0.0, 0.0])
            row[0] += item.length
            row[1] += item.covered
    order = {name: k for k, name in enumerate(("all", *GRADE_LIMIT))}
    rows = sorted(classes.items(), key=lambda entry: (order.get(entry[0], len(order)), entry[0]))
    gaps = [item for item in subject.covers if item.length - item.covered > _LEAST_GAP]
    gaps.sort(key=lambda item: (item.covered - item.length, item.way))
    shown = gaps[:_MOST_GAPS]
    more = "" if len(shown) == len(gaps) else f" The first {len(shown):,} of {len(gaps):,} are listed."
    return {
        "text": "Ways that convert uses by default: for cars, open to the public, no driveways or parking aisles."
        " A way is covered where it lies on a lane of any kind, or within 1 m of one. Heights are not compared."
        + more,
        "least": _LEAST_GAP,
        "rows": [[name, rounded(all_ / 1000.0, 3), rounded(done / 1000.0, 3)] for name, (all_, done) in rows if all_],
        "missing": [
            [
                item.way,
                item.highway,
                item.name,
                rounded(item.length, 0),
                rounded(item.length - item.covered, 0),
                rounded(item.x - x0),
                rounded(item.y - y0),
            ]
            for item in shown
        ],
    }


def findings(subject: Subject, result: CheckResult | None) -> tuple[list[list[Any]], str | None]:
    """Return the findings as rows of severity, rule, road, lane, s, x, y and text, and a sentence about them."""
    if result is None:
        return [], None
    x0, y0 = origin_of(subject.scene)
    number = {name: k for k, name in reversed(list(enumerate(subject.file.roads.id)))}
    rows = []
    for item in result.findings:
        x = None if item.x is None else rounded(item.x - x0)
        y = None if item.y is None else rounded(item.y - y0)
        place = [None, None] if x is None or y is None else [x, y]
        road = number.get(item.road, -1) if item.road else -1
        rows.append([item.severity.word, item.rule, road, item.lane, rounded(item.s), *place, item.text])
    total = sum(item.findings for item in result.counts)
    sentence = f"osm2xodr check: {counted(total, 'finding')} of {counted(len(result.counts), 'kind')}"
    if total > len(rows):
        sentence += f", the worst {len(rows):,} are listed"
    return rows, ". ".join((sentence, *(note.rstrip(".") for note in result.notes))) + "."


def verdict(
    errors: Mapping[str, Any] | None, cover: Mapping[str, Any] | None, result: CheckResult | None
) -> list[list[str]]:
    """Return the figures that summarise the tables, as rows of label and value."""
    out = []
    if errors is not None:
        rows = {row[0]: row for row in errors["rows"]}
        label = "on the ground" if "on the ground" in rows else "all roads"
        out.append([f"rms off the elevation model, {label}", f"{rows[label][3]:,.2f} m"])
    if cover is not None and cover["rows"]:
        _, length, covered = cover["rows"][0]
        out.append(["of OSM's car ways covered", f"{100.0 * covered / length:.1f} %" if length else "none"])
    if result is not None:
        words = ("error", "warning")
        totals = [sum(item.findings for item in result.counts if item.severity.word == word) for word in words]
        out.append(["errors and warnings", " + ".join(f"{total:,}" for total in totals)])
    return out


def junction_nodes(subject: Subject, report: Mapping[str, Any] | None) -> list[list[str]]:
    """Return the OSM ids of the nodes of each junction, as far as the report of its conversion says them."""
    given = report.get("junction_nodes") if report is not None else None
    known = given if isinstance(given, Mapping) else {}
    return [re.findall(r"-?\d+", str(known.get(name, ""))) for name in subject.file.junctions.id]


def log(subject: Subject, report: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """Return what the conversion guessed, dropped and repaired, each with its place if that is known."""
    if report is None:
        return None
    x0, y0 = origin_of(subject.scene)
    places = {f"way/{item.way}": (rounded(item.x - x0), rounded(item.y - y0)) for item in subject.covers or ()}
    order = {"repaired": 0, "guessed": 1, "dropped": 2, "note": 3}
    items: list[tuple[str, str, str, str, float | None, float | None, str]] = []
    for entry in report.get("diagnostics", ()):
        if not isinstance(entry, Mapping):
            continue
        osm_id = str(entry.get("osm_id") or "")
        known = osm_id if _OSM_ID.fullmatch(osm_id) else ""
        kind, code, message = (str(entry.get(key, "")) for key in ("kind", "code", "message"))
        line = codes()[code].line_for(known) if code in codes() else ""
        items.append((kind, code, known, message, *places.get(osm_id, (None, None)), line))
    items.sort(key=lambda item: (order.get(item[0], len(order)), item[1]))
    made = report.get("input", {})
    area = PurePath(str(made.get("area", ""))).name if isinstance(made, Mapping) else ""
    source = f" of {area}" if area else ""
    return {"text": f"What osm2xodr guessed, dropped and repaired in its conversion{source}.", "items": items}
