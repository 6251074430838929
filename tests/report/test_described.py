"""What the files of a study without LIGGGHTS hold is described."""

from reference_pages import untold


def test_every_column_of_a_study_with_a_table_is_described(table):
    missing, stale = untold(table[1])
    assert missing == []
    assert not any("margins.csv" in one for one in stale)
