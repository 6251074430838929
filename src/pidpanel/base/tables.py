"""Tables and datasets of the stage."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.base.notching import Limit, Notch, notches
from pidpanel.base.random import RandomCase, RandomResponse
from pidpanel.base.supports import Inertia
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.panel.basis import PanelBasis
from pidpanel.solve.bands import reduction
from pidpanel.solve.lines import root_mean_square

INTERFACE = "interface"
"""Name of the interface in columns of points."""

INPUTS, DIRECTIONS = ("stated", "notched"), ("up", "down")


@dataclass(frozen=True)
class SineCase:
    """A scenario with a damping model in a sweep, by direction up and down.

    Attributes
    ----------
    acceleration
        (2, nf, n_points) amplitude of the absolute acceleration [m/s²].
    displacement
        (2, nf, n_points) amplitude of the deflection relative to the supports [m].
    force
        (2, nf) amplitude of the interface force [N].
    residual
        Largest |ln(Γ_out/Γ)|.
    """

    scenario: str
    model: str
    frequency: Array
    acceleration: Array
    displacement: Array
    force: Array
    residual: float


def mode_rows(basis: PanelBasis, inertia: Inertia) -> pd.DataFrame:
    """Return a row per mode of a basis: frequency, masses, and sums of effective masses."""
    modes = np.flatnonzero(~basis.is_residual)
    effective = inertia.effective_mass(basis.modal_mass)[modes]
    return pd.DataFrame(
        {
            "mode": np.arange(1, modes.size + 1),
            "frequency_hz": basis.natural_frequency[modes],
            "modal_mass_kg": basis.modal_mass[modes],
            "participation_kg": inertia.participation[modes],
            "effective_mass_kg": effective,
            "effective_mass_share": effective / inertia.mass,
            "cumulative_share": np.cumsum(effective) / inertia.mass,
        }
    )


def _responses(cases: Sequence[RandomCase]) -> Iterator[tuple[RandomCase, str, RandomResponse]]:
    """Yield the responses of each case with the name of the input."""
    for case in cases:
        for name, part in zip(INPUTS, (case.stated, case.notched), strict=True):
            if part is not None:
                yield case, name, part


def summary_rows(cases: Sequence[RandomCase], points: Sequence[str]) -> pd.DataFrame:
    """Return a row per case, input and point, and one for the interface force."""
    bare = {(c.model, name): part for c, name, part in _responses(cases) if c.scenario.is_bare}
    rows: list[dict[str, Any]] = []
    for case, name, part in _responses(cases):
        head = {"reading": case.model, "scenario": case.scenario.label, "input": name}
        rows += [
            {**head, "status": "ok", **row}
            for row in _rows(case.frequency, part, bare[case.model, name], points)
        ]
    for case in cases:
        if case.stated is None:
            head = {"reading": case.model, "scenario": case.scenario.label, "input": INPUTS[0]}
            rows += [{**head, "status": "unstable", "point": point} for point in points]
    return pd.DataFrame(rows)


def _rows(
    f: Array, part: RandomResponse, bare: RandomResponse, points: Sequence[str]
) -> Iterator[dict[str, Any]]:
    """Yield a row per point, and one for the interface."""

    def rms(psd: Array) -> Array:
        return root_mean_square(f, psd)

    g = STANDARD_GRAVITY
    acceleration, error = rms(part.absolute) / g, np.full(len(points), np.nan)
    if part.errors is not None:
        error = part.errors.log_rms[: len(points)] * acceleration
    gain = np.sqrt(part.absolute / part.input[:, None])
    columns = {
        "point": list(points),
        "acceleration_rms_g": acceleration,
        "acceleration_rms_error_g": error,
        "reduction_db": reduction(rms(bare.absolute) / g, acceleration),
        "relative_displacement_rms_mm": 1e3 * rms(part.relative),
        "peak_transmissibility": gain.max(axis=0),
        "peak_frequency_hz": f[gain.argmax(axis=0)],
    }
    head = {
        "input_rms_g": float(rms(part.input)) / g,
        "outside_run_points_share": part.outside_share,
    }
    for values in zip(*columns.values(), strict=True):
        yield {**head, **dict(zip(columns, values, strict=True))}
    mass = np.sqrt(part.force / part.input)
    yield {
        **head,
        "point": INTERFACE,
        "force_rms_n": float(rms(part.force)),
        "reduction_db": float(reduction(rms(bare.force), rms(part.force))),
        "peak_dynamic_mass_kg": mass.max(),
        "peak_frequency_hz": f[mass.argmax()],
    }


Variables = Mapping[str, tuple[Array, str, str]]
"""Values (nf,) or (nf, n_points), unit and long name by name."""


def _dataset(
    frequency: Array, points: Sequence[str], variables: Variables, **place: str
) -> xr.Dataset:
    """Return the curves of one case at its place among all."""
    axis = ("frequency", frequency, {"units": "Hz", "long_name": "frequency"})
    curves = {
        name: (("frequency", "point")[: values.ndim], values, {"units": unit, "long_name": text})
        for name, (values, unit, text) in variables.items()
    }
    dataset = xr.Dataset(curves, coords={"frequency": axis, "point": list(points)})
    return dataset.expand_dims({name: [value] for name, value in place.items()})


def random_dataset(
    cases: Sequence[RandomCase], models: Sequence[str], labels: Sequence[str], points: Sequence[str]
) -> xr.Dataset:
    """Return PSDs of input, points and interface under the stated and the notched input."""
    parts = []
    for case, name, part in _responses(cases):
        error = np.full(part.absolute.shape, np.nan)
        if part.errors is not None:
            error = part.errors.log_psd[:, : len(points)]
        acceleration, psd = "m2 s-4 Hz-1", "one-sided PSD of the"
        variables = {
            "input_psd": (part.input, acceleration, f"{psd} acceleration of the supports"),
            "absolute_acceleration_psd": (
                part.absolute, acceleration, f"{psd} absolute acceleration"
            ),
            "log_error": (error, "1", "standard error of ln of the absolute acceleration PSD"),
            "relative_displacement_psd": (
                part.relative, "m2 Hz-1", f"{psd} deflection relative to the supports"
            ),
            "interface_force_psd": (part.force, "N2 Hz-1", f"{psd} force of all supports"),
        }  # fmt: skip
        place = {"reading": case.model, "scenario": case.scenario.label, "input": name}
        parts.append(_dataset(case.frequency, points, variables, **place))
    return _merged(parts, models, labels).reindex(input=list(INPUTS))


def sine_dataset(
    cases: Sequence[SineCase], models: Sequence[str], labels: Sequence[str], points: Sequence[str]
) -> xr.Dataset:
    """Return amplitudes over the sweeps."""
    parts = []
    for case in cases:
        for number, direction in enumerate(DIRECTIONS):
            variables = {
                "acceleration": (
                    case.acceleration[number], "m s-2", "amplitude of the absolute acceleration"
                ),
                "relative_displacement": (
                    case.displacement[number], "m",
                    "amplitude of the deflection relative to the supports",
                ),
                "interface_force": (
                    case.force[number], "N", "amplitude of the force of all supports"
                ),
            }  # fmt: skip
            place = {"reading": case.model, "scenario": case.scenario, "direction": direction}
            parts.append(_dataset(case.frequency, points, variables, **place))
    return _merged(parts, models, labels).reindex(direction=list(DIRECTIONS))


def _merged(
    parts: Sequence[xr.Dataset], models: Sequence[str], labels: Sequence[str]
) -> xr.Dataset:
    """Return all cases in their order; NaN where there is none."""
    merged = xr.merge(parts, join="outer", compat="no_conflicts")
    return merged.reindex(reading=list(models), scenario=list(labels))


def input_rows(cases: Sequence[RandomCase], limits: Sequence[Limit]) -> pd.DataFrame:
    """Return the notched input of each case line by line [g²/Hz], with the reason of each notch."""
    names = ["", *(limit.reason for limit in limits)]
    parts = [
        pd.DataFrame(
            {
                "reading": case.model,
                "scenario": case.scenario.label,
                "frequency_hz": case.frequency,
                "stated_psd_g2_hz": case.stated.input / STANDARD_GRAVITY**2,
                "notched_psd_g2_hz": case.notches.psd / STANDARD_GRAVITY**2,
                "notch_db": 10 * np.log10(case.stated.input / case.notches.psd),
                "reason": [names[reason + 1] for reason in case.notches.reason.tolist()],
            }
        )
        for case in cases
        if case.notches is not None and case.stated is not None
    ]
    return pd.concat(parts, ignore_index=True)


def notch_rows(cases: Sequence[RandomCase], limits: Sequence[Limit]) -> pd.DataFrame:
    """Return a row per notch of each case."""
    rows = [
        {"reading": case.model, "scenario": case.scenario.label, **asdict(notch)}
        for case in cases
        if case.notches is not None and case.stated is not None
        for notch in notches(case.frequency, case.stated.input, case.notches, limits)
    ]
    columns = ["reading", "scenario", *Notch.__dataclass_fields__]
    return pd.DataFrame(rows, columns=columns)


def sine_rows(cases: Sequence[SineCase], points: Sequence[str], level_g: float) -> pd.DataFrame:
    """Return the peaks of each sweep, a row per direction and point."""
    rows: list[dict[str, Any]] = []
    for case in cases:
        for number, direction in enumerate(DIRECTIONS):
            head = {
                "reading": case.model,
                "scenario": case.scenario,
                "direction": direction,
                "motion_residual": case.residual,
            }
            acceleration = case.acceleration[number] / STANDARD_GRAVITY
            displacement, force = case.displacement[number], case.force[number]
            rows += [
                {
                    **head,
                    "point": point,
                    "peak_acceleration_g": curve.max(),
                    "peak_frequency_hz": case.frequency[curve.argmax()],
                    "peak_transmissibility": curve.max() / level_g,
                    "peak_relative_displacement_mm": 1e3 * deflection.max(),
                }
                for point, curve, deflection in zip(
                    points, acceleration.T, displacement.T, strict=True
                )
            ]
            peak = {
                "peak_force_n": force.max(),
                "peak_frequency_hz": case.frequency[force.argmax()],
            }
            rows.append({**head, "point": INTERFACE, **peak})
    return pd.DataFrame(rows)
