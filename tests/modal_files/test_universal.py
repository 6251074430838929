"""Universal files written by pyuff and by the format's specification."""

import numpy as np
import pyuff

from pidpanel.modal_files import read_modes

# Elements 100 and 103 and node 101, by the specification of data set 2467
GROUPS = (
    "    -1\n  2467\n"
    + "".join(
        "".join(f"{value:10}" for value in row) + "\n" if isinstance(row, list) else f"{row}\n"
        for row in (
            [1, 0, 0, 0, 0, 0, 0, 3],
            "left wing",
            [8, 100, 0, 0, 8, 103, 0, 0],
            [7, 101, 0, 0],
        )
    )
    + "    -1\n"
)


def write(path, plate, *, kind=2, data=2, unit=(1, 1.0, 1.0), mass=True, nodes=2411, skip=()):
    file = pyuff.UFF(str(path))
    x, y, z = unit[1] * plate.position.T
    count = len(plate.node)
    zeros = np.zeros(count, dtype=int)
    sets = [
        pyuff.prepare_164(units_code=unit[0], units_description="text", temp_mode=1,
                          length=unit[1], force=unit[2], temp=1.0, temp_offset=0.0),
        {"type": nodes, "node_nums": plate.node, "def_cs": zeros, "disp_cs": zeros,
         "color": zeros, "x": x, "y": y, "z": z},
        {"type": 2412, 94: [{"element_nums": 100 + k, "fe_descriptor": 94, "phys_table": 7 + k % 2,
                             "mat_table": 1, "color": 1, "num_nodes": 4, "nodes_nums": corners}
                            for k, corners in enumerate(plate.corners)]},
        *(pyuff.prepare_55(model_type=1, id1="a", id2="b", id3="c", id4="d", id5="e",
                           analysis_type=kind, data_ch=2, spec_data_type=8, data_type=data,
                           r1=r1, r2=r2, r3=r3, n_data_per_node=3, node_nums=plate.node,
                           load_case=1, mode_n=k + 1, modal_m=mass * plate.modal_mass[k],
                           freq=float(plate.frequency[k]), modal_damp_vis=0.0, modal_damp_his=0.0)
          for k, (r1, r2, r3) in enumerate(plate.displacement.transpose(2, 1, 0)))]  # fmt: skip
    file.write_sets([part for part in sets if part["type"] not in skip], "overwrite")
    with path.open("a") as stream:
        stream.write(GROUPS)
    return path


def test_modes_of_a_universal_file_are_those_written(plate, tmp_path):
    model = read_modes(write(tmp_path / "plate.uff", plate))
    order = np.argsort(model.node_number)[np.argsort(np.argsort(plate.node))]
    np.testing.assert_allclose(model.position[order], plate.position, atol=1e-6)
    np.testing.assert_allclose(model.displacement[order], plate.displacement, rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(model.frequency, plate.frequency, rtol=1e-5)
    np.testing.assert_allclose(model.areal_mass, 3.0, rtol=1e-4)
    assert {name: len(cells) for name, cells in model.groups.items()} == {
        "7": 48, "8": 48, "left wing": 2
    }  # fmt: skip
