"""The sound of a study: spectrum.csv, modal_force.nc and, where it is asked for, air.nc."""

import sys
from collections.abc import Sequence
from pathlib import Path

from pidpanel.panel.basis_files import read_basis
from pidpanel.sound import field_files, from_study
from pidpanel.stamp import stamp
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Take the study, modes.nc and the files to write."""
    study_file, modes, bands, modal_force, *air = map(Path, arguments)
    study, basis = load_study(study_file), read_basis(modes)
    from_study.band_table(study.sound).to_csv(bands, index=False, float_format="%.7g")
    force = from_study.modal_force_tables(study.sound, study.response.frequency_hz[1], basis)
    field_files.write_tables(modal_force, force, {**stamp(study), "field": study.sound.field})
    for nc in air:
        field_files.write_tables(nc, from_study.air_tables(study.sound, basis, force), stamp(study))


if __name__ == "__main__":
    main(sys.argv[1:])
