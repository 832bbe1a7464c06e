"""The summary of a batch: a table, and a page with a map."""

from __future__ import annotations

from osm2xodr.batch.index.summary import write_summary

__all__ = ["write_summary"]
