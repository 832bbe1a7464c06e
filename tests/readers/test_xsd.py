"""The files are valid against the schema of every version that can be written."""

from __future__ import annotations

import pytest
from lxml import etree
from real_readers import schema_errors
from scene_files import SCENES, SMALL_SCENES, Conversions, Scene


@pytest.mark.parametrize("version", ["1.4", "1.6", "1.7"])
@pytest.mark.parametrize("scene", SCENES, ids=str)
def test_valid(scene: Scene, version: str, conversions: Conversions) -> None:
    conversion = conversions.of(scene, version)
    assert schema_errors(conversion.path, version) == []
    assert _stated_version(conversion.path.read_bytes()) == version


# xmlschema takes some 10 s for each MB: those of under 1 MB.
@pytest.mark.parametrize("scene", [scene for scene in SMALL_SCENES if scene.name != "i5_exit_ramp"], ids=str)
def test_valid_1_8(scene: Scene, conversions: Conversions) -> None:
    conversion = conversions.of(scene, "1.8")
    assert schema_errors(conversion.path, "1.8") == []
    assert _stated_version(conversion.path.read_bytes()) == "1.8"


def _stated_version(document: bytes) -> str:
    header = etree.fromstring(document, etree.XMLParser(huge_tree=True)).find("header")
    assert header is not None
    return f"{header.get('revMajor')}.{header.get('revMinor')}"
