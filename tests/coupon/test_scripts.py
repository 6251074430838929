"""The scripts of the stage, from their arguments to their files."""

import json

import pandas as pd
import pytest

from pidpanel.atlas.table import read_atlas
from pidpanel.coupon import coding
from pidpanel.coupon.batches import Batch
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.summary import CoverageMissed
from pidpanel.study import load_any_study
from tests.jobs import call

STUDY = """
coupon:
  cell: {across_flats_mm: 6.35, depth_mm: 10, count: 1}
  particles: {diameter_mm: 2.5, youngs_modulus_mpa: 50}
  sweep: {fill_fraction: [0.5], frequency_hz: [100], acceleration_g: [10, 12]}
  accuracy: {relative_error: 0.5, seeds: 1, min_cycles: 30, max_cycles: 30, min_time_s: 0, coverage: COVERAGE}
"""


def study_file(folder, coverage):
    path = folder / "tiny.yaml"
    path.write_text(STUDY.replace("COVERAGE", str(coverage)))
    return path


def gather(study, folder):
    made, params = {"cases": folder / "cases.csv"}, {"damper": "coupon"}
    call("cases", study, {}, made, params=params, coupon=folder / "coupon")


@pytest.mark.liggghts
def test_a_small_study_goes_through_all_scripts(tmp_path):
    # red: the bed looked for by another name than it was written to
    study = study_file(tmp_path, 0.5)
    cases = cases_of(load_any_study(study).coupon)
    coupon = tmp_path / "coupon"
    bed = cases[0].point.bed
    packing_file = coupon / "packing" / bed.packing.label / "packing.json"
    bed_file = coupon / "bed" / bed.label / "bed.json"
    for file in (packing_file, bed_file):
        file.parent.mkdir(parents=True)  # as Snakemake does
    values = tmp_path / "values.json"
    values.write_text(json.dumps(coding.encode(bed.packing)))
    call("pour", study, {"values": values}, {"packing": packing_file})
    values.write_text(json.dumps(coding.encode(bed)))
    call("loosen", study, {"values": values, "packing": packing_file}, {"bed": bed_file})
    values.write_text(json.dumps(Batch(cases).content))
    call("shake", study, {"batch": values}, {"batch": tmp_path / "batch.json"}, coupon=coupon)
    states = json.loads((tmp_path / "batch.json").read_text())["ended"]
    assert states == {f"{case.label}/s1": "ok" for case in cases}
    gather(study, tmp_path)
    table = pd.read_csv(tmp_path / "cases.csv")
    assert table["case"].tolist() == [case.label for case in cases]
    assert (table["equivalent_damping_n_s_m3"] > 0).all()
    assert table["acceleration_g"].tolist() == pytest.approx([10, 12])
    rows = tmp_path / "atlas.csv"
    call("atlas", study, {"cases": tmp_path / "cases.csv"}, {"atlas": rows})
    atlas = read_atlas(rows)
    assert atlas["loss_factor"].tolist() == pytest.approx(table["loss_factor"].tolist(), rel=1e-5)
    assert atlas["source"].tolist() == ["tiny", "tiny"]


def test_a_table_without_its_coverage_is_refused_with_the_cases_named(tmp_path):
    # red: no coverage checked in `write_table`
    study = study_file(tmp_path, 1.0)
    with pytest.raises(CoverageMissed) as ended:
        gather(study, tmp_path)
    said = str(ended.value).splitlines()
    assert len(said) == 3
    assert ": RecordUnreadable: " in said[0]
    assert (
        said[-1]
        == "0.0% of the cases are ok; coupon.accuracy.coverage requires 100.0%; raise coupon.accuracy.max_cycles, or lower the coverage"
    )
    assert len((tmp_path / "cases.csv").read_text().splitlines()) == 3
