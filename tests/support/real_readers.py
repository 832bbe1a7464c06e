"""Runs the programs that users load OpenDRIVE files into, each in a process of its own: a crash is an answer."""

from __future__ import annotations

import importlib.util
import json
import os
import platform
import signal
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import xmlschema
from lxml import etree

READER_TIMEOUT = 120.0

# Where pyproject.toml installs all real readers of OpenDRIVE, unless they are left out on purpose (make test-oldest).
ALL_READERS = (
    sys.version_info < (3, 13)
    and sys.platform == "linux"
    and platform.machine() == "x86_64"
    and "WITHOUT_READERS" not in os.environ
)


def need(module: str, distribution: str) -> None:
    """Fail the test where a reader is not installed: without it nothing is known about the file.

    Skip it where there is none to install.
    """
    if importlib.util.find_spec(module) is None:
        if not ALL_READERS:
            pytest.skip(f"{distribution} has no packages here")
        pytest.fail(
            f"{distribution} is not installed, so the file cannot be tried in it; "
            "install what the tests need with: pip install -e '.[test]'",
            pytrace=False,
        )


def run_reader(command: list[str], **options: Any) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        command, capture_output=True, text=True, errors="replace", timeout=READER_TIMEOUT, check=False, **options
    )
    if done.returncode < 0:
        pytest.fail(f"{command[0]} crashes with {signal.Signals(-done.returncode).name}:\n{done.stderr[-2000:]}")
    return done


# ---------------------------------------------------------------- CARLA


def carla_answers(path: Path) -> dict[str, Any]:
    """Load a file into the CARLA client's map and return what it sees (see `carla_probe`)."""
    need("carla", "the CARLA client (carla)")
    done = run_reader([sys.executable, str(Path(__file__).with_name("carla_probe.py")), str(path)])
    if done.returncode:
        pytest.fail(f"CARLA does not load {path.name}:\n{(done.stderr + done.stdout)[-2000:]}")
    answers: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answers


# ---------------------------------------------------------------- SUMO


@dataclass(frozen=True)
class SumoNet:
    """What netconvert makes of a file: exit status, its messages, and the lanes for cars outside of junctions.

    `lights` are the ids of its traffic lights, with the number of connections that each controls.
    """

    exit_status: int
    errors: list[str]
    warnings: Counter[str]
    edges: int
    lane_km: float
    lights: dict[str, int]


def run_sumo(program: str, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Run one of SUMO's programs."""
    need("sumo", "SUMO (eclipse-sumo)")
    # Not imported: the package points PROJ at its own data for the whole process.
    spec = importlib.util.find_spec("sumo")
    assert spec is not None
    assert spec.origin is not None
    home = Path(spec.origin).parent
    command = [str(home / "bin" / program), *map(str, arguments)]
    return run_reader(command, env={**os.environ, "SUMO_HOME": str(home), "PROJ_DATA": str(home / "data" / "proj")})


def sumo_net(path: Path, folder: Path, *options: str) -> SumoNet:
    """Import a file with netconvert, which writes NAME.net.xml into the folder."""
    net = folder / f"{path.stem}.net.xml"
    quiet = ("--xml-validation", "never", "--aggregate-warnings", "-1", "--output.street-names", "false")
    done = run_sumo("netconvert", "--opendrive-files", path, "-o", net, *quiet, *options)
    lines = (done.stderr + done.stdout).splitlines()
    edges, lane_m = 0, 0.0
    lights: dict[str, int] = {}
    if net.exists():
        root = etree.parse(str(net)).getroot()
        lights = {str(item.get("id")): 0 for item in root.iterfind("tlLogic")}
        for item in root.iterfind("connection[@tl]"):
            lights[str(item.attrib["tl"])] += 1
        for edge in root.iterfind("edge"):
            lanes = [float(e.attrib["length"]) for e in edge.iterfind("lane") if _for_cars(e)]
            if edge.get("function") is None and lanes:
                edges += 1
                lane_m += sum(lanes)
    return SumoNet(
        done.returncode,
        [line for line in lines if line.startswith("Error")],
        Counter(
            " ".join(w for w in line.split() if not any(c in w for c in "0123456789'"))
            for line in lines
            if line.startswith("Warning")
        ),
        edges,
        lane_m / 1000,
        lights,
    )


def _for_cars(lane: etree._Element) -> bool:
    allow, disallow = lane.get("allow"), lane.get("disallow", "").split()
    return (
        ("passenger" in allow.split() or allow == "all")
        if allow is not None
        else not {"passenger", "all"} & set(disallow)
    )


# ---------------------------------------------------------------- ASAM


SCHEMA = {
    "1.4": "1.4/OpenDRIVE_1.4H.xsd",
    "1.6": "1.6.1/opendrive_16_core.xsd",
    "1.7": "1.7.0/opendrive_17_core.xsd",
    "1.8": "1.8.0/OpenDRIVE_Core.xsd",
}


@cache
def _schema(version: str) -> Any:
    need("qc_opendrive", "the ASAM checker (asam-qc-opendrive)")
    import qc_opendrive

    path = str(Path(qc_opendrive.__file__).parent / "schema" / SCHEMA[version])
    # 1.8 is XSD 1.1, which lxml does not know
    return xmlschema.XMLSchema11(path) if version == "1.8" else etree.XMLSchema(etree.parse(path))


def schema_errors(path: Path, version: str) -> list[str]:
    """Return what the schema of a version finds in a file."""
    schema = _schema(version)
    if version == "1.8":
        return [f"{error.path}: {error.reason}" for error in schema.iter_errors(str(path))]
    schema.validate(etree.parse(str(path), etree.XMLParser(huge_tree=True)))
    return [f"line {error.line}: {error.message}" for error in schema.error_log]


@dataclass(frozen=True)
class QcResult:
    """Issues of the ASAM checker bundle, and the checkers by the status that they ended with."""

    issues: list[str]
    checkers: dict[str, list[str]]


def qc_result(path: Path, folder: Path) -> QcResult:
    """Run the checker bundle of ASAM on a file."""
    need("qc_opendrive", "the ASAM checker (asam-qc-opendrive)")
    result, config = folder / f"{path.stem}.xqar", folder / f"{path.stem}.qc.xml"
    root = etree.Element("Config")
    etree.SubElement(root, "Param", name="InputFile", value=str(path))
    bundle = etree.SubElement(root, "CheckerBundle", application="xodrBundle")
    etree.SubElement(bundle, "Param", name="resultFile", value=str(result))
    config.write_bytes(etree.tostring(root))
    done = run_reader([sys.executable, "-m", "qc_opendrive.main", "-c", str(config)], cwd=folder)
    if not result.exists():
        pytest.fail(f"the ASAM checker writes no result for {path.name}:\n{done.stderr[-2000:]}")
    found = etree.parse(str(result)).getroot()
    issues = [f"{e.get('ruleUID')}: {e.get('description')}" for e in found.iter("Issue")]
    checkers: dict[str, list[str]] = {}
    for e in found.iter("Checker"):
        checkers.setdefault(str(e.get("status")), []).append(str(e.get("checkerId")))
    return QcResult(issues, checkers)
