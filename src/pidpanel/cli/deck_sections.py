"""Sections of a study from properties and materials of a Nastran deck: PSHELL, PCOMP, MAT1, MAT8.

What a section of a study cannot state is refused in one line, a `ValueError`.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from pidpanel.modal_files.model import MASS_UNITS
from pidpanel.nastran.cards import BLANKS, real_number
from pidpanel.nastran.deck import Deck

# Places of what is read among the fields of a card
MATERIALS = {
    "MAT1": {"E": 1, "G": 2, "nu": 3, "rho": 4},
    "MAT8": {"E": 1, "E2": 2, "nu": 3, "G": 4, "GL": 5, "GW": 6, "rho": 7},
}
DENSITIES = (500.0, 25000.0)  # of plies and plates [kg/m³]; outside, a deck has other units
MODULI = (1e8, 1.2e12)  # of plies and plates [Pa], likewise
PLY_MODULI = (1e9, 1.2e12)  # of those that tell a unit [Pa]
SOFT = 0.02  # largest stiffness of a core in its plane over that of the faces
HOMOGENEOUS = 1e-6  # deviation of 12 I/T³ from 1
LIGHTEST = 5.0  # density of a core in a study [kg/m³]


class DeckSection(NamedTuple):
    """A section as a study states it; angles are from the x axis of the materials of elements."""

    values: Mapping[str, Any]
    is_directional: bool  # whether a turn about the normal changes it
    is_symmetric: bool  # whether it is the same from both sides


class DeckSections:
    """The sections of a deck by property number, in SI with a length unit."""

    def __init__(self, deck: Deck, unit: float) -> None:
        if unit not in MASS_UNITS:
            allowed = ", ".join(f"{value:g}" for value in MASS_UNITS)
            raise ValueError(f"unit_m = {unit:g} implies no unit of mass; {allowed} do")
        self.unit, self.mass = unit, MASS_UNITS[unit] * deck.mass_factor
        self.pressure = MASS_UNITS[unit] / unit
        self.cards = {
            name: {card.fields[0]: card for card in deck.cards.get(name, ())}
            for name in ("PSHELL", "PCOMP", "PCOMPG", "MAT1", "MAT2", "MAT8")
        }

    def section(self, number: str) -> DeckSection:
        """Return the section of a property; `ValueError` in one line."""
        for name, read in (("PSHELL", self._pshell), ("PCOMP", self._pcomp)):
            if number in self.cards[name]:
                card = self.cards[name][number]
                try:
                    return read([*card.fields, *BLANKS])
                except ValueError as error:
                    raise ValueError(f"{card.place}: {name} {number}: {error}") from None
        kind = "PCOMPG is not read" if number in self.cards["PCOMPG"] else "no PSHELL or PCOMP"
        raise ValueError(f"property {number}: {kind}")

    def is_possible(self, number: str, *, has_density: bool) -> bool:
        """Return whether a material of a property has a usual modulus, and a usual density."""
        card = self.cards["PSHELL"].get(number) or self.cards["PCOMP"].get(number)
        if card is None:
            return False
        fields = [*card.fields, *BLANKS]
        for name in filter(None, [fields[1]] if card.name == "PSHELL" else fields[8::4]):
            try:
                values = self._material(name, is_core=True)
            except ValueError:
                continue
            ranges = [("E", PLY_MODULI), *[("rho", DENSITIES)] * has_density]
            if all(low <= values[key] <= high for key, (low, high) in ranges):
                return True
        return False

    def _material(self, number: str, *, is_core: bool = False) -> dict[str, float]:
        """Return the constants of a material in SI."""
        name = next((name for name in MATERIALS if number in self.cards[name]), "")
        if not name:
            kind = "MAT2, which is not read" if number in self.cards["MAT2"] else "not in the deck"
            raise ValueError(f"material {number} is {kind}; MAT1 and MAT8 are")
        fields = [*self.cards[name][number].fields, *BLANKS]
        scale = {"rho": self.mass / self.unit**3, "nu": 1.0}
        values = {
            key: real_number(fields[place]) * scale.get(key, self.pressure)
            for key, place in MATERIALS[name].items()
        }
        values.setdefault("E2", values["E"])
        if name == "MAT1":
            values = _isotropic(values)
        if not is_core:
            for key, label, (low, high) in (("E", "Pa", MODULI), ("rho", "kg/m³", DENSITIES)):
                if not low <= values[key] <= high:
                    message = f"material {number} has {values[key]:.3g} {label}"
                    raise ValueError(
                        f"{message} with a unit of {self.unit:g} m; {low:g} to {high:g} are allowed"
                    )
        return values

    def _mass_per_area(self, text: str) -> float:
        return real_number(text) * self.mass / self.unit**2

    def _pshell(self, fields: Sequence[str]) -> DeckSection:
        membrane, bending, shear = fields[1], fields[3], fields[5]
        thickness, extra = self.unit * real_number(fields[2]), self._mass_per_area(fields[7])
        if not membrane or bending == "-1" or not bending or thickness <= 0:
            raise ValueError("needs MID1, MID2 and T: without them it does not stretch or bend")
        if membrane not in self.cards["MAT1"] or bending not in self.cards["MAT1"]:
            raise ValueError("its materials must be MAT1, or a PCOMP must state the plies")
        if fields[10]:
            raise ValueError("couples stretching and bending by MID4, which is not read")
        material, bent = self._material(membrane), self._material(bending)
        inertia = real_number(fields[4] or "1")
        D = inertia * thickness**3 / 12 * bent["E"] / (1 - bent["nu"] ** 2)
        if abs(inertia - 1) < HOMOGENEOUS and bent == material:
            return DeckSection(
                {
                    "kind": "solid",
                    "youngs_modulus_gpa": _rounded(1e-9 * material["E"]),
                    "poissons_ratio": _rounded(material["nu"]),
                    "density_kg_m3": _rounded(material["rho"] + extra / thickness),
                    "thickness_mm": _rounded(1e3 * thickness),
                },
                is_directional=False,
                is_symmetric=True,
            )
        mass = material["rho"] * thickness + extra
        if shear and bent == material and inertia > 1:
            core = self._material(shear, is_core=True)
            stiffness = core["G"] * thickness * real_number(fields[6] or "0.833333")
            return _sandwich_of_shell(material, thickness, inertia, stiffness, mass)
        depths = [abs(self.unit * real_number(text)) for text in fields[8:10]]
        return DeckSection(
            {
                "kind": "thin",
                "mass_per_area_kg_m2": _rounded(mass),
                "bending_stiffness_n_m": _rounded(D),
                "thickness_mm": _rounded(1e3 * (sum(depths) or thickness * math.cbrt(inertia))),
                "poissons_ratio": _rounded(bent["nu"]),
            },
            is_directional=False,
            is_symmetric=True,
        )

    def _pcomp(self, fields: Sequence[str]) -> DeckSection:
        if (kind := fields[7].upper()) not in ("", "SYM"):
            raise ValueError(f"LAM = {kind} is not read; blank and SYM are")
        plies = _plies(fields, self.unit)
        depth = sum(ply["thickness_mm"] for ply in plies)
        offset = real_number(fields[1]) * 1e3 * self.unit if fields[1] else -depth / 2
        core = max(range(len(plies)), key=lambda k: plies[k]["thickness_mm"])
        bottom, top = plies[:core], plies[:core:-1]
        names = list(dict.fromkeys(ply["material"] for ply in bottom + top))
        materials = {name: self._material(name) for name in names}
        honeycomb = self._material(plies[core]["material"], is_core=True)
        faces = sum(materials[ply["material"]]["E"] * ply["thickness_mm"] for ply in bottom + top)
        thickness = plies[core]["thickness_mm"]
        if not (bottom and top) or honeycomb["E"] * thickness > SOFT * faces:
            raise ValueError("no soft core between faces, as of a sandwich")
        if fields[1] and abs(offset + depth / 2) > 1e-3 * depth:
            raise ValueError(f"Z0 = {fields[1]} is not half its thickness, and is not read")
        moduli = {key: honeycomb.get(key) or honeycomb["G"] for key in ("GL", "GW")}
        if not all(moduli.values()):
            raise ValueError("its core has no transverse shear modulus")
        is_symmetric = top == bottom
        face = {"faces": top} if is_symmetric else {"top": top, "bottom": bottom}
        values = {
            "kind": "sandwich",
            "materials": {name: _written(skin) for name, skin in materials.items()},
            **face,
            "core": {
                "thickness_mm": thickness,
                "shear_modulus_l_mpa": _rounded(1e-6 * moduli["GL"]),
                "shear_modulus_w_mpa": _rounded(1e-6 * moduli["GW"]),
                "density_kg_m3": _rounded(honeycomb["rho"]),
                "ribbon_deg": plies[core]["angle_deg"],
            },
            "extra_mass_per_area_kg_m2": _rounded(self._mass_per_area(fields[2])),
        }
        is_isotropic = all("is_isotropic" in skin for skin in materials.values())
        return DeckSection(values, not is_isotropic or moduli["GL"] != moduli["GW"], is_symmetric)


def turned(section: DeckSection, degrees: float, *, is_below: bool) -> dict[str, Any]:
    """Return a section with its angles from another axis, or as it is seen from below.

    Parameters
    ----------
    degrees
        Angle from the new axis to the x axis of the materials.
    is_below
        Whether the normals of the elements are opposite to the new one.
    """
    values = dict(section.values)
    if values["kind"] != "sandwich":
        return values
    sign = -1.0 if is_below else 1.0
    for key in ("faces", "top", "bottom"):
        if key in values:
            values[key] = [
                {**ply, "angle_deg": _angle(degrees + sign * ply["angle_deg"])}
                for ply in values[key]
            ]
    if is_below and not section.is_symmetric:
        values["top"], values["bottom"] = values["bottom"], values["top"]
    ribbon = _angle(degrees + sign * values["core"]["ribbon_deg"])
    return {**values, "core": {**values["core"], "ribbon_deg": ribbon}}


def _angle(degrees: float) -> float:
    """Return an angle of a direction without sense, above −90° to 90°."""
    return 90.0 - (90.0 - round(degrees, 4)) % 180.0


def _isotropic(values: Mapping[str, float]) -> dict[str, float]:
    """Return E, ν and G of which one may be missing."""
    E, G, nu = (values[key] for key in ("E", "G", "nu"))
    if not E and G:
        E = 2 * (1 + nu) * G
    elif not nu and E and G:
        nu = E / (2 * G) - 1
    elif not G:
        G = E / (2 * (1 + nu))
    return {"E": E, "E2": E, "nu": nu, "G": G, "rho": values["rho"], "is_isotropic": 1.0}


def _sandwich_of_shell(
    face: Mapping[str, float], thickness: float, inertia: float, shear: float, mass: float
) -> DeckSection:
    """Return two faces of half a thickness, so far apart that their inertia is that stated.

    I = 2 (t/2) (d/2)² + 2 (t/2)³/12 with t the thickness of both [m]. The core has the shear
    stiffness S = G d²/t_c [N/m]; what the faces do not weigh is in its density and beside it.
    """
    half = thickness / 2
    distance = math.sqrt((inertia - 0.25) * thickness**2 / 3)
    depth = distance - half
    if depth < half:
        raise ValueError(f"12I/T³ = {inertia:g} leaves no room for a core")
    rest = mass - face["rho"] * thickness
    density = min(LIGHTEST, rest / depth)
    if density < LIGHTEST:
        raise ValueError("its NSM has no mass of a core, at least 5 kg/m³")
    modulus = _rounded(1e-6 * shear * depth / distance**2)
    values = {
        "kind": "sandwich",
        "materials": {"face": _written(face)},
        "faces": [{"material": "face", "thickness_mm": _rounded(1e3 * half), "angle_deg": 0.0}],
        "core": {
            "thickness_mm": _rounded(1e3 * depth), "shear_modulus_l_mpa": modulus,
            "shear_modulus_w_mpa": modulus, "density_kg_m3": density, "ribbon_deg": 0.0,
        },
        "extra_mass_per_area_kg_m2": _rounded(rest - density * depth),
    }  # fmt: skip
    return DeckSection(values, is_directional=False, is_symmetric=True)


def _written(values: Mapping[str, float]) -> dict[str, float]:
    """Return a material of ``section.materials``."""
    density = {"density_kg_m3": _rounded(values["rho"])}
    if "is_isotropic" in values:
        modulus = {"youngs_modulus_gpa": _rounded(1e-9 * values["E"])}
        return {**modulus, "poissons_ratio": _rounded(values["nu"]), **density}
    moduli = {"e1_gpa": "E", "e2_gpa": "E2", "g12_gpa": "G"}
    constants = {name: _rounded(1e-9 * values[key]) for name, key in moduli.items()}
    return {**constants, "nu12": _rounded(values["nu"]), **density}


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")


def _plies(fields: Sequence[str], unit: float) -> list[dict[str, Any]]:
    """Return the plies of a PCOMP from −z to +z; neighbours of the same kind are one."""
    stated: list[dict[str, Any]] = []
    for k in range(8, len(fields) - 3, 4):
        if any(fields[k : k + 3]):
            material, thickness, angle = fields[k : k + 3]
            last = stated[-1] if stated else {"material": "", "thickness_mm": 0.0}
            length = 1e3 * unit * real_number(thickness) if thickness else last["thickness_mm"]
            stated.append({
                "material": material or last["material"], "thickness_mm": float(f"{length:.9g}"),
                "angle_deg": real_number(angle or "0"),
            })  # fmt: skip
    if fields[7].upper() == "SYM":
        stated += [dict(ply) for ply in reversed(stated)]
    plies: list[dict[str, Any]] = []
    for ply in stated:
        if plies and all(ply[key] == plies[-1][key] for key in ("material", "angle_deg")):
            plies[-1]["thickness_mm"] += ply["thickness_mm"]
        else:
            plies.append(ply)
    return plies
