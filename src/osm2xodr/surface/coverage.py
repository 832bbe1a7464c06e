"""How much of the roads elevation models measure, and where they do not."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import CoverageError
from osm2xodr.model import FloatArray
from osm2xodr.surface.dem_surface import Bounds
from osm2xodr.surface.options import SurfaceOptions

# Least share of the roads that elevation models must cover unless the user allows less: guesses should not outweigh
# measurements. A choice.
_COVERAGE_MIN: Final = 0.5
# Number of files that a message names before "and n more".
_FILES_NAMED: Final = 3


def judge_coverage(
    paths: Sequence[Path],
    options: SurfaceOptions,
    coverage: float,
    length: float,
    places: tuple[FloatArray, FloatArray],
    diagnostics: Diagnostics,
) -> None:
    """Report what elevation models do not measure of the roads, and fail if that is too much.

    `coverage` is the share of the roads that is measured, `length`, m, that of the rest, and `places` are longitudes
    and latitudes (n,) of its ends, degrees.

    Raises
    ------
    CoverageError
        Less is measured than the options ask for.
    """
    names = names_of(paths)
    if not len(places[0]):
        return
    if options.coverage_least is not None:
        if coverage < options.coverage_least:
            wanted = f"and --fail-below-coverage asks for {100.0 * options.coverage_least:g} %"
            remedy = "give elevation models that cover the roads"
            raise CoverageError(f"{names}: {_only(coverage)}, {wanted}; {remedy}")
    elif coverage < _COVERAGE_MIN and not options.allow_partial:
        remedy = "give elevation models that cover the roads, or allow the rest to be guessed with --allow-partial"
        raise CoverageError(f"{names}: {_only(coverage)}; {remedy}")
    lon, lat = places
    box = box_text((float(lon.min()), float(lat.min()), float(lon.max()), float(lat.max())))
    share = f"{_percent(1.0 - coverage)} of the roads ({length / 1e3:,.1f} km, {box})"
    diagnostics.guessed("dem-gap", "", f"{names}: {share} have no measured height; it was filled in.")


def _only(coverage: float) -> str:
    return f"only {_percent(coverage)} of the roads have a measured height"


def names_of(paths: Sequence[Path]) -> str:
    """Name files in a sentence, the first few of many."""
    more = f" and {len(paths) - _FILES_NAMED} more" if len(paths) > _FILES_NAMED else ""
    return ", ".join(str(path) for path in paths[:_FILES_NAMED]) + more


def box_text(box: Bounds) -> str:
    """Format a box for a message."""
    west, south, east, north = box
    return f"{west:.4f} to {east:.4f} E, {south:.4f} to {north:.4f} N"


def _percent(share: float) -> str:
    """Format a share with enough digits not to be rounded to nothing or everything."""
    percent = 100.0 * share
    return f"{percent:{'.2g' if percent < 1.0 else '.0f' if percent <= 99.0 else '.2f'}} %"
