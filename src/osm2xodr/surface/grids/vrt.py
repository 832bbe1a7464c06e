"""The files that a virtual raster (VRT) refers to, checked to be local before GDAL opens any of them."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Final

from osm2xodr.errors import InputError

# GDAL's virtual file systems, addresses with a scheme, and data sets given as text instead of a name.
_ELSEWHERE: Final = re.compile(r"(^|[^\w.-])/vsi\w+/|[a-z][a-z0-9+.-]+://", re.IGNORECASE)
_NOT_A_FILE: Final = re.compile(r"^\s*<|^[a-z0-9_]{2,}:", re.IGNORECASE)
_NAME_TAGS: Final = frozenset({"sourcefilename", "sourcedataset"})
# Largest depth of virtual rasters that refer to each other.
_DEPTH_MAX: Final = 8
# Longest name that a message quotes, characters.
_QUOTED_MAX: Final = 200


def is_virtual(path: Path) -> bool:
    """Whether a file is a virtual raster, whatever its name."""
    with path.open("rb") as stream:
        return b"<vrtdataset" in stream.read(2048).lower()


def virtual_sources(path: Path, depth: int = 0) -> list[Path]:
    """Return the local rasters that a virtual raster refers to, directly or through others; refuse anything else.

    `InputError` if it is not XML, has a document type or entities, refers to elsewhere, or nests too deeply.
    """
    if depth > _DEPTH_MAX:
        why = f"refer to each other more than {_DEPTH_MAX} deep; give the DEMs themselves"
        raise InputError(f"{path}: virtual rasters {why}")
    found: list[Path] = []
    root = _read(path)
    for element in root.iter():
        for text in (element.text or "", element.tail or "", *element.attrib.values()):
            if _ELSEWHERE.search(text):
                raise _refusal(path, text.strip())
        if element.tag.casefold() in _NAME_TAGS:
            name = (element.text or "").strip()
            if _NOT_A_FILE.search(name):
                raise _refusal(path, name)
            relative = {key.casefold(): value for key, value in element.attrib.items()}.get("relativetovrt", "0")
            source = Path(name) if relative.strip() == "0" else path.parent / name
            found += [source, *_sources_behind(path, source, depth)]
    return found


def _sources_behind(path: Path, source: Path, depth: int) -> list[Path]:
    """Return the rasters behind a source if it is virtual too; absent ones are left to GDAL to report."""
    if not source.is_file():
        return []
    if is_virtual(source):
        return virtual_sources(source, depth + 1)
    with source.open("rb") as stream:
        if stream.read(64).lstrip(b"\xef\xbb\xbf \t\r\n").startswith((b"<", b"{")):
            raise _refusal(path, str(source))
    return []


def _refusal(path: Path, name: str) -> InputError:
    """Make the error for a virtual raster that refers to something that is not read."""
    why = "but only local rasters are read; download it first"
    return InputError(f"{path}: the virtual raster refers to '{name[:_QUOTED_MAX]}', {why}")


def _read(path: Path) -> ET.Element:
    """Parse a virtual raster that has neither document type nor entities."""
    text = path.read_bytes()
    if b"<!doctype" in text.lower() or b"<!entity" in text.lower():
        why = "has a document type or entities, which are not read; remove them"
        raise InputError(f"{path}: the virtual raster {why}")
    try:
        return ET.fromstring(text)
    except ET.ParseError as error:
        why = f"is not well-formed XML ({error}); make it anew with gdalbuildvrt"
        raise InputError(f"{path}: the virtual raster {why}") from None
