"""Reads OpenDRIVE 1.4 to 1.8 of any writer into tables, strictly: what is wrong is reported, never repaired."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from osm2xodr.opendrive.reader.roads import first_index

if TYPE_CHECKING:
    from osm2xodr.opendrive.tables import OpenDrive

__all__ = ["first_index", "read_xodr"]


def read_xodr(path: Path) -> OpenDrive:
    """Read a file of OpenDRIVE.

    Numbers that are missing or unreadable become NaN, references to what is not in the file `ABSENT`; each becomes a
    `Misfit` with the line of the file. Where ids are used twice, references lead to the first of them. Records of
    one owner stand in ascending s (lanes from left to right), whatever their order in the file.

    Parameters
    ----------
    path
        The file, plain or compressed by gzip; ``-`` is standard input.

    Raises
    ------
    InputError
        If it cannot be read, is not XML, or is not OpenDRIVE.
    """
    # Imported here so that the command line starts without numpy.
    from osm2xodr.opendrive.reader.document import read_document

    return read_document(path)
