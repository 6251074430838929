"""Files of a study are read once, to the size that they state, and none is waited for."""

import os

import pytest

from pidpanel.damping.table_files import read_columns
from pidpanel.panel.gmsh_files import read_gmsh
from pidpanel.panel.nastran import read_nastran
from pidpanel.text_files import TextFileError, read_bytes, read_text

ENDLESS = "/proc/self/status"  # a file that states no bytes, as /proc/kmsg, which never ends


def test_a_file_that_states_no_bytes_is_empty(tmp_path):
    for name in ("table.csv", "panel.msh", "panel.bdf"):
        (tmp_path / name).symlink_to(ENDLESS)
    assert read_text(tmp_path / "table.csv") == ""
    with pytest.raises(ValueError, match=r"table\.csv") as told:
        read_columns(tmp_path / "table.csv")
    assert "State" not in str(told.value)
    with pytest.raises(ValueError, match="must begin with"):
        read_gmsh(tmp_path / "panel.msh")
    with pytest.raises(ValueError, match=r"panel\.bdf") as told:
        read_nastran(tmp_path / "panel.bdf", ())
    assert "State" not in str(told.value)


@pytest.mark.parametrize("name", ["pipe.msh", "/dev/zero", "/dev/full", "."])
def test_what_is_no_file_is_not_read(tmp_path, name):
    os.mkfifo(tmp_path / "pipe.msh")
    with pytest.raises(TextFileError, match="must be a file"):
        read_bytes(tmp_path / name)
    with pytest.raises(ValueError, match="must be a file"):
        read_gmsh(tmp_path / name)
    with pytest.raises(ValueError, match="must be a file"):
        read_columns(tmp_path / name)
