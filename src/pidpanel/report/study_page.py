"""The page of a study with a panel: which parts it has, in which order."""

from collections.abc import Sequence
from dataclasses import replace

from pidpanel.damping.laws import paper_corrected
from pidpanel.damping.surface_cases import COUNTED
from pidpanel.paths import SECTION
from pidpanel.progress import tracked
from pidpanel.report.answer import answer_of
from pidpanel.report.answer_section import answer_fragment
from pidpanel.report.answer_text import NOTHING_MOVES, headline
from pidpanel.report.atlas_section import atlas_section
from pidpanel.report.base_section import base_section
from pidpanel.report.claims import patch_distance, verdict_table, verdicts
from pidpanel.report.coupled_section import coupled_section
from pidpanel.report.coupon_section import Law, coupon_section, coupon_text, losses_section
from pidpanel.report.damping_section import damping_section
from pidpanel.report.facts import study_facts
from pidpanel.report.html import CAVEATS, Fragment, Page, PageSection
from pidpanel.report.inputs import Inputs, PanelInputs
from pidpanel.report.layouts_section import layouts_section
from pidpanel.report.maps_section import maps_section
from pidpanel.report.measurement_section import curves_of, measurement_section
from pidpanel.report.names import family_of, with_names
from pidpanel.report.optimise_section import optimise_section, proposal_choice, proposal_headline
from pidpanel.report.panel_section import is_papers_panel, panel_section
from pidpanel.report.response_section import response_section
from pidpanel.report.severity_section import severity_section
from pidpanel.report.sound_section import sound_section
from pidpanel.report.stress_section import stress_section
from pidpanel.report.summary_section import summary_section
from pidpanel.report.verdict_section import verdict_section
from pidpanel.report.warnings import study_warnings
from pidpanel.sound.from_study import spectrum_of


def study_page(inputs: Inputs, steps: Sequence[tuple[str, str]]) -> Page:
    """Return the whole page."""
    study = inputs.study
    answer = answer_of(study, inputs.summary)
    proposal = inputs.proposal
    text = headline(answer) if answer else NOTHING_MOVES
    warnings = study_warnings(inputs, answer)
    blocks = [answer_fragment(inputs, answer)] if answer else []
    proposed = []
    if proposal is not None:
        text, proposed = proposal_headline(proposal), [optimise_section(proposal)]
        # of the bare panel alone the drawing and the PSD are with each layout
        beside = blocks if answer is not None and answer.candidates else []
        blocks = [proposal_choice(proposal, inputs.basis), *beside]
    return Page(
        title=study.title or study.name,
        answer=text,
        first=blocks,
        caveats=warnings[:CAVEATS],
        facts=study_facts(inputs),
        assumptions=study.assumptions,
        warnings=warnings[CAVEATS:],
        claims=_claims(inputs),
        sections=[*proposed, *(replace(section, folded=True) for section in _sections(inputs))],
        steps=steps,
    )


def _claims(inputs: Inputs) -> Fragment | None:
    """Return the paper's claims tested, where the panel is the paper's; else None."""
    if not is_papers_panel(inputs.modes, inputs.printed):
        return None
    distance = patch_distance(inputs.basis)
    return verdict_table(verdicts(inputs.study, inputs.summary, inputs.psd, distance))


def _of_coupon(inputs: PanelInputs, name: str, law: Law | None) -> list[PageSection]:
    """Return the parts of one coupon: its runs, its losses, the surface if one is read."""
    coupon = inputs.coupons[name]
    good = coupon.cases[coupon.cases["status"].isin(COUNTED)]
    on_coupon = coupon_section(coupon, text=coupon_text(coupon), law=law)
    sections = [on_coupon, losses_section(good)]
    if name in inputs.damping:
        sections.append(damping_section(inputs.damping[name]))
    return sections


def coupon_sections(inputs: PanelInputs, law: Law | None = None) -> list[PageSection]:
    """Return the parts of all coupons; with a law of the paper to draw beside its cases."""
    sections = []
    for name in tracked(list(inputs.coupons), "coupons of the page"):
        of_coupon = _of_coupon(inputs, name, law)
        sections += of_coupon if name == SECTION else [s.with_suffix(name) for s in of_coupon]
    return sections


def _sections(inputs: Inputs) -> list[PageSection]:
    """Return the parts of the page in order, those left out of which there is nothing to show."""
    study, names = inputs.study, inputs.names
    points, frequency = list(study.panel.points), study.response.frequency_hz
    sound = study.acoustics
    # the paper states levels and no spectrum
    assumed = is_papers_panel(inputs.modes, inputs.printed) and study.oaspl_db is not None
    sections = [
        panel_section(inputs.basis, inputs.modes, inputs.printed),
        sound_section(
            inputs.bands, sound.spectrum.name, spectrum_of(sound).rows, frequency, assumed=assumed
        ),
    ]
    law = paper_corrected if "paper_corrected" in study.readings else None
    sections += coupon_sections(inputs, law)
    if inputs.atlas is not None:
        sections.append(atlas_section(inputs.atlas, inputs.layouts, names, frequency))
    if inputs.coupled is not None:
        sections.append(coupled_section(inputs.coupled, names, inputs.moving_points))
    if study.layouts:
        sections.append(layouts_section(inputs))
    families = tracked(list(study.families), "families of scenarios of the page")
    sections += [response_section(inputs, family_of(study, name)) for name in families]
    if inputs.coupled is not None and inputs.coupled.verdict is not None:
        verdict = with_names(inputs.coupled.verdict, names)
        sections.append(verdict_section(verdict, points, inputs.psd, inputs.coupled.psd))
    layouts = {scenario.layout_label: scenario.name for scenario in study.all_scenarios()}
    if inputs.measurements is not None:
        curves = {"sound": inputs.psd, "base": curves_of(inputs.base)}
        sections.append(measurement_section(inputs.measurements, curves, {**layouts, **names}))
    if inputs.base is not None:
        sections.append(
            base_section(inputs.base, layouts, points, study.panel.section.thickness_mm)
        )
    if inputs.maps is not None:
        sections.append(maps_section(inputs.maps, inputs.basis.cell_in_patch, names))
    sections.append(summary_section(study, inputs.summary))
    sections.append(stress_section(with_names(inputs.stress, names)))
    if inputs.severity is not None:
        sections.append(
            severity_section(inputs.severity, inputs.summary, names, inputs.basis.cell_in_patch)
        )
    return sections
