"""What `check` accepts is carried out: studies drawn at random, from the mesh to the maps.

`make fuzz` draws many, to their pages; the tests a few.
"""

import csv
import os
import random

import pytest
import random_studies

from pidpanel.check import checked_study
from pidpanel.study import StudyError

MANY = int(os.environ.get("PIDPANEL_FUZZ", "0")) // 50
FIRST = random.SystemRandom().randrange(10**6) if MANY else 0
SEEDS = range(FIRST, FIRST + MANY) if MANY else (1, 3)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_study_that_check_accepts_is_carried_out(tmp_path, seed):
    file = random_studies.written(tmp_path, random_studies.drawn(seed))
    try:
        study = checked_study(file)
    except StudyError as error:
        assert str(error).startswith(f"{file}:"), "a refusal names its place"
        return
    summary = random_studies.carried_out(study, file, tmp_path / "results", page=bool(MANY))
    with summary.open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    expected = len(study.all_scenarios()) * len(study.panel.points)
    assert len(rows) == expected
    assert all(random_studies.is_finite(row["acceleration_rms_g"]) for row in rows
               if row["status"] == "ok")  # fmt: skip


def test_most_of_what_is_drawn_is_accepted(tmp_path):
    refused = 0
    for seed in range(8):
        try:
            checked_study(random_studies.written(tmp_path, random_studies.drawn(seed)))
        except StudyError:
            refused += 1
    assert refused <= 4
