"""The section ``sound`` of a study: a spectrum, its level and its field."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from pidpanel.paths import DATA
from pidpanel.study.base import OVERALL, Acceleration, Level, SectionModel, Text, as_tuple, file_in
from pidpanel.study.choice import Choice
from pidpanel.study.mistakes import Mistake
from pidpanel.study.quantity import Quantity, whole

PressureReference = Literal["surface", "room", "incident"]

MOST_SOURCES = 200

SPEED = 343.0  # of sound in air [m/s]


class Wall(SectionModel):
    """A rigid wall behind the panel, parallel to it; the edges of the panel are free."""

    wall_m: Annotated[float, Quantity(1e-4, 2, unit="metres")]
    """Distance of the wall from the panel [m], at least a tenth of the panel's thickness. A wall
    farther away changes little: use ``free``."""


class Source(SectionModel):
    """A source far away, whose wave is plane at the panel."""

    incidence_deg: Annotated[float, Quantity(0, 180)]
    """Angle between the direction of its wave and the normal of the panel [°]; above 90 from
    behind."""
    azimuth_deg: Annotated[float, Quantity(-180, 360)] = 0.0
    """Direction of its wave in the plane of the panel, from x [°]."""
    level_db: Annotated[float, Quantity(-60, 60)] = 0.0
    """Level over that of the others [dB]."""

    @property
    def angles(self) -> tuple[float, float]:
        """Incidence and azimuth [rad]."""
        return math.radians(self.incidence_deg), math.radians(self.azimuth_deg)


class StatedField(SectionModel):
    """Loudspeakers round the panel, farther away than its size; or what microphones measured."""

    sources: Annotated[tuple[Source, ...], Field(min_length=1, max_length=MOST_SOURCES)] | None = (
        None
    )
    """The loudspeakers. The spectrum is that of all together, averaged over space."""
    one_drive: bool = False
    """Whether one signal drives all, in phase at the middle of the panel; independent otherwise."""
    cross_spectra: Annotated[Path, file_in()] | None = None
    """Cross-spectra of microphones: a CSV table (``frequency_hz``, ``microphone``, ``other``,
    ``real_pa2_hz``, ``imaginary_pa2_hz``) or a universal file (data set 58)."""
    microphones: Annotated[Path, file_in()] | None = None
    """CSV table of their positions in the axes of the panel (``microphone``, ``x_m``, ``y_m``,
    ``z_m``)."""
    averages: Annotated[int, whole(1, 1000000)] | None = None
    """Independent blocks that the cross-spectra are the mean of; without it their error is not
    part of that of the answer."""
    noise_db: Annotated[float, Quantity(-60, -6)] = -30.0
    """Noise of the microphones, with errors of gains and positions, relative to the pressure [dB].
    """

    def mistakes(self) -> Iterator[Mistake]:
        if (self.sources is None) == (self.cross_spectra is None):
            yield Mistake((), "must have sources or cross_spectra")
        elif self.one_drive and self.sources is None:
            yield Mistake(("one_drive",), "only allowed with sources")
        if (self.cross_spectra is None) != (self.microphones is None):
            yield Mistake(("microphones",), "required with cross_spectra, not allowed otherwise")
        for key in {"noise_db", "averages"} & self.model_fields_set:
            if self.cross_spectra is None:
                yield Mistake((key,), "only allowed with cross_spectra")


NamedField = Literal["diffuse", "uncorrelated", "uniform", "plane_wave", "progressive_wave"]


SpectrumFile = Annotated[Path, file_in(DATA / "spl")]
Envelope = Annotated[tuple[SpectrumFile, ...], Field(min_length=2)]


class Sound(SectionModel):
    """The acoustic field: a spectrum, its level, its coherence, where it was measured."""

    spectrum: Annotated[SpectrumFile | Envelope, Choice()] | None = None
    """CSV table of octave or third-octave levels, or of a pressure PSD (``frequency_hz``,
    ``psd_pa2_hz``), relative to the study or from pidpanel; a list for the highest of several
    tables in each third octave. Required unless ``field`` has ``cross_spectra``, whose mean it is
    by default."""
    oaspl_db: Level | None = None
    """Overall level to which the spectrum is shifted [dB]; by default that of the table."""
    level: Literal["median", "p95_50", "test"] | None = None
    """What the levels are: their ``median`` over flights; ``p95_50``, not exceeded in 95 % of
    flights with 50 % confidence; or those that a ``test`` prescribes. Spreads of levels
    (``uncertain``) are about a median, or the tolerance of a test."""
    levels: Mapping[Text, Annotated[float, Quantity(-60, 60)]] = {}
    """Levels by name, over ``oaspl_db`` [dB], such as ``{acceptance: 0, protoqualification: 3,
    qualification: 6}``. The bare panel, layouts, and families of one patch and fill that state no
    level are computed at each, since damping depends on the amplitude."""
    shift_db: Annotated[float, Quantity(-60, 60)] = 0.0
    """Shift of every band [dB], such as 3 for protoqualification; not together with oaspl_db."""
    field: Annotated[NamedField | StatedField, Choice()] = "diffuse"
    """``diffuse``: waves from all directions equally; ``uncorrelated``: the paper's, without
    coherence; ``uniform``: in phase everywhere; ``plane_wave``: from ``incidence_deg``;
    ``progressive_wave``: a plane wave at grazing incidence, as in a progressive-wave tube;
    ``{sources: …}``: waves of some loudspeakers; ``{cross_spectra: …, microphones: …}``: as
    microphones measured it."""
    incidence_deg: Annotated[float, Quantity(0, 90)] | None = None
    """Angle between the direction of a plane wave and the normal of the panel [°]."""
    azimuth_deg: Annotated[float, Quantity(-180, 360)] | None = None
    """Direction of a wave in the plane of the panel, from x [°]; 0 by default."""
    surroundings: Annotated[Literal["free", "baffle"] | Wall, Choice()] = "baffle"
    """What the panel hangs in. ``free``: in the room, with sound and air on both faces and round
    its edges; ``baffle``: in an infinite rigid wall that continues it; ``{wall_m: 0.08}``: as
    ``free``, with a rigid wall at that distance behind it."""
    loaded_sides: Literal[1, 2] | None = None
    """Of a panel in a baffle, 1 by default. 2: independent fields of that level on both faces,
    twice the PSD."""
    pressure_reference: PressureReference | None = None
    """Where the levels of the table were measured. ``surface``, the default in a baffle: on the
    panel; ``room``: far from it, so a rigid face has twice the PSD in a diffuse field. It is the
    only one that ``surroundings: free`` allows; of a plane wave it is then that of the wave alone;
    ``incident``: an incoming wave alone, so a rigid face has four times the PSD."""
    steady_acceleration_g: Acceleration | None = None
    """Steady acceleration of the launch as the particles feel it, besides gravity, along x, y and
    the normal z of the panel [g]: opposite to that of the launcher."""
    speed_m_s: Annotated[float, Quantity(100, 1400, unit="velocity")] = SPEED
    """Speed of sound [m/s]."""
    air_density_kg_m3: Annotated[float, Quantity(0.01, 50, unit="density")] = 1.2
    """Density of the air [kg/m³]."""

    @property
    def named_levels(self) -> dict[float, str]:
        """Names of the overall levels [dB] of ``levels``."""
        return {round((self.oaspl_db or 0.0) + over, 6): name for name, over in self.levels.items()}

    def level_text(self, oaspl_db: float) -> str:
        """Return an overall level [dB] in words, with its name in ``levels``."""
        name = self.named_levels.get(oaspl_db)
        return f"{name} ({oaspl_db:g} dB)" if name else f"{oaspl_db:g} dB"

    @property
    def is_free(self) -> bool:
        """Whether the edges of the panel are free, before a wall or without one."""
        return self.surroundings != "baffle"

    @property
    def wall(self) -> float:
        """Distance of the wall behind the panel [m]; ∞ without one."""
        return self.surroundings.wall_m if isinstance(self.surroundings, Wall) else math.inf

    @property
    def reference(self) -> PressureReference:
        """Where the levels were measured."""
        return self.pressure_reference or ("room" if self.is_free else "surface")

    @property
    def faces(self) -> Literal[1, 2]:
        """Faces with sound on them."""
        return 2 if self.is_free else self.loaded_sides or 1

    @property
    def field_name(self) -> str:
        """The field in a word."""
        if isinstance(self.field, StatedField):
            return "sources" if self.field.sources else "measured"
        return self.field

    @property
    def spectra(self) -> tuple[Path, ...]:
        """The tables of the spectrum; none where microphones measured it."""
        return () if self.spectrum is None else as_tuple(self.spectrum)

    @property
    def level_names(self) -> list[str]:
        """Names of the files that have the level."""
        stated = self.field.cross_spectra if isinstance(self.field, StatedField) else None
        return [file.name for file in self.spectra or as_tuple(stated or ())]

    @property
    def diffuse(self) -> "Sound":
        """The same in a diffuse field."""
        return self.model_copy(update={"field": "diffuse"})

    @property
    def incidence(self) -> float:
        """Angle of incidence [rad]; a right angle for a progressive wave."""
        return math.radians(90.0 if self.incidence_deg is None else self.incidence_deg)

    @property
    def azimuth(self) -> float:
        """Direction in the plane of the panel, from x [rad]."""
        return math.radians(self.azimuth_deg or 0.0)

    def mistakes(self) -> Iterator[Mistake]:
        if self.spectrum is None and self.field_name != "measured":
            yield Mistake(("spectrum",), "missing; required")
        if self.levels and self.oaspl_db is None:
            message = "missing; required with levels, the overall level at 0 dB"
            yield Mistake(("oaspl_db",), message)
        for level, name in self.named_levels.items() if self.oaspl_db is not None else ():
            if not OVERALL.holds(level):
                yield Mistake(("levels", name), f"gives {level:g} dB; {OVERALL.allowed}")
        if len(self.named_levels) < len(self.levels):
            yield Mistake(("levels",), "two names have the same level; must differ")
        if self.oaspl_db is not None and self.shift_db != 0:
            yield Mistake(("shift_db",), f"not allowed together with oaspl_db = {self.oaspl_db:g}")
        if (self.field == "plane_wave") != (self.incidence_deg is not None):
            message = "required for field: plane_wave, not allowed otherwise"
            yield Mistake(("incidence_deg",), message)
        if self.azimuth_deg is not None and not self.field_name.endswith("_wave"):
            message = "only allowed for field: plane_wave or progressive_wave"
            yield Mistake(("azimuth_deg",), message)
        if self.is_free:
            yield from self._mistakes_of_free()
        for keys, angle in self._angles():
            if self.is_free and angle == 90:
                message = "must be below 90 with free edges, where a wave along the panel does not "
                message += "load it; of sources, or above"
                yield Mistake(keys, message)
            elif not self.is_free and angle > 90:
                yield Mistake(keys, "must be at most 90 in a baffle, which hides what is behind")

    def _angles(self) -> Iterator[tuple[tuple[str | int, ...], float]]:
        """Yield the angles of incidence with their keys [°]."""
        if self.incidence_deg is not None:
            yield ("incidence_deg",), self.incidence_deg
        if isinstance(self.field, StatedField):
            for number, source in enumerate(self.field.sources or ()):
                yield ("field", "sources", number, "incidence_deg"), source.incidence_deg

    def _mistakes_of_free(self) -> Iterator[Mistake]:
        """Yield what belongs to a panel in a baffle."""
        remedy = "with free edges; set sound.surroundings: baffle"
        if self.pressure_reference not in (None, "room"):
            yield Mistake(("pressure_reference",), f"must be room {remedy} for it")
        if self.loaded_sides is not None:
            yield Mistake(("loaded_sides",), f"not allowed {remedy} to load one face")
        if self.field_name not in ("diffuse", "plane_wave", "sources", "measured"):
            reason = ", where a wave along the panel does not load it"
            place = f"with free edges{reason * self.field_name.endswith('wave')}"
            message = (
                f"must be diffuse, plane_wave, sources or cross_spectra {place}; "
                "set sound.surroundings: baffle for it"
            )
            yield Mistake(("field",), message)
