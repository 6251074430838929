"""The requests of a call of Snakemake, and the LIGGGHTS runs of a study."""

import json
import math
from types import SimpleNamespace

import pytest

from pidpanel.coupon import coding
from pidpanel.coupon.from_study import cases_of
from pidpanel.provenance import locks, requests
from pidpanel.provenance.requests import LONG_AGO, Requests
from pidpanel.study.coupon import Coupon
from pidpanel.workflow.plan import CouponRuns

OUTPUTS = ["results/a/panel/modes.nc", "results/a/panel/modes.csv"]


@pytest.fixture()
def made(tmp_path, monkeypatch):
    """Files of a job and its record, and requests of a call."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(locks.WORKFLOW_PROCESS, raising=False)
    request = tmp_path / Requests().quick(OUTPUTS, {"study": "1"})
    for output in OUTPUTS:
        (tmp_path / output).write_text(output)
    requests.write_record(request, requests.read_request(request), OUTPUTS)
    return tmp_path, request


def test_a_damaged_file_is_named_at_once_and_set_aside_before_jobs_begin(made, capsys):
    # red: `set_aside` in `job`: a dry run would take the file away
    folder, request = made
    asked = Requests()
    asked.quick(OUTPUTS, {"study": "1"})
    assert request.stat().st_mtime == LONG_AGO
    (folder / OUTPUTS[1]).write_text("damaged")
    asked = Requests()
    asked.quick(OUTPUTS, {"study": "1"})
    assert f"{OUTPUTS[1]}: damaged, changed or lost" in capsys.readouterr().err
    assert request.stat().st_mtime > LONG_AGO and (folder / OUTPUTS[1]).exists()
    asked.begin()
    assert (folder / f"{OUTPUTS[1]}.broken").read_text() == "damaged"
    assert (folder / OUTPUTS[0]).exists()


def test_a_job_of_a_cluster_writes_no_request(made, monkeypatch):
    # red: `is_main` left out of `is_new`
    _, request = made
    before = request.read_text()
    monkeypatch.setenv(locks.WORKFLOW_PROCESS, "1")
    Requests().quick(OUTPUTS, {"study": "2"})
    assert request.read_text() == before


COUPON = {
    "cell": {"count": 1},
    "sweep": {"fill_fraction": [0.5], "frequency_hz": [100], "acceleration_g": [20]},
}


def test_runs_are_open_until_their_batch_is_there(tmp_path, monkeypatch):
    # red: `is_made=True` for a batch; the label of another case
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(locks.WORKFLOW_PROCESS, raising=False)
    coupon = Coupon.model_validate(COUPON)
    runs = CouponRuns(SimpleNamespace(coupons={"coupon": coupon}), Requests(), math.inf)
    (case,) = cases_of(coupon)
    (label,) = runs.batches
    (outcome,) = runs.outcomes(runs.swept("coupon"))
    assert outcome == f"results/coupon/batch/{label}.json"
    content = json.loads((tmp_path / runs.batch(label)).read_text())
    assert content["cases"] == [json.loads(json.dumps(coding.encode(case)))]
    assert runs.is_open and requests.ATTEMPT in content
    for bed in runs.beds:
        values = json.loads((tmp_path / runs.bed(bed)).read_text())
        assert values == json.loads(json.dumps(coding.encode(runs.beds[bed])))
    assert runs.legs_of_batch(label) == [] and runs.retries is None
