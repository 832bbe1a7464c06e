"""The page's tables: accuracy, coverage, findings, and what the converter said."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from osm2xodr.defaults import GRADE_LIMIT
from osm2xodr.viewing.modes import strip_classes
from osm2xodr.viewing.page.data import Subject, on_structure, origin_of, rounded
from osm2xodr.viewing.page.ground import height_errors, worst_stations

if TYPE_CHECKING:
    from osm2xodr.checking import CheckResult

# Roads that a table of the worst ones lists, and ways with gaps, at most; choices.
_MOST_ROADS: Final = 25
_MOST_GAPS: Final = 2000
# Least length without a road of a way that is listed as missing, m.
_LEAST_GAP: Final = 15.0
_OSM_ID = re.compile(r"(?:way|node|relation)/-?\d+")


def accuracy(subject: Subject, models: Sequence[str]) -> dict[str, Any] | None:
    """Return how far roads are off the elevation model; None where nothing is measured."""
    scene, file = subject.scene, subject.file
    if not np.isfinite(scene.ground).any():
        return None
    everything = np.ones(len(scene.s), np.bool_)
    outside = file.roads.junction[scene.station_road] == -1
    bridged = on_structure(subject)
    names, class_of = strip_classes(file, scene)
    station_class = class_of[scene.station_strip]
    groups = [("all roads", everything)]
    ground = everything
    text = "Height of the reference lines above the elevation model"
    if bridged.any():
        ground = ~bridged
        groups += [("on the ground", ground), ("bridges and tunnels", bridged)]
        text += "; bridges and tunnels are told as far as the file or OpenStreetMap names them"
    else:
        text += "; which roads are bridges or tunnels is unknown, so all count"
    groups += [("outside of junctions", ground & outside), ("in junctions", ground & ~outside)]
    groups += [(f"class {name}", ground & (station_class == k)) for k, name in enumerate(names)]
    error = scene.z - scene.ground
    worst = worst_stations(error, scene, ground, _MOST_ROADS)
    steep = worst_stations(scene.grade, scene, outside, _MOST_ROADS)
    roads = scene.station_road
    square = {int(road): _rms(error[(roads == road) & ground & np.isfinite(error)]) for road in roads[worst]}
    return {
        "text": f"{text}. Elevation model: {', '.join(models)}.",
        "rows": [
            [item.label, rounded(item.length / 1000.0), *(rounded(value) for value in _figures(item))]
            for item in height_errors(scene, groups)
        ],
        "worst": [
            [int(roads[k]), rounded(scene.s[k], 1), rounded(error[k]), rounded(square[int(roads[k])])] for k in worst
        ],
        "steep": [[int(roads[k]), rounded(scene.s[k], 1), rounded(scene.grade[k], 4)] for k in steep],
    }


def _figures(item: Any) -> tuple[float, ...]:
    """Return the figures of a row of errors."""
    return item.mean, item.rms, item.p95, item.largest


def _rms(values: Any) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")


def coverage(subject: Subject) -> dict[str, Any] | None:
    """Return how much of OSM's ways lies on carriageways, and what does not; None without a file of OSM."""
    if subject.covers is None:
        return None
    x0, y0 = origin_of(subject.scene)
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
        "text": "Ways that convert takes by default: for cars, open to the public, no driveways or parking aisles. A"
        " way is covered where it lies on a lane of any kind, or within 1 m of one; heights and lanes do not count."
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
    rows = [
        [
            item.severity.word,
            item.rule,
            number.get(item.road, -1) if item.road else -1,
            item.lane,
            rounded(item.s),
            None if item.x is None else rounded(item.x - x0),
            None if item.y is None else rounded(item.y - y0),
            item.text,
        ]
        for item in result.findings
    ]
    for row in rows:
        if row[5] is None or row[6] is None:
            row[5] = row[6] = None
    counted = sum(item.findings for item in result.counts)
    sentence = f"osm2xodr check: {counted:,} findings of {len(result.counts):,} kinds"
    if counted > len(rows):
        sentence += f", the worst {len(rows):,} are listed"
    return rows, ". ".join((sentence, *(note.rstrip(".") for note in result.notes))) + "."


def verdict(
    errors: Mapping[str, Any] | None, cover: Mapping[str, Any] | None, result: CheckResult | None
) -> list[list[str]]:
    """Return the figures that sum up the tables, as rows of label and value."""
    out = []
    if errors is not None:
        rows = {row[0]: row for row in errors["rows"]}
        label = "on the ground" if "on the ground" in rows else "all roads"
        out.append([f"rms off the elevation model, {label}", f"{rows[label][3]:,.2f} m"])
    if cover is not None and cover["rows"]:
        _, length, covered = cover["rows"][0]
        out.append(["of OSM's car ways covered", f"{100.0 * covered / length:.1f} %" if length else "none"])
    if result is not None:
        by_word = {
            word: sum(item.findings for item in result.counts if item.severity.word == word)
            for word in ("error", "warning")
        }
        out.append(["errors and warnings", " + ".join(f"{count:,}" for count in by_word.values())])
    return out


def log(subject: Subject, report: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """Return what the converter guessed, dropped and repaired, with places where the way is known to lie."""
    if report is None:
        return None
    x0, y0 = origin_of(subject.scene)
    places = {f"way/{item.way}": (rounded(item.x - x0), rounded(item.y - y0)) for item in subject.covers or ()}
    order = {"repaired": 0, "guessed": 1, "dropped": 2, "note": 3}
    items: list[tuple[str, str, str, str, float | None, float | None]] = []
    for entry in report.get("diagnostics", ()):
        if not isinstance(entry, Mapping):
            continue
        osm_id = str(entry.get("osm_id") or "")
        x, y = places.get(osm_id, (None, None))
        known = osm_id if _OSM_ID.fullmatch(osm_id) else ""
        items.append(
            (str(entry.get("kind", "")), str(entry.get("code", "")), known, str(entry.get("message", "")), x, y)
        )
    items.sort(key=lambda item: (order.get(item[0], len(order)), item[1]))
    made = report.get("input", {})
    area = PurePath(str(made.get("area", ""))).name if isinstance(made, Mapping) else ""
    source = f" of {area}" if area else ""
    return {"text": f"What osm2xodr guessed, dropped and repaired in its conversion{source}.", "items": items}
