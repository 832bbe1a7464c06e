#!/usr/bin/env python3
"""Make the table of countries in the package from the borders of country-coder. Run by hand.

    npm pack @rapideditor/country-coder && tar xzf rapideditor-country-coder-*.tgz
    tools/make_countries.py package/src/data/borders.json package/package.json

Source: https://github.com/rapideditor/country-coder, ISC licence, (c) country-coder contributors; the licence is
beside the table. The table has the outlines of all places with a geometry, in units of 1e-4 degrees (11 m; over water
the source is much coarser), the ISO 3166-1 alpha-2 code of each, whether traffic drives on the left, and whether
speed limits are in miles per hour.

The table is JSON, compressed with gzip::

    {"source": text, "unit_deg": 1e-4,
     "places": [{"code": "MT", "left": true, "mph": false, "rings": [[x0, y0, dx1, dy1, ...], ...]}, ...]}

Holes are rings like any other: a point is inside a place if it is inside an odd number of its rings.
"""

from __future__ import annotations

import argparse
import gzip
import json
from pathlib import Path
from typing import Any

UNIT_DEG = 1e-4
TARGET = Path(__file__).resolve().parent.parent / "src/osm2xodr/osmParsing/network/data/countries.json.gz"

# The only place to which country-coder gives neither a code nor a country nor groups.
OTHERS = {"Northern Cyprus": "CY"}
# Groups with a two-letter code that are neither countries nor territories.
UNIONS = {"EU", "UN"}


def own_code(properties: dict[str, Any]) -> str:
    """Return a place's own code, unless ISO 3166-1 only reserves it (such as AC for Ascension, part of SH)."""
    return "" if properties.get("isoStatus") == "excRes" else str(properties.get("iso1A2", ""))


def code_of(properties: dict[str, Any], codes: dict[str, str]) -> str:
    """Return the ISO code of a place: its own, that of the territory it is part of, or that of its country."""
    groups = [codes[group] for group in properties.get("groups", []) if group in codes]
    country = properties.get("country", OTHERS.get(properties["nameEn"], ""))
    return own_code(properties) or (groups[0] if groups else str(country))


def deltas(ring: list[list[float]]) -> list[int]:
    """Return a ring in whole units, each point relative to the one before; repeated points are left out."""
    out: list[int] = []
    last = (0, 0)
    for lon, lat in ring:
        point = (round(lon / UNIT_DEG), round(lat / UNIT_DEG))
        if not out or point != last:
            out += [point[0] - last[0], point[1] - last[1]]
            last = point
    return out


def main() -> None:
    """Read borders.json, write the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("borders", type=Path, help="borders.json of country-coder")
    parser.add_argument("package", type=Path, help="package.json of country-coder, for its version")
    arguments = parser.parse_args()
    features = json.loads(arguments.borders.read_text(encoding="utf-8"))["features"]
    version = json.loads(arguments.package.read_text(encoding="utf-8"))["version"]
    codes: dict[str, str] = {}  # places name the groups they are part of by code or by Wikidata id
    for feature in features:
        code = own_code(feature["properties"])
        if code and code not in UNIONS:
            codes |= {code: code, feature["properties"]["wikidata"]: code}
    places = []
    for feature in features:
        if feature["geometry"]:
            properties = feature["properties"]
            rings = [deltas(ring) for polygon in feature["geometry"]["coordinates"] for ring in polygon]
            places.append(
                {
                    "code": code_of(properties, codes),
                    "left": properties.get("driveSide") == "left",
                    "mph": properties.get("roadSpeedUnit") == "mph",
                    "rings": rings,
                }
            )
    places.sort(key=lambda place: (place["code"], place["rings"]))
    table = {"source": f"country-coder {version}, ISC licence", "unit_deg": UNIT_DEG, "places": places}
    text = json.dumps(table, separators=(",", ":"))
    TARGET.parent.mkdir(exist_ok=True)
    TARGET.write_bytes(gzip.compress(text.encode("ascii"), compresslevel=9, mtime=0))
    print(f"{TARGET}: {len(places)} places, {TARGET.stat().st_size} bytes")


if __name__ == "__main__":
    main()
