"""Frequency responses of a damper."""

import pytest
import pyuff


@pytest.fixture
def force_file(tmp_path):
    """(values, lines, changed fields of pyuff) → a universal file of force over acceleration."""

    def write(values, lines, **changes):
        data = {
            "type": 58, "func_type": 4, "rsp_node": 1, "rsp_dir": 3, "ref_dir": 3, "ref_node": 1,
            "data": values, "x": lines, "id1": "damper", "ordinate_spec_data_type": 13,
            "ordinate_axis_units_lab": "N", "orddenom_spec_data_type": 12,
            "orddenom_axis_units_lab": "m/s^2", "ord_data_type": 6, "abscissa_spacing": 1,
            "version_num": 1, "load_case_id": 0, "rsp_ent_name": "a", "ref_ent_name": "b",
        }  # fmt: skip
        pyuff.UFF(str(tmp_path / "frf.uff")).write_sets([data | changes], "overwrite")
        return tmp_path / "frf.uff"

    return write
