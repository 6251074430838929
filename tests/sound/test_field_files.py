"""What is written of a sound field is what is read."""

import numpy as np
import pytest

from pidpanel.sound.field_files import ADDED_VOLUME, MODAL_FORCE, read_table, write_tables
from pidpanel.sound.wavenumber_table import WavenumberTable, chebyshev_nodes


def test_tables_on_different_nodes_come_back_from_one_file(tmp_path):
    random = np.random.default_rng(4)
    wave = WavenumberTable(
        5.0, chebyshev_nodes(5.0, 3), random.standard_normal((3, 2, 2)), random.random((3, 2, 2))
    )
    mass = WavenumberTable(7.0, chebyshev_nodes(7.0, 4), random.standard_normal((4, 2, 2)))
    path = tmp_path / "tables.nc"
    write_tables(path, {MODAL_FORCE: wave, ADDED_VOLUME: mass}, {"study": "x"})
    for name, table in ((MODAL_FORCE, wave), (ADDED_VOLUME, mass)):
        read = read_table(path, name)
        np.testing.assert_array_equal(read.matrix([0.3, 4.9]), table.matrix([0.3, 4.9]))
        assert read.wavenumber_max == table.wavenumber_max
    with pytest.raises(KeyError):
        read_table(path, "diffuse_modal_force")
