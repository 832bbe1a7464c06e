"""Results of invented batches, and the files that conversions would have left."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from osm2xodr.batching.model import Result, Status

Ring = tuple[tuple[float, float], ...]

FIGURES: dict[str, Any] = {
    "roads": 12,
    "connecting_roads": 34,
    "junctions": 5,
    "road_length": 6789.4,
    "connecting_length": 432.1,
    "lowest": -3.26,
    "highest": 1234.5,
    "dem_coverage": 0.98765,
    "further": {"grade_max": 0.1234},
}


def rectangle(west: float, south: float, width: float, height: float) -> tuple[Ring]:
    """Return an outline, degrees."""
    east, north = west + width, south + height
    return (((west, south), (east, south), (east, north), (west, north)),)


def report(**statistics: Any) -> bytes:
    """Return a report; `statistics` replace those of `FIGURES`."""
    counts = [("guessed", "lane-count", 40), ("guessed", "surface", 2), ("dropped", "closed", 3), ("note", "x", 1)]
    return json.dumps(
        {
            "format": 2,
            "input": {"osm2xodr": "9.8.7"},
            "output": {"file": "somewhere.xodr", "bytes": 1_234_567, "xodr_version": "1.7"},
            "statistics": {**FIGURES, **statistics},
            "counts": [{"kind": kind, "code": code, "count": count} for kind, code, count in counts],
            "diagnostics": [],
        }
    ).encode()


def result(name: str, status: Status = Status.DONE, message: str = "", **more: Any) -> Result:
    """Return a result that took 12.345 s and 600 MB, unless nothing was converted."""
    spent = {} if status is Status.UNCHANGED else {"seconds": 12.345, "memory": 600_000_000}
    return Result(name, status, message, **{**spent, **more})


def leave_files(out_dir: Path, results: Sequence[Result], suffixes: Sequence[str] = (".xodr", ".json")) -> None:
    """Write what conversions leave: of those that ended well, reports of roads of 1, 2, 3 … km."""
    out_dir.mkdir(exist_ok=True)
    for k, item in enumerate(results, 1):
        if item.status in (Status.DONE, Status.UNCHANGED):
            for suffix in suffixes:
                content = report(road_length=1000.0 * k) if suffix == ".json" else b"-"
                (out_dir / f"{item.name}{suffix}").write_bytes(content)
