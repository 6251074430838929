"""Universal files written by pyuff and by the format's specification."""

import numpy as np
import pytest
import pyuff

from pidpanel.modal_files import read_modes
from tests.modal_files.conftest import SIGNS

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


MILLIMETRES = 5, 1e3, 1e3  # mN: masses in kg
INCHES = 7, 39.37, 0.224809


@pytest.mark.parametrize("unit", [MILLIMETRES, INCHES])
def test_data_set_164_states_the_units_of_length_and_mass(plate, tmp_path, unit):
    _, length, force = unit
    heavy = plate._replace(modal_mass=plate.modal_mass * force / length)  # N s²/m in the file's
    model = read_modes(write(tmp_path / "plate.unv", heavy, unit=unit))
    np.testing.assert_allclose(np.sort(model.position, 0), np.sort(plate.position, 0), atol=1e-5)
    np.testing.assert_allclose(model.modal_mass, plate.modal_mass, rtol=1e-4)


def test_modes_and_mesh_may_be_in_two_files(plate, tmp_path):
    modes = write(tmp_path / "modes.uff", plate, skip=(164, 2411, 2412))
    mesh = write(tmp_path / "mesh.unv", plate, skip=(55,))
    assert len(read_modes(modes, mesh).cells) == 96
    with pytest.raises(ValueError, match=r"unit_m = 0.001 contradicts 1 of data set 164"):
        read_modes(modes, mesh, 1e-3)
    mesh = write(tmp_path / "mesh.unv", plate, skip=(55, 164))
    with pytest.raises(ValueError, match=r"modes.uff with mesh.unv: unit_m is missing"):
        read_modes(modes, mesh)
    with pytest.raises(ValueError, match=r"modes.uff: no surface elements; triangles"):
        read_modes(modes, unit_m=1.0)


def analysis_2414(plate, *, kind=2, data=2, location=1, width=3, exponent="E"):
    """Displacements at nodes by the specification of data set 2414."""
    text = ""
    for k, frequency in enumerate(plate.frequency, 1):
        integers = lambda *values: "".join(f"{value:10}" for value in values) + "\n"  # noqa: E731
        reals = lambda *values: "".join(f"{value:13.5E}" for value in values) + "\n"  # noqa: E731
        text += "    -1\n  2414\n" + integers(k) + f"mode {k}\n" + integers(location)
        text += 5 * "none\n" + integers(1, kind, 2 if width == 3 else 3, 8, data, width)
        text += integers(0, 0, 1, 0, 1, k, 0, 0) + integers(0, 0)
        text += reals(0, frequency, 0, plate.modal_mass[k - 1], 0, 0) + reals(0, 0, 0, 0, 0, 0)
        for node, vector in zip(plate.node, plate.displacement[:, :, k - 1], strict=True):
            text += integers(node) + reals(*vector, *(width - 3) * [9.0])
        text += "    -1\n"
    return text.replace("E", exponent)


@pytest.mark.parametrize(("width", "exponent"), [(3, "E"), (6, "E"), (3, "D")])
def test_analysis_data_at_nodes_are_modes_too(plate, tmp_path, width, exponent):
    path = write(tmp_path / "plate.unv", plate, skip=(55,))
    with path.open("a") as stream:
        stream.write(analysis_2414(plate, width=width, exponent=exponent))
    model = read_modes(path)
    order = np.argsort(model.node_number)[np.argsort(np.argsort(plate.node))]
    np.testing.assert_allclose(model.displacement[order], plate.displacement, atol=1e-5)
    np.testing.assert_allclose(model.areal_mass, 3.0, rtol=1e-4)


def test_nodes_of_single_precision_and_lines_of_windows_are_read(plate, tmp_path):
    path = write(tmp_path / "plate.uff", plate, skip=(2411,))
    lines = [f"{n:10}{0:10}{0:10}{0:10}{x:13.5E}{y:13.5E}{z:13.5E}\n"
             for n, (x, y, z) in zip(plate.node, plate.position, strict=True)]  # fmt: skip
    text = path.read_text() + "    -1\n    15\n" + "".join(lines) + "    -1\n"
    path.write_bytes(text.replace("\n", "\r\n").encode())
    np.testing.assert_allclose(read_modes(path).areal_mass, 3.0, rtol=1e-4)


def test_quadratic_elements_go_round_their_nodes(plate, tmp_path):
    eight = plate._replace(
        node=np.arange(1, 9),
        position=np.array([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]]) @ np.eye(2, 3),
        corners=np.arange(1, 9)[None],
        displacement=np.ones((8, 1, 1)) * SIGNS,
    )  # fmt: skip
    path = write(tmp_path / "plate.uff", eight)
    path.write_text(path.read_text().replace("        94", "        95").replace(
        f"{1:10}{4:10}\n         1", f"{1:10}{8:10}\n         1"))  # fmt: skip
    model = read_modes(path)
    area = np.cross(
        *np.swapaxes(np.diff(model.position[model.cells][:, [0, 1, 0, 3]], axis=1)[:, ::2], 0, 1)
    )
    assert (area[:, 2] > 0).all()
    assert model.modal_mass / model.areal_mass == pytest.approx(4 * 3)  # area of 4 m², |φ|² of 3


def test_modes_that_are_complex_or_without_mass_are_refused(plate, tmp_path):
    path = write(tmp_path / "plate.uff", plate, mass=0.0)
    with pytest.raises(ValueError, match="mode 1 has no modal mass; state normalised: mass"):
        read_modes(path)
    text = path.read_text()
    for kinds in ("3", "7"):  # of complex eigenvalues
        path.write_text(text.replace(f"{1:10}{2:10}{2:10}{8:10}", f"{1:10}{kinds:>10}{2:10}{8:10}"))
        with pytest.raises(
            ValueError, match="has complex modes alone; real normal modes are needed"
        ):
            read_modes(path)
    complex_ = plate._replace(displacement=plate.displacement * (1 + 0.01j))
    with pytest.raises(ValueError, match="has complex modes alone; real normal modes are needed"):
        read_modes(write(path, complex_, data=5))


def test_normal_modes_written_as_complex_numbers_in_phase_are_real(plate, tmp_path):
    in_phase = plate._replace(displacement=plate.displacement * (1 + 1e-5j))
    model = read_modes(write(tmp_path / "plate.uff", in_phase, data=5))
    np.testing.assert_allclose(model.areal_mass, 3.0, rtol=1e-4)


def test_a_largest_rotation_of_one_is_no_mass_of_one(plate, tmp_path):
    path = write(tmp_path / "plate.unv", plate, skip=(55,))
    changes = {"modal_mass": 0 * plate.modal_mass, "displacement": plate.displacement / 2}
    scaled = analysis_2414(plate._replace(**changes), width=6)
    path.write_text(path.read_text() + scaled.replace("9.00000E+00", "1.00000E+00"))
    with pytest.raises(ValueError, match="largest components of all modes are 1"):
        read_modes(path, normalised="mass")


def test_a_uniform_mass_gives_those_of_modes_of_any_scale(plate, tmp_path):
    scales = np.array([0.3, 2.0, 7.0, 1.0])
    free = plate._replace(displacement=plate.displacement * scales)
    path = write(tmp_path / "plate.uff", free, mass=0.0)
    model = read_modes(path, uniform_kg=2.88)  # 3 kg/m² on 1.2 m × 0.8 m
    np.testing.assert_allclose(model.modal_mass, plate.modal_mass * scales**2, rtol=1e-4)
    for file, options in ((path, {"normalised": "mass"}), (write(tmp_path / "m.uff", plate), {})):
        with pytest.raises(ValueError, match="only allowed for modes without masses or scale"):
            read_modes(file, uniform_kg=2.88, **options)


def test_broken_universal_files_are_refused(plate, tmp_path):
    path = write(tmp_path / "plate.uff", plate)
    text = path.read_text()
    cases = {
        "data set 55: its values are not rows of 4 numbers": text.replace(
            "\n       278\n", "\nx\n", 1
        ),
        "data set 2412: an element after": text.replace(
            "         7         1         1         4\n", "\n", 1
        ),
        "its nodes are in the frames 0, 5; one for all is allowed": text.replace(
            f"{plate.node[0]:10}{0:10}{0:10}", f"{plate.node[0]:10}{0:10}{5:10}", 1
        ),
        "data set 2411: its values are not rows of 7": text.replace(
            "    -1\n    -1\n  2412", "1 2\n    -1\n    -1\n  2412"
        ),
    }
    for message, content in cases.items():
        assert content != text
        path.write_text(content)
        with pytest.raises(ValueError, match=message):
            read_modes(path)
    with pytest.raises(
        ValueError, match=r"plate.txt: modes cannot be in this format; allowed are .vtu"
    ):
        read_modes(tmp_path / "plate.txt")
    with pytest.raises(ValueError, match=r"none.uff: cannot be read: No such file"):
        read_modes(tmp_path / "none.uff")
