"""LIGGGHTS' language is in one folder and nowhere else."""

import re
from pathlib import Path

import pytest

from pidpanel.coupon.liggghts import process

SPOKEN = re.compile(
    r"""["'\n](?:
        run\ [\d{] | (?:dump|fix|compute|group)\ [\w{}]+\ [\w{}]+\ \w | (?:undump|unfix)\ [\w{]
        | dump_modify\ | thermo | timestep\ [\d{] | velocity\ all\ | variable\ \w+\ equal\ | pair_
        | (?:read|write)_(?:restart|data)\ | neigh | create_(?:box|atoms)\ | region\ \w+\ block
    )
    | \.execute\( | \._execute\( | hertz\ tangential | \bc_\w+\[\d""",
    re.VERBOSE,
)
PACKAGE = Path(process.__file__).parents[2]


def commands(folder):
    """Lines with a command of LIGGGHTS in Python files of a folder, that of LIGGGHTS left out.

    The module of the contact law states LIGGGHTS' words for it.
    """
    for path in sorted(folder.rglob("*.py")):
        if "liggghts" in path.relative_to(folder).parts or path.name == "contact.py":
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if SPOKEN.search(line):
                yield f"{path.relative_to(folder)}:{number}: {line.strip()}"


def test_liggghts_is_spoken_in_one_folder_alone():
    # red: `solver._execute("undump last")` in runs.py
    assert list(commands(PACKAGE)) == []


@pytest.mark.parametrize(
    "line",
    [
        'solver.told("run 100")',
        'solver.told(f"run {steps}")',
        "solver.execute(text)",
        'text = f"dump x all custom {n} y id"',
        'solver.told("unfix cycle")',
        'solver.told("velocity all set 0 0 1")',
        'columns = "c_pairs[1]"',
    ],
)
def test_a_command_elsewhere_is_seen_and_named(tmp_path, line):
    # red: a pattern that never matches
    (tmp_path / "runs.py").write_text(f"import os\n{line}\n")
    assert list(commands(tmp_path)) == [f"runs.py:2: {line}"]
