"""A digest of code follows what the code means, and nothing else."""

import textwrap

import pytest

from pidpanel import fingerprint


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A package with a module that imports another, one that only type checkers see, one lazily."""
    files = {
        "__init__": "",
        "a": """
            '''Module a.'''
            from typing import TYPE_CHECKING
            from pidpanel import b
            if TYPE_CHECKING:
                from pidpanel import typed
            else:
                from pidpanel import untyped
            def f(x):
                '''Twice x.'''
                from pidpanel.folder import late
                return 2 * x  # twice
            """,
        "b": "VALUE = 1\n'''A docstring of an attribute.'''\n",
        "typed": "T = 1\n",
        "untyped": "U = 1\n",
        "folder/__init__": "",
        "folder/late": "LATE = 1\n",
        "folder/other": "OTHER = 1\n",
    }
    for name, text in files.items():
        path = tmp_path / "pidpanel" / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text))
    monkeypatch.setattr(fingerprint, "ROOTS", {"pidpanel": tmp_path})

    def digest(change=None):
        """Digest of a with one file changed from an old text to a new one."""
        if change is not None:
            name, old, new = change
            path = tmp_path / "pidpanel" / f"{name}.py"
            text = path.read_text()
            assert old in text
            path.write_text(text.replace(old, new))
        for cached in (fingerprint._tree, fingerprint._meaning, fingerprint._imported):
            cached.cache_clear()
        return fingerprint.code_digest("pidpanel.a")

    yield digest
    for cached in (fingerprint._tree, fingerprint._meaning, fingerprint._imported):
        cached.cache_clear()


@pytest.mark.parametrize(
    "change",
    [
        ("a", "# twice", "# two times"),
        ("a", "'''Twice x.'''", "'''Two times x.'''"),
        ("a", "'''Module a.'''", "'''The module a.'''"),
        ("b", "'''A docstring of an attribute.'''", ""),
        ("a", "    return", "\n\n    return"),
        ("typed", "T = 1", "T = 2"),
        ("folder/other", "OTHER = 1", "OTHER = 2"),
    ],
)
def test_what_changes_no_meaning_changes_no_digest(project, change):
    # red: digest.update(path.read_bytes()) in place of the syntax tree
    before = project()
    assert project(change) == before


@pytest.mark.parametrize(
    "change",
    [
        ("a", "2 * x", "3 * x"),
        ("b", "VALUE = 1", "VALUE = 2"),
        ("folder/late", "LATE = 1", "LATE = 2"),
        ("untyped", "U = 1", "U = 2"),
        ("folder/__init__", "", "NEW = 1\n"),
    ],
)
def test_code_that_runs_changes_the_digest_wherever_it_is_imported(project, change):
    # red: `_imported` that looks at the head of a module alone
    before = project()
    assert project(change) != before


def test_a_package_stands_for_all_its_modules(project):
    project()
    behind = fingerprint.code_behind("pidpanel.folder")
    assert behind == {"pidpanel.folder", "pidpanel.folder.late", "pidpanel.folder.other"}


def test_a_module_that_is_not_there_is_named(project):
    with pytest.raises(ValueError, match=r"pidpanel\.nowhere: no module of this project"):
        fingerprint.code_digest("pidpanel.nowhere")


def test_files_count_by_their_content_and_order(tmp_path):
    # red: file_digest of the names
    one, two, same = (tmp_path / name for name in ("one", "two", "same"))
    one.write_text("1")
    two.write_text("2")
    same.write_text("1")
    assert fingerprint.file_digest(one) == fingerprint.file_digest(same)
    assert fingerprint.file_digest(one, two) != fingerprint.file_digest(two, one)
    assert fingerprint.text_digest(["a", "b"]) != fingerprint.text_digest(["ab"])
