"""Documents of OpenDRIVE as trees that keep what they do not understand."""

from __future__ import annotations

from pathlib import Path

from lxml import etree

from osm2xodr.crop_and_merge.records import Element
from osm2xodr.errors import InputError
from osm2xodr.system import ByteSink, xml_stream


def read_tree(path: Path) -> Element:
    """Return the root of a file that was read before, plain or packed by gzip, as it is."""
    try:
        parser = etree.XMLParser(huge_tree=True, resolve_entities=False, no_network=True, remove_blank_text=True)
        with path.open("rb") as stream:
            # The address is one that is always UTF-8, which names of files need not be.
            root = etree.parse(xml_stream(stream), parser, base_url="").getroot()
    except (OSError, EOFError, etree.XMLSyntaxError) as error:
        raise InputError(f"cannot read {path}: {error}; give a file of OpenDRIVE") from error
    if "}" in root.tag:
        raise InputError(f"{path} has a namespace, which OpenDRIVE does not have; remove it")
    return root


def write_tree(root: Element, stream: ByteSink) -> None:
    """Write a document with one element per line."""
    tree = root.getroottree()
    etree.indent(tree, " ")
    stream.write(etree.tostring(tree, xml_declaration=True, encoding="UTF-8"))
    stream.write(b"\n")
