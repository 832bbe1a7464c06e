"""The function ``batch``: here, because areas are converted by command lines, also on other machines."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from shlex import join
from typing import TYPE_CHECKING, Any, Final

import click

from osm2xodr.cli.batch_options import BatchArguments, plan, refuse_contradictions
from osm2xodr.cli.batches import run
from osm2xodr.errors import OptionError
from osm2xodr.python_api import ConvertOptions
from osm2xodr.system import parse_duration, parse_memory

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from osm2xodr.batching import Result
    from osm2xodr.python_api import AreaKeywords

    _Path = str | os.PathLike[str]

# Parameters that the command line calls otherwise.
_SPELLINGS: Final = {"from": "source"}


def batch(
    output: _Path,
    manifest: _Path | None = None,
    *,
    source: _Path | None = None,
    tiles: str | float | None = None,
    areas: _Path | None = None,
    dem: _Path | Iterable[_Path] = (),
    corrections: _Path | None = None,
    shared_frame: bool = False,
    surroundings: bool = False,
    workers: int | None = None,
    scheduler: str = "",
    max_memory: str | int | None = None,
    timeout: str | float | None = None,
    force: bool = False,
    on_end: Callable[[Result], None] | None = None,
    **options: Unpack[AreaKeywords],
) -> list[Result]:
    """Convert many areas: those that a manifest lists, or those cut out of one map.

    Called again, it only converts areas that failed, or whose map, elevation models, options or version have changed.

    Parameters
    ----------
    output
        Folder to write to, which ``docs/batch.md`` describes.
    manifest
        List of areas, TOML or CSV; or else give `source` with `tiles` or `areas`.
    source
        Map to cut areas out of.
    tiles
        Side of the squares that it is cut into, m, or text such as ``5km``.
    areas
        GeoJSON file whose polygons are cut out of it.
    dem
        Elevation models of areas that name none: files, patterns and folders, as in `convert`.
    corrections
        What you know better than OpenStreetMap, for all areas.
    shared_frame
        Give all areas the same projection, ids of their own, and roads that meet at the borders.
    surroundings
        Cut out buildings and water as well, for scenes.
    workers
        How many areas are converted at once; by default one per core.
    scheduler
        Address of a Dask scheduler whose workers convert them.
    max_memory
        Memory that an area may take, bytes, or text such as ``2G``.
    timeout
        Time that an area may take, s, or text such as ``10min``.
    force
        Make everything anew.
    on_end
        Is called with the result of each area that was converted as it ends.
    **options
        Options of `convert` for all areas: ``ways="major"`` and so on.

    Returns
    -------
    list of Result
        What became of each area, in their order: its `name`, `status` (``done``, ``unchanged``, ``empty``,
        ``failed``) and, in `message`, why it failed or is empty.

    Raises
    ------
    OptionError
        An option has a value that cannot be, or contradicts another one.
    InputError
        The list of areas or the map cannot be read.
    Osm2xodrError
        There is no Dask where a scheduler is named.
    OutputError
        The folder cannot be written.
    """
    models = (dem,) if isinstance(dem, (str, os.PathLike)) else dem
    try:
        arguments = BatchArguments(
            manifest=_path(manifest),
            source=_path(source),
            tiles=_parsed("tiles", tiles, _length),
            areas=_path(areas),
            dem=tuple(os.fspath(model) for model in models),
            output=Path(output),
            options=join(_words(ConvertOptions(**options), options)),
            corrections=_path(corrections),
            shared_frame=shared_frame,
            surroundings=surroundings,
            workers=workers,
            scheduler=scheduler,
            max_memory=_parsed("max_memory", max_memory, parse_memory),
            timeout=_parsed("timeout", timeout, parse_duration),
            force=force,
            dry_run=False,
            verbose=0,
            quiet=True,
        )
        refuse_contradictions(arguments)
        return run(arguments, plan(arguments), _Listener(on_end), frozenset())[0]
    except click.UsageError as error:
        raise OptionError(re.sub("--([a-z-]+)", _keyword, error.format_message())) from error


class _Listener:
    """Hands on the results of areas."""

    def __init__(self, on_end: Callable[[Result], None] | None) -> None:
        self._on_end = on_end

    def stage(self, name: str) -> None:
        """Take nothing."""

    def begin(self, areas: int) -> None:
        """Take nothing."""

    def settle(self, ended: int, failed: int) -> None:
        """Take nothing."""

    def convert(self, weights: Sequence[float]) -> None:
        """Take nothing."""

    def end(self, result: Result, weight: float) -> None:
        """Hand on a result."""
        if self._on_end is not None:
            self._on_end(result)


def _words(chosen: ConvertOptions, given: Iterable[str]) -> list[str]:
    """Return options as words of the command line, by their names."""
    words = []
    for name in given:
        value, option = getattr(chosen, name), f"--{name.replace('_', '-')}"
        if name in ("left_hand", "right_hand"):
            option = "--left-hand" if chosen.left_hand else "--right-hand"
            value = chosen.left_hand is not None
        if isinstance(value, bool):
            words += [option] if value else []
        elif value is not None:
            words.append(f"{option}={value}")
    return words


def _path(given: _Path | None) -> Path | None:
    return None if given is None else Path(given)


def _parsed(option: str, given: Any, parse: Callable[[str], Any]) -> Any:
    """Return a number, or what a text says."""
    if not isinstance(given, str):
        return given
    try:
        return parse(given)
    except ValueError as error:
        raise OptionError(f"{option}: {error}", option) from error


def _length(text: str) -> float:
    from osm2xodr.batching import parse_length

    return parse_length(text)


def _keyword(option: re.Match[str]) -> str:
    """Return an option of the command line by its name in Python."""
    return _SPELLINGS.get(option[1], option[1].replace("-", "_"))
