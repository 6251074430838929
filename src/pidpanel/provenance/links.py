"""Folders that may come from somebody else: no path in them leads elsewhere or waits for ever."""

import os
from pathlib import Path


class LinkError(ValueError):
    """A link or a special file where results are read and written."""


def check_working_folder(folder: Path) -> None:
    """Refuse links below ``results`` of a folder, and in what Snakemake keeps there.

    ``results`` itself may be a link, such as to a larger disk.

    Raises
    ------
    LinkError
        One line: the first such path, and what to do.
    """
    kept = folder / ".snakemake"
    if kept.is_symlink():
        raise _refusal(str(kept))
    check_links(folder / "results", kept)


def check_links(*folders: Path) -> None:
    """Refuse links, pipes and devices below folders.

    pidpanel, Snakemake and LIGGGHTS read, replace and remove results by their paths, and make no
    link among them. One that came with the folder would have them write to where it leads.

    Raises
    ------
    LinkError
        One line: the first such path, and what to do.
    """
    remaining: list[str | Path] = list(folders)
    while remaining:
        try:
            with os.scandir(remaining.pop()) as listing:
                entries = list(listing)
        except (FileNotFoundError, NotADirectoryError, PermissionError):
            continue  # removed meanwhile, or of another user
        for entry in entries:
            if entry.is_symlink():
                raise _refusal(entry.path)
            if entry.is_dir():
                remaining.append(entry.path)
            elif not entry.is_file():
                raise LinkError(f"{entry.path}: must be a file or a folder; remove it")


def _refusal(path: str) -> LinkError:
    target = os.readlink(path)
    return LinkError(
        f"{path}: is a link to {target!r}, where nothing may be written or read; remove it"
    )
