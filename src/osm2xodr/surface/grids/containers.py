"""Files that lead to rasters: zip archives, which need not be unpacked, and virtual rasters (VRT).

A raster in an archive has the path of the archive with its own behind it: ``dem.zip/tile.tif``. Virtual rasters are
read, checked, and written anew as GDAL may read them: GDAL parses XML in its own way, and opens whatever a virtual
raster names. It never sees the file of a user, but the elements that were read here, with the names of local files
that were found to be regular ones.
"""

from __future__ import annotations

import contextlib
import functools
import lzma
import os
import re
import stat
import xml.etree.ElementTree as ET
import zipfile
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Final

from osm2xodr.errors import InputError

_ARCHIVE: Final = ".zip"
# Endings of rasters in archives, in small letters. Virtual rasters are not among them: what they refer to is checked
# on disk alone.
_RASTERS: Final = (".tif", ".tiff", ".asc", ".img", ".hgt")
# Most rasters of one archive; a choice, far above what agencies put into one.
_RASTERS_MAX: Final = 10_000
# What tells grids of text from others, bytes at the beginning of a file: they have no zero byte there.
_TEXT_HEAD: Final = 512
_CHUNK: Final = 1 << 20

# GDAL's virtual file systems, addresses with a scheme, and data sets given as text instead of a name.
_ELSEWHERE: Final = re.compile(r"(^|[^\w.-])/vsi\w+/|[a-z][a-z0-9+.-]+://", re.IGNORECASE)
_NOT_A_FILE: Final = re.compile(r"^\s*<|^[a-z0-9_]{2,}:", re.IGNORECASE)
# Elements that name a raster; that name a CRS, which GDAL takes from a file if there is one of that name; that are of
# no use for heights, and lead to further files; and kinds of virtual rasters that are made of pictures or of arrays.
_NAMES: Final = frozenset({"sourcefilename", "sourcedataset"})
_SYSTEMS: Final = frozenset({"srs", "sourcesrs", "targetsrs", "cutlinesrs"})
_DROPPED: Final = frozenset({"overview", "overviewlist", "histograms"})
_NOT_READ: Final = frozenset(
    {"pansharpeningoptions", "processingsteps", "group", "geoloctransformer", "rpctransformer", "pixelfunctioncode"}
)
# What is taken over from an element that names a raster: whether it is opened for this element alone.
_SHARED: Final = "shared"
_TRUE: Final = re.compile(r"\s*[+-]?0*[1-9]")
# Largest depth of virtual rasters that refer to each other; how often rasters are referred to in all, counted anew
# wherever a virtual one is, as GDAL reads them: a country has some 40,000 tiles of 1 km; and the largest file, bytes,
# which is so many references of 600 bytes. Choices, as is the depth of elements: GDAL's own tools write 12.
_DEPTH_MAX: Final = 8
_REFERENCES_MAX: Final = 100_000
_SIZE_MAX: Final = 64_000_000
_ELEMENT_DEPTH_MAX: Final = 32
# Bytes at the beginning of a file that show what it is.
_VRT_HEAD: Final = 2048
# Longest name that a message quotes, characters.
_QUOTED_MAX: Final = 200


def rasters_in(path: Path) -> list[Path]:
    """Return the rasters of a zip archive, by name; any other path is returned as it is.

    `InputError` if the archive is damaged or has no rasters.
    """
    if path.suffix.lower() != _ARCHIVE or not path.is_file():
        if (archive := archive_of(path)) is not None:
            _check_texts(archive, [path.relative_to(archive).as_posix()])
        return [path]
    found = [name for name in sorted(_members(path)) if Path(name).suffix.lower() in _RASTERS]
    if not found:
        known = ", ".join(_RASTERS)
        raise InputError(
            f"{path}: there is no elevation model in the archive ({known}); unpack it, and name the file"
        )
    if len(found) > _RASTERS_MAX:
        raise InputError(
            f"{path}: there are {len(found):,} rasters in the archive; unpack it, and name those you need"
        )
    _check_texts(path, found)
    return [path / name for name in found]


def _check_texts(path: Path, names: Iterable[str]) -> None:
    """Raise `InputError` if a grid of text is damaged in its archive: GDAL would read on and on behind the damage."""
    try:
        with zipfile.ZipFile(path) as archive:
            for name in names:
                # How some are packed Python cannot read.
                with contextlib.suppress(NotImplementedError, RuntimeError, KeyError), archive.open(name) as member:
                    if b"\0" not in member.read(_TEXT_HEAD):
                        while member.read(_CHUNK):
                            pass
    except (zipfile.BadZipFile, OSError, ValueError, EOFError, zlib.error, lzma.LZMAError):
        raise _damaged(path) from None


def _members(path: Path) -> frozenset[str]:
    """Return the names of the files in an archive."""
    try:
        of = path.stat()
        return _members_of(path, of.st_mtime_ns, of.st_size)
    except OSError as error:
        raise InputError(f"{path}: the archive cannot be read ({error.strerror}); check its permissions") from None
    except (zipfile.BadZipFile, ValueError, NotImplementedError):
        raise _damaged(path) from None


def _damaged(path: Path) -> InputError:
    return InputError(f"{path}: the archive is damaged or cut short; get it whole")


@functools.lru_cache(maxsize=4)
def _members_of(path: Path, changed: int, size: int) -> frozenset[str]:
    """Return what `_members` does; it is asked for each raster of an archive."""
    with zipfile.ZipFile(path) as archive:
        return frozenset(item.filename for item in archive.infolist() if not item.is_dir())


def beside(path: Path, names: Iterable[str]) -> list[Path]:
    """Return the files of some names that lie beside a raster, on disk or in its archive.

    `InputError` if one is no regular file: whoever reads it may wait for ever.
    """
    archive = archive_of(path)
    if archive is None:
        return [item for item in map(path.with_name, names) if _is_regular(path, item)]
    folder, members = path.parent.relative_to(archive).as_posix(), _members(archive)
    within = "" if folder == "." else f"{folder}/"
    return [path.with_name(name) for name in names if within + name in members]


def _is_regular(path: Path, beside: Path) -> bool:
    """Whether there is a regular file beside a raster."""
    try:
        mode = beside.stat().st_mode
    except OSError:
        return False
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise InputError(f"{path}: {beside.name}, which is read with it, is no regular file; remove it")
    return stat.S_ISREG(mode)


def archive_of(path: Path) -> Path | None:
    """Return the archive that a raster is in; None if it is a file by itself."""
    for parent in path.parents:
        if parent.suffix.lower() == _ARCHIVE and parent.is_file():
            return parent
    return None


def gdal_name(path: Path) -> str:
    """Return what GDAL opens a raster by."""
    archive = archive_of(path)
    if archive is None:
        return str(path.absolute())
    # In braces archives may have any name.
    return f"/vsizip/{{{archive.absolute()}}}/{path.relative_to(archive).as_posix()}"


@dataclass(slots=True, eq=False)
class VirtualRaster:
    """A virtual raster that was checked."""

    path: Path
    root: ET.Element
    named: list[tuple[ET.Element, Path]] = field(default_factory=list)  # What names a raster, and that raster
    references: int = 0  # How often rasters are referred to, those behind other virtual ones counted each time

    def text(self, names: Mapping[Path, str]) -> bytes:
        """Return what GDAL is to read; `names` are those of the virtual rasters among its sources."""
        for element, source in self.named:
            element.text = names.get(source) or str(source)
        return ET.tostring(self.root, encoding="unicode").encode("utf-8", "surrogateescape")


def is_virtual(path: Path) -> bool:
    """Whether a file is a virtual raster, whatever its name."""
    with path.open("rb") as stream:
        return _looks_virtual(stream.read(_VRT_HEAD))


def virtual_sources(path: Path) -> list[Path]:
    """Return the local rasters that a virtual raster refers to, directly or through others, each once.

    `InputError` as of `read_virtual`.
    """
    return list(dict.fromkeys(source for virtual in read_virtual(path) for _, source in virtual.named))


def read_virtual(path: Path) -> list[VirtualRaster]:
    """Read a virtual raster and those among its sources: each after those that it refers to, the given one at last.

    Sources that are not there are left to GDAL to report. `InputError` if a file is not XML, has a document type or
    entities, refers to anything but regular local files or in a circle, or if all together are too deep or too large.
    """
    reader = _Reader()
    reader.visit(Path(os.path.realpath(path)))
    return list(reader.done.values())


class _Reader:
    """Visits virtual rasters, each once."""

    def __init__(self) -> None:
        self.done: dict[Path, VirtualRaster] = {}
        self._trail: list[Path] = []
        self._plain: set[Path] = set()  # Sources that are no virtual rasters

    def visit(self, path: Path) -> VirtualRaster:
        """Read a virtual raster, and what it refers to."""
        if path in self.done:
            return self.done[path]
        if len(self._trail) > _DEPTH_MAX or path in self._trail:
            why = f"refer to each other more than {_DEPTH_MAX} deep; give the DEMs themselves"
            raise InputError(f"{path}: virtual rasters {why}")
        self._trail.append(path)
        virtual = VirtualRaster(path, _read(path))
        _clean(path, virtual.root)
        for element in [item for item in virtual.root.iter() if item.tag.casefold() in _NAMES]:
            source = _source(path, element)
            behind = self._behind(path, source)
            virtual.named.append((element, source if behind is None else behind.path))
            virtual.references += 1 if behind is None else 1 + behind.references
            if virtual.references > _REFERENCES_MAX:
                why = f"refers to rasters more than {_REFERENCES_MAX:,} times"
                raise InputError(
                    f"{path}: the virtual raster {why}; give one of the area alone, or the DEMs themselves"
                )
        self._trail.pop()
        self.done[path] = virtual
        return virtual

    def _behind(self, path: Path, source: Path) -> VirtualRaster | None:
        """Check a source, and return what it is if it is virtual too."""
        if source in self._plain:
            return None
        try:
            if not stat.S_ISREG(source.stat().st_mode):
                raise _refusal(path, str(source))
            with source.open("rb") as stream:
                head = stream.read(_VRT_HEAD)
        except (FileNotFoundError, NotADirectoryError):
            head = b""
        except (OSError, ValueError) as error:
            why = f"which cannot be opened ({getattr(error, 'strerror', None) or error}); correct it"
            raise InputError(f"{path}: the virtual raster refers to '{str(source)[:_QUOTED_MAX]}', {why}") from None
        if _looks_virtual(head):
            # GDAL follows links before it looks for what is beside.
            return self.visit(Path(os.path.realpath(source)))
        if head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith((b"<", b"{")):
            raise _refusal(path, str(source))
        self._plain.add(source)
        return None


def _looks_virtual(head: bytes) -> bool:
    return b"<vrtdataset" in head.lower()


def _source(path: Path, element: ET.Element) -> Path:
    """Return the raster that an element names, and leave nothing but its name in the element."""
    name = (element.text or "").strip()
    if _NOT_A_FILE.search(name):
        raise _refusal(path, name)
    given = {key.casefold(): value for key, value in element.attrib.items()}
    shared = {key: value for key, value in given.items() if key == _SHARED and value in ("0", "1")}
    # Its name is as GDAL would find it: beside the virtual raster, or from the current folder.
    beside = _TRUE.match(given.get("relativetovrt", "0")) is not None
    element[:] = []
    element.attrib.clear()
    element.attrib.update(shared, relativeToVRT="0")
    return (path.parent / name if beside else Path(name)).absolute()


def _clean(path: Path, root: ET.Element) -> None:
    """Refuse what leads elsewhere, and remove what leads to further files and is of no use for heights."""
    if root.tag.casefold() != "vrtdataset":
        raise InputError(f"{path}: the virtual raster is none; make it anew with gdalbuildvrt")
    todo = [root]
    while todo:
        parent = todo.pop()
        _check(path, parent)
        # What a raster says about itself is text; but what GDAL keeps apart from it may name other files.
        parent[:] = [item for item in parent if not (_is_metadata(item) and "domain" in _keys(item))]
        todo += [item for item in parent if not _is_metadata(item)]
        parent[:] = [item for item in parent if item.tag.casefold() not in _DROPPED]


def _is_metadata(element: ET.Element) -> bool:
    return element.tag.casefold() == "metadata"


def _keys(element: ET.Element) -> set[str]:
    """Return the names of what is in an element: to GDAL attributes and elements are the same."""
    return {key.casefold() for key in (*element.attrib, *(item.tag for item in element))}


def _check(path: Path, element: ET.Element) -> None:
    """Refuse an element that leads elsewhere, or that is of a kind which is not read."""
    for text in (element.text or "", element.tail or "", *element.attrib.values()):
        if _ELSEWHERE.search(text):
            raise _refusal(path, text.strip())
    for key, value in element.attrib.items():
        if key.casefold() in _NAMES | _SYSTEMS:
            raise _refusal(path, value)
    tag, text = element.tag.casefold(), (element.text or "").strip()
    if tag in _NOT_READ:
        why = f"has an element {element.tag}, which is not read; make a GeoTIFF of it with gdal_translate"
        raise InputError(f"{path}: the virtual raster {why}")
    if (tag in _SYSTEMS and os.path.exists(text)) or (tag in ("ooi", "option") and re.search(r"[/\\]", text)):
        raise _refusal(path, text)


def _refusal(path: Path, name: str) -> InputError:
    """Make the error for a virtual raster that refers to something that is not read."""
    why = "but only local rasters are read; download it first"
    return InputError(f"{path}: the virtual raster refers to '{name[:_QUOTED_MAX]}', {why}")


def _read(path: Path) -> ET.Element:
    """Parse a virtual raster that has neither document type nor entities."""
    with path.open("rb") as stream:
        text = stream.read(_SIZE_MAX + 1)
    if len(text) > _SIZE_MAX:
        why = f"has over {_SIZE_MAX // 10**6} MB; give one of the area alone, or the DEMs themselves"
        raise InputError(f"{path}: the virtual raster {why}")
    if b"<!doctype" in text.lower() or b"<!entity" in text.lower():
        why = "has a document type or entities, which are not read; remove them"
        raise InputError(f"{path}: the virtual raster {why}")
    try:
        return _tree(path, text)
    except (ET.ParseError, ValueError, LookupError) as error:
        why = f"is not well-formed XML ({error}); make it anew with gdalbuildvrt"
        raise InputError(f"{path}: the virtual raster {why}") from None


def _tree(path: Path, text: bytes) -> ET.Element:
    """Return the elements of a text, without namespaces, which GDAL does not know."""
    trail: list[ET.Element] = []
    for event, element in ET.iterparse(BytesIO(text), ("start", "end")):
        if event == "end":
            root = trail.pop()
            continue
        trail.append(element)
        if len(trail) > _ELEMENT_DEPTH_MAX:
            raise InputError(f"{path}: the virtual raster has elements too deep within each other; make it anew")
        element.tag = element.tag.rpartition("}")[2]
        for key in [key for key in element.attrib if "}" in key]:
            del element.attrib[key]
    return root
