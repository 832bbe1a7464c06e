"""What ``convert`` is told by files: configs (``--config``) and reports of earlier runs (``--from-report``).

Both give values to options that the command line does not give.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import click
from click.core import ParameterSource

from osm2xodr.cli.options import PATH
from osm2xodr.conventions import Declaration
from osm2xodr.errors import InputError, OutputError
from osm2xodr.python_api import DECLARATIONS
from osm2xodr.system import label, parse_json

if TYPE_CHECKING:
    from osm2xodr.reporting import Written

_Values = dict[str, Any]

# Keys outside of tables, and those of the table of outputs with the parameters that they are.
_FILES: Final = ("area", "dem", "bbox", "polygon")
_OUTPUTS: Final = MappingProxyType(
    {
        "xodr": "output",
        "report-json": "report_json",
        "osm-issues": "osm_issues",
        "html": "html",
        "check": "check",
        "overwrite": "overwrite",
    }
)
_SWITCHES: Final = frozenset({"check", "overwrite"})
# What the result does not depend on.
_NO_MATTER: Final = frozenset({"jobs"})


def config_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --config and --from-report to a command."""
    for name, read, text in (
        ("--from-report", _read_report, "Repeat the run that --report-json wrote this file about, exactly."),
        ("--config", _read_config, "Take what is not given here from a file in TOML; docs/config.md describes it."),
    ):

        def take(context: click.Context, _: click.Parameter, path: Path | None, read: Any = read) -> Path | None:
            if path is None:
                return None
            if context.default_map:
                raise click.UsageError("--config and --from-report exclude each other; give one of them", context)
            context.default_map = read(path)
            return path

        command = click.option(name, type=PATH, metavar="FILE", is_eager=True, callback=take, help=text)(command)
    return command


def check_replay(report: Path, written: Written, context: click.Context) -> None:
    """Refuse a result that is not that of the run that is repeated, unless something else was asked for."""
    wanted = _parse_report(report)["output"].get("sha256")
    asked = ({"area", "dem"} | DECLARATIONS.keys()) - _NO_MATTER
    if any(context.get_parameter_source(name) is ParameterSource.COMMANDLINE for name in asked):
        return
    if wanted not in (None, written.sha256):
        raise OutputError(
            f"{label(written.path)} is not what {report} is about: the map, an elevation model or the version of"
            " osm2xodr has changed since; --report-json says what is found now"
        )


def _read_config(path: Path) -> _Values:
    """Return the values of options in a config; paths in it are relative to its folder."""
    from osm2xodr.batching import decoded, parse_toml, read_file, unknown_key

    document = parse_toml(path, decoded(path, read_file(path)))
    tables = {name: document.pop(name, {}) for name in ("options", "outputs")}
    for name, table in tables.items():
        if not isinstance(table, dict):
            raise InputError(f"{path}: {name} is not a table; write [{name}]")
    own = [name.replace("_", "-") for name in DECLARATIONS if name not in _FILES]
    for where, keys, known in (
        ("", document, (*_FILES, "options", "outputs")),
        (" [options]:", tables["options"], own),
        (" [outputs]:", tables["outputs"], tuple(_OUTPUTS)),
    ):
        for key in keys:
            if key not in known:
                raise InputError(f"{path}:{where} {unknown_key(key, known)}")
    out: _Values = {}
    for key in _FILES:
        if key in document:
            out[key] = _file_value(path, key, document[key])
    for key, value in tables["options"].items():
        name = key.replace("-", "_")
        out[name] = _option_value(path, key, value, DECLARATIONS[name])
    for key, value in tables["outputs"].items():
        if key in _SWITCHES and not isinstance(value, bool):
            raise InputError(f"{path}: [outputs]: {key} is {value!r}; write true or false")
        out[_OUTPUTS[key]] = value if key in _SWITCHES else _path(path, key, value)
    return out


def _file_value(path: Path, key: str, value: Any) -> Any:
    """Return the map, the elevation models, or the part of the map to convert."""
    if key == "bbox":
        if not isinstance(value, list):
            raise InputError(f"{path}: bbox is not a list; write such as bbox = [1.50, 42.50, 1.55, 42.55]")
        return ",".join(str(item) for item in value)
    if key == "dem":
        return [_path(path, key, item) for item in (value if isinstance(value, list) else [value])]
    return _path(path, key, value)


def _path(path: Path, key: str, value: Any) -> str:
    """Return a path, relative to the folder of the config."""
    if not isinstance(value, str) or not value:
        raise InputError(f'{path}: {key} is {value!r}, and no path; write such as {key} = "file"')
    return value if value == "-" else str(path.parent / value)


def _option_value(path: Path, key: str, value: Any, declared: Declaration) -> Any:
    """Return the value of an option as on the command line."""
    where = f"{path}: [options]: {key}"
    if declared.kind is bool:
        if not isinstance(value, bool):
            raise InputError(f"{where} is {value!r}; write true or false")
        return value
    if declared.kind is Path:
        return _path(path, key, value)
    if declared.metavar == "LIST" and isinstance(value, list):
        return ",".join(str(item) for item in value)
    if declared.metavar == "TABLE" and isinstance(value, Mapping):
        return ",".join(f"{name}={item}" for name, item in value.items())
    if declared.kind is int and not isinstance(value, int):
        raise InputError(f"{where} is {value!r}; write a whole number")
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise InputError(f"{where} is neither text nor a number; write it as after --{key}")
    return str(value)


def _parse_report(path: Path) -> dict[str, Any]:
    """Return what a report says; `InputError` if it is none."""
    from osm2xodr.batching import read_file

    try:
        document = parse_json(read_file(path))
        if isinstance(document["input"]["area"], str) and isinstance(document["output"]["file"], str):
            found: dict[str, Any] = document
            return found
    except (ValueError, LookupError, TypeError):
        pass
    raise InputError(f"{path} is not a report of convert; give the file that convert --report-json wrote")


def _read_report(path: Path) -> _Values:
    """Return the values of options in a report; paths in it are relative to where convert was started."""
    document = _parse_report(path)
    asked, made = document["input"], document["output"]
    values = {"area": asked["area"], "dem": asked.get("dem", []), "output": made["file"], "name": asked.get("name")}
    values["xodr_version"] = made.get("xodr_version")
    for name, declared in DECLARATIONS.items():
        if declared.negates and declared.negates in asked:
            values[name] = not asked[declared.negates]
        elif name in asked:
            values[name] = asked[name]
    # The side of the road is one value, and two flags.
    if values.get("left_hand") is False:
        values["right_hand"] = True
    return {name: value for name, value in values.items() if value is not None}
