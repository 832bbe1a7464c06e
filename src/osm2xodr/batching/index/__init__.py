"""The summary of a batch: a table, and a page with a map."""

from __future__ import annotations

from osm2xodr.batching.index.summary import write_summary
from osm2xodr.batching.index.thumbnails import thumbnail

__all__ = ["thumbnail", "write_summary"]
