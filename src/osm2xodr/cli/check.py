"""The commands ``check``, which finds defects of an OpenDRIVE file, and ``explain``, which says what they mean."""

from __future__ import annotations

import difflib
import shlex
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from osm2xodr import defaults
from osm2xodr.cli.options import PATH, check_targets, limit_options, overwrite_option
from osm2xodr.system import STANDARD_OUTPUT, Progress, label, shown, stream_to

if TYPE_CHECKING:
    from osm2xodr.checking import CheckResult


# `osm2xodr.checking.FORMATS`, `READERS`, `DEFAULT_READERS` and the words of `Severity`, which are too slow to load
# for --help; a test holds them equal.
FORMATS = ("text", "json", "sarif", "junit", "github")
READERS = ("carla", "esmini", "sumo", "libopendrive", "roadrunner")
DEFAULT_READERS = "carla,esmini,sumo"
SUMO = "sumo"
SEVERITIES = ("error", "warning", "info")
# For --for: the standard alone.
STANDARD_ONLY = "standard"

CLEAN, FINDINGS = 0, 1
# What share of the time each stage takes, s for a file of 200 MB.
_PLAN = (("reading", 23.0), ("checking the schema", 6.0), ("checking roads", 19.0))

# Width of the text, characters.
_WIDTH = 100


def _list_rules(context: click.Context) -> None:
    """Print all rules, and end."""
    from osm2xodr.checking import RULES

    widest = max(map(len, RULES))
    for name, rule in RULES.items():
        click.echo(f"{name:<{widest}}  {rule.severity.word:<7}  {rule.meaning}")
    context.exit()


@click.command(
    short_help="Check an OpenDRIVE file.",
    epilog="""\b
Examples:
  osm2xodr check area.xodr
  osm2xodr check area.xodr --for carla --fail-on error
  osm2xodr check area.xodr --format sarif -o area.sarif --ignore overlap
  osm2xodr check out/*.xodr --format github

osm2xodr explain RULE says more about one of them.

Exit status: 0 nothing found, 1 findings (see --fail-on) or cannot check, 2 wrong usage, 130 interrupted.""",
)
@click.argument("files", nargs=-1, required=True, type=PATH)
@click.option(
    "--list-rules",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=lambda context, _, wanted: _list_rules(context) if wanted else None,
    help="List all rules and what each finds.",
)
@click.option(
    "--for",
    "readers",
    default=DEFAULT_READERS,
    show_default=True,
    metavar="LIST",
    help=f"Readers that must be able to use the file: {', '.join(READERS)}; {STANDARD_ONLY} for none of them.",
)
@click.option(
    "--schema",
    type=PATH,
    metavar="XSD",
    help="XML schema of OpenDRIVE.  [default: that of asam-qc-opendrive, if installed]",
)
@click.option("--only", multiple=True, metavar="RULE", help="Look at this rule only. May be repeated.")
@click.option("--ignore", multiple=True, metavar="RULE", help="Leave this rule out. May be repeated.")
@click.option(
    "--max-findings",
    type=click.IntRange(min=0),
    default=defaults.CHECK_FINDINGS,
    show_default=True,
    metavar="N",
    help="Findings listed for each rule, the worst; all are counted.",
)
@click.option(
    "--fail-on",
    type=click.Choice(SEVERITIES),
    default="warning",
    show_default=True,
    help="Least severity of findings that make the exit status 1.",
)
@click.option(
    "--format", "form", type=click.Choice(FORMATS), default="text", show_default=True, help="Format of the result."
)
@click.option(
    "-o",
    "--output",
    type=PATH,
    default=STANDARD_OUTPUT,
    metavar="FILE",
    help="File to write.  [default: standard output]",
)
@overwrite_option
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but the result.")
@limit_options
def check(
    files: tuple[Path, ...],
    readers: str,
    fail_on: str,
    form: str,
    output: Path,
    overwrite: bool,
    quiet: bool,
    **how: Any,
) -> int:
    """Check FILES, OpenDRIVE 1.4 to 1.8 of any writer, against the standard and what its readers stumble over."""
    inputs = files if how["schema"] is None else (*files, how["schema"])
    check_targets([("-o", output)], inputs, overwrite=overwrite)
    from osm2xodr.checking import FORMATS as WRITERS, Severity
    from osm2xodr.python_api import check as run

    wanted = [word for word in readers.split(",") if word.strip() != STANDARD_ONLY]
    results = []
    for file in files:
        with shown(Progress(sys.stderr, quiet=quiet, plan=_PLAN)):
            results.append(run(file, readers=wanted, **how))
    least = Severity[fail_on.upper()]
    with stream_to(output) as stream:
        stream.write(WRITERS[form](results, least).encode("utf-8", "replace"))
    if output != STANDARD_OUTPUT and not quiet:
        for result in results:
            click.echo(f"osm2xodr: {result.headline()}", err=True)
        click.echo(f"osm2xodr: wrote {label(output)}", err=True)
    asked = click.get_current_context().get_parameter_source("readers") is not ParameterSource.DEFAULT
    for file, result in zip(files, results, strict=True) if asked and not quiet and SUMO in wanted else ():
        if command := _load_command(file, result):
            click.echo(f"osm2xodr: SUMO loads it with: {command}", err=True)
    return FINDINGS if any(result.failed(least) for result in results) else CLEAN


def _load_command(file: Path, result: CheckResult) -> str:
    """Return the command that imports a file into SUMO; empty where none reads it right, or that is not known."""
    from osm2xodr.conventions import TARGETS, programmes_file

    ignored, negated = "left-hand-ignored", "left-hand-negated"
    found = result.by_rule()
    if ignored in found or not {ignored, negated} <= result.rules:
        return ""
    path, lights = shlex.quote(str(file)), programmes_file(file).exists()
    return TARGETS[SUMO].load_command(path, left_hand=negated in found, programmes=lights)


@click.command(
    short_help="Say what a diagnostic or a rule of check means.",
    epilog="""\b
Examples:
  osm2xodr explain clearance
  osm2xodr explain lane-count link-kink
  osm2xodr check --list-rules

docs/diagnostics.md lists all diagnostics, docs/check.md all rules.

Exit status: 0 explained, 2 unknown code, 130 interrupted.""",
)
@click.argument("code", nargs=-1, required=True)
def explain(code: tuple[str, ...]) -> None:
    """Say what CODE means and what to do: of a diagnostic, as convert reports it, or a rule of check."""
    text = "\n".join(block for name in code for block in _blocks(name.strip().lower()))
    with stream_to(STANDARD_OUTPUT) as stream:
        stream.write(text.encode())


def _blocks(name: str) -> Iterator[str]:
    """Yield what there is to say about a name."""
    from osm2xodr.checking import RULES
    from osm2xodr.reporting import codes

    known, rule = codes().get(name), RULES.get(name)
    if known is None and rule is None:
        near = difflib.get_close_matches(name, [*codes(), *RULES], 1)
        hint = f"do you mean {near[0]}?" if near else "osm2xodr check --list-rules lists rules"
        raise click.UsageError(f"{name!r} is no diagnostic and no rule of check; {hint}")
    if known is not None:
        kinds = ", ".join(kind.value for kind in known.kinds)
        sentences = [known.meaning, f"What to do: {known.remedy}"]
        if known.correction:
            sentences.append(f"Line for --corrections: {known.line_for('node/ID' if name == 'ele' else 'way/ID')}")
        yield _block(f"{name} (diagnostic of convert: {kinds})", sentences)
    if rule is not None:
        who = ", ".join(rule.readers) or "the standard"
        impact = [f"Who is affected: {who}{f': {rule.impact}' if rule.impact else ''}"]
        what = f"{name} (rule of check: {rule.severity.word})"
        yield _block(what, [rule.meaning, *impact, f"What to do: {rule.remedy}"])


def _block(head: str, paragraphs: list[str]) -> str:
    lines = [textwrap.fill(text, _WIDTH, initial_indent="  ", subsequent_indent="  ") for text in paragraphs]
    return "\n".join([head, *lines]) + "\n"
