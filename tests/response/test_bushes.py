"""Dampers for Nastran: read back, and solved as a second system of equations."""

import numpy as np
import pytest

from pidpanel.response.from_study import read_response_panel, write_export
from pidpanel.response.nastran import grid_areas, write_bushes
from pidpanel.response.psd_files import read_psd
from pidpanel.study import load_study
from tests.jobs import RESPONSE, call, make_panel, make_sound, within
from tests.jobs import files as named


def cards(path):
    """[name, *fields] of each card by the columns of the format, 8 or 16 characters a field."""
    found = []
    for line in path.read_text().splitlines():
        if line.startswith("$"):
            continue
        width = 16 if "*" in line[:8] else 8
        fields = [line[k : k + width].strip() for k in range(8, 72, width)]
        name = line[:8].strip().rstrip("*")
        if name:
            found.append([name, *fields])
        else:
            found[-1] += fields
    return found


def cards_of_pyyeti(path):
    """The same by pyYeti's reader of bulk data."""
    with np.printoptions():  # which pyYeti sets for all others
        bulk = pytest.importorskip("pyyeti.nastran.bulk")
    names = ("GRID", "CBUSH", "PBUSHT", "TABLED1")
    rows = [
        [name, *row]
        for name in names
        for row in bulk.rdcards(str(path), rf"{name}\*?\s", regex=True, return_var="list")
    ]
    return [[str(field) for field in row] for row in rows]


READERS = pytest.mark.parametrize("read", [cards, cards_of_pyyeti])


def springs(deck):
    """{vertex: f → K + iωB [N/m]} of a deck, as Nastran attaches them."""
    tables, properties, found = {}, {}, {}
    for name, *fields in deck:
        if name == "TABLED1":
            values = [field for field in fields[3:] if field and field != "LINEAR"]
            end = values.index("ENDT")
            tables[int(float(fields[0]))] = np.array(values[:end], float).reshape(-1, 2).T
        elif name == "PBUSHT":
            assert (fields[1], fields[9]) == ("K", "B")
            properties[int(fields[0])] = [int(fields[4]), int(fields[12])]  # component 3
        elif name == "CBUSH":
            assert not any(fields[3:7]) and fields[7] == "0"  # grounded, basic system
            found[int(fields[2]) - 1] = int(fields[1])

    def at(number):
        stiffness, damping = (tables[table] for table in properties[number])
        return lambda f: np.interp(f, *stiffness) + 2j * np.pi * f * np.interp(f, *damping)

    return {vertex: at(number) for vertex, number in found.items()}


@READERS
def test_the_springs_of_a_patch_add_up_to_its_damper(tmp_path, read):
    vertices = np.array([[0.0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1], [0.5, 0.1]])
    cells = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2]])
    frequency = np.linspace(20.0, 400.0, 400)
    damping = (30 * frequency**0.5, 5 - 0.01 * frequency)
    inside = {"a": np.array([True, True, False])}
    path = tmp_path / "dampers.bdf"
    write_bushes(path, "study", frequency, {"a": damping}, vertices, cells, inside)
    attached = springs(read(path))
    assert sorted(attached) == [0, 1, 2, 3]
    for f in (20.0, 77.7, 400.0):
        expected = 0.02 * (2j * np.pi * f * 30 * f**0.5 - (2 * np.pi * f) ** 2 * (5 - 0.01 * f))
        assert sum(spring(f) for spring in attached.values()) == pytest.approx(expected, rel=3e-4)
    # corners of two triangles of the patch have twice the share of the others
    assert attached[0](50.0) == pytest.approx(2 * attached[1](50.0))


@pytest.mark.parametrize("split", [False, True], ids=["rectangles", "triangles"])
def test_the_areas_of_grids_integrate_a_wave_over_a_patch(split):
    x, y = np.meshgrid(np.linspace(-0.1, 0.1, 9), np.linspace(-0.05, 0.05, 5))
    corner = (np.arange(4)[:, None] * 9 + np.arange(8)).ravel()
    cells = corner[:, None] + [0, 1, 10, 9]
    if split:
        cells = np.vstack([cells[:, [0, 1, 2]], cells[:, [0, 3, 2]]])
    areas = grid_areas(np.stack([x.ravel(), y.ravel()], axis=1), cells)
    assert areas.min() > 0 and areas.sum() == pytest.approx(0.02)
    assert areas @ x.ravel() ** 2 == pytest.approx(0.02 * 0.2**2 / 12)
    k = 2 * np.pi / 0.9  # ∫ cos² kx dA over the patch
    integral = 0.02 * (1 + np.sin(0.2 * k) / (0.2 * k)) / 2
    assert areas @ np.cos(k * x.ravel()) ** 2 == pytest.approx(integral, rel=1.5e-3)


@pytest.fixture(scope="module")
def layouts(tmp_path_factory, write_study, law_values):
    """Folder and study of two dampers together on a fine mesh, one of which follows its motion."""
    folder = tmp_path_factory.mktemp("bushes")
    values = law_values()
    values["dampers"] = {
        "lab": {"table": "lab.csv"},
        "pot": {"equivalent_damping_n_s_m3": 900, "apparent_mass_kg_m2": 2},
    }
    values["panel"]["mesh"]["elements"] = [60, 40]
    filled = {"damper": "lab", "fill_fraction": 0.5}
    values["scenarios"] = {"both": {"layout": {"PID-1": filled, "Left wing": {"damper": "pot"}}}}
    study = write_study(folder, "layouts", values)
    make_panel(study, folder)
    make_sound(study, folder)
    files = within(folder, RESPONSE | {"modes": "modes.nc", "modal_force": "modal_force.nc"})
    files |= within(folder, {"plate": "plate.nc", "section": "section.csv"})
    call("response", study, files, within(folder, RESPONSE))
    loaded = load_study(study)
    write_export(loaded, files["modes"], files["psd"], files["summary"], folder / "export")
    return folder, loaded, files


@pytest.mark.slow
@READERS
def test_a_deck_read_back_and_solved_densely_gives_the_response(layouts, read):
    # the same modes and sound; springs at the vertices for the integral over the patch, whose
    # elements are 25 mm: 7e-4 of the PSD
    folder, study, files = layouts
    attached = springs(read(folder / "export" / "dampers_both.bdf"))
    panel = read_response_panel(study, named({"air": None} | files))
    basis, psd = panel.basis, read_psd(files["psd"])
    lines = psd["frequency"].to_numpy()
    chosen = np.arange(5, lines.size, lines.size // 40)
    expected = psd["acceleration_psd"].sel(scenario="both").to_numpy()[chosen]
    shape = basis.shape_at_vertices[list(attached)]
    for f, values in zip(lines[chosen], expected, strict=True):
        spring = np.array([value(f) for value in attached.values()])
        omega, natural = 2 * np.pi * f, 2 * np.pi * basis.natural_frequency
        loss = 2j * omega * natural * panel.settings.damping_ratio.of_modes(basis.natural_frequency)
        dynamic = np.diag(basis.modal_mass * (natural**2 - omega**2 + loss))
        motion = np.linalg.solve(
            dynamic + shape.T @ (spring[:, None] * shape), np.eye(len(natural))
        )
        force = panel.excitation.spectrum(np.array([f]))[0] * panel.excitation(np.array([f]))[0]
        at_points = basis.shape_at_points @ motion
        response = omega**4 * np.einsum("pi,ij,pj->p", at_points, force, at_points.conj()).real
        np.testing.assert_allclose(response, values, rtol=1.5e-3)
