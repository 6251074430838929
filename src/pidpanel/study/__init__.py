"""The study file as checked, frozen models.

Every key carries its unit in its name (``depth_mm``). Unknown keys are refused with the nearest
right one named; a mistake is answered by one line with the file, the line, the key, the value and
what is allowed (`StudyError`).

`base`
    What all sections are made of.
`coupon`, `panel`, `sound`, `damping`, `response`
    The sections, one module each; scenarios belong to the response.
`study`
    The whole, and what its sections ask of each other.
`reading`
    The YAML file, its error lines, the files that it names.
`schema`
    What the models allow at a place of the file.
"""

from pidpanel.study.base import StudyError
from pidpanel.study.reading import load_any_study, load_study
from pidpanel.study.response import Family, Scenario
from pidpanel.study.study import CouponStudy, Study

__all__ = [
    "CouponStudy",
    "Family",
    "Scenario",
    "Study",
    "StudyError",
    "load_any_study",
    "load_study",
]
