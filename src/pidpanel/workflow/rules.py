"""Rules of a study with a panel, from its mesh to its page: what depends on what.

`workflow/rules` gives them to Snakemake, `workflow.fork_runner` runs them without it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pidpanel.paths import ATLAS_CASES, ATLAS_CONSTANTS
from pidpanel.provenance.digests import text_digest, values_digest
from pidpanel.study import Study
from pidpanel.study.dampers import damper_masses, resolved_masses

if TYPE_CHECKING:
    from pidpanel.workflow.plan import Plan

RESPONSE_SECTIONS = ("damping", "panel", "sound", "response")
# titles, the choice of maps and of cases, and coupled runs change no response to given damping
NOT_FOR_RESPONSE = {"response": {"maps"}, "damping": {"coupled"}}

RESPONSE = {  # files of the responses
    "psd": "psd.nc", "summary": "summary.csv", "layouts": "layouts.csv", "stress": "stress.nc",
    "stress_table": "stress.csv", "left_out": "left_out.nc",
}  # fmt: skip
PROPOSAL = ("layouts", "front", "summary", "search", "psd")  # tables of the proposed layouts

MEASUREMENT = ("measured", "differences")  # tables of the measurements
OPTIONAL = ("optimise", "severity", "measurement", "base")  # rules that the report reads if any

# Tables of the severity of the responses.
SEVERITY = ("oscillators", "peaks", "fatigue", "strength", "margins")


@dataclass(frozen=True)
class Rule:
    """A rule: its files, and what these depend on besides."""

    log: str  # file with the output of the job
    input: Mapping[str, str | Sequence[str]]
    output: Mapping[str, str]
    values: Mapping[str, Any]  # what the output depends on besides other results and the package
    params: Mapping[str, str] = field(default_factory=dict)  # further texts for the job

    def made(self, *names: str) -> dict[str, str]:
        """Return files of the output by their names."""
        return {name: self.output[name] for name in names}


def panel_rules(plan: Plan, study: Study) -> dict[str, Rule]:
    """Return the rules by name, each after those whose results it reads.

    Each has a script of its name.
    """
    panel = _panel(plan, study)
    files: dict[str, str | list[str]] = {**panel.made("modes", "plate", "section")}
    rules = {"panel": panel}
    if study.sound is not None:
        sound = _sound(plan, study, panel.output)
        files |= {**sound.made("modal_force"), "air": air_files(sound)}
        response = _response(plan, study, files)
        maps = _maps(plan, study, files, response)
        rules |= {"sound": sound, "response": response, "maps": maps}
        if study.severity is not None:
            rules["severity"] = _severity(plan, study, response, maps)
    if study.base is not None:
        rules["base"] = _base(plan, study, panel)
    if study.optimise is not None:
        rules["optimise"] = _optimise(plan, study, files)
    if study.measurements:
        rules["measurement"] = _measurement(plan, rules)
    if study.sound is not None:
        rules["export"] = _export(plan, study, panel, response)
    return {**rules, "report": _report(plan, study, rules)}


def air_files(sound: Rule) -> list[str]:
    """Return the file of the air if it is included."""
    return [sound.output["air"]] if "air" in sound.output else []


def scenarios_digest(study: Study) -> str:
    """Return the digest of all scenarios, without their titles' families."""
    return text_digest(scenario.model_dump_json() for scenario in study.all_scenarios())


def coupled_files(plan: Plan) -> dict[str, str]:
    """Return the tables of the coupled runs."""
    names = ("summary", "third_octaves", "impedance", "psd")
    return {name: plan.results(f"coupled/{name}.csv") for name in names}


def films(plan: Plan) -> list[str]:
    """Return the film of each coupon."""
    return [plan.damper_file("coupon", damper, "film.nc") for damper in plan.study.coupons]


def _panel(plan: Plan, study: Study) -> Rule:
    output = plan.files(
        "panel", modes="modes.nc", table="modes.csv", shapes="modes.vtu", mesh="mesh.msh",
        section="section.csv", plate="plate.nc",
    )  # fmt: skip
    values = {
        "study": plan.section("panel"),
        # basis and mesh follow the panel with its heaviest dampers
        "damper_mass": values_digest(damper_masses(study)),
        "resolved_mass": values_digest(resolved_masses(study)),
        "highest": study.response.frequency_hz[1],
        "speed": study.wave_speed,
    }
    return Rule(plan.results("panel/panel.log"), {}, output, values)


def _sound(plan: Plan, study: Study, panel: Mapping[str, str]) -> Rule:
    output = plan.files("sound", spectrum="spectrum.csv", modal_force="modal_force.nc")
    if study.radiation != "none":
        output["air"] = plan.results("sound/air.nc")
    values = {
        "study": plan.section("sound"),
        "highest": study.response.frequency_hz[1],
        "air_mass": study.response.air_mass,
    }
    return Rule(plan.results("sound/sound.log"), {"modes": panel["modes"]}, output, values)


def _response(plan: Plan, study: Study, files: Mapping[str, str | Sequence[str]]) -> Rule:
    damping = _damping(plan, study)
    return Rule(
        plan.results("response/response.log"),
        {**files, **damping.input},
        plan.files("response", **RESPONSE),
        {"study": plan.section(*RESPONSE_SECTIONS, without=NOT_FOR_RESPONSE), **damping.values},
        damping.params,
    )


def _damping(plan: Plan, study: Study) -> Rule:
    """Return what a rule needs that reads the damping of all scenarios."""
    # coupons come as surfaces
    dampers = {
        damper: study.all_dampers[damper].model_dump(exclude={"coupon"})
        for damper in study.used_dampers
    }
    folders = {"damping": bool(study.surfaces), "coupled": study.is_coupled}
    return Rule(
        "",
        {
            "surfaces": [plan.damper_file("damping", d, "surface.nc") for d in study.surfaces],
            "coupled": list(coupled_files(plan).values()) if study.is_coupled else [],
        },
        {},
        {"dampers": values_digest(dampers), "scenarios": scenarios_digest(study), **_atlas(study)},
        {name: plan.results(name) for name, is_read in folders.items() if is_read},
    )


def _atlas(study: Study) -> dict[str, str]:
    """Return what the damping from the atlas depends on; nothing where none is."""
    coupons = {**study.atlas_coupons, **study.prior_coupons}
    inputs = {"cell", "particles", "walls", "gravity_g", "gravity_direction"}
    beds = [coupon.model_dump(include=inputs) for coupon in coupons.values()]
    return {"atlas": values_digest([ATLAS_CASES, ATLAS_CONSTANTS, *beds])} if coupons else {}


def _optimise(plan: Plan, study: Study, files: Mapping[str, str | Sequence[str]]) -> Rule:
    surfaces = [plan.damper_file("damping", damper, "surface.nc") for damper in study.surfaces]
    sections = (*RESPONSE_SECTIONS, "base", "dampers", "optimise")
    return Rule(
        plan.results("optimise/optimise.log"),
        {**files, "surfaces": surfaces},
        {name: plan.results(f"optimise/{name}.csv") for name in PROPOSAL},
        {"study": plan.section(*sections, without=NOT_FOR_RESPONSE), **_atlas(study)},
        {"damping": plan.results("damping")} if surfaces else {},
    )


def _severity(plan: Plan, study: Study, response: Rule, maps: Rule) -> Rule:
    read = response.made("psd", "summary", "stress", "stress_table")
    made = {name: plan.results(f"severity/{name}.csv") for name in SEVERITY}
    if study.severity is not None and study.severity.strength is not None:
        read["maps"] = maps.output["maps"]
        made["maps"] = plan.results("severity/maps.nc")
    return Rule(
        plan.results("severity/severity.log"), read, made, {"study": plan.section("severity")}
    )


def _measurement(plan: Plan, rules: Mapping[str, Rule]) -> Rule:
    """Return the rule of the measurements of a study, with the curves of other rules."""
    computed = {name: rules[name] for name in ("response", "base") if name in rules}
    return Rule(
        plan.results("measurement/measurement.log"),
        {name: rule.output.get("psd") or rule.output["sine"] for name, rule in computed.items()},
        {name: plan.results(f"measurement/{name}.csv") for name in MEASUREMENT},
        {"study": plan.section("measurements")},
    )


def _base(plan: Plan, study: Study, panel: Rule) -> Rule:
    parts = {} if study.base is None else study.base.parts
    names = {"modes_table": "modes.csv"}
    if parts["random"]:
        names |= {"psd": "psd.nc", "psd_table": "psd.csv", "summary": "summary.csv"}
    if parts["limits"]:
        names |= {"notched": "notched.csv"}
    if parts["sine"]:
        names |= {"sine": "sine.nc", "sine_table": "sine.csv"}
    damping = _damping(plan, study)
    return Rule(
        plan.results("base/base.log"),
        {**panel.made("modes", "plate", "section"), **damping.input},
        plan.files("base", **names),
        {"study": plan.section("base", *RESPONSE_SECTIONS), **damping.values},
        damping.params,
    )


def _maps(
    plan: Plan, study: Study, files: Mapping[str, str | Sequence[str]], response: Rule
) -> Rule:
    read = {name: files[name] for name in ("modes", "plate", "modal_force", "air")}
    read |= response.made("left_out", "psd")
    return Rule(
        plan.results("response/maps.log"),
        {**read, "coupled": coupled_files(plan)["impedance"] if study.is_coupled else []},
        plan.files("response", maps="maps.nc", folder="maps"),
        {"study": plan.section("panel", "sound", "response"), "scenarios": scenarios_digest(study)},
    )


def _export(plan: Plan, study: Study, panel: Rule, response: Rule) -> Rule:
    return Rule(
        plan.results("response/export.log"),
        {**panel.made("modes"), **response.made("psd", "summary")},
        {"folder": plan.results("response/export")},
        {
            "readings": study.readings,
            "damping_ratio": study.panel.damping_ratio,
            "scenarios": scenarios_digest(study),
        },
    )


def _report(plan: Plan, study: Study, rules: Mapping[str, Rule]) -> Rule:
    read: dict[str, str | Sequence[str]] = {
        **rules["panel"].made("modes", "section"),
        "mode_table": rules["panel"].output["table"],
        "cases": [plan.damper_file("coupon", d, "cases.csv") for d in study.coupons],
        "films": films(plan),
        "damping": [
            plan.damper_file("damping", damper, name)
            for damper in study.surfaces
            for name in ("surface.nc", "law.csv")
        ],
        "optional": [file for name in OPTIONAL if name in rules
                     for file in rules[name].output.values()],
    }  # fmt: skip
    if study.sound is not None:
        response = rules["response"].made("psd", "summary", "layouts", "stress_table")
        read["response"] = list(response.values())
        read |= {**rules["maps"].made("maps"), **rules["sound"].made("spectrum")}
    if study.is_coupled:
        coupled = [coupled_files(plan)[name] for name in ("summary", "impedance")]
        if len(study.readings) > 1 and study.sound is not None:
            coupled.append(plan.results("coupled/verdict.csv"))
        read["coupled"] = coupled
    return Rule(
        plan.results("report.log"),
        read,
        {"page": plan.results("report.html"), "figures": plan.results("report")},
        {"study": plan.section()},
        {"results": plan.results("")},
    )
