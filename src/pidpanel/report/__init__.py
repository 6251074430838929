"""What came out, for people: one self-contained page of text, figures and tables.

`from_study` reads a study and what its stages left (`read`, `inputs`). `study_page` and
`comparison` put the parts of a page in order: `answer` at its head, then the functions
``<part>_section``, some with figures from ``<part>_figures``. `html` writes the page.
"""
