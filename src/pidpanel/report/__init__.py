"""What came out, for people: one self-contained page of text, figures and tables.

From files to a page:

`write`
    One function a page: reads, builds, writes.
`read`, `inputs`, `evidence`
    What the stages left, as records; single runs of the coupon.
`study_page`, `coupon_page`
    Which parts a page has, in which order.
`comparison`, `comparison_page`
    What differs between two studies, and its page.
`html`, `charts`
    The page as text; curves that a reader can zoom and switch.

What a page says first:

`answer`
    The scenarios against the bare panel, and which of them can be told apart.
`answer_text`, `answer_section`, `answer_figures`, `scenario_list`
    The answer in a sentence with its caveats; its table and pictures; its figures; scenarios in few
    words.
`coupon_text`
    A coupon in words, and what came out of it in plain figures.

What is folded below it:

`outcome`
    Every comparison in sentences.
`claims`, `claims_table`
    The paper's claims tested against the numbers.
`warnings`, `known_errors`
    Limitations of the numbers; which have errors at all.
`facts`
    What was computed, with what, and how to reproduce it.

The parts of a page, each a function ``<part>_section``:

`panel_section`, `sound_section`, `coupon_section`, `losses_section`, `varied_section`
    What was put in, and the coupon.
`damping_section`, `coupled_section`, `layouts_section`, `response_section`, `radiation_section`
    The surface and its laws, coupled runs, explicit layouts, families of scenarios, the air.
`verdict`, `verdict_files`, `verdict_section`, `verdict_bands`
    Readings beside coupled runs.
`maps_section`, `summary_section`, `stress_section`
    Fields over the panel, all scenarios, strain and stress.

Figures, from arrays and frames:

`panel_figures`, `sound_figures`, `coupon_figures`, `damping_figures`, `response_figures`, \
`maps_figures`
    Figures of matplotlib.
`pictures`, `films`
    Rendered scenes; a shaken cell in motion.
`style`, `layout`
    Colours and PNG files; margins, legends and axes that figures share.

`text`, `names`, `rms`, `psds`
    Numbers and units, and scenarios, as pages write them; rms accelerations and PSDs of scenarios.
"""
