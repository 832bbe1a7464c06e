"""osm2xodr as a library: what ``import osm2xodr`` gives, and what the commands of the command line call."""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.python_api.converting import (
        Conversion as Conversion,
        changed_options as changed_options,
        convert as convert,
        pipeline_options as pipeline_options,
    )
    from osm2xodr.python_api.exports import (
        CARLA_TILE as CARLA_TILE,
        EXPORT_FORMATS as EXPORT_FORMATS,
        EXPORT_LAYERS as EXPORT_LAYERS,
        EXPORT_PROJECTORS as EXPORT_PROJECTORS,
        SCENE_FORMATS as SCENE_FORMATS,
        SCENE_TILE as SCENE_TILE,
        export as export,
        export_format as export_format,
        export_scene as export_scene,
        materials_file as materials_file,
        projector_file as projector_file,
    )
    from osm2xodr.python_api.fetches import fetch as fetch
    from osm2xodr.python_api.files import (
        PICTURE_FORMATS as PICTURE_FORMATS,
        RENDER_WIDTH_LEAST as RENDER_WIDTH_LEAST,
        check as check,
        locate as locate,
        render as render,
        report as report,
    )
    from osm2xodr.python_api.inputs import (
        AreaMap as AreaMap,
        area_map as area_map,
        read_corrections as read_corrections,
    )
    from osm2xodr.python_api.keywords import AreaKeywords as AreaKeywords, ConvertKeywords as ConvertKeywords
    from osm2xodr.python_api.network import RoadNetwork as RoadNetwork, read as read
    from osm2xodr.python_api.nouns import (
        Connection as Connection,
        Elements as Elements,
        Junction as Junction,
        Lane as Lane,
        Link as Link,
        Road as Road,
        Signal as Signal,
    )
    from osm2xodr.python_api.options import (
        DECLARATIONS as DECLARATIONS,
        ConvertOptions as ConvertOptions,
    )
    from osm2xodr.python_api.parts import clipping as clipping, crop as crop, merge as merge

__getattr__ = lazy_exports(
    __name__,
    {
        "inputs": ("AreaMap", "area_map", "read_corrections"),
        "converting": ("Conversion", "changed_options", "convert", "pipeline_options"),
        "exports": (
            "CARLA_TILE",
            "EXPORT_FORMATS",
            "EXPORT_LAYERS",
            "EXPORT_PROJECTORS",
            "SCENE_FORMATS",
            "SCENE_TILE",
            "export",
            "export_format",
            "export_scene",
            "materials_file",
            "projector_file",
        ),
        "fetches": ("fetch",),
        "files": ("PICTURE_FORMATS", "RENDER_WIDTH_LEAST", "check", "locate", "render", "report"),
        "keywords": ("AreaKeywords", "ConvertKeywords"),
        "network": ("RoadNetwork", "read"),
        "nouns": ("Connection", "Elements", "Junction", "Lane", "Link", "Road", "Signal"),
        "parts": ("clipping", "crop", "merge"),
        "options": ("DECLARATIONS", "ConvertOptions"),
    },
)
