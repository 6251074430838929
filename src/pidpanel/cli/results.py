"""Results that are made from others which are complete."""

from pathlib import Path

from pidpanel.cli.snakemake import RunError, jobs_left, run


def make(study: Path, folder: Path, target: str, rule: str, *, force: bool = False) -> Path:
    """Return the path of a result that one rule makes; make it where it is out of date."""
    left = jobs_left(study, folder, target)
    unfinished = {name: count for name, count in left.items() if name != rule}
    if unfinished:
        named = ", ".join(f"{count} × {name}" for name, count in unfinished.items())
        raise RunError(
            f"{folder / target}: jobs before it are not done: {named}; use pidpanel run first"
        )
    if left or force:
        options = [target, "--quiet", "progress", "rules", *(["--forcerun", rule] if force else [])]
        if run(study, folder, 1, options):
            raise RunError(f"{folder / target}: failed; see above")
    return folder / target
