"""What is wrong in OpenStreetMap itself, as a list of places for those who mend it there.

Imports nothing heavy: the command line imports it at its start.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from osm2xodr.diagnostics import Diagnostic, Diagnostics
from osm2xodr.reporting.report import codes

if TYPE_CHECKING:
    from osm2xodr.model import LocalFrame

_ADDRESS: Final = "https://www.openstreetmap.org/"
# Decimals of degrees, as in OSM: about 1 cm.
_DECIMALS: Final = 7


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
