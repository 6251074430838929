"""Files that a killed process or a power cut leaves as they were, or whole."""

import contextlib
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

DRAFT = ".new_"  # what the name of a file begins with until it is whole; its suffix stays


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give the path of a draft that takes the place of a file, or of a folder, when it is whole.

    After a failure nothing of it is left, and what was there before stays.
    """
    draft = path.with_name(DRAFT + path.name)
    discard(draft)
    try:
        yield draft
        sync(draft, *(draft.rglob("*") if draft.is_dir() else ()))
        if draft.is_dir():
            discard(path)
        os.replace(draft, path)
        sync(path.parent)
    finally:
        discard(draft)


def write_text(path: Path, text: str) -> None:
    """Write a text file in UTF-8."""
    with replacing(path) as draft:
        draft.write_text(text, encoding="utf-8")


def sync(*paths: Path) -> None:
    """Wait until files and folders are on the disk."""
    for path in paths:
        handle = os.open(path, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def discard(path: Path) -> None:
    """Remove a file, or a folder with all that is in it, if it is there."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
