"""Builds the site of the documents, without a link that leads nowhere: ``tools/make_site.py [-o FOLDER]``.

The pages are those of ``docs``, and what is made of the program itself: its options, and what Python has. Needs the
extra ``docs``, and no network: the site brings all that it shows. It is also an extension of Sphinx, for formulas.
"""

from __future__ import annotations

import argparse
import base64
import inspect
import json
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import click
from docutils import nodes
from latex2mathml.converter import convert as to_mathml
from sphinx.application import Sphinx

import osm2xodr
from osm2xodr.cli.program import cli

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT: Final = Path(__file__).parents[1]
DOCS: Final = ROOT / "docs"

# Where each page stands; Sphinx refuses one that stands nowhere. An asterisk stands for all pages of such names.
SECTIONS: Final = {
    "Start": ("start*.md", "fetch", "gallery", "how_it_works"),
    "Use": (
        "commands", "config", "corrections", "batch", "parts", "report", "check", "readers", "scene", "lanelet2",
        "locate_export",
    ),
    "What is made": ("what_is_written", "elevation", "junctions", "furniture", "accuracy"),
    "Reference": ("options", "python", "*.ipynb", "diagnostics"),
    "Method": (
        "method/README", "method/plan_view", "method/junctions", "method/lanes", "method/heights",
        "method/structures",
    ),
    "Project": ("changelog", "contributing"),
}  # fmt: skip
OPTIONS: Final = {
    "extensions": ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "make_site"],
    "project": "osm2xodr",
    "version": osm2xodr.__version__,
    "release": osm2xodr.__version__,
    "html_theme": "furo",
    "html_title": "osm2xodr",
    "html_copy_source": False,
    "html_show_sphinx": False,
    "html_math_renderer": "mathml",
    "myst_enable_extensions": ["dollarmath", "deflist"],
    "myst_fence_as_directive": ["math"],
    "myst_heading_anchors": 4,
    "default_role": "code",
    "autodoc_typehints": "none",
    "napoleon_google_docstring": False,
    # Tables of files, Makefiles and cron have no grammar there.
    "suppress_warnings": ["misc.highlighting_failure"],
}


def build(target: Path, builder: str = "html") -> None:
    """Build the site anew, or do what another builder does; SystemExit if anything is wrong with it."""
    source = target.with_name(f"{target.name}-source")
    for folder in (source, target):
        shutil.rmtree(folder, ignore_errors=True)
    write_pages(source)
    app = Sphinx(
        str(source), None, str(target), str(source / ".doctrees"), builder, OPTIONS, status=None, warningiserror=True
    )
    app.build(force_all=True)
    if app.statuscode:
        raise SystemExit("the site has faults, see above")


# ---------------------------------------------------------------- its pages


def write_pages(folder: Path) -> None:
    """Write the source of all pages."""
    shutil.copytree(DOCS, folder, ignore=shutil.ignore_patterns("*.1"))
    for path in sorted(DOCS.glob("*.ipynb")):
        write_notebook(path, folder)
    made = {
        "index.md": _root_page("README.md") + "".join(_contents()),
        "changelog.md": _root_page("CHANGELOG.md"),
        "contributing.md": _root_page("CONTRIBUTING.md"),
        "options.md": "".join(_options()),
        "python.md": "".join(_python()),
    }
    for name, text in made.items():
        if (folder / name).exists():
            raise SystemExit(f"docs/{name} is made by tools/make_site.py; give the document another name")
        (folder / name).write_text(text, encoding="utf-8")


def write_notebook(path: Path, folder: Path) -> None:
    """Write the page of a notebook: its text, code, and what the code printed and drew."""
    parts = []
    for number, cell in enumerate(json.loads(path.read_text(encoding="utf-8"))["cells"]):
        text = "".join(cell["source"])
        parts.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
        for place, output in enumerate(cell.get("outputs", ())):
            data = output.get("data", {"text/plain": output.get("text", ())})
            if "image/png" in data:
                name = f"{path.stem}_{number}_{place}.png"
                (folder / "images" / name).write_bytes(base64.b64decode("".join(data["image/png"])))
                parts.append(f"![What cell {number + 1} draws](images/{name})")
            else:
                parts.append(f"```text\n{''.join(data['text/plain'])}\n```")
    parts.append(f"{{download}}`As a notebook <{path.name}>`\n")
    (folder / f"{path.stem}.md").write_text("\n\n".join(parts), encoding="utf-8")


def _root_page(name: str) -> str:
    """Return a document of the root, with links as they are among the documents."""
    text = (ROOT / name).read_text(encoding="utf-8")
    # Files that are no document are those of the repository.
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    base = project["tool"]["hatch"]["metadata"]["hooks"]["custom"]["repository"]
    away = re.sub(r"\]\((?!docs/|[a-z]+:|#)", f"]({base}/blob/main/", text)
    return away.replace("](docs/", "](")


def _contents() -> Iterator[str]:
    for title, pages in SECTIONS.items():
        found = [page for name in pages for page in (_named(name) if "*" in name else [name])]
        yield f"\n```{{toctree}}\n:hidden:\n:maxdepth: 1\n:caption: {title}\n\n" + "\n".join(found) + "\n```\n"


def _named(pattern: str) -> list[str]:
    return sorted(path.stem for path in DOCS.glob(pattern))


def _options() -> Iterator[str]:
    """Yield the page of all commands with their options, from their declarations."""
    yield "# Options\n\nWhat `osm2xodr COMMAND --help` prints, of all commands; as does the manual page.\n"
    program = click.Context(cli, info_name="osm2xodr", **cli.context_settings)
    for name, command in cli.commands.items():
        with click.Context(command, program, name) as context:
            usage = " ".join(command.collect_usage_pieces(context))
            yield f"\n## {name}\n\n```text\nosm2xodr {name} {usage}\n```\n\n{_escaped(command.help or '')}\n\n"
            for item in command.get_params(context):
                record = None if isinstance(item, click.Argument) else item.get_help_record(context)
                if record is not None:
                    yield f"`{record[0]}`\n: {_escaped(record[1])}\n\n"
            epilog = "\n".join(line for line in (command.epilog or "").splitlines() if line != "\b")
            yield f"```text\n{epilog}\n```\n" if epilog else ""


def _escaped(text: str) -> str:
    """Return text in which nothing stands for form."""
    return re.sub(r"([\\`*_<>\[\]{}$|#~])", r"\\\1", " ".join(text.replace("\b", "").split()))


def _python() -> Iterator[str]:
    """Yield the page of all that Python has."""
    yield f"# Python\n\n```{{eval-rst}}\n{inspect.getdoc(osm2xodr)}\n```\n"
    found = [(name, getattr(osm2xodr, name)) for name in sorted(dir(osm2xodr)) if not name.startswith("_")]
    parts = {
        "Functions": [("autofunction", name) for name, item in found if inspect.isfunction(item)],
        "Classes": [("autoclass", name) for name, item in found if _is_class(item)],
        "Errors": [("autoexception", name) for name, item in found if inspect.isclass(item) and not _is_class(item)],
    }
    for title, items in parts.items():
        yield f"\n## {title}\n\n```{{eval-rst}}\n"
        for kind, name in items:
            yield f".. {kind}:: osm2xodr.{name}\n" + ("   :members:\n\n" if kind == "autoclass" else "\n")
        yield "```\n"


def _is_class(item: object) -> bool:
    return inspect.isclass(item) and not issubclass(item, Exception)


# ---------------------------------------------------------------- formulas


def _mathml(node: nodes.Element, display: str) -> str:
    """Return a formula as every browser draws it; two things of LaTeX are put in the converter's words."""
    text = re.sub(r"(\\?\w+)('+)\^", r"{\1\2}^", node.astext())
    return str(to_mathml(text, display=display)).replace("\\_", "_")


def _inline(writer: Any, node: nodes.Element) -> None:
    writer.body.append(_mathml(node, "inline"))
    raise nodes.SkipNode


def _block(writer: Any, node: nodes.Element) -> None:
    writer.body.append(f'<div class="math">{_mathml(node, "block")}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Make it an extension of Sphinx."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def main() -> None:
    """Build the site."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "build" / "site")
    parser.add_argument("--builder", default="html", help="of Sphinx; linkcheck asks for every address elsewhere")
    options = parser.parse_args()
    build(options.output, options.builder)


if __name__ == "__main__":
    main()
