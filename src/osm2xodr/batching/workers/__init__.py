"""Conversions spread over the cores of this machine or of a cluster."""

from __future__ import annotations

from osm2xodr.batching.workers.area_process import AreaJob, Outcome
from osm2xodr.batching.workers.dask_cluster import check_dask
from osm2xodr.batching.workers.pool import Workers, running

__all__ = ["AreaJob", "Outcome", "Workers", "check_dask", "running"]
