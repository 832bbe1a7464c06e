"""Reads OpenDRIVE 1.4 to 1.8 of any writer into tables, strictly: what is wrong is reported, never repaired."""

from __future__ import annotations

from osm2xodr.opendrive.reader.document import read_xodr as read_xodr, tables_of as tables_of
from osm2xodr.opendrive.reader.roads import first_index as first_index
