"""The codes of diagnostics, read from the source of the package."""

from __future__ import annotations

import ast
import itertools
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

import osm2xodr

SOURCE = Path(osm2xodr.__file__).parent
KINDS = ("guessed", "dropped", "repaired", "note")


class _Tree:
    """A module, and all nodes in it."""

    def __init__(self, module: ast.Module) -> None:
        self.body = module.body
        self.nodes = list(ast.walk(module))

    @cached_property
    def around(self) -> dict[ast.AST, ast.FunctionDef]:
        """The innermost function around each node in one."""
        return {node: item for item in self.nodes if isinstance(item, ast.FunctionDef) for node in ast.walk(item)}


def raised_codes() -> dict[str, set[str]]:
    """Return the kinds of the diagnostics of each code.

    A code is a literal, a constant of its module, a variable of a loop over literals, or what calls of the function
    around it give as its parameter. One that is none of these raises LookupError with its place.
    """
    texts = {path: path.read_text("utf-8") for path in sorted(SOURCE.rglob("*.py"))}
    trees = {path: _Tree(ast.parse(text)) for path, text in texts.items()}
    found: dict[str, set[str]] = {}
    for path, tree in trees.items():
        if path.name == "diagnostics.py" or not ("diagnostics" in texts[path] or "Kind" in texts[path]):
            continue
        for function, kinds, code in _sites(tree):
            codes = _texts(code, tree, function, trees)
            if not codes:
                raise LookupError(
                    f"{path}:{code.lineno}: the code {ast.unparse(code)} cannot be told from the source"
                )
            for text in codes:
                found.setdefault(text, set()).update(kinds)
    return found


def _sites(tree: _Tree) -> Iterator[tuple[ast.FunctionDef | None, set[str], ast.expr]]:
    """Yield the function around it, the kinds and the code of everything that makes a diagnostic."""
    # Other modules have kinds of their own.
    imports = [
        node for node in tree.body if isinstance(node, ast.ImportFrom) and node.module == "osm2xodr.diagnostics"
    ]
    imported = {alias.name for node in imports for alias in node.names}
    for node in tree.nodes:
        said = node.func if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) else None
        # By the name of what it is said to.
        if said and said.attr in KINDS and ast.unparse(said.value).endswith("diagnostics"):
            assert isinstance(node, ast.Call)
            yield tree.around.get(node), {said.attr}, node.args[0]
        if isinstance(node, (ast.Call, ast.Tuple)) and "Kind" in imported:
            items = node.args if isinstance(node, ast.Call) else node.elts
            for item, code in itertools.pairwise(items):
                if (kinds := _kinds(item)) and not _kinds(code):
                    yield tree.around.get(node), kinds, code


def _kinds(node: ast.expr) -> set[str]:
    """Return the kinds that an expression such as ``Kind.NOTE`` can be."""
    if isinstance(node, ast.IfExp):
        return _kinds(node.body) | _kinds(node.orelse)
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "Kind":
        return {node.attr.lower()}
    return set()


def _texts(node: ast.expr, tree: _Tree, function: ast.FunctionDef | None, trees: dict[Path, _Tree]) -> set[str]:
    """Return the texts that an expression can be."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return {node.value}
    if isinstance(node, ast.IfExp):
        return _texts(node.body, tree, function, trees) | _texts(node.orelse, tree, function, trees)
    if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name) and function is not None:
        return _returned(node.value.id, function, trees)
    if not isinstance(node, ast.Name):
        return set()
    for item in tree.body:
        if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name) and item.target.id == node.id:
            return _texts(item.value, tree, None, trees) if item.value is not None else set()
    if function is None:
        return set()
    names = [argument.arg for argument in (*function.args.args, *function.args.kwonlyargs)]
    if node.id in names:
        return _given(function.name, names.index(node.id), node.id, trees)
    return _looped(node.id, function)


def _given(name: str, place: int, keyword: str, trees: dict[Path, _Tree]) -> set[str]:
    """Return the texts that calls of a function give for a parameter."""
    found: set[str] = set()
    for tree in trees.values():
        calls = [
            node
            for node in tree.nodes
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == name
        ]
        for node in calls:
            given = [item.value for item in node.keywords if item.arg == keyword]
            if place < len(node.args):
                given.append(node.args[place])
            for item in given:
                found |= _texts(item, tree, tree.around.get(node), trees)
    return found


def _looped(name: str, function: ast.FunctionDef) -> set[str]:
    """Return the texts that a variable of a loop over tuples of literals has."""
    for node in ast.walk(function):
        if isinstance(node, ast.For) and isinstance(node.target, ast.Tuple) and isinstance(node.iter, ast.Tuple):
            names = [item.id for item in node.target.elts if isinstance(item, ast.Name)]
            if name in names:
                rows = [row for row in node.iter.elts if isinstance(row, ast.Tuple)]
                cells = [row.elts[names.index(name)] for row in rows]
                return {
                    cell.value for cell in cells if isinstance(cell, ast.Constant) and isinstance(cell.value, str)
                }
    return set()


def _returned(name: str, function: ast.FunctionDef, trees: dict[Path, _Tree]) -> set[str]:
    """Return the first texts of the tuples that the function returns whose result a variable is."""
    made = {
        node.value.func.id
        for node in ast.walk(function)
        if isinstance(node, ast.Assign)
        and isinstance(node.value, ast.Call)
        and isinstance(node.value.func, ast.Name)
        and any(isinstance(target, ast.Name) and target.id == name for target in node.targets)
    }
    found = set()
    for tree in trees.values():
        for item in tree.nodes:
            if isinstance(item, ast.FunctionDef) and item.name in made:
                for node in ast.walk(item):
                    if isinstance(node, ast.Tuple) and node.elts and isinstance(node.elts[0], ast.Constant):
                        found.add(str(node.elts[0].value))
    return found
