"""Whatever somebody else's file holds, it is read or refused by name, and nothing else happens.

`make fuzz` draws many more examples than the tests do, and others each time.
"""

import dataclasses
import json
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pidpanel.check import checked_study
from pidpanel.columns import ColumnsError
from pidpanel.coupon import records
from pidpanel.coupon.liggghts import failures, output
from pidpanel.coupon.records import RunState
from pidpanel.damping.table_files import read_columns
from pidpanel.panel.gmsh_files import read_gmsh
from pidpanel.panel.nastran import read_nastran
from pidpanel.paths import DATA, WORKFLOW
from pidpanel.sound.table import read_spectrum
from pidpanel.study import StudyError

GOLDEN = Path(__file__).parents[1] / "coupon" / "liggghts" / "golden" / "shake"
MANY = int(os.environ.get("PIDPANEL_FUZZ", "0"))
fuzzed = settings(
    max_examples=MANY or 40,
    derandomize=not MANY,
    deadline=None,
    suppress_health_check=list(HealthCheck),
)

PIECES = st.sampled_from(
    [b"", b"\x00", b"\xff\xfe", b"nan", b"-inf", b"1e999", b"-", b",", b"\n", b"\t", b"\r", b": ",
     b"{", b"}", b"[", b"]", b"&a ", b"*a", b"!!python/object/apply:os.system [x]", b"'", b'"', b"#",
     b"../../x", b"$(touch hit)", b"0", b"9" * 40, b"\xe2\x80\xae", b"GRID,", b"CQUAD4"]
) | st.binary(max_size=8)  # fmt: skip


@st.composite
def garbled(draw, data):
    """The bytes of a file with some pieces of it cut out, doubled or replaced."""
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(data)))
        stop = min(len(data), start + draw(st.integers(0, 40)))
        put = draw(PIECES | st.just(data[start:stop] * 2))
        data = data[:start] + put + data[stop:]
    return data


def reads():
    """Of each kind of file one that is right, how it is read, and how it may be refused."""
    table = Path(__file__).parents[1] / "damping" / "data"
    mesh = WORKFLOW / "studies" / "bdf_panel.bdf"
    kinds = {
        "study": (WORKFLOW / "studies" / "smoke.yaml", checked_study, StudyError),
        "sound": (DATA / "spl" / "smc_s_016_2014_min_third.csv", read_spectrum, ValueError),
        "damping": (DATA / "damping" / "acrylic_2mm.csv", read_columns, ColumnsError),
        "nastran": (mesh, read_nastran, ValueError),
        "rows": (
            GOLDEN / "cycles_1.txt",
            lambda path: output.read_cycles(
                path.read_text(errors="replace"), "rows", steps_per_cycle=1000, cycles=12
            ),
            failures.SolverFailure,
        ),
        "dump": (
            GOLDEN / "last.dump",
            lambda path: output.read_dump(
                path.read_text(errors="replace"), "dump", output.POSITION_AND_VELOCITY
            ),
            failures.SolverFailure,
        ),
    }
    assert table.is_dir()
    return kinds


READS = reads()


@pytest.mark.parametrize("kind", list(READS))
def test_a_garbled_file_is_read_or_refused_by_name(kind, tmp_path_factory):
    right, read, refusal = READS[kind]
    folder = tmp_path_factory.mktemp(kind)
    file = folder / right.name
    whole = right.read_bytes()
    file.write_bytes(whole)
    read(file)

    @fuzzed
    @given(garbled(whole))
    def look(data):
        file.write_bytes(data)
        try:
            read(file)
        except refusal as error:
            assert str(error)
            # one of ours, not whatever of that kind a library came upon
            assert str(folder) in str(error) or refusal is not ValueError, error
        assert list(folder.iterdir()) == [file]

    look()


@fuzzed
@given(data=st.binary(max_size=200))
def test_a_mesh_of_gmsh_is_read_or_refused_by_name(data, tmp_path_factory):
    file = tmp_path_factory.mktemp("gmsh") / "mesh.msh"
    file.write_bytes(b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + data)
    with pytest.raises(ValueError, match=r"mesh\.msh"):
        read_gmsh(file)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=8,
)


@fuzzed
@given(st.sampled_from(sorted(RunState.__dataclass_fields__)), JSON)
def test_a_record_takes_what_is_of_its_kind_or_refuses_it(tmp_path_factory, key, value):
    file = tmp_path_factory.mktemp("record") / "state.json"
    values = dataclasses.asdict(RunState("a", 1, 1e-6, (), (), 0, {})) | {key: value}
    file.write_text(json.dumps(values))
    try:
        found = records.read(RunState, file)
    except failures.RecordUnreadable as error:
        assert key in str(error)
    else:
        records.write(file, found)
        assert records.read(RunState, file) == found or value != value
