"""Whom a file owes its data, as its header says."""

from __future__ import annotations

from osm2xodr.opendrive import OpenDrive

_WORD = "attribution"


def credits_of(file: OpenDrive) -> str:
    """Return all attributions in ``userData`` of the header, each once; empty without any.

    They are those whose code contains the word, so that data of several sources may each have one.
    """
    found = [value.strip() for (road, code), value in file.provenance.items() if road == -1 and _WORD in code.lower()]
    return "; ".join(dict.fromkeys(value for value in found if value))
