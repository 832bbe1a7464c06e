"""The report: one page of HTML to explore a road network."""

from __future__ import annotations

import base64
import dataclasses
import gzip
import json
import re
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from osm2xodr import __version__
from osm2xodr.curves import sorted_unique
from osm2xodr.defaults import REPORT_FINDINGS
from osm2xodr.diagnostics import Diagnostics, counted
from osm2xodr.errors import InputError
from osm2xodr.opendrive import OpenDrive, frame_of, read_xodr
from osm2xodr.system import advance, release_memory, stage, stream_to
from osm2xodr.viewing.colours import lane_types, make_modes
from osm2xodr.viewing.options import ReportOptions
from osm2xodr.viewing.page import tables
from osm2xodr.viewing.page.accuracy import compare_with_osm, read_ground
from osm2xodr.viewing.page.data import Subject, make_subject, origin_of, page_arrays, page_info
from osm2xodr.viewing.page.packing import pack_arrays
from osm2xodr.viewing.page.things import bodies_of
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
    rows, sentence = tables.findings(subject, result)
    errors = tables.accuracy(subject, [path.name for path in options.dem])
    cover = tables.coverage(subject)
    headline = _headline(subject, options, diagnostics)
    headline["figures"] += tables.verdict(errors, cover, result)
    info = {
        **headline,
        **page_info(subject, modes),
        "contents": contents,
        "findings": rows,
        "checked": sentence,
        "finding_count": 0 if result is None else sum(count.findings for count in result.counts),
        "accuracy": errors,
        "coverage": cover,
        "log": tables.log(subject, options.log),
        "junction_nodes": tables.junction_nodes(subject, options.log),
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
