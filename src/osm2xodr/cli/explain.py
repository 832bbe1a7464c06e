"""The command ``explain``: what a diagnostic or a rule of ``check`` means."""

from __future__ import annotations

import difflib
import textwrap
from collections.abc import Iterator

import click

from osm2xodr.system import STANDARD_OUTPUT, stream_to

# Width of the text, characters.
_WIDTH = 100


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
