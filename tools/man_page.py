"""Makes the manual page docs/osm2xodr.1 of the program's own help: ``tools/man_page.py``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click

from osm2xodr.cli.program import cli

TARGET = Path(__file__).parents[1] / "docs" / "osm2xodr.1"

_HEAD = """\
.\\" Made by tools/man_page.py of the program's help; a test holds them equal.
.TH OSM2XODR 1 "" osm2xodr "User Commands"
.SH NAME
osm2xodr \\- OpenStreetMap and elevation models to OpenDRIVE road networks
.SH SYNOPSIS
.B osm2xodr
.I command
.RI [ options ]
"""


def page() -> str:
    """Return the page."""
    parts = [_HEAD, ".SH DESCRIPTION\n", _text(cli.help or ""), ".SH COMMANDS\n"]
    program = click.Context(cli, info_name="osm2xodr", **cli.context_settings)
    for name, command in cli.commands.items():
        with click.Context(command, program, name) as context:
            parts += _command(name, command, context)
    parts += [
        ".SH EXIT STATUS\n",
        _text("0 done, 1 cannot be done, 2 wrong usage, 130 interrupted, 143 ended by the system."),
    ]
    return "".join(parts)


def _command(name: str, command: click.Command, context: click.Context) -> Iterator[str]:
    usage = " ".join(command.collect_usage_pieces(context))
    yield f'.SS "osm2xodr {name} {_escaped(usage)}"\n'
    yield _text(command.help or "")
    for item in command.get_params(context):
        record = None if isinstance(item, click.Argument) else item.get_help_record(context)
        if record is not None:
            yield f".TP\n.B {_escaped(record[0])}\n{_text(record[1])}"
    if command.epilog:
        yield ".PP\n.nf\n" + _text("\n".join(line for line in command.epilog.splitlines() if line != "\b")) + ".fi\n"


def _text(text: str) -> str:
    """Return lines of text, none of which is taken for a request."""
    lines = [_escaped(line) for line in text.splitlines()]
    return "\n".join(f"\\&{line}" if line[:1] in (".", "'") else line for line in lines) + "\n"


def _escaped(text: str) -> str:
    return text.replace("\\", "\\e").replace("-", "\\-").replace('"', "\\(dq")


if __name__ == "__main__":
    TARGET.write_text(page(), encoding="utf-8")
