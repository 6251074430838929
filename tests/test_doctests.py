"""Every example in a docstring holds, and none is left out."""

import ast
import doctest
import importlib
import importlib.util

import pytest

from pidpanel.paths import PROJECT, WORKFLOW

DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def written_examples(path):
    """Number of examples in the docstrings of a file, run or not."""
    parser = doctest.DocTestParser()
    nodes = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, DOCUMENTED)]
    return sum(len(parser.get_examples(ast.get_docstring(node) or "")) for node in nodes)


def module_at(path):
    """The module of a file, imported by its name where it lies in ``src``."""
    if path.is_relative_to(PROJECT / "src"):
        parts = path.relative_to(PROJECT / "src").with_suffix("").parts
        return importlib.import_module(".".join(p for p in parts if p != "__init__"))
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def examined(*folders):
    """Files below some folders with examples in their docstrings."""
    files = (path for folder in folders for path in sorted(folder.rglob("*.py")))
    return [path for path in files if ">>> " in path.read_text()]


def check(path):
    result = doctest.testmod(module_at(path))
    # an example that no test finder reaches would hold whatever it says
    assert result.attempted == written_examples(path)
    assert result.failed == 0


FILES = examined(PROJECT / "src", WORKFLOW / "scripts")


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PROJECT)))
def test_examples_in_docstrings_hold(path):
    check(path)


def test_a_wrong_example_and_one_that_is_not_run_are_seen(tmp_path):
    wrong, unseen = tmp_path / "wrong.py", tmp_path / "unseen.py"
    wrong.write_text('"""A sum.\n\n>>> 1 + 1\n3\n"""\n')
    unseen.write_text(
        'def f():\n    def g():\n        """A sum.\n\n        >>> 1\n        1\n        """\n'
    )
    for path in (wrong, unseen):
        with pytest.raises(AssertionError):
            check(path)


def test_modules_with_examples_are_found():
    assert PROJECT / "src" / "pidpanel" / "damping" / "laws.py" in FILES
