"""What is cut out of maps for areas, kept from one start of a batch to the next.

Reading and cutting a country takes many minutes. A cut is used again as long as the map, what is cut out of it and
the version are the same; a record beside each says so, which is written when the cut is complete.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from osm2xodr import __version__
from osm2xodr.batch.areas import PlannedArea
from osm2xodr.batch.fingerprints import Mark, remove
from osm2xodr.batch.model import CutRequest
from osm2xodr.batch.out_dir import OutDir
from osm2xodr.osmParsing import DRIVABLE, WaySelection, parse_ways_option
from osm2xodr.system import stream_to

# Version of the layout of records; one of another version counts as none.
_FORMAT: Final = 1


@dataclass(frozen=True, slots=True)
class _Record:
    """What a cut is, and what it was made of."""

    source: str  # SHA-256 of the map
    how: str  # As `KeptCuts.how` returns it
    ways: int  # Number of ways in it that become streets; without any there is no file
    # Of the file: bytes, and time of change, ns since 1970
    size: int = 0
    mtime_ns: int = 0
    version: str = __version__  # Of osm2xodr


class KeptCuts:
    """The cuts of a batch."""

    def __init__(self, out: OutDir, kept: frozenset[int], *, context: bool) -> None:
        self._out = out
        self._kept = kept  # OSM ids of ways that become streets in any case
        self._context = context

    def clear(self, names: Sequence[str]) -> None:
        """Remove all cuts that are not of areas of these names."""
        kept = set(names)
        for path in (*self._out.cuts.glob("*.osm.pbf"), *self._out.cuts.glob("*.json")):
            if path.name.removesuffix(".osm.pbf").removesuffix(".json") not in kept:
                remove(path)

    def make(self, source: Path, mark: Mark, parts: Sequence[PlannedArea]) -> dict[str, int]:
        """Cut out what is not there yet, and return the number of ways in each area that become streets.

        `mark` is that of the map. Raises as `cut_areas`.
        """
        from osm2xodr.batch.cutting import cut_areas

        counts: dict[str, int] = {}
        missing = []
        for item in parts:
            known = self._known(item, mark)
            if known is None:
                missing.append(item)
            else:
                counts[item.area.name] = known
        if missing:
            how = {item.area.name: self.how(item) for item in missing}

            def keep(made: Mapping[str, int]) -> None:
                for name, ways in made.items():
                    self._record(name, _Record(mark.sha256, how[name], ways))

            # A record must not outlive the file that it is of.
            remove(*(self._path(name) for name in how))
            counts.update(cut_areas(source, [self._request(item) for item in missing], keep))
        return counts

    def how(self, item: PlannedArea) -> str:
        """Return the SHA-256 of all that says how an area is cut out of its map."""
        assert item.frame is not None
        assert item.outline is not None
        ways, private = _chosen_ways(item.area.options)
        chosen = [sorted(ways.highways), sorted(ways.services_out), private, sorted(self._kept)]
        text = json.dumps([item.frame.proj, [ring.tolist() for ring in item.outline.rings], self._context, chosen])
        return hashlib.sha256(text.encode()).hexdigest()

    def _request(self, item: PlannedArea) -> CutRequest:
        assert item.frame is not None
        assert item.outline is not None
        name, (ways, private) = item.area.name, _chosen_ways(item.area.options)
        return CutRequest(
            name,
            self._out.cut(name),
            item.frame,
            item.outline,
            self._context,
            ways,
            private,
            self._kept,
            item.area.where,
        )

    def _known(self, item: PlannedArea, mark: Mark) -> int | None:
        """Return the number of ways that become streets in a cut that is there; None if it is not."""
        name = item.area.name
        try:
            data = json.loads(self._path(name).read_bytes())
            if data.pop("format") != _FORMAT:
                return None
            record = _Record(**data)
            wanted = _Record(mark.sha256, self.how(item), record.ways)
            return record.ways if record == self._measured(name, wanted) else None
        except (OSError, ValueError, LookupError, TypeError, AttributeError):
            return None

    def _record(self, name: str, record: _Record) -> None:
        text = json.dumps({"format": _FORMAT, **dataclasses.asdict(self._measured(name, record))})
        with stream_to(self._path(name)) as stream:
            stream.write(text.encode("ascii") + b"\n")

    def _measured(self, name: str, record: _Record) -> _Record:
        """Return a record with the size and time of its file."""
        if not record.ways:
            return record
        found = self._out.cut(name).stat()
        return dataclasses.replace(record, size=found.st_size, mtime_ns=found.st_mtime_ns)

    def _path(self, name: str) -> Path:
        return self._out.cuts / f"{name}.json"


def _chosen_ways(options: Sequence[str]) -> tuple[WaySelection, bool]:
    """Return which ways become streets by options of ``convert``, and whether private ones do."""
    ways = parse_ways_option(options[options.index("--ways") + 1]) if "--ways" in options else DRIVABLE
    return ways, "--include-private" in options
