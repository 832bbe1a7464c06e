"""The command ``completion``: what makes shells complete commands and options."""

from __future__ import annotations

import click

from osm2xodr.system import STANDARD_OUTPUT, stream_to

SHELLS = ("bash", "zsh", "fish")
# The variable by which shells ask for words.
_VARIABLE = "_OSM2XODR_COMPLETE"


@click.command(
    short_help="Print what makes a shell complete commands and options.",
    epilog="""\b
Examples:
  osm2xodr completion bash > ~/.local/share/bash-completion/completions/osm2xodr
  osm2xodr completion zsh > ~/.zfunc/_osm2xodr
  osm2xodr completion fish > ~/.config/fish/completions/osm2xodr.fish

Exit status: 0 printed, 2 wrong usage, 130 interrupted.""",
)
@click.argument("shell", type=click.Choice(SHELLS))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print the script that makes SHELL (bash from 4.4 on, zsh, fish) complete commands, options and files."""
    # Here, so that other commands start without it.
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    assert kind is not None
    script = kind(context.find_root().command, {}, "osm2xodr", _VARIABLE)
    with stream_to(STANDARD_OUTPUT) as stream:
        # Not by `source`, which asks the shell for its version: it need not be installed here.
        stream.write((script.source_template % script.source_vars()).encode())
