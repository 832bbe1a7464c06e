"""The page that compares ways to find heights on a user's elevation models: one file of HTML that needs no other."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from osm2xodr import __version__, defaults
from osm2xodr.model import FloatArray
from osm2xodr.surface import DemComparison, MethodResult, SurfaceComparison
from osm2xodr.viewing.surface_pictures import ERROR, LAND, bars, error_map, image, relief, scale_bar

_STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 1040px; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.5em; } h2 { font-size: 1.25em; margin-top: 2em; } h3 { font-size: 1.05em; margin-top: 1.6em; }
table { border-collapse: collapse; margin: .6em 0; }
th, td { padding: .2em .9em .2em 0; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child { text-align: left; } th { font-weight: 600; }
tr.best td { font-weight: 600; }
dl { display: grid; grid-template-columns: max-content auto; gap: .1em 1em; margin: .6em 0; }
dt { color: #666; } dd { margin: 0; }
.pictures { display: flex; flex-wrap: wrap; gap: 1em; } figure { margin: 0; } figcaption { font-size: .9em; }
img { image-rendering: pixelated; display: block; max-width: 100%; height: auto; }
svg text { font: 12px system-ui, sans-serif; fill: #222; } .bar { fill: #5b86b8; } .note { color: #555; }
"""
# Colours reach to this percentile of the errors, so that a few large ones do not pale all others.
_SHOWN = 99.0


def surface_page(comparison: SurfaceComparison) -> str:
    """Return the page, HTML; all that comes from files is escaped."""
    models = "".join(_model(model) for model in comparison.models)
    box = comparison.box_deg
    where = (
        "all of each file" if box is None else "west, south, east, north {:g}, {:g}, {:g}, {:g} degrees".format(*box)
    )
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>Elevation models compared</title>'
        f"<style>{_STYLE}</style></head><body>\n<h1>How well heights are found in elevation models</h1>\n"
        f'<p class="note">osm2xodr {escape(__version__)}; looked at: {escape(where)}.</p>\n'
        "<p>Interpolations are told every other row and column and asked for the cells between; the error is what "
        "they answer less what the cell says. Cells are twice as far apart as they are for a road, so that roads see "
        "smaller errors, but the same order of methods. A model's own noise is part of every error: the method that "
        "follows noise least is not always the one that follows the ground best. Polynomials are held against the "
        "heights that they are fitted to: what they miss is terrain that a trend does not have.</p>\n"
        f"{models}</body></html>\n"
    )


def _model(model: DemComparison) -> str:
    """Return the section of one elevation model."""
    grid = model.grid
    shown = int(np.argmax([np.isfinite(patch.z).sum() for patch in grid.patches]))
    z = grid.patches[shown].z.astype(np.float64)
    known = z[np.isfinite(z)]
    low, high = float(known.min()), float(known.max())
    note = ""
    if len(grid.patches) > 1:
        rows, cols = z.shape
        note = (
            f'<p class="note">{len(grid.patches)} patches of {cols} x {rows} cells were looked at, evenly spread; '
            "the pictures show one of them, the figures are those of all.</p>\n"
        )
    ground = image(relief(z, grid.steps, low, high), grid.steps, "Heights")
    return (
        f"<h2>{escape(str(model.path))}</h2>\n{_facts(model)}{note}"
        f"<figure>{ground}<figcaption>Heights {scale_bar(LAND, low, high, 'm')}</figcaption></figure>\n"
        f"<h3>Interpolations</h3>\n{_table('Method', grid.interpolations)}"
        f"{bars([result.name for result in grid.interpolations], [r.rms for r in grid.interpolations], 'm')}\n"
        f"<p>{_verdict(model)}</p>\n"
        f"{_maps(grid.interpolations, shown, grid.steps, 'Errors')}"
        f"<h3>Polynomials of degree 2 to 5</h3>\n{_table('Degree', grid.polynomials)}"
        f"{bars([f'degree {result.name}' for result in grid.polynomials], [r.rms for r in grid.polynomials], 'm')}\n"
        f"{_maps(grid.polynomials, shown, grid.steps, 'Trend less heights')}"
    )


def _facts(model: DemComparison) -> str:
    """Return what the elevation model is."""
    cols, rows = model.size
    voids = f"{100.0 * model.voids / max(model.cells, 1):.3g} % of {model.cells:,}"
    if model.outliers:
        voids += f", {model.outliers:,} of them heights that are no ground"
    facts = (
        ("Format", f"{model.driver}, {model.dtype}, heights in {model.unit}"),
        ("Reference system", model.crs),
        ("Cells", f"{cols:,} x {rows:,} of {model.cell_size:.3g} m ({_steps(model.grid.steps)})"),
        ("Voids", voids),
        ("Standard error of heights, estimated", f"{model.sigma:.2g} m"),
        ("Taken for", "a surface model (canopy and roofs)" if model.covered else "a terrain model (the ground)"),
    )
    return "<dl>" + "".join(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in facts) + "</dl>\n"


def _steps(steps: tuple[float, float]) -> str:
    """Return the lengths of a column and a row in words."""
    return f"{steps[0]:.3g} m across, {steps[1]:.3g} m along"


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
    """Return what the figures come to."""
    best = min(model.grid.interpolations, key=lambda result: result.rms)
    usual = next(result for result in model.grid.interpolations if result.name == defaults.SURFACE_METHOD)
    if not best.count:
        return "There is nothing to compare: no cell lies between others that have a height."
    if usual.rms <= best.rms:
        return f"On these heights {usual.name}, which convert uses unless told otherwise, has the smallest error."
    share = 100.0 * (1.0 - best.rms / usual.rms)
    return (
        f"On these heights {best.name} has the smallest error, {share:.0f} % below that of {usual.name}, which "
        f"convert uses unless told otherwise; <code>--surface {best.name}</code> chooses it."
    )


def _maps(results: Sequence[MethodResult], shown: int, steps: tuple[float, float], title: str) -> str:
    """Return pictures of the errors of some methods, all in the same colours."""
    errors: list[FloatArray] = [result.errors[shown] for result in results]
    sizes = [np.abs(error[np.isfinite(error)]) for error in errors]
    limits = sorted(float(np.percentile(size, _SHOWN)) for size in sizes if len(size))
    # The worst method may be off the scale, so that the others are told apart.
    limit = max([1e-3, *limits[-2:][:1]])
    figures = "".join(
        f"<figure>{image(error_map(error, limit), steps, escape(f'{title}, {result.name}'))}"
        f"<figcaption>{escape(result.name)}</figcaption></figure>"
        for result, error in zip(results, errors, strict=True)
    )
    return f'<p>{escape(title)} {scale_bar(ERROR, -limit, limit, "m")}</p>\n<div class="pictures">{figures}</div>\n'
