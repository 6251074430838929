"""`pidpanel new --modes`: a study from the modes of another solver that is checked as it stands."""

import numpy as np
import pytest
import scipy.stats

from pidpanel.cli import main
from pidpanel.structure.from_study import studied
from pidpanel.study import load_study
from tests.modal_files.conftest import AREAL_MASS, HEIGHT, WIDTH
from tests.modal_files.test_nastran import deck, frames, op2

NORMALISED = "EIGRL,1,,,4\nENDDATA"


@pytest.fixture
def new(tmp_path, monkeypatch, capsys):
    """(plate, cards, options) → status, study or None, what was printed."""
    monkeypatch.chdir(tmp_path)

    def run(plate, *options, unit=1.0, cards="ENDDATA", **content):
        basic = np.broadcast_to(np.eye(3), (len(plate.node), 3, 3))
        is_basic = unit != 1.0 or "values" in content
        (tmp_path / "plate.op2").write_bytes(
            op2(plate, basic if is_basic else frames(plate), **content)
        )
        text = deck(plate).replace("ENDDATA", cards)
        if is_basic:  # nodes in the basic frame
            nodes = "\n".join(
                f"GRID,{n},," + ",".join(f"{v!r}" for v in x)
                for n, x in zip(plate.node.tolist(), plate.position.tolist(), strict=True)
            )
            quads = [line for line in text.splitlines() if line.startswith("CQUAD")]
            text = "\n".join([nodes, *quads, cards, ""])
        (tmp_path / "plate.bdf").write_text(text)
        files = ["--modes", "plate.op2", "--mesh", "plate.bdf"]
        status = main(["new", "mine.yaml", "--force", *files, *options])
        printed = capsys.readouterr()
        study = load_study(tmp_path / "mine.yaml") if status == 0 else None
        return status, study, printed.out + printed.err

    return run


def test_a_study_has_the_unit_mass_and_side_of_the_modes(new, plate):
    _, study, _ = new(plate)
    structure = study.panel
    assert structure.modes.unit_m == 1.0
    assert structure.mass_kg == pytest.approx(AREAL_MASS * WIDTH * HEIGHT, rel=1e-5)
    assert abs(np.dot(structure.outward, plate.normal)) == pytest.approx(1, abs=2e-3)
    assert study.response.frequency_hz[1] <= plate.frequency[-1] / 2
    patches = studied(structure).patches
    assert all(0 < len(cells) < 30 for cells in patches.values())
    # the first mode moves most in the middle
    middle = plate.position.mean(axis=0)
    np.testing.assert_allclose(structure.patches["centre"].centre_m, middle, atol=0.1)


def test_millimetres_and_tonnes_are_told_from_metres(new, plate):
    small = plate._replace(position=1e3 * plate.position, modal_mass=1e-3 * plate.modal_mass)
    _, study, _ = new(small, unit=1e-3)
    assert study.panel.modes.unit_m == 0.001
    assert study.panel.mass_kg == pytest.approx(AREAL_MASS * WIDTH * HEIGHT, rel=1e-5)


def test_a_unit_that_is_not_clear_is_asked_for(new, plate):
    light = plate._replace(modal_mass=plate.modal_mass * 0.5 / AREAL_MASS)  # 78 kg/m² in feet
    status, _, printed = new(light)
    assert status == 2 and "possible are 1, 0.3048: --unit-m" in printed
    assert new(light, "--unit-m", "0.3048")[1].panel.modes.unit_m == 0.3048


def test_modes_that_a_deck_scales_to_one_need_no_masses(new, plate):
    scaled = plate._replace(displacement=plate.displacement * plate.modal_mass**-0.5)
    _, study, printed = new(scaled, cards=NORMALISED, masses=False)
    assert study.panel.modes.normalised == "mass" and "scaled to 1" in printed
    assert study.panel.mass_kg == pytest.approx(AREAL_MASS * WIDTH * HEIGHT, rel=1e-5)
    for cards in ("ENDDATA", NORMALISED.replace("4", "4,,,MAX")):
        status, _, printed = new(scaled, cards=cards, masses=False)
        assert status == 2 and "mode 1 has no modal mass" in printed
    status, study, _ = new(scaled, "--mass-normalised", masses=False)
    assert status == 0 and study.panel.modes.normalised == "mass"


def test_a_uniform_mass_is_stated_where_no_mode_has_one(new, plate):
    *options, mass = "--unit-m", "1", "--uniform-kg", "2.5"
    status, study, _ = new(plate, *options, mass, masses=False)
    assert status == 0 and study.panel.mass_kg == 2.5 and study.panel.modes.uniform_mass
    assert studied(study.panel).model.areal_mass == pytest.approx(2.5 / (WIDTH * HEIGHT))


def test_a_web_across_the_surface_tilts_its_direction_and_has_no_free_air(new, plate):
    """A T: each part has a direction that most of it faces."""
    middle = plate.node.reshape(9, 13)[4]
    lower = 1000 + np.arange(13)
    quads = np.stack([middle[:-1], middle[1:], lower[1:], lower[:-1]], axis=1)
    rows = plate.position.reshape(9, 13, 3)[4] - 0.2 * plate.normal
    motion = plate.displacement.reshape(9, 13, 3, -1)[4]
    tee = plate._replace(
        node=np.append(plate.node, lower),
        position=np.concatenate([plate.position, rows]),
        corners=np.concatenate([plate.corners, quads]),
        displacement=np.concatenate([plate.displacement, motion]),
    )
    values = (2 * np.pi * tee.frequency) ** 2
    _, study, _ = new(tee, values=values.tolist())
    outward = np.array(study.panel.outward)
    assert abs(outward @ plate.normal) > 0.9 * np.linalg.norm(outward)
    assert study.sound.surroundings == "baffle"


def test_rigid_modes_give_the_mass(new, plate):
    mixed = scipy.stats.ortho_group.rvs(3, random_state=1)  # of three translations of 3.1 kg
    motion = np.broadcast_to(mixed, (len(plate.node), 3, 3))
    free = plate._replace(
        displacement=np.concatenate([motion, plate.displacement[:, :, :1]], axis=2),
        modal_mass=np.array([3.1, 3.1, 3.1, 0.7]), frequency=np.array([0, 0, 0, 120.0]),
    )  # fmt: skip
    values = (2 * np.pi * free.frequency) ** 2
    _, study, printed = new(free, values=values.tolist())
    assert study.panel.mass_kg == pytest.approx(3.1, rel=1e-6) and "by the rigid modes" in printed


def test_modes_that_end_below_the_sound_are_refused(new, plate):
    slow = plate._replace(frequency=plate.frequency / 20)
    status, _, printed = new(slow)
    assert status == 2 and "end too low" in printed and printed.count("\n") == 1
