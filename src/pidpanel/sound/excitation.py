"""A sound field on the panel as an excitation of its modes."""

from dataclasses import dataclass

from pidpanel.arrays import Array, Complexes
from pidpanel.sound.field import wavenumber
from pidpanel.sound.spectrum import PressureReference, Spectrum, pressure_psd
from pidpanel.sound.wavenumber_table import WavenumberTable


@dataclass(frozen=True)
class SoundExcitation:
    """A diffuse, plane, progressive, uniform or uncorrelated sound field.

    Implements `solve.excitation.Excitation`: S is the PSD of the pressure on the face [Pa²/Hz], G
    the modal force of the field [m⁴].
    """

    pressure: Spectrum
    table: WavenumberTable  # G over wavenumber, which depends on the field (`sound.field`)
    speed: float  # speed of sound [m/s]
    # See `spectrum.pressure_psd`
    reference: PressureReference = "surface"
    loaded_sides: int = 1

    def spectrum(self, frequency: Array) -> Array:
        """Return S (nf,) [Pa²/Hz] at the frequencies (nf,) [Hz]."""
        return pressure_psd(self.pressure, frequency, self.reference, self.loaded_sides)

    def __call__(self, frequency: Array) -> Array | Complexes:
        """Return G (nf, n, n) [m⁴]."""
        return self.table.matrix(wavenumber(frequency, self.speed))

    def factors(self, frequency: Array) -> Array | Complexes | None:
        """Return L (nf, n, r) [m²] with G = L Lᴴ; None where r is not small."""
        return self.table.factors_at(wavenumber(frequency, self.speed))
