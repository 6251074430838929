"""Points that do not move: those on a support, to a millionth of each shape."""

from types import SimpleNamespace

import numpy as np

from pidpanel.solve.panel import deflection_at_points, fixed_points


def test_a_point_is_fixed_where_no_shape_moves_it_by_a_millionth_of_its_largest():
    # shapes of up to 2000, of ½, and one that rests at all vertices, which counts as of 1
    vertices = np.array([[-2000.0, 0.5, 0.0], [1.0, 0.1, 0.0]])
    points = np.array(
        [
            [1.9e-3, 4e-7, 0.9e-6],
            [-2.1e-3, 0.0, 0.0],
            [0.0, 6e-7, 0.0],
            [0.0, 0.0, -1.05e-6],
            [0.0, 0.0, 0.0],
        ]
    )
    basis = SimpleNamespace(shape_at_points=points, shape_at_vertices=vertices)
    assert fixed_points(basis).tolist() == [True, False, False, False, True]
    np.testing.assert_array_equal(deflection_at_points(basis)[[0, 4]], 0)
    np.testing.assert_array_equal(deflection_at_points(basis)[1:4], points[1:4])
