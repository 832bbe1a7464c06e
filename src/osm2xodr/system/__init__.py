"""What is asked of the operating system: files, processes, threads, memory, standard streams."""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system.lazy import lazy_exports as lazy_exports

if TYPE_CHECKING:
    from osm2xodr.system.files import (
        FILES_KEY as FILES_KEY,
        STANDARD_OUTPUT as STANDARD_OUTPUT,
        ByteSink as ByteSink,
        appended as appended,
        atomic_folder as atomic_folder,
        check_folder as check_folder,
        check_target as check_target,
        complete as complete,
        label as label,
        lock as lock,
        make_folder as make_folder,
        parse_json as parse_json,
        remove_made as remove_made,
        settle as settle,
        silence_standard_output as silence_standard_output,
        stream_to as stream_to,
    )
    from osm2xodr.system.libraries import (
        DATA_OF_OTHERS as DATA_OF_OTHERS,
        RASTER_DRIVERS as RASTER_DRIVERS,
        VIRTUAL_DRIVER as VIRTUAL_DRIVER,
        gdal as gdal,
        library_environment as library_environment,
        one_thread as one_thread,
        own_process as own_process,
        raster_errors as raster_errors,
    )
    from osm2xodr.system.limits import (
        ENDING_SIGNALS as ENDING_SIGNALS,
        LEAST_MEMORY as LEAST_MEMORY,
        LimitError as LimitError,
        TimeLimitError as TimeLimitError,
        available_memory as available_memory,
        limited as limited,
        parse_duration as parse_duration,
        parse_memory as parse_memory,
        release_memory as release_memory,
        uninterrupted as uninterrupted,
    )
    from osm2xodr.system.parallel import Task as Task, available_jobs as available_jobs, map_parallel as map_parallel
    from osm2xodr.system.records import record as record
    from osm2xodr.system.streams import (
        Progress as Progress,
        advance as advance,
        occupy_closed_streams as occupy_closed_streams,
        patient_standard_error as patient_standard_error,
        shown as shown,
        stage as stage,
        time_left as time_left,
    )
    from osm2xodr.system.texts import is_page as is_page, plain_text as plain_text, xml_stream as xml_stream

__getattr__ = lazy_exports(
    __name__,
    {
        "files": (
            "FILES_KEY",
            "STANDARD_OUTPUT",
            "ByteSink",
            "appended",
            "atomic_folder",
            "check_folder",
            "check_target",
            "complete",
            "label",
            "lock",
            "make_folder",
            "parse_json",
            "remove_made",
            "settle",
            "silence_standard_output",
            "stream_to",
        ),
        "libraries": (
            "DATA_OF_OTHERS",
            "RASTER_DRIVERS",
            "VIRTUAL_DRIVER",
            "gdal",
            "library_environment",
            "one_thread",
            "own_process",
            "raster_errors",
        ),
        "limits": (
            "ENDING_SIGNALS",
            "LEAST_MEMORY",
            "LimitError",
            "TimeLimitError",
            "available_memory",
            "limited",
            "parse_duration",
            "parse_memory",
            "release_memory",
            "uninterrupted",
        ),
        "texts": ("is_page", "plain_text", "xml_stream"),
        "parallel": ("Task", "available_jobs", "map_parallel"),
        "records": ("record",),
        "streams": (
            "Progress",
            "advance",
            "occupy_closed_streams",
            "patient_standard_error",
            "shown",
            "stage",
            "time_left",
        ),
    },
)
