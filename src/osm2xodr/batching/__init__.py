"""Batches: lists of areas, areas cut out of one map, conversions spread over processes, and a summary."""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.batching.areas import (
        PlannedArea as PlannedArea,
        frame_around as frame_around,
        keep_bounds as keep_bounds,
        make_tiles as make_tiles,
        outlined as outlined,
        parse_length as parse_length,
        read_areas as read_areas,
        read_file as read_file,
        read_partition as read_partition,
        read_polygons as read_polygons,
        recall_bounds as recall_bounds,
    )
    from osm2xodr.batching.cutting import bounds_of as bounds_of, cut_areas as cut_areas
    from osm2xodr.batching.manifest import (
        ManifestContext as ManifestContext,
        decoded as decoded,
        parse_toml as parse_toml,
        read_manifest as read_manifest,
        unknown_key as unknown_key,
    )
    from osm2xodr.batching.model import (
        EMPTY as EMPTY,
        Area as Area,
        CutRequest as CutRequest,
        Result as Result,
        Status as Status,
    )
    from osm2xodr.batching.out_dir import open_out_dir as open_out_dir
    from osm2xodr.batching.summary import write_summary as write_summary
    from osm2xodr.batching.workers import Workers as Workers, check_dask as check_dask
    from osm2xodr.batching.workflow import (
        BatchOptions as BatchOptions,
        Listener as Listener,
        run_batch as run_batch,
    )

__getattr__ = lazy_exports(
    __name__,
    {
        "areas": (
            "PlannedArea",
            "frame_around",
            "keep_bounds",
            "make_tiles",
            "outlined",
            "parse_length",
            "read_areas",
            "read_file",
            "read_partition",
            "read_polygons",
            "recall_bounds",
        ),
        "cutting": ("bounds_of", "cut_areas"),
        "summary": ("write_summary",),
        "manifest": ("ManifestContext", "decoded", "parse_toml", "read_manifest", "unknown_key"),
        "model": ("EMPTY", "Area", "CutRequest", "Result", "Status"),
        "out_dir": ("open_out_dir",),
        "workers": ("Workers", "check_dask"),
        "workflow": ("BatchOptions", "Listener", "run_batch"),
    },
)
