"""The page that compares ways to find heights on a user's elevation models: one file of HTML that needs no other."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from osm2xodr import __version__, defaults
from osm2xodr.model import FloatArray
from osm2xodr.surface import DemComparison, MethodResult, SurfaceComparison
from osm2xodr.viewing.shell import facts, package_text, page_html
from osm2xodr.viewing.surface_pictures import bars, error_map, error_ramp, image, land_ramp, relief, scale_bar

# Colours reach to this percentile of the errors, so that a few large ones do not pale all others.
_SHOWN = 99.0


def surface_page(comparison: SurfaceComparison) -> bytes:
    """Return the page, HTML in UTF-8."""
    box = comparison.box_deg
    where = (
        "all of each file" if box is None else "west, south, east, north {:g}, {:g}, {:g}, {:g} degrees".format(*box)
    )
    body = (
        "<h1>How well heights are found in elevation models</h1>\n"
        f'<p class="note">osm2xodr {escape(__version__)}; examined: {escape(where)}.</p>\n'
        "<p>Interpolations are given every other row and column, and are asked for the cells between; the error is "
        "the answer less the height of the cell. Cells are twice as far apart as they are for a road, so roads see "
        "smaller errors, but the same order of methods. A model's own noise is part of every error: the method that "
        "follows noise least is not always the one that follows the ground best. Polynomials are compared with the "
        "heights that they are fitted to: what they miss is terrain that a trend does not have.</p>\n"
        + "".join(_model(model) for model in comparison.models)
    )
    return page_html("Elevation models compared", body, package_text("osm2xodr.viewing", "template/surface.css"))


def _model(model: DemComparison) -> str:
    """Return the section of one elevation model."""
    grid = model.grid
    shown = int(np.argmax([np.isfinite(patch.z).sum() for patch in grid.patches]))
    z = grid.patches[shown].z.astype(np.float64)
    known = z[np.isfinite(z)]
    note = ""
    if len(grid.patches) > 1:
        rows, cols = z.shape
        note = (
            f'<p class="note">{len(grid.patches)} patches of {cols} x {rows} cells were examined, evenly spread; '
            "the pictures show one of them, the figures are for all.</p>\n"
        )
    ramp = land_ramp(float(known.min()), float(known.max()))
    ground = image(relief(z, grid.steps, ramp), grid.steps, "Heights")
    interpolations = _methods("Method", "Errors", grid.interpolations, shown, grid.steps, _verdict(model))
    polynomials = _methods("Degree", "Trend less heights", grid.polynomials, shown, grid.steps)
    return (
        f"<h2>{escape(str(model.path))}</h2>\n{_facts(model)}{note}"
        f"<figure>{ground}<figcaption>Heights {scale_bar(ramp)}</figcaption></figure>\n"
        f"<h3>Interpolations</h3>\n{interpolations}<h3>Polynomials of degree 2 to 5</h3>\n{polynomials}"
    )


def _methods(
    heading: str,
    title: str,
    results: Sequence[MethodResult],
    shown: int,
    steps: tuple[float, float],
    verdict: str = "",
) -> str:
    """Return table, bars, verdict and maps of some methods."""
    prefix = "degree " if heading == "Degree" else ""
    chart = bars([f"{prefix}{result.name}" for result in results], [result.rms for result in results], "m")
    text = f"<p>{verdict}</p>\n" if verdict else ""
    return f"{_table(heading, results)}{chart}\n{text}{_maps(results, shown, steps, title)}"


def _facts(model: DemComparison) -> str:
    """Return the facts about the elevation model."""
    across, along = model.grid.steps
    voids = f"{100.0 * model.voids / max(model.cells, 1):.3g} % of {model.cells:,}"
    if model.outliers:
        voids += f", {model.outliers:,} of them heights that are not the ground"
    lengths = f"({across:.3g} m across, {along:.3g} m along)"
    rows = (
        ("Format", f"{model.driver}, {model.dtype}, heights in {model.unit}"),
        ("Reference system", model.crs),
        ("Cells", f"{model.size[0]:,} x {model.size[1]:,} of {model.cell_size:.3g} m {lengths}"),
        ("Voids", voids),
        ("Standard error of heights, estimated", f"{model.sigma:.2g} m"),
        ("Taken for", "a surface model (canopy and roofs)" if model.covered else "a terrain model (the ground)"),
    )
    return f"{facts(rows)}\n"


def _table(title: str, results: Sequence[MethodResult]) -> str:
    """Return the figures of some methods."""
    best = min((result.rms for result in results), default=0.0)
    rows = "".join(
        f"<tr{' class=best' if result.rms == best else ''}><td>{escape(result.name)}</td><td>{result.rms:.3f}</td>"
        f"<td>{result.p95:.3f}</td><td>{result.maximum:.2f}</td><td>{result.bias:+.3f}</td>"
        f"<td>{100.0 * result.grade_rms:.2f}</td><td>{result.seconds:.3f}</td><td>{result.count:,}</td></tr>"
        for result in results
    )
    heads = ("rms, m", "95 %, m", "largest, m", "mean, m", "grade rms, %", "time, s", "cells")
    head = f"<th>{title}</th>" + "".join(f"<th>{name}</th>" for name in heads)
    return f"<table><tr>{head}</tr>{rows}</table>\n"


def _verdict(model: DemComparison) -> str:
    """Return a sentence on which method is best."""
    best = min(model.grid.interpolations, key=lambda result: result.rms)
    usual = next(result for result in model.grid.interpolations if result.name == defaults.SURFACE_METHOD)
    if not best.count:
        return "There is nothing to compare: no cell lies between others that have a height."
    if usual.rms <= best.rms:
        return f"On these heights {usual.name}, which convert uses by default, has the smallest error."
    share = 100.0 * (1.0 - best.rms / usual.rms)
    return (
        f"On these heights {best.name} has the smallest error, {share:.0f} % below that of {usual.name}, which "
        f"convert uses by default; <code>--surface {best.name}</code> chooses it."
    )


def _maps(results: Sequence[MethodResult], shown: int, steps: tuple[float, float], title: str) -> str:
    """Return pictures of the errors of some methods, all in the same colours."""
    errors: list[FloatArray] = [result.errors[shown] for result in results]
    sizes = [np.abs(error[np.isfinite(error)]) for error in errors]
    limits = sorted(float(np.percentile(size, _SHOWN)) for size in sizes if len(size))
    # The worst method may be off the scale, so that the others can be distinguished.
    ramp = error_ramp(max([1e-3, *limits[-2:][:1]]))
    figures = "".join(
        f"<figure>{image(error_map(error, ramp), steps, f'{title}, {result.name}')}"
        f"<figcaption>{escape(result.name)}</figcaption></figure>"
        for result, error in zip(results, errors, strict=True)
    )
    return f'<p>{escape(title)} {scale_bar(ramp)}</p>\n<div class="pictures">{figures}</div>\n'
