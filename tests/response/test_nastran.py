"""Cards fill the columns that Nastran reads: a name of 8 characters, fields of 16."""

import numpy as np

from pidpanel.response.nastran import large_field_table


def test_fields_fill_their_columns_and_the_table_ends():
    # red: {number:16d} → {number:8d}; {fields:48} → {fields:47}; FIELDS_PER_LINE = 4 → 8
    x, y = np.array([20.0, 31.5, 2000.0]), np.array([1e-12, 0.25, 3e5])
    lines = "".join(large_field_table("TABRND1", 7, ["LINEAR", "LINEAR"], x, y)).splitlines()
    assert lines[0] == "TABRND1*" + f"{7:16d}" + 2 * f"{'LINEAR':>16}" + 16 * " "
    assert lines[1] == "*"
    fields = []
    for line in lines[2:]:
        assert line[:8] == "*       " and len(line) <= 72
        fields += [line[k : k + 16] for k in range(8, len(line), 16)]
    assert [float(field) for field in fields[:-1]] == [20.0, 1e-12, 31.5, 0.25, 2000.0, 3e5]
    assert fields[-1].strip() == "ENDT"
