"""The report: one page of HTML to explore a road network, with the tables that it shows.

These are accuracy, coverage, findings, and the messages of the conversion.
"""

from __future__ import annotations

import base64
import dataclasses
import gzip
import json
import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from osm2xodr import __version__
from osm2xodr.curves import sorted_unique
from osm2xodr.defaults import GRADE_LIMIT, REPORT_FINDINGS
from osm2xodr.diagnostics import Diagnostics, counted
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import OpenDrive, frame_of, read_xodr
from osm2xodr.reporting import codes
from osm2xodr.system import advance, release_memory, stage, stream_to
from osm2xodr.viewing.colours import lane_types, make_modes, strip_classes
from osm2xodr.viewing.options import ReportOptions
from osm2xodr.viewing.page.accuracy import compare_with_osm, height_errors, read_ground, worst_stations
from osm2xodr.viewing.page.data import Subject, make_subject, on_structure, origin_of, page_arrays, page_info
from osm2xodr.viewing.page.things import bodies_of, pack_arrays, rounded
from osm2xodr.viewing.scene import make_scene, unmeasured_share
from osm2xodr.viewing.shell import filled, package_text, page_html

if TYPE_CHECKING:
    from osm2xodr.checking import CheckResult


_SCRIPTS = (
    "data.js",
    "route.js",
    "colours.js",
    "layers.js",
    "furniture.js",
    "tiles.js",
    "map.js",
    "profile.js",
    "details.js",
    "panel.js",
    "ground.js",
    "bodies.js",
    "view3d.js",
    "main.js",
)
_LICENCES = ("leaflet.LICENSE", "uplot.LICENSE", "three.LICENSE")
_THREE = {"core": "three.core.js", "module": "three.module.js", "controls": "three.orbit_controls.js"}
# Images of markers and controls that the page does not use.
_IMAGE = re.compile(r"url\((?!#)[^)]*\)")
_SOURCE_MAP = re.compile(r"^//# sourceMappingURL=.*$", re.MULTILINE)

# Roads that a table of the worst ones lists, and ways with gaps, at most; choices.
_MOST_ROADS: Final = 25
_MOST_GAPS: Final = 2000
# Least length without a road of a way that is listed as missing, m.
_LEAST_GAP: Final = 15.0
_OSM_ID = re.compile(r"(?:way|node|relation)/-?\d+")


def write_report(
    source: Path | OpenDrive,
    out: Path,
    options: ReportOptions,
    diagnostics: Diagnostics,
    result: CheckResult | None = None,
) -> int:
    """Write the report about a file of OpenDRIVE, one page of HTML, and return its size in bytes.

    Parameters
    ----------
    source
        The file, or what was read of it.
    out
        Where to; the file is there as a whole or not at all. ``-`` is standard output.
    options
        What the report contains.
    diagnostics
        Receives what was found about the elevation models.
    result
        What the check found, if the file was checked before.

    Raises
    ------
    InputError
        The file is not OpenDRIVE, the area or an elevation model cannot be read, or the file does not say where it
        lies although it is to be compared.
    CoverageError
        No elevation model has heights at the roads.
    OutputError
        The page cannot be written.
    """
    page = make_report(source, options, diagnostics, result)
    with stream_to(out) as stream:
        stream.write(page)
    return len(page)


def make_report(
    source: Path | OpenDrive, options: ReportOptions, diagnostics: Diagnostics, result: CheckResult | None = None
) -> bytes:
    """Return the report as HTML, UTF-8, for `write_report`; the same input gives the same bytes."""
    file = read_xodr(source) if isinstance(source, Path) else source
    if result is None and options.check:
        # Not every report needs the checks. What they take of memory is free again before the rest takes its own.
        from osm2xodr.checking import CheckOptions, check_drive

        result = check_drive(file, CheckOptions(most=REPORT_FINDINGS))
        release_memory()
    stage("making the page")
    subject = _subject(file, options, diagnostics)
    advance(0.5)
    modes = make_modes(file, subject.scene, lane_types(file, subject.scene), has_findings=result is not None)
    contents, arrays = pack_arrays(page_arrays(subject))
    rows, sentence = findings(subject, result)
    errors = accuracy(subject, [path.name for path in options.dem])
    cover = coverage(subject)
    headline = _headline(subject, options, diagnostics)
    headline["figures"] += verdict(errors, cover, result)
    info = {
        **headline,
        **page_info(subject, modes),
        "contents": contents,
        "findings": rows,
        "checked": sentence,
        "finding_count": 0 if result is None else sum(count.findings for count in result.counts),
        "accuracy": errors,
        "coverage": cover,
        "log": log(subject, options.log),
        "junction_nodes": junction_nodes(subject, options.log),
    }
    return _filled_page(info["title"], _as_json(info), arrays)


def _subject(file: OpenDrive, options: ReportOptions, diagnostics: Diagnostics) -> Subject:
    """Read everything that the report is about."""
    scene = make_scene(file)
    frame, reason = frame_of(file.header)
    terrain = cover = height = None
    if options.osm is not None or options.dem:
        if frame is None:
            raise InputError(
                f"{file.path}: {reason}; leave --osm and --dem out, or give a file that says where it lies"
            )
        if not len(scene.s):
            raise InputError(f"{file.path} has no road that can be drawn; there is nothing to compare")
    if options.dem and frame is not None:
        ground, terrain, height = read_ground(options, scene, frame, diagnostics)
        scene = dataclasses.replace(scene, ground=ground)
    if options.osm is not None and frame is not None:
        cover = compare_with_osm(options.osm, file, frame)
    bodies = bodies_of(file, options, height, frame, scene, origin_of(scene), diagnostics)
    return make_subject(file, scene, frame, terrain, cover, bodies)


def _headline(subject: Subject, options: ReportOptions, diagnostics: Diagnostics) -> dict[str, Any]:
    """Return headline, figures, facts about the file, and notes."""
    file, scene = subject.file, subject.scene
    header = file.header
    outside = file.roads.junction == -1
    length = np.where(np.isfinite(file.roads.length), file.roads.length, 0.0)
    name = header.attributes.get("name", "")
    revision = ".".join(str(part) for part in header.revision if part >= 0) or "of no stated version"
    figures = [
        ["roads", f"{int(outside.sum()):,}"],
        ["km of roads", f"{length[outside].sum() / 1000.0:,.2f}"],
        ["junctions", f"{len(file.junctions.id):,}"],
        ["connecting roads", f"{int((~outside).sum()):,}"],
        ["km through junctions", f"{length[~outside].sum() / 1000.0:,.2f}"],
        ["lanes drawn", f"{len(scene.lane):,}"],
    ]
    gap, share = unmeasured_share(file)
    if gap > 0.0:
        figures.append(["km without a measured height", f"{gap / 1000.0:,.2f}"])
    known = scene.z[np.isfinite(scene.z)]
    if len(known):
        figures += [["lowest", f"{known.min():,.1f} m"], ["highest", f"{known.max():,.1f} m"]]
    keys = [key for key in ("name", "vendor", "date", "version") if header.attributes.get(key)]
    about = [
        ["file", file.path.name],
        ["OpenDRIVE", revision],
        *([key, header.attributes[key]] for key in keys),
        ["geoReference", header.geo_reference or "none"],
        *([code, value] for (road, code), value in file.provenance.items() if road == -1),
        ["report by", f"osm2xodr {__version__}"],
    ]
    notes = []
    if undrawn := len(file.roads.id) - len(sorted_unique(scene.strip_road)):
        notes.append(
            f"Not drawn, for lack of a plan view, of lanes or of readable numbers: {counted(undrawn, 'road')}."
        )
    if file.misfits:
        places = counted(len(file.misfits), "place")
        notes.append(f"The reader could not read {places} of the file; osm2xodr check lists them.")
    if gap > 0.0:
        note = "no elevation model measured the height: hatched in the map, shaded in profiles"
        notes.append(f"On {gap / 1000.0:,.1f} km of roads ({max(100.0 * share, 0.1):.1f} %) {note}.")
    notes += [*subject.bodies.notes, *(item.message for item in diagnostics)]
    return {
        "title": options.title or name or file.path.name,
        "subtitle": f"{file.path.name} · OpenDRIVE {revision} · {length.sum() / 1000.0:,.1f} km",
        "figures": figures,
        "about": about,
        "notes": notes,
    }


def _filled_page(title: str, info: bytes, arrays: bytes) -> bytes:
    """Put texts, libraries and data into the page."""
    data = {"info": _compressed(info), "arrays": _compressed(arrays), "three": _three()}
    script = '(() => {\n"use strict";\n' + "\n".join(_text(f"template/{name}") for name in _SCRIPTS) + "\n})();\n"
    styles = (_IMAGE.sub("none", _text("vendor/leaflet.css")), _text("vendor/uplot.css"), _text("template/page.css"))
    return page_html(
        title,
        filled(_text("template/page.html"), data),
        "\n".join(styles),
        scripts=(_library("leaflet.js"), _library("uplot.js"), script),
        # The view in 3D unpacks its library into such an address.
        blob_scripts=True,
        licences=[_text(f"vendor/{name}") for name in _LICENCES],
    )


@cache
def _three() -> str:
    """Return the library of the view in 3D, compressed; it is the same on all pages."""
    return _compressed(_as_json({key: _library(name) for key, name in _THREE.items()}))


def _library(name: str) -> str:
    """Return the text of a library, without the address of its source map."""
    return _SOURCE_MAP.sub("", _text(f"vendor/{name}"))


def _text(path: str) -> str:
    return package_text("osm2xodr.viewing.page", path)


def _compressed(data: bytes) -> str:
    """Return bytes as base64 of gzip; the same bytes give the same text."""
    return base64.b64encode(gzip.compress(data, 6, mtime=0)).decode("ascii")


def _as_json(value: Any) -> bytes:
    """Return a value as JSON, UTF-8, with finite numbers only; lone surrogates become question marks."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode("utf-8", "replace")


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
