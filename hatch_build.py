"""What the build does: compile loops, and say where the project is.

Modules that have a `.pxd` file beside them, which says what types their loops have in C, are compiled. Where there is
no C compiler, or no headers of Python, the same modules run as Python: slower, with the same result.

The address of the repository stands in pyproject.toml alone; the addresses in the metadata, and those of links and
pictures in the README, are made of it.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

ROOT = Path(__file__).parent
SOURCE = ROOT / "src"
PACKAGE = "osm2xodr"
SUFFIX = sysconfig.get_config_var("EXT_SUFFIX")
# What compiled modules share has this name and the version of Cython: those that another one made go on with theirs.
SHARED = "cython_"
# Every machine is to round as Python does: no multiplication and addition in one, nothing that only newer processors
# have.
FLAGS = ["/O2", "/fp:precise"] if os.name == "nt" else ["-O2", "-g0", "-ffp-contract=off"]
DIRECTIVES = {
    "language_level": 3,
    "annotation_typing": False,
    "infer_types": True,
    "boundscheck": False,
    "wraparound": False,
    "cdivision": True,
    "initializedcheck": False,
}


def has_compiler() -> bool:
    """Say whether there is what compiling needs: a C compiler and the headers of Python."""
    compiler = os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc"
    return bool(shutil.which(compiler.split()[0])) and Path(sysconfig.get_path("include"), "Python.h").exists()


def modules() -> list[Path]:
    """Return the modules that are compiled."""
    return sorted(path.with_suffix(".py") for path in SOURCE.rglob("*.pxd"))


def compiled(module: Path) -> Path:
    """Return the compiled form of a module, for this Python: beside it."""
    return module.with_suffix(SUFFIX)


def forms() -> list[Path]:
    """Return the compiled forms of modules that are there, and what these share: code of Cython's for arrays."""
    shared = SOURCE.glob(f"{PACKAGE}/{SHARED}*{SUFFIX}")
    return [path for path in (*map(compiled, modules()), *shared) if path.exists()]


def made_of(module: Path) -> int:
    """Return when what a compiled form is made of was changed last, ns: compiled forms bear this date themselves."""
    sources = [module, Path(__file__), *SOURCE.rglob("*.pxd")]
    return max(path.stat().st_mtime_ns for path in sources)


def up_to_date(module: Path) -> bool:
    """Say whether a module's compiled form is there and made of what stands there now."""
    return compiled(module).exists() and compiled(module).stat().st_mtime_ns == made_of(module)


def build() -> str | None:
    """Compile what is not up to date; return why nothing can be compiled, if so."""
    from Cython import __version__ as cython
    from Cython.Build import cythonize
    from setuptools import Distribution, Extension
    from setuptools.errors import BaseError, CCompilerError

    old = [module for module in modules() if not up_to_date(module)]
    for module in old:
        compiled(module).unlink(missing_ok=True)
    if not old:
        return None
    names = {".".join(module.relative_to(SOURCE).with_suffix("").parts): module for module in old}
    with tempfile.TemporaryDirectory() as folder:
        sources = {name: str(module) for name, module in names.items()}
        shared = SHARED + re.sub(r"[^0-9a-z]", "_", cython)
        sources[f"{PACKAGE}.{shared}"] = str(Path(folder, f"{shared}.c"))
        extensions = cythonize(
            [Extension(name, [source], extra_compile_args=FLAGS) for name, source in sources.items()],
            build_dir=folder,
            include_path=[str(SOURCE)],
            compiler_directives=DIRECTIVES,
            shared_utility_qualified_name=f"{PACKAGE}.{shared}",
            quiet=True,
        )
        command: Any = Distribution({"ext_modules": extensions}).get_command_obj("build_ext")
        command.build_lib, command.build_temp, command.parallel = folder, folder, os.cpu_count()
        command.ensure_finalized()
        try:
            command.run()
        except (BaseError, CCompilerError) as error:
            return str(error)
        (SOURCE / PACKAGE).mkdir(exist_ok=True)
        shutil.move(command.get_ext_fullpath(f"{PACKAGE}.{shared}"), SOURCE / PACKAGE / f"{shared}{SUFFIX}")
        for name, module in names.items():
            made = Path(command.get_ext_fullpath(name))
            os.utime(made, ns=(made_of(module), made_of(module)))
            shutil.move(made, compiled(module))
    return None


class CustomBuildHook(BuildHookInterface[Any]):
    """Puts compiled modules into wheels, and beside the modules for editable installations."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile what can be compiled."""
        problem = build()
        if problem:
            self.app.display_warning(
                f"osm2xodr is installed without compiled loops, and will be slow: {problem}. Install a C compiler "
                "and the headers of Python, then install osm2xodr again."
            )
            return
        build_data.update(pure_python=False, infer_tag=True)
        if version != "editable":
            build_data["force_include"].update({str(form): str(form.relative_to(SOURCE)) for form in forms()})


def with_addresses(text: str, repository: str, site: str, version: str) -> str:
    """Return Markdown of the root in which links to documents lead to the site, and other ones to the repository."""

    def address(match: re.Match[str]) -> str:
        mark, words, target = match.groups()
        page = re.fullmatch(r"docs/(.+)\.md", target)
        there = f"{site}/{page[1]}.html" if page else f"{repository}/{'raw' if mark else 'blob'}/{version}/{target}"
        return f"{mark}[{words}]({there})"

    return re.sub(r"(!?)\[([^\]]*)\]\((?![a-z]+:|#)([^)\s]+)\)", address, text)


class CustomMetadataHook(MetadataHookInterface):
    """Makes the addresses and the description that package indexes show."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add them."""
        base, site = self.config["repository"], self.config["documentation"]
        metadata["urls"] = {
            "Repository": base,
            "Documentation": site,
            "Changelog": f"{base}/blob/main/CHANGELOG.md",
            "Issues": f"{base}/issues",
        }
        version = re.search(r'^__version__ = "(.+)"', (SOURCE / PACKAGE / "__init__.py").read_text("utf-8"), re.M)
        assert version is not None
        text = with_addresses((ROOT / "README.md").read_text(encoding="utf-8"), base, site, f"v{version[1]}")
        metadata["readme"] = {"content-type": "text/markdown", "text": text}


if __name__ == "__main__":
    sys.exit(build())
