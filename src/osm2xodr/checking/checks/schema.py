"""Checks files against the XML schema of their version, if there is one."""

from __future__ import annotations

import importlib
import importlib.util
import locale
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final, TypeAlias

from osm2xodr.errors import InputError
from osm2xodr.system import xml_stream

# Where the schemas lie in the package of ASAM's checker, by version.
_PACKAGE: Final = "qc_opendrive"
_SCHEMAS: Final = {
    (1, 1): "1.1/OpenDRIVE_1.1.xsd",
    (1, 2): "1.2/OpenDRIVE_1.2.xsd",
    (1, 4): "1.4/OpenDRIVE_1.4H.xsd",
    (1, 5): "1.5/OpenDRIVE_1.5M.xsd",
    (1, 6): "1.6.1/opendrive_16_core.xsd",
    (1, 7): "1.7.0/opendrive_17_core.xsd",
    (1, 8): "1.8.0/OpenDRIVE_Core.xsd",
}

# Larger files are not checked against the schema of 1.8, bytes: xmlschema takes ten seconds and more for each MB.
_MOST_BYTES: Final = 2_000_000

# Larger files are not read as a tree, bytes: a choice.
_LARGEST_TREE: Final = 50_000_000
# Bytes that are read at once.
_CHUNK: Final = 1 << 18
# How lxml reads files: of any size, and nothing but the file.
_SAFE: Final[dict[str, Any]] = {"huge_tree": True, "resolve_entities": False, "no_network": True}

# Line of the file and what is wrong there.
Violation: TypeAlias = tuple[int, str]


def schema_violations(
    path: Path, revision: tuple[int, int], schema: Path | None
) -> tuple[tuple[Violation, ...], str | None]:
    """Return how a file violates its schema, and a note on why that was not checked, if so.

    The schema is by default that of the file's version in the package of ASAM's checker, if it is installed.

    Raises
    ------
    InputError
        The schema that was given cannot be used.
    """
    if str(path) == "-":
        return (), "the schema was not checked: standard input can be read only once"
    found = schema or _installed(revision)
    if found is None:
        version = ".".join(str(part) for part in revision)
        if importlib.util.find_spec(_PACKAGE) is None:
            return (), "the schema was not checked: give one with --schema, or pip install asam-qc-opendrive"
        return (), f"the schema was not checked: there is none for version {version}; give one with --schema"
    try:
        found.read_bytes()
    except OSError as error:
        raise InputError(
            f"cannot read the schema {found}: {(error.strerror or str(error)).lower()}; give its .xsd file"
        ) from error
    # Here, so that commands that check no schema start at once.
    from lxml import etree

    try:
        with _decimal_points():
            compiled = etree.XMLSchema(etree.parse(str(found)))
    except etree.LxmlError as error:
        # The schemas of 1.8 use XML Schema 1.1, which lxml does not read.
        if schema is None and path.stat().st_size > _MOST_BYTES:
            return (
                (),
                f"the schema was not checked: it takes long for a file of this size; --schema {found.name} does it",
            )
        return _by_xmlschema(_tree(path), found, str(error))
    with _decimal_points():
        # Only a tree has the lines of violations, but it takes twenty times the memory of the file.
        errors = _streamed(path, compiled)
        if not errors:
            return (), None
        if path.stat().st_size > _LARGEST_TREE:
            note = f"violations of the schema have no line in files of more than {_LARGEST_TREE / 1e6:.0f} MB"
            return tuple((0, _one_line(error)) for error in errors), note
        compiled.validate(_tree(path))
    log: Any = compiled.error_log
    return tuple((error.line, _one_line(error)) for error in log), None


@contextmanager
def _decimal_points() -> Iterator[None]:
    """Make the C library, which libxml2 uses, read decimal points: the surrounding program may have set commas."""
    before = locale.setlocale(locale.LC_NUMERIC)
    if locale.localeconv()["decimal_point"] == ".":
        yield
        return
    locale.setlocale(locale.LC_NUMERIC, "C")
    try:
        yield
    finally:
        locale.setlocale(locale.LC_NUMERIC, before)


def _installed(revision: tuple[int, int]) -> Path | None:
    """Return the schema of a version in the package of ASAM's checker."""
    spec = importlib.util.find_spec(_PACKAGE)
    if spec is None or spec.origin is None or revision not in _SCHEMAS:
        return None
    path = Path(spec.origin).parent / "schema" / _SCHEMAS[revision]
    return path if path.is_file() else None


def _module(name: str) -> Any:
    """Return an optional library, or None if it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


def _one_line(error: Any) -> str:
    return " ".join(error.message.split())


class _Nothing:
    """Takes what a parser of lxml finds, and keeps nothing of it."""

    def close(self) -> None:
        """End the document."""


def _streamed(path: Path, compiled: Any) -> list[Any]:
    """Return how a file violates a schema, without a tree of it, so that lines are not known."""
    from lxml import etree

    target: Any = _Nothing()
    parser: Any = etree.XMLParser(target=target, schema=compiled, **_SAFE)
    with path.open("rb") as file, suppress(etree.XMLSyntaxError):
        stream = xml_stream(file)
        while chunk := stream.read(_CHUNK):
            parser.feed(chunk)
        parser.close()
    return list(parser.feed_error_log)


def _tree(path: Path) -> Any:
    """Return a file as a tree of lxml."""
    from lxml import etree

    with path.open("rb") as file:
        return etree.parse(xml_stream(file), etree.XMLParser(**_SAFE), base_url="")


def _by_xmlschema(tree: Any, found: Path, refused: str) -> tuple[tuple[Violation, ...], str | None]:
    """Check with xmlschema, which reads XML Schema 1.1 as well."""
    library = _module("xmlschema")
    if library is None:
        return (), "the schema was not checked: install xmlschema, which reads XML Schema 1.1"
    try:
        schema = library.XMLSchema11(str(found))
    except (library.XMLSchemaException, SyntaxError) as error:
        raise InputError(f"{found} is not a usable XML schema ({refused}); give another with --schema") from error
    return tuple(
        (int(error.sourceline or 0), f"{error.path}: {' '.join(str(error.reason).split())}")
        for error in schema.iter_errors(tree)
    ), None
