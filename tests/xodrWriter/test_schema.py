"""Documents against the schemas of ASAM, which come with its checker."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import pytest
import qc_opendrive
import xmlschema
from lxml import etree
from sample_road_maps import crossing, furnished_crossing

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import RoadMap, Rule
from osm2xodr.xodrWriter import VERSIONS, WriteOptions, write_xodr

SCHEMAS = Path(qc_opendrive.__file__).parent / "schema"
SCHEMA = {
    "1.4": SCHEMAS / "1.4" / "OpenDRIVE_1.4H.xsd",
    "1.6": SCHEMAS / "1.6.1" / "opendrive_16_core.xsd",
    "1.7": SCHEMAS / "1.7.0" / "opendrive_17_core.xsd",
    "1.8": SCHEMAS / "1.8.0" / "OpenDRIVE_Core.xsd",
}


def written(road_map: RoadMap, options: WriteOptions) -> bytes:
    stream = io.BytesIO()
    write_xodr(road_map, stream, options, Diagnostics())
    return stream.getvalue()


def schema_errors(document: bytes, version: str) -> list[str]:
    if version == "1.8":  # XSD 1.1, which lxml does not know
        found = xmlschema.XMLSchema11(str(SCHEMA[version])).iter_errors(io.BytesIO(document))
        return [str(error.reason) for error in found]
    schema = etree.XMLSchema(etree.parse(str(SCHEMA[version])))
    return [] if schema.validate(etree.fromstring(document)) else [str(schema.error_log)]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("rule", list(Rule))
def test_valid_against_the_schema_of_its_version(version: str, rule: Rule) -> None:
    options = WriteOptions(version, 'Ordino "&" <more>', "2024-05-06", "0.1.0")
    document = written(replace(furnished_crossing(), rule=rule), options)
    assert schema_errors(document, version) == []
    assert etree.fromstring(document)[0].get("revMinor") == version.split(".")[1]


def test_the_schemas_do_find_errors() -> None:
    for version in VERSIONS:
        broken = written(crossing(), WriteOptions(version)).replace(b'type="driving"', b'type="flying"', 1)
        assert len(schema_errors(broken, version)) > 0
