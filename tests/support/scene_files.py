"""Real places that are converted in tests, and the conversion of each, once per session."""

from __future__ import annotations

import fcntl
import json
import os
import subprocess
import sys
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from osm_truth import OsmTruth, read_osm
from xodr_file import XodrFile, read_xodr

TESTS = Path(__file__).parents[1]
CONVERSION_TIMEOUT = 120.0


def _dispatched() -> str:
    """Return the features of processors that NumPy has code of its own for, and uses here."""
    try:
        from numpy._core import _multiarray_umath as umath
    except ImportError:
        from numpy.core import _multiarray_umath as umath  # type: ignore[no-redef]
    found: Any = umath
    return " ".join(name for name in found.__cpu_dispatch__ if found.__cpu_features__.get(name))


# What makes NumPy, linear algebra and the C library compute as on an old processor, without wide vectors and without
# multiplication and addition in one. Names of features that a C library does not know are ignored.
OLD_PROCESSOR = {
    "NPY_DISABLE_CPU_FEATURES": _dispatched(),
    "OPENBLAS_CORETYPE": "Nehalem",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-AVX2_Usable,-FMA,-FMA_Usable,-FMA4,-AVX512F,-AVX512VL",
}


@dataclass(frozen=True)
class Scene:
    """A folder with an OSM file and an elevation model."""

    name: str
    osm: Path
    dem: Path

    def __str__(self) -> str:
        return self.name


def _scene(folder: Path) -> Scene:
    osm, dem = sorted(folder.glob("*.osm*")), sorted(folder.glob("*.tif"))
    if len(osm) != 1 or len(dem) != 1 or not (folder / "SOURCES.md").is_file():
        raise ValueError(f"{folder} needs one OSM file, one DEM and a SOURCES.md")
    return Scene(folder.name, osm[0], dem[0])


def _folders(parent: Path) -> list[Path]:
    return sorted(p for p in parent.glob("*") if p.is_dir()) if parent.is_dir() else []


# A new folder in tests/scenes is a new test. They are small; the sample that users see is larger.
SMALL_SCENES = tuple(_scene(folder) for folder in _folders(TESTS / "scenes"))
SAMPLES = tuple(_scene(folder) for folder in _folders(TESTS.parent / "data" / "samples"))
SCENES = SMALL_SCENES + SAMPLES


def scene_named(name: str) -> Scene:
    """Return a scene; raise `KeyError` if there is none of the name."""
    return {scene.name: scene for scene in SCENES}[name]


@dataclass(frozen=True)
class Conversion:
    """A scene as the command line converts it."""

    scene: Scene
    path: Path
    report: dict[str, object]
    messages: str

    @cached_property
    def network(self) -> XodrFile:
        return read_xodr(self.path)

    @cached_property
    def osm(self) -> OsmTruth:
        return read_osm(self.scene.osm, self.network.georeference)


@dataclass
class Conversions:
    """Converts scenes on demand, each in each version only once, also where several processes run the tests."""

    folder: Path
    _done: dict[tuple[str, str, int], Conversion] = field(default_factory=dict)

    def of(self, scene: Scene, version: str = "1.7", jobs: int = 1) -> Conversion:
        """Return the conversion of a scene to a version of OpenDRIVE, by so many processes.

        Runs with another number of them also differ in what must not matter: the order of sets, the threads that
        linear algebra is told to use, and the kind of processor.
        """
        key = (scene.name, version, jobs)
        if key not in self._done:
            self._done[key] = self._convert(*key, scene)
        return self._done[key]

    def _convert(self, name: str, version: str, jobs: int, scene: Scene) -> Conversion:
        out = self.folder / f"{name}.{version}.{jobs}.xodr"
        report = out.with_suffix(".json")
        command = [
            sys.executable,
            "-m",
            "osm2xodr",
            "convert",
            str(scene.osm),
            "--dem",
            str(scene.dem),
            "-o",
            str(out),
        ]
        command += ["--name", name, "--xodr-version", version, "--report-json", str(report)]
        command += ["--jobs", str(jobs), "-v"]
        environment = {**os.environ, "PYTHONHASHSEED": str(jobs), "OPENBLAS_NUM_THREADS": str(jobs)}
        if jobs > 1:
            environment |= OLD_PROCESSOR
        messages = out.with_suffix(".txt")
        with out.with_suffix(".lock").open("w") as lock:
            # Processes of tests share the folder: the first one converts, others wait for it.
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not messages.exists():
                done = subprocess.run(
                    command,
                    capture_output=True,
                    text=True,
                    timeout=CONVERSION_TIMEOUT,
                    env=environment,
                    check=False,
                )
                if done.returncode:
                    raise AssertionError(f"{' '.join(command)}\nends with {done.returncode}:\n{done.stderr}")
                messages.write_text(done.stderr, encoding="utf-8")
        report_read = json.loads(report.read_text(encoding="utf-8"))
        return Conversion(scene, out, report_read, messages.read_text(encoding="utf-8"))
