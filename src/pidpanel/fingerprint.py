"""Hashes of what a result rests on: code without its comments, and files.

A result is computed again when the code behind it changes, and not when a comment or a docstring
does. The code behind a module is the module itself and every module of the project that it
imports, directly or not.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from pidpanel.paths import PACKAGE, WORKFLOW

ROOTS = {"pidpanel": PACKAGE.parent, "scripts": WORKFLOW}
"""Folder in which each of the project's packages lies."""

BLOCKS = {"body", "orelse", "finalbody"}
"""Fields of a syntax tree that hold statements."""


def code_digest(*modules: str) -> str:
    """Hash of the code behind some modules.

    Parameters
    ----------
    modules
        Dotted names, such as ``pidpanel.panel.modes`` or ``scripts.panel``; a package stands
        for all modules in it.

    Returns
    -------
    str
        64 hexadecimal digits, the same on every machine and with every version of Python.

    Raises
    ------
    ValueError
        If there is no such module.
    """
    return _digest_of(code_behind(*modules))


def module_digest(*modules: str) -> str:
    """Hash of the code of some modules themselves, without that of what they import.

    Parameters
    ----------
    modules
        Dotted names, as of `code_digest`.

    Returns
    -------
    str
        As of `code_digest`.

    Raises
    ------
    ValueError
        If there is no such module.
    """
    return _digest_of({name for module in modules for name in _with_members(module)})


def _digest_of(modules: set[str]) -> str:
    digest = hashlib.sha256()
    for name in sorted(modules):
        digest.update(f"{name} {_meaning(_file_of(name) or Path())}\n".encode())
    return digest.hexdigest()


def code_behind(*modules: str) -> set[str]:
    """Names of the modules themselves and of all that they import of this project."""
    found: set[str] = set()
    waiting = [name for module in modules for name in _with_members(module)]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += [other for other in _imported(name) if other not in found]
    return found


def file_digest(*paths: Path) -> str:
    """Hash of the content of files, in their order; 64 hexadecimal digits."""
    digest = hashlib.sha256()
    for path in paths:
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def _file_of(module: str) -> Path | None:
    """File of a module of this project; None for a module of somebody else."""
    root, *parts = module.split(".")
    if root not in ROOTS:
        return None
    folder = ROOTS[root].joinpath(root, *parts)
    for path in (folder / "__init__.py", folder.with_suffix(".py")):
        if path.is_file():
            return path
    return None


def _with_members(module: str) -> Iterator[str]:
    path = _file_of(module)
    if path is None:
        raise ValueError(f"{module}: no module of this project")
    yield module
    if path.name == "__init__.py":
        for member in sorted(path.parent.rglob("*.py")):
            parts = member.relative_to(path.parent).with_suffix("").parts
            yield ".".join((module, *(part for part in parts if part != "__init__")))


@cache
def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_bytes(), str(path))


@cache
def _meaning(path: Path) -> str:
    """Hash of the syntax tree of a file without docstrings; comments are not in it."""
    parts: list[str] = []
    _dump(_tree(path), parts.append)
    return hashlib.sha256("".join(parts).encode()).hexdigest()


def _dump(node: Any, write: Callable[[str], None]) -> None:
    """As `ast.dump`, whose text changed with Python 3.12 and 3.13: what is empty is left out."""
    if isinstance(node, ast.AST):
        write(type(node).__name__)
        before = "("
        for name in node._fields:
            value = getattr(node, name, None)
            if name in BLOCKS and isinstance(value, list):
                value = [one for one in value if not _is_docstring(one)]
            if value is not None and value != []:
                write(f"{before}{name}=")
                _dump(value, write)
                before = ", "
        write("()" if before == "(" else ")")
    elif isinstance(node, list):
        write("[")
        for number, item in enumerate(node):
            if number:
                write(", ")
            _dump(item, write)
        write("]")
    else:
        write(repr(node))


def _is_docstring(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


@cache
def _imported(module: str) -> tuple[str, ...]:
    """Modules of this project that a module imports, and the packages they lie in."""
    path = _file_of(module)
    if path is None:
        return ()
    named: list[str] = []
    for node in _run_nodes(_tree(path)):
        if isinstance(node, ast.Import):
            named += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            named += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    packages = (
        ".".join(parts[:end])
        for parts in (name.split(".") for name in named)
        for end in range(1, len(parts) + 1)
    )
    return tuple(dict.fromkeys(name for name in packages if _file_of(name)))


def _run_nodes(tree: ast.AST) -> Iterator[ast.AST]:
    """Nodes that run: without the imports that only type checkers see."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        if isinstance(node, ast.If) and _names_type_checking(node.test):
            waiting += node.orelse
        else:
            waiting += ast.iter_child_nodes(node)


def _names_type_checking(test: ast.expr) -> bool:
    return "TYPE_CHECKING" in (getattr(test, "id", ""), getattr(test, "attr", ""))


def text_digest(texts: Iterable[str]) -> str:
    """Hash of some texts, in their order; 64 hexadecimal digits."""
    digest = hashlib.sha256()
    for text in texts:
        digest.update(hashlib.sha256(text.encode()).digest())
    return digest.hexdigest()
