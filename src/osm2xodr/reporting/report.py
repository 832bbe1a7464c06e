"""What is said about a conversion: to people as text, to programs as JSON, to mappers as a list of OSM's mistakes.

Also what the codes of diagnostics mean. Imports nothing heavy: the command line imports it at its start.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path, PurePath
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from osm2xodr.diagnostics import Diagnostic, Diagnostics, Kind
from osm2xodr.system import record

if TYPE_CHECKING:
    from osm2xodr.model import BorderEnd, ElevationReport, Junction, LocalFrame
    from osm2xodr.reporting.statistics import Statistics
    from osm2xodr.surface import DemSummary


# Version of the layout of the JSON report; goes up when a field is removed or changes its meaning.
REPORT_FORMAT = 2

_ADDRESS: Final = "https://www.openstreetmap.org/"
# Decimals of degrees, as in OSM: about 1 cm.
_DECIMALS: Final = 7


def details(diagnostics: Diagnostics) -> list[str]:
    """Return one line for each diagnostic, with the correction that may help."""
    lines = []
    for item in diagnostics:
        known = codes().get(item.code)
        correction = known.line_for(item.osm_id) if known is not None else ""
        text = f"  {item.kind.value}: {item.code}: {example(item.message, item.osm_id, 1)}"
        lines.append(f"{text}; correct it by {correction}" if correction else text)
    return lines


def report(
    inputs: Mapping[str, Any],
    elevation_models: Sequence[DemSummary],
    statistics: Statistics,
    elevation: ElevationReport | None,
    diagnostics: Diagnostics,
    output: Mapping[str, Any],
    border_ends: Sequence[BorderEnd] | None = None,
    junctions: Sequence[Junction] = (),
) -> bytes:
    """Return the JSON report on a conversion, UTF-8; the same input gives the same bytes.

    `inputs` are files and options by name, `output` says what was written; `elevation` is None where the world is
    flat, and `border_ends`, where roads were cut off, for an area by itself. The nodes of OSM that `junctions` come
    from are not in the road network's own file.
    """
    counts = [{"kind": kind.value, "code": code, "count": n} for (kind, code), n in diagnostics.counts().items()]
    found = [
        {"kind": item.kind.value, "code": item.code, "osm_id": item.osm_id or None, "message": item.message}
        for item in diagnostics
    ]
    document = {
        "format": REPORT_FORMAT,
        "input": dict(inputs),
        "elevation_models": [dataclasses.asdict(item) for item in elevation_models],
        "output": dict(output),
        "statistics": dataclasses.asdict(statistics),
        "elevation": None if elevation is None else dataclasses.asdict(elevation),
        **({} if border_ends is None else {"border_ends": [dataclasses.asdict(item) for item in border_ends]}),
        "junction_nodes": {item.id: " ".join(map(str, item.osm_node_ids)) for item in junctions},
        "counts": counts,
        "diagnostics": found,
    }
    text = json.dumps(_plain(document), indent=1, ensure_ascii=False, allow_nan=False)
    # Names from damaged files may contain lone surrogates, which UTF-8 cannot encode.
    return text.encode("utf-8", "replace") + b"\n"


def _plain(value: Any) -> Any:
    """Return a value as JSON has it: text for paths, null for numbers that are not finite."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, PurePath) else value


def example(message: str, osm_id: str, count: int, most: int | None = None) -> str:
    """Return the first of several findings, and how many more there are.

    A message that would make the text longer than `most` is cut; its element is not.
    """
    text = message.rstrip(".")
    room = len(text) if most is None else most
    where = osm_id if osm_id not in text[: room - 1] else ""
    others = f"and {count - 1:,} more" if count > 1 else ""
    both = ", ".join(filter(None, (where, others)))
    tail = f" ({both})" if both else ""
    if most is not None and len(text) + len(tail) > most:
        text = f"{text[: max(most - len(tail) - 1, 0)]}…"
    return text + tail


@record
class Code:
    """What one code means; ``codes.ini`` says what the fields are."""

    kinds: tuple[Kind, ...]
    meaning: str
    remedy: str
    harm: int | None  # None where it needs no attention
    osm: tuple[Kind, ...]  # Kinds of it that stand for mistakes in OSM
    correction: str  # Key and value of a correction, as an example; empty where none helps

    def line_for(self, osm_id: str) -> str:
        """Return a line for a file of corrections about an element, such as ``way.1.lanes = 2``; empty for none."""
        kind, _, number = osm_id.partition("/")
        return f"{kind}.{number}.{self.correction}" if self.correction and number else ""


@cache
def codes() -> Mapping[str, Code]:
    """Return all codes of diagnostics, by name."""
    # Here, so that commands that need none of it start at once.
    from configparser import ConfigParser
    from importlib import resources

    parser = ConfigParser(delimiters="=", interpolation=None)
    parser.read_string(resources.files("osm2xodr.reporting").joinpath("codes.ini").read_text(encoding="utf-8"))
    found = {}
    for name in parser.sections():
        item = parser[name]
        kinds = tuple(Kind(word) for word in item["kinds"].split(", "))
        meaning, remedy = (" ".join(item[key].split()) for key in ("meaning", "remedy"))
        osm = tuple(Kind(word) for word in item.get("osm", "").split(", ") if word)
        found[name] = Code(kinds, meaning, remedy, item.getint("harm"), osm, item.get("correction", ""))
    return MappingProxyType(found)


def mistakes(diagnostics: Diagnostics) -> Iterator[Diagnostic]:
    """Yield what stands for a mistake in OSM, by the table of codes; what is about no single element is left out."""
    for item in diagnostics:
        known = codes().get(item.code)
        if item.osm_id and known is not None and item.kind in known.osm:
            yield item


def osm_issues(diagnostics: Diagnostics, path: Path, frame: LocalFrame) -> bytes:
    """Return the mistakes as GeoJSON (RFC 7946), UTF-8: a point for each, on its element.

    `path` is the map, from which the places of elements are read; what it lacks has no geometry. `frame` is any local
    frame around them. Raises `InputError` if the map cannot be read.
    """
    # They load the reader of OSM files.
    from osm2xodr.osmParsing import element_places
    from osm2xodr.projection import to_geographic

    found = list(mistakes(diagnostics))
    places: dict[str, tuple[float, float]] = {}
    for osm_id, xy in element_places(path, frame, {item.osm_id for item in found}).items():
        # Of a way its middle, of a relation its first member with a place.
        row = 0 if osm_id.startswith("relation/") else len(xy) // 2
        lon, lat = to_geographic(frame, *xy[row])
        places[osm_id] = round(float(lon), _DECIMALS), round(float(lat), _DECIMALS)
    features = [_feature(item, places) for item in found]
    document = {"type": "FeatureCollection", "features": features}
    # Names from damaged files may contain lone surrogates, which UTF-8 cannot encode.
    return json.dumps(document, indent=1, ensure_ascii=False).encode("utf-8", "replace") + b"\n"


def _feature(item: Diagnostic, places: Mapping[str, tuple[float, float]]) -> dict[str, Any]:
    place = places.get(item.osm_id)
    return {
        "type": "Feature",
        "geometry": None if place is None else {"type": "Point", "coordinates": list(place)},
        "properties": {
            "osm": item.osm_id,
            "url": f"{_ADDRESS}{item.osm_id}",
            "code": item.code,
            "kind": item.kind.value,
            "message": item.message,
        },
    }
