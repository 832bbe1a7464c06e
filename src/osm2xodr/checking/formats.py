"""Results of checks as text, JSON, SARIF, JUnit and annotations of GitHub; of one file or of several."""

from __future__ import annotations

import dataclasses
import json
import os
import re
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Final
from urllib.parse import quote
from xml.etree import ElementTree

from osm2xodr import __version__
from osm2xodr.checking.checker import CheckResult, place
from osm2xodr.checking.findings import RULES, Finding, Severity
from osm2xodr.diagnostics import counted

# XML 1.0, production 2.
_NOT_IN_XML: Final = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_SARIF_LEVELS: Final = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "note"}
_GITHUB_COMMANDS: Final = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "notice"}


def as_text(results: Sequence[CheckResult], fail_on: Severity) -> str:
    """Return results for people."""
    del fail_on
    return "\n".join("\n".join(result.lines()) + "\n" for result in results)


def as_json(results: Sequence[CheckResult], fail_on: Severity) -> str:
    """Return the result of one file as JSON, those of several as a list."""
    documents = [_document(result, fail_on) for result in results]
    return json.dumps(documents[0] if len(documents) == 1 else documents, indent=1, ensure_ascii=False) + "\n"


def _document(result: CheckResult, fail_on: Severity) -> dict[str, Any]:
    roads, junctions, length = result.size
    return {
        "osm2xodr": __version__,
        "file": str(result.path),
        "version": result.version,
        "roads": roads,
        "junctions": junctions,
        "reference_km": round(length, 6),
        "readers": list(result.readers),
        "failed": result.failed(fail_on),
        "errors": result.count(Severity.ERROR),
        "warnings": result.count(Severity.WARNING),
        "notes": result.count(Severity.INFO),
        "counts": [
            {"rule": item.rule, "severity": item.severity.word, "findings": item.findings} for item in result.counts
        ],
        "findings": [_finding(item) for item in result.findings],
        "not_checked": list(result.notes),
    }


def _finding(finding: Finding) -> dict[str, Any]:
    """Return a finding's fields."""
    fields = {item.name: getattr(finding, item.name) for item in dataclasses.fields(finding)}
    words = {"severity": finding.severity.word, "unit": RULES[finding.rule].unit}
    return {**fields, **words, "readers": list(finding.readers)}


def as_sarif(results: Sequence[CheckResult], fail_on: Severity) -> str:
    """Return results as SARIF 2.1.0 (OASIS), which code hosts show beside files: a run for each file."""
    del fail_on
    document = {
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [_run(result) for result in results],
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def _run(result: CheckResult) -> dict[str, Any]:
    names = sorted({item.rule for item in result.findings})
    rules = [
        {
            "id": name,
            "shortDescription": {"text": RULES[name].meaning},
            "help": {"text": RULES[name].remedy},
            "defaultConfiguration": {"level": _SARIF_LEVELS[RULES[name].severity]},
        }
        for name in names
    ]
    return {
        "tool": {"driver": {"name": "osm2xodr", "version": __version__, "rules": rules}},
        "results": [_sarif_result(result, item, names.index(item.rule)) for item in result.findings],
        "properties": {"counts": result.by_rule(), "notChecked": list(result.notes)},
    }


def _sarif_result(result: CheckResult, finding: Finding, rule: int) -> dict[str, Any]:
    """Return a finding as a result of SARIF."""
    location: dict[str, Any] = {
        "physicalLocation": {
            "artifactLocation": {"uri": quote(os.fsencode(result.path.as_posix()))},
            # SARIF counts lines from 1.
            "region": {"startLine": max(finding.line, 1)},
        },
    }
    if finding.road:
        lane = "" if finding.lane is None else f"/lane/{finding.lane}"
        location["logicalLocations"] = [{"fullyQualifiedName": f"road/{finding.road}{lane}"}]
    fields = _finding(finding)
    properties = {name: fields[name] for name in ("s", "x", "y", "lat", "lon", "value", "limit", "unit", "readers")}
    return {
        "ruleId": finding.rule,
        "ruleIndex": rule,
        "level": _SARIF_LEVELS[finding.severity],
        "message": {"text": f"{place(finding)}: {finding.text}"},
        "locations": [location],
        "properties": {name: value for name, value in properties.items() if value is not None},
    }


def as_junit(results: Sequence[CheckResult], fail_on: Severity) -> str:
    """Return results as JUnit XML: each rule is a test, which fails if it has findings of a severity or worse."""
    root = ElementTree.Element("testsuites")
    root.extend(_suite(result, fail_on) for result in results)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _suite(result: CheckResult, fail_on: Severity) -> ElementTree.Element:
    failing = {item.rule for item in result.counts if item.severity >= fail_on}
    counts = result.by_rule()
    suite = ElementTree.Element(
        "testsuite",
        name=_printable(f"osm2xodr check {result.path}"),
        tests=str(len(result.rules)),
        failures=str(len(failing)),
    )
    for name in sorted(result.rules):
        case = ElementTree.SubElement(suite, "testcase", classname="osm2xodr.check", name=name)
        if name not in counts:
            continue
        text = "\n".join(f"{place(item)}: {item.text}" for item in result.findings if item.rule == name)
        tag = "failure" if name in failing else "system-out"
        element = ElementTree.SubElement(case, tag)
        if name in failing:
            element.set("message", f"{counted(counts[name], 'finding')}: {RULES[name].meaning}")
        element.text = _printable(text)
    return suite


def as_github(results: Sequence[CheckResult], fail_on: Severity) -> str:
    """Return findings as annotations that a workflow of GitHub shows (its documentation: Workflow commands)."""
    del fail_on
    lines = []
    for result in results:
        for item in result.findings:
            where = (
                f"file={_escaped(str(result.path), ':,')},line={max(item.line, 1)},title={_escaped(item.rule, ':,')}"
            )
            text = _escaped(f"{place(item)}: {item.text}")
            lines.append(f"::{_GITHUB_COMMANDS[item.severity]} {where}::{text}\n")
        lines.append(f"{_escaped(result.headline())}\n")
    return "".join(lines)


def _escaped(text: str, more: str = "") -> str:
    """Return text with what has a meaning in commands of workflows escaped."""
    return "".join(f"%{ord(letter):02X}" if letter in f"%\r\n{more}" else letter for letter in text)


def _printable(text: str) -> str:
    """Return text with the replacement character for those that XML 1.0 does not allow."""
    return _NOT_IN_XML.sub("\ufffd", text)


FORMATS: Final[Mapping[str, Callable[[Sequence[CheckResult], Severity], str]]] = MappingProxyType(
    {"text": as_text, "json": as_json, "sarif": as_sarif, "junit": as_junit, "github": as_github}
)
