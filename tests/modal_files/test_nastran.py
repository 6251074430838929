"""OP2 and decks by the format's definition: frames of nodes, word sizes, masses, refusals."""

import struct

import numpy as np
import pytest

from pidpanel.modal_files import read_modes
from tests.modal_files.conftest import SIGNS

AREAL_MASS = 3.0  # [kg/m²], of the plate
LOCAL = np.array([[1.0, 2, 3], [1, 2, 4.5], [1, 3, 3]])  # origin, on z, in the xz plane


class Writer:
    """Tables of an OP2: Fortran records of keys and of what they announce."""

    def __init__(self, order="<", size=4):
        self.order, self.size, self.data = order, size, b""
        self.whole, self.real = {4: "if", 8: "qd"}[size]

    def record(self, content):
        length = struct.pack(f"{self.order}i", len(content))
        self.data += length + content + length

    def words(self, *values):
        """A key, and the words that it announces."""
        parts = []
        for value in values:
            if isinstance(value, str):  # four characters to a word
                text = value.encode().ljust(4 * -(-len(value) // 4))
                parts += [text[k : k + 4].ljust(self.size) for k in range(0, len(text), 4)]
            else:
                code = self.real if isinstance(value, float) else self.whole
                parts.append(struct.pack(self.order + code, value))
        self.key(sum(map(len, parts)) // self.size)
        self.record(b"".join(parts))

    def key(self, number):
        self.record(struct.pack(self.order + self.whole, number))

    def header(self):
        self.words(11, 26, 26)
        self.words("NASTRAN FORT TAPE ID CODE - ")
        self.words("XXXXXXXX")
        for key in (-1, 0):
            self.key(key)

    def table(self, name, records):
        self.words(f"{name:<8}")
        self.key(-1)
        self.words(101, 0, 0, 0, 0, 0, 0)
        for number, record in enumerate([[f"{name:<8}"], *records, None], 2):
            self.key(-number)
            self.words(0)
            if record is not None:
                half = len(record) // 2  # in two pieces, as large ones are
                for piece in filter(None, (record[:half], record[half:])):
                    self.words(*piece)
        self.key(0)


def identification(analysis, table, mode, value, form=1, case=1):
    return [10 * analysis + 1, table, 0, case, mode, value, 0.0, 0, form, 8, *136 * [0]]


def op2(
    plate,
    frames,
    *,
    order="<",
    size=4,
    masses=True,
    analysis=2,
    form=1,
    case=lambda _: 1,
    values=None,
):
    """Eigenvectors of a plate in the frames (n_nodes, 3, 3) of its nodes."""
    local = np.einsum("nij,nim->njm", frames, plate.displacement)  # Rᵀ u
    values = (2 * np.pi * plate.frequency) ** 2 if values is None else np.array(values)
    writer = Writer(order, size)
    writer.header()
    if masses:
        rows = [[k + 1, k + 1, float(value), float(abs(value) ** 0.5), float(f), float(m), float(m * value)]
                for k, (value, f, m) in enumerate(zip(values, plate.frequency, plate.modal_mass, strict=True))]  # fmt: skip
        writer.table(
            "LAMA", [identification(analysis, 6, 0, 0.0), [word for row in rows for word in row]]
        )
    records = []
    for k, value in enumerate(values.tolist()):
        records.append(identification(analysis, 7, k + 1, value, form, case(k)))
        scalar = [990001, 2, 7.0, 0.0, 0.0, 0.0, 0.0, 0.0]  # a scalar point
        points = ([10 * node + 1, 1, *map(float, u), 0.0, 0.0, 0.0]
                  for node, u in zip(plate.node.tolist(), local[:, :, k], strict=True))  # fmt: skip
        records.append(sum(points, scalar))
    writer.table("OUGV1", records)
    writer.key(0)
    return writer.data


def frames(plate):
    """Cylindrical and spherical axes about a local frame, by hand."""
    z = np.array([0, 0, 1.0])  # of LOCAL
    x, y = np.array([0, 1.0, 0]), np.array([-1.0, 0, 0])
    axes = np.broadcast_to(np.eye(3), (len(plate.node), 3, 3)).copy()
    for row in range(len(plate.node)):
        from_origin = plate.position[row] - LOCAL[0]
        height = from_origin @ z
        radial = from_origin - height * z
        radial /= np.linalg.norm(radial)
        ray = from_origin / np.linalg.norm(from_origin)
        around = np.cross(z, radial)
        if row % 4 == 1:
            axes[row] = np.stack([radial, around, z], axis=1)
        elif row % 4 == 2:
            axes[row] = np.stack([ray, np.cross(around, ray), around], axis=1)
        elif row % 4 == 3:
            axes[row] = np.stack([x, y, z], axis=1)
    return axes


def deck(plate):
    """Nodes in four frames: basic, cylindrical, spherical and rectangular, by GRDSET too."""
    card = {1: 21, 2: 22, 3: 23}
    points = ",".join(f"{value}" for value in LOCAL[:2].ravel())
    lines = [
        "SOL 103",
        "SET 7 = 100 THRU 103,",
        " 110",
        "SET 8 = ALL",
        "BEGIN BULK",
        "GRDSET,,,,,,23",
    ]
    for system, number in (("R", 23), ("C", 21), ("S", 22)):
        lines += [f"CORD2{system},{number},0,{points}", ",1.,3.,3."]
    for row, (node, x) in enumerate(zip(plate.node, plate.position, strict=True)):
        place, system, motion = x, "0", card.get(row % 4, 0)
        local = np.array([x[1] - 2, 1 - x[0], x[2] - 3])  # in 23: y → 1, −x → 2, z → 3
        if row % 4 == 1:
            place, system = (
                [np.hypot(*local[:2]), np.degrees(np.arctan2(local[1], local[0])), local[2]],
                21,
            )
        elif row % 4 == 2:
            distance = np.linalg.norm(local)
            place = [
                distance,
                *np.degrees([np.arccos(local[2] / distance), np.arctan2(local[1], local[0])]),
            ]
            system = 22
        elif row % 4 == 3:
            place, system, motion = local, 23, ""  # GRDSET
        x1, x2, x3 = (f"{value:.12g}" for value in place)
        lines += [
            f"GRID*   {node:<16}{system:<16}{x1:<16}{x2:<16}",
            f"*       {x3:<16}{motion!s:<16}",
        ]
    for k, corners in enumerate(plate.corners):
        first = f"CQUAD4,{100 + k},{7 + k % 2}," + ",".join(map(str, corners))
        lines.append(first if k % 3 else first.replace("CQUAD4", "CQUADR"))
    return "\n".join([*lines, "RBE2,999,5,123,8", "CONM2,998,5,,1.", "ENDDATA", ""])


def read(tmp_path, plate, data, **options):
    (tmp_path / "plate.op2").write_bytes(data)
    (tmp_path / "plate.bdf").write_text(deck(plate))
    return read_modes(tmp_path / "plate.op2", tmp_path / "plate.bdf", 1.0, **options)


@pytest.mark.parametrize(("order", "size"), [("<", 4), (">", 4), ("<", 8), (">", 8)])
def test_modes_in_the_frames_of_nodes_are_those_of_the_basic_frame(plate, tmp_path, order, size):
    model = read(tmp_path, plate, op2(plate, frames(plate), order=order, size=size))
    np.testing.assert_allclose(model.position, plate.position, atol=1e-9)
    np.testing.assert_allclose(model.displacement, plate.displacement, atol=2e-7)
    np.testing.assert_allclose(model.frequency, plate.frequency, rtol=1e-6)
    np.testing.assert_allclose(model.areal_mass, AREAL_MASS, rtol=1e-6)
    assert {name: len(cells) for name, cells in model.groups.items()} == {
        "7": 48,
        "8": 48,
        "SET 7": 5,
    }
    np.testing.assert_array_equal(model.groups["SET 7"], [0, 1, 2, 3, 10])


def test_modes_without_masses_may_be_declared(plate, tmp_path):
    plate = plate._replace(displacement=plate.displacement * plate.modal_mass**-0.5)
    data = op2(plate, frames(plate), masses=False)
    assert read(tmp_path, plate, data, normalised="mass").areal_mass == pytest.approx(AREAL_MASS)
    with pytest.raises(ValueError, match=r"plate.op2 with plate.bdf: mode 1 has no modal mass"):
        read(tmp_path, plate, data)


def test_static_displacements_are_cases_without_frequency(plate, tmp_path):
    (tmp_path / "static.op2").write_bytes(op2(plate, frames(plate), masses=False, analysis=1))
    model = read(tmp_path, plate, op2(plate, frames(plate)), static=tmp_path / "static.op2")
    np.testing.assert_allclose(model.static_displacement, plate.displacement, atol=2e-7)
    assert model.displacement.shape[2] == 4


def test_broken_op2_are_refused(plate, tmp_path):
    data = op2(plate, frames(plate))
    cases = {
        "has no real eigenvectors, only complex": op2(plate, frames(plate), analysis=9, form=2),
        "is no OP2 of Nastran, or is cut off": data[: len(data) // 2 + 1],
        r"has modes of subcases \[1, 2\]; one is allowed": op2(
            plate, frames(plate), case=lambda mode: 1 + mode // 2
        ),
    }
    for message, content in cases.items():
        with pytest.raises(ValueError, match=message):
            read(tmp_path, plate, content)
    with pytest.raises(ValueError, match="is no OP2"):
        read(tmp_path, plate, b"SOL 103\nCEND\n")


def test_a_mesh_of_another_model_is_refused(plate, tmp_path):
    data = op2(plate, frames(plate))
    fewer = plate._replace(node=plate.node[:-1], displacement=plate.displacement[:-1])
    partial = op2(fewer, frames(plate)[:-1])
    with pytest.raises(ValueError, match="element 195: its node 5 is not in the modes; 1 elements"):
        read(tmp_path, plate, partial)
    other = plate._replace(corners=plate.corners + 4 * (np.arange(4) == 3))
    with pytest.raises(ValueError, match=r"element 100: its node \d+ is not in the mesh"):
        read(tmp_path, other, data)


def test_decks_include_files_of_their_folder_alone(plate, tmp_path):
    (tmp_path / "plate.op2").write_bytes(op2(plate, frames(plate)))
    control, bulk = deck(plate).split("BEGIN BULK\n")
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "mesh.bdf").write_text(bulk)
    main = tmp_path / "main.bdf"
    main.write_text(f"{control}BEGIN BULK\nINCLUDE 'parts/mesh.bdf'\nENDDATA\n")
    model = read_modes(tmp_path / "plate.op2", main, 1.0)
    np.testing.assert_allclose(model.displacement, plate.displacement, atol=2e-7)
    (tmp_path / "deep").mkdir()
    outside = tmp_path / "deep" / "main.bdf"
    outside.write_text("BEGIN BULK\nINCLUDE '../parts/mesh.bdf'\n")
    with pytest.raises(ValueError, match=r"main.bdf:2: '../parts/mesh.bdf' is not a file in"):
        read_modes(tmp_path / "plate.op2", outside, 1.0)
    main.write_text("BEGIN BULK\nGRID,5,99,0.,0.,0.\n")
    with pytest.raises(ValueError, match="coordinate system 99 must be a CORD1R"):
        read_modes(tmp_path / "plate.op2", main, 1.0)


def test_rigid_motions_have_no_frequency_and_unstable_modes_are_refused(plate, tmp_path):
    values = [-1e-3, 1e-4, 5e3, 2e4]
    frequency = np.sign(values) * np.sqrt(np.abs(values)) / (2 * np.pi)
    data = op2(plate, frames(plate), values=values)
    assert read(tmp_path, plate, data).frequency == pytest.approx([0, 0, *frequency[2:]])
    with pytest.raises(ValueError, match=r"mode 1 has -1.59\d+ Hz; 0 to 1e"):
        read(tmp_path, plate, op2(plate, frames(plate), values=[-100.0, 1.0, 5e3, 2e4]))


@pytest.mark.parametrize(("middles", "cells"), [("5,6,7,8", 5), ("5,6,,8", 1), ("", 1)])
def test_middles_of_quadratic_shells_may_be_blank(plate, tmp_path, middles, cells):
    square = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1]]
    lines = [f"GRID,{k},,{x}.,{y}.,0." for k, (x, y) in enumerate(square, 1)]
    text = "\n".join(
        [
            *lines,
            f"CQUAD8,9,3,1,2,3,4,{middles}".replace("5,6,7,8", "5,6,\n,7,8").replace(
                "5,6,,8", "5,6,\n,,8"
            ),
            "",
        ]
    )
    eight = plate._replace(node=np.arange(1, 9), displacement=np.ones((8, 1, 1)) * SIGNS)
    (tmp_path / "plate.op2").write_bytes(op2(eight, np.broadcast_to(np.eye(3), (8, 3, 3))))
    (tmp_path / "square.bdf").write_text(text)
    model = read_modes(tmp_path / "plate.op2", tmp_path / "square.bdf", 1.0)
    assert len(model.cells) == cells
    np.testing.assert_allclose(model.modal_mass / model.areal_mass, 4 * 3)  # 4 m², |φ|² of 3
