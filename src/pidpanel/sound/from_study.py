"""The sound of a study: the one place in `sound` that reads the section ``sound``."""

from pidpanel.sound.spectrum import BandSpectrum
from pidpanel.sound.table import read_spl_table
from pidpanel.study.sound import Sound


def spectrum_of(sound: Sound) -> BandSpectrum:
    """Return the band levels of a study, at the overall level or with the shift it states.

    Parameters
    ----------
    sound
        The section ``sound`` of a study.

    Returns
    -------
    The table of ``sound.spectrum`` at ``oaspl_db``, or every band ``shift_db`` higher.

    Raises
    ------
    SpectrumError
        Where the table cannot be read (`read_spl_table`).
    """
    spectrum = read_spl_table(sound.spectrum).shifted(sound.shift_db)
    return spectrum if sound.oaspl_db is None else spectrum.at_oaspl(sound.oaspl_db)
