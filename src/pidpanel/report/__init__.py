"""What came out, for people: one self-contained page of text, figures and tables.

From files to a page:

`write`
    One function a page: reads, builds, writes.
`read`, `inputs`, `evidence`
    What the stages left, as records; single runs of the coupon.
`study_page`, `coupon_page`, `verification_page`
    Which parts a page has, in which order.
`html`
    The page as text.

What a page says first:

`facts`
    What was computed, with what, and how to reproduce it.
`outcome`
    The main results in sentences.
`claims`
    The paper's claims tested against the numbers.
`warnings`
    Limitations of the numbers.

The parts of a page, each a function ``<part>_section``:

`panel_section`, `sound_section`, `coupon_section`, `losses_section`, `varied_section`
    What was put in, and the coupon.
`damping_section`, `layouts_section`, `response_section`, `radiation_section`
    The surface and its laws, explicit layouts, families of scenarios, the air.
`maps_section`, `summary_section`, `stress_section`
    Fields over the panel, all scenarios, strain and stress.

Figures, from arrays and frames:

`panel_figures`, `sound_figures`, `coupon_figures`, `damping_figures`, `response_figures`, \
`maps_figures`, `verification_figures`
    Figures of matplotlib.
`pictures`
    Rendered scenes.
`style`, `layout`
    Colours and PNG files; margins, legends and axes that figures share.

`text`, `rms`, `psds`
    Numbers, units and names as pages write them; rms accelerations and PSDs of scenarios.
"""
