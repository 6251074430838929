"""The study file as checked, frozen models.

Every key has its unit in its name (``depth_mm``); the models hold the values as written and give
them in SI as properties (``depth``). Unknown keys are refused. A mistake is one line with the
file, the line, the key, the value and what is allowed (`StudyError`).

`base`
    What all sections are made of.
`coupon`, `dampers`, `panel`, `sound`, `damping`, `response`, `scenarios`
    The sections, one module each.
`study`
    A whole study.
`requirements`
    What its sections require of each other.
`document`
    The YAML file, the lines of its keys, and the study in it.
`mistakes`, `choice`
    Mistakes at keys; keys with alternatives.
"""

from pidpanel.study.base import StudyError
from pidpanel.study.coupon_study import CouponStudy
from pidpanel.study.document import load_any_study, load_study
from pidpanel.study.scenarios import Family, Filling, Layout, Scenario
from pidpanel.study.study import Study

__all__ = [
    "CouponStudy",
    "Family",
    "Filling",
    "Layout",
    "Scenario",
    "Study",
    "StudyError",
    "load_any_study",
    "load_study",
]
