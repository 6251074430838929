"""A results file that is damaged is one line that names it."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pidpanel.provenance.results import ResultsDamaged, read_csv, read_netcdf


@pytest.fixture
def whole(tmp_path):
    """A dataset and a table, as stages write them."""
    values = {"psd": ("frequency", np.linspace(1, 2, 500)), "point": ("points", ["A", "B"])}
    xr.Dataset(values).to_netcdf(tmp_path / "psd.nc", engine="scipy")
    pd.DataFrame({"point": ["A", "B"], "rms": [1.0, 2.0]}).to_csv(tmp_path / "summary.csv")
    return tmp_path


DAMAGE = {
    "empty": lambda content: b"",
    "cut in the header": lambda content: content[:30],
    "cut in the values": lambda content: content[: len(content) // 2],
    "other bytes": lambda content: bytes(range(256)) * 20,
    "no header": lambda content: b"\0" * 64 + content[64:],
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_dataset_is_one_line_that_names_it(whole, damage):
    path = whole / "psd.nc"
    assert read_netcdf(path, ["psd"])["psd"].size == 500
    path.write_bytes(DAMAGE[damage](path.read_bytes()))
    with pytest.raises(ResultsDamaged) as raised:
        read_netcdf(path, ["psd"])
    assert str(raised.value).startswith(f"{path}: ") and "\n" not in str(raised.value)
    assert "run the study again" in str(raised.value)


@pytest.mark.parametrize("damage", ["empty", "other bytes"])
def test_a_damaged_table_is_one_line_that_names_it(whole, damage):
    path = whole / "summary.csv"
    assert read_csv(path, ["point", "rms"])["rms"].sum() == 3
    path.write_bytes(DAMAGE[damage](path.read_bytes()))
    with pytest.raises(ResultsDamaged, match=r"summary\.csv: "):
        read_csv(path, ["point", "rms"])


def test_a_table_that_ends_after_its_header_is_damaged(whole):
    (whole / "summary.csv").write_text("point,rms\n")
    with pytest.raises(ResultsDamaged, match=r"summary\.csv: has no rows"):
        read_csv(whole / "summary.csv", ["point", "rms"])


def test_what_a_file_lacks_is_named(whole):
    with pytest.raises(ResultsDamaged, match=r"psd\.nc: has no frequency, scenario; delete it"):
        read_netcdf(whole / "psd.nc", ["psd", "frequency", "scenario"])
    with pytest.raises(ResultsDamaged, match=r"summary\.csv: has no scenario; delete it"):
        read_csv(whole / "summary.csv", ["point", "scenario"])
    with pytest.raises(FileNotFoundError):  # the machine's, not a damage
        read_netcdf(whole / "none.nc")
