"""Maps in the report."""

import numpy as np
import pytest

from pidpanel.report.maps_section import _exceeded_by, map_figure
from pidpanel.response.mapping import UNITS, map_dataset


@pytest.fixture
def maps():
    """A 2 × 1 panel of two cells; the acceleration rises from 0 to 50 m/s²."""
    vertices = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0]])
    cells = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
    one = {name: np.linspace(0, 50, 6) for name in ("acceleration", "displacement")}
    one |= {name: 1e6 * np.linspace(0, 3, 12).reshape(2, 6) for name in UNITS if name not in one}
    return map_dataset({"bare": one, "A_r0.5": one}, [0.1, 0.2], vertices, cells, ["t", "b"])


def test_each_map_has_its_unit_and_one_scale(maps):
    # means of the corners: 30 m/s² and 27/11 MPa in the second cell
    figure = map_figure(maps, np.array([[True, False]]), ["bare panel", "A"])
    labels = [ax.get_ylabel() for ax in figure.axes]
    assert "rms acceleration, g" in labels and "rms von Mises stress, MPa" in labels
    tops = [ax.collections[0].levels[-1] for ax in figure.axes[:4]]
    assert tops == pytest.approx([30 / 9.80665] * 2 + [27 / 11] * 2)


def test_one_singular_corner_does_not_take_the_colours():
    values, area = np.append(np.linspace(0, 1, 999), 1e6)[None], np.ones(1000)
    assert _exceeded_by(values, area) == pytest.approx(0.99, abs=0.01)


def test_ticks_of_a_colour_bar_lie_where_their_values_are(maps):
    figure = map_figure(maps, np.array([[True, False]]), ["bare panel", "A"])
    figure.draw_without_rendering()
    for bar in (ax for ax in figure.axes if ax.get_label() == "<colorbar>"):
        field = next(ax for ax in figure.axes if ax.get_label() != "<colorbar>")
        assert field.collections[0].levels[0] == 0
        low, high = bar.get_ylim()
        ticks = bar.get_yticks()
        assert len(ticks) >= 3 and low <= min(ticks) and max(ticks) <= high
        # in equal steps of the values and of the bar
        assert np.ptp(np.diff(ticks)) < 1e-9
        labels = [float(text.get_text()) for text in bar.get_yticklabels()]
        places = bar.transData.transform(np.column_stack([0 * ticks, ticks]))[:, 1]
        assert np.polyfit(labels, places, 1)[0] > 0
        assert np.ptp(np.diff(places) / np.diff(labels)) < 0.03 * np.mean(np.diff(places))
