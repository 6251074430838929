"""What came out, for people: one self-contained page of text, figures and tables.

From files to a page: `from_study` (the only reader of the study, one function a page), `read`,
`inputs` and `evidence` (what the stages left, as records), `study_page` and `coupon_page` (which
parts a page has, in which order), `write`,
`comparison` and `comparison_page` (two studies), `html` and `charts` (the page as text).

What a page says first: `answer` (scenarios against the bare panel, and which of them are apart),
`answer_text`, `answer_section`, `answer_figures`, `scenario_list`, `coupon_text`.

What is folded below it: `claims` and `claims_table` (the paper's claims), `warnings` and
`known_errors` (limitations), `facts` (what was computed with what).

The parts of a page, each a function ``<part>_section``: `panel_section`, `sound_section`,
`coupon_section`, `losses_section`, `varied_section`, `damping_section`, `coupled_section`,
`layouts_section`, `response_section`, `maps_section`, `summary_section`, `stress_section`,
`severity_section`, `measurement_section`, `base_section`, `optimise_section`; damping models
against coupled runs: `verdict`, `verdict_files`, `verdict_section`, `verdict_bands`.

Figures, from arrays and frames: `panel_figures`, `sound_figures`, `coupon_figures`,
`damping_figures`, `response_figures`, `maps_figures`, `base_figures`,
`front_drawing`, `films`;
`style` and `layout` (colours, PNG files, margins, legends, axes).

`text`, `names`, `rms`, `psds`: numbers and units, scenarios, rms accelerations and PSDs.
"""
