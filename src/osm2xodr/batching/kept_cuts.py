"""What batches keep from one start to the next: cuts of maps, and what each area was made of.

Reading and cutting a country takes many minutes. A cut is used again as long as the map, what is cut out of it and
the version are the same; a record beside each says so, which is written when the cut is complete. An area whose
fingerprint has not changed is left alone.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from osm2xodr import __version__
from osm2xodr.batching.areas import Block, PlannedArea
from osm2xodr.batching.model import CutRequest
from osm2xodr.batching.out_dir import OutDir
from osm2xodr.model import Corrections, Outline
from osm2xodr.osmParsing import DRIVABLE, WaySelection, parse_ways_option
from osm2xodr.system import parse_json, record, stream_to

# Version of the layout of records; one of another version counts as none.
_FORMAT: Final = 2

# Version of the layout of states; a file of another version counts as no state.
_FINGERPRINT_FORMAT: Final = 1


@record
class _Record:
    """What a cut is, and what it was made of."""

    source: str  # SHA-256 of the map
    how: str  # As `KeptCuts.how` returns it
    ways: dict[str, int]  # Number of ways that become streets in each of its areas; without any there is no file
    # Of the file: bytes, and time of change, ns since 1970
    size: int = 0
    mtime_ns: int = 0
    version: str = __version__  # Of osm2xodr


class KeptCuts:
    """The cuts of a batch."""

    def __init__(
        self, out: OutDir, corrections: Corrections, planned: Sequence[PlannedArea], *, context: bool, scenes: bool
    ) -> None:
        self._out = out
        self._blocks: dict[str, list[PlannedArea]] = {}  # The areas of each block, by its name
        for item in planned:
            if item.block is not None:
                self._blocks.setdefault(item.block.name, []).append(item)
        self._kept = corrections.kept_ways()  # OSM ids of ways that become streets in any case
        self._context = context
        self._scenes = scenes  # Whether cuts have what scenes show

    def names(self, block: Block) -> list[str]:
        """Return the names of the areas of a block."""
        return [item.area.name for item in self._blocks[block.name]]

    def clear(self, names: Sequence[str]) -> None:
        """Remove all cuts that are not of areas of these names."""
        kept = set(names)
        for path in (*self._out.cuts.glob("*.osm.pbf"), *self._out.cuts.glob("*.json")):
            if path.name.removesuffix(".osm.pbf").removesuffix(".json") not in kept:
                remove(path)

    def make(
        self, source: Path, mark: Mark, areas: Sequence[PlannedArea], out_of: Path | None = None
    ) -> dict[str, int]:
        """Cut out what is not there yet, and return the number of ways in each area that become streets.

        `mark` is that of the map; `out_of` is a cut of it that has all of the areas, if there is one. Raises as
        `cut_areas`.
        """
        from osm2xodr.batching.cutting import cut_areas

        counts: dict[str, int] = {}
        missing: dict[str, CutRequest] = {}
        how: dict[str, str] = {}
        for name, group in self._groups(areas).items():
            known = self._known(name, group, mark)
            if known is None:
                missing[name], how[name] = self._request(name, group), self.how(group[0])
            else:
                counts.update(known)
        if missing:

            def keep(made: Mapping[str, int]) -> None:
                for name, request in missing.items():
                    inside = request.parts or (name,)
                    if all(part in made for part in inside):
                        self._record(name, _Record(mark.sha256, how[name], {part: made[part] for part in inside}))

            # A record must not outlive the file that it is of.
            remove(*(self._path(name) for name in missing))
            counts.update(cut_areas(out_of or source, list(missing.values()), keep))
        return {item.area.name: counts[item.area.name] for item in areas}

    def _groups(self, areas: Sequence[PlannedArea]) -> dict[str, list[PlannedArea]]:
        """Return areas by the name of the cut that they are in: their block's, with all of it, or their own."""
        found: dict[str, list[PlannedArea]] = {}
        for item in areas:
            name = cut_name(item)
            if name not in found:
                found[name] = [item] if item.block is None else self._blocks[name]
        return found

    def how(self, item: PlannedArea) -> str:
        """Return the SHA-256 of all that says how an area is cut out of its map."""
        assert item.frame is not None
        ways, private = _chosen_ways(item.area.options)
        chosen = [sorted(ways.highways), sorted(ways.services_out), private, sorted(self._kept)]
        rings = [ring.tolist() for ring in _outline(item).rings]
        text = json.dumps([item.frame.proj, rings, self._context, self._scenes, chosen])
        return hashlib.sha256(text.encode()).hexdigest()

    def _request(self, name: str, group: Sequence[PlannedArea]) -> CutRequest:
        """Return what is cut out for an area, or for all areas of a block."""
        item = group[0]
        assert item.frame is not None
        ways, private = _chosen_ways(item.area.options)
        parts = {one.area.name: one.outline for one in group if one.outline is not None} if item.block else {}
        return CutRequest(
            name,
            self._out.cut(name),
            item.frame,
            _outline(item),
            self._context,
            ways,
            private,
            self._kept,
            item.area.where,
            parts,
            self._scenes,
            "--allow-partial" in item.area.options,
        )

    def _known(self, name: str, group: Sequence[PlannedArea], mark: Mark) -> dict[str, int] | None:
        """Return the number of ways that become streets in each area of a cut that is there; None if it is not."""
        try:
            data = parse_json(self._path(name).read_bytes())
            if data.pop("format") != _FORMAT:
                return None
            record = _Record(**data)
            wanted = _Record(
                mark.sha256, self.how(group[0]), {item.area.name: int(record.ways[item.area.name]) for item in group}
            )
            return dict(wanted.ways) if record == self._measured(name, wanted) else None
        except (OSError, ValueError, LookupError, TypeError, AttributeError):
            return None

    def _record(self, name: str, record: _Record) -> None:
        text = json.dumps({"format": _FORMAT, **dataclasses.asdict(self._measured(name, record))})
        with stream_to(self._path(name)) as stream:
            stream.write(text.encode("ascii") + b"\n")

    def _measured(self, name: str, record: _Record) -> _Record:
        """Return a record with the size and time of its file."""
        if not any(record.ways.values()):
            return record
        found = self._out.cut(name).stat()
        return dataclasses.replace(record, size=found.st_size, mtime_ns=found.st_mtime_ns)

    def _path(self, name: str) -> Path:
        return self._out.cuts / f"{name}.json"


def cut_name(item: PlannedArea) -> str:
    """Return the name of the cut that an area is converted from: that of its block, if it is made with one."""
    return item.area.name if item.block is None else item.block.name


def _outline(item: PlannedArea) -> Outline:
    """Return what is cut out."""
    outline = item.outline if item.block is None else item.block.outline
    assert outline is not None
    return outline


def _chosen_ways(options: Sequence[str]) -> tuple[WaySelection, bool]:
    """Return which ways become streets by options of ``convert``, and whether private ones do."""
    ways = parse_ways_option(options[options.index("--ways") + 1]) if "--ways" in options else DRIVABLE
    return ways, "--include-private" in options


@record
class Mark:
    """A file at some time: its size, bytes, time of change, ns since 1970, and SHA-256."""

    path: str
    size: int
    mtime_ns: int
    sha256: str


@record
class State:
    """What an area was made of, and what was made of it."""

    arguments: tuple[str, ...]  # Of ``osm2xodr``, without bounds on memory and time
    inputs: tuple[Mark, ...]  # Files that were read, apart from the cut
    # The map that the area was cut out of, and the SHA-256 of outline and frame; None and empty without a cut
    cut_from: Mark | None = None
    cut_how: str = ""
    cut: Mark | None = None  # What was cut out
    outputs: tuple[Mark, ...] = ()  # Files that were made; none where there is nothing to drive on
    version: str = __version__  # Of osm2xodr


class Marks:
    """Marks of files; a file is only read again if its size or time of change differ."""

    def __init__(self) -> None:
        self._known: dict[str, Mark] = {}

    def learn(self, states: Iterable[State]) -> None:
        """Take over the marks of earlier runs."""
        for state in states:
            for mark in (*state.inputs, *state.outputs, state.cut_from):
                if mark is not None:
                    self._known[mark.path] = mark

    def of(self, path: Path) -> Mark | None:
        """Return the mark of a file; None if it cannot be read."""
        key = str(path)
        try:
            found = path.stat()
            known = self._known.get(key)
            if known is None or (known.size, known.mtime_ns) != (found.st_size, found.st_mtime_ns):
                known = Mark(key, found.st_size, found.st_mtime_ns, _sha256(path))
                self._known[key] = known
        except OSError:
            return None
        return known

    def of_all(self, paths: Sequence[Path]) -> tuple[Mark, ...] | None:
        """Return the marks of files; None if one of them cannot be read."""
        marks = [self.of(path) for path in paths]
        found = tuple(mark for mark in marks if mark is not None)
        return found if len(found) == len(marks) else None

    def same(self, mark: Mark | None) -> bool:
        """Return whether a file still has the contents of its mark."""
        now = None if mark is None else self.of(Path(mark.path))
        return now is not None and mark is not None and now.sha256 == mark.sha256


def contents(marks: Iterable[Mark]) -> list[tuple[str, str]]:
    """Return paths and SHA-256, without times of change."""
    return [(mark.path, mark.sha256) for mark in marks]


def load_state(path: Path) -> State | None:
    """Read a state; None if there is none, or none of this layout."""
    try:
        data: Any = parse_json(path.read_bytes())
        if data.pop("format") != _FINGERPRINT_FORMAT:
            return None
        data["arguments"] = tuple(data["arguments"])
        for name in ("inputs", "outputs"):
            data[name] = tuple(Mark(**item) for item in data[name])
        for name in ("cut_from", "cut"):
            data[name] = Mark(**data[name]) if data[name] is not None else None
        return State(**data)
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        return None


def save_state(path: Path, state: State) -> None:
    """Write a state, as a whole or not at all."""
    text = json.dumps({"format": _FINGERPRINT_FORMAT, **dataclasses.asdict(state)}, indent=1)
    with stream_to(path) as stream:
        stream.write(text.encode("ascii") + b"\n")


def remove(*paths: Path) -> None:
    """Remove files, those of them that exist."""
    for path in paths:
        path.unlink(missing_ok=True)


def _sha256(path: Path) -> str:
    digest = hashlib.sha256()
    with path.open("rb") as stream:
        while block := stream.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()
