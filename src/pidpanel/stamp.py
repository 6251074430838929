"""What every result carries: of which study it is and what made it. No time stamps."""

import hashlib
from importlib.metadata import version

from pidpanel.coupon.liggghts.process import VERSION
from pidpanel.study import CouponStudy


def stamp(study: CouponStudy) -> dict[str, str]:
    """Attributes of a result file: study, its hash, versions of pidpanel and LIGGGHTS."""
    return {
        "study": study.name,
        "study_hash": hashlib.sha256(study.model_dump_json().encode()).hexdigest()[:16],
        "pidpanel_version": version("pidpanel"),
        "liggghts_version": VERSION,
    }
