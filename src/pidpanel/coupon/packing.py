"""Packings: cells with poured spheres, and how they are poured."""

from dataclasses import asdict, dataclass, replace
from functools import cached_property

from pidpanel.arrays import Array
from pidpanel.atlas.groups import ElasticSphere
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import geometry
from pidpanel.coupon.contact import Constants
from pidpanel.coupon.liggghts import deck, process
from pidpanel.geometry.cells import SHAPES, ShapeName
from pidpanel.geometry.sizes import Sizes
from pidpanel.provenance.digests import json_digest

# Version of the algorithms that draw the spheres, scatter them over the cells, and write spheres
# and walls for LIGGGHTS: `sizes`, `geometry`, `start_files`, `preparation.scattered`. Like
# `POUR_VERSION` and `bed.LOOSEN_VERSION` it increases when their results change
# (`tests/coupon/test_versions.py`).
PLACEMENT_VERSION = 1

# Version of the algorithm that lets the spheres settle and counts a full cell: `preparation.pour`.
POUR_VERSION = 1


@dataclass(frozen=True)
class Pouring:
    """Settings for pouring a packing."""

    # [Pa]; softness in the pour only sets how deep a sphere at rest sinks in: 2 µm at the bottom of
    # 25 mm of acrylic, and what that releases when it is shaken stiffer is 1e-3 of m g d
    youngs_modulus: float = 20e6
    restitution: float = 0.5  # [1]
    # Duration of the fall from rest whose speed is the terminal speed under drag [s]
    fall_time: float = 0.2
    time_step_rayleigh: float = 0.25  # time step over the Rayleigh time of the smallest sphere [1]
    # Kinetic energy per sphere over m g d at which a poured bed is at rest [1]
    settled: float = 1e-6


POURING = Pouring()


@dataclass(frozen=True)
class Packing:
    """Cells with spheres, poured higher than the cells are deep."""

    shape: ShapeName  # of a cell: a key of `cells.SHAPES`
    # Size of a cell [m]
    across_flats: float
    depth: float
    count: int
    diameter: float  # nominal diameter of the spheres [m]
    sizes: Sizes
    density: float  # [kg/m³]
    # Constants of the pour [1]
    poissons_ratio: float
    friction: float
    wall_friction: float
    seed: int  # of the random numbers

    @cached_property
    def outline(self) -> Array:
        """Corners of one cell round its centre, (k, 2) [m]."""
        return SHAPES[self.shape].outline(self.across_flats)

    @cached_property
    def centres(self) -> Array:
        """Centres of the cells, (count, 2) [m]."""
        return geometry.cell_centres(self.across_flats, self.count)

    @cached_property
    def cell_area(self) -> float:
        """Area of one cell [m²]."""
        return geometry.polygon_area(self.outline)

    @property
    def area(self) -> float:
        """Area of all cells [m²]."""
        return self.count * self.cell_area

    @property
    def pour_constants(self) -> Constants:
        """Constants of the contacts of the pour."""
        alike = Constants.alike(
            POURING.youngs_modulus, self.poissons_ratio, POURING.restitution, self.friction
        )
        return replace(alike, wall_friction=self.wall_friction)

    @property
    def pour_time_step(self) -> float:
        """Time step of the pour [s]."""
        return POURING.time_step_rayleigh * self.smallest(POURING.youngs_modulus).rayleigh_time

    def smallest(self, youngs_modulus: float) -> ElasticSphere:
        """Return the smallest sphere, with a modulus [Pa]."""
        radius = self.sizes.smallest / 2
        return ElasticSphere(radius, self.density, youngs_modulus, self.poissons_ratio)

    def deck_text(self, *, drag: float, chunk_steps: int) -> str:
        """Return the deck that pours the packing.

        Parameters
        ----------
        drag
            Force over speed [N s/m].
        """
        values = {
            **self.pour_constants.deck_values,
            "data_file": deck.START_FILE,
            "walls_file": deck.WALLS_FILE,
            "skin": 0.3 * self.diameter,
            "gravity": STANDARD_GRAVITY,
            "drag": drag,
            "time_step": self.pour_time_step,
            "chunk_steps": chunk_steps,
        }
        return deck.render("fill.in.j2", values)

    @cached_property
    def identity(self) -> str:
        """Hash of all that the packing depends on."""
        # drag and the length of a chunk follow from the spheres by the code that pours
        text = self.deck_text(drag=1.0, chunk_steps=1)
        return json_digest(
            asdict(self),
            # twelve digits, as LIGGGHTS is given them: more may differ between machines
            [f"{x:.12g} {y:.12g}" for x, y in self.outline],
            asdict(POURING),
            deck.without_comments(text),
            process.RUN,
            process.VERSION,
            [PLACEMENT_VERSION, POUR_VERSION],
        )

    @property
    def name(self) -> str:
        """The label without its hash."""
        return (
            f"{self.shape}{self.across_flats * 1e3:g}x{self.depth * 1e3:g}mm_n{self.count}"
            f"_d{self.diameter * 1e3:g}mm_s{self.seed}"
        )

    @property
    def label(self) -> str:
        """Folder below ``results/coupon/packing``."""
        return f"{self.name}_{self.identity[:8]}"
