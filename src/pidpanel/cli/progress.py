"""Progress of a run: its cases, its stages, failed jobs."""

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

from pidpanel.coupon.from_study import distinct_cases
from pidpanel.progress import last_line
from pidpanel.study import CouponStudy, Study

# Stage of a rule, where it is not the rule's own name.
STAGE_OF = {
    **dict.fromkeys(("pour", "loosen", "shake", "cases", "film"), "coupon"),
    **dict.fromkeys(("maps", "export"), "response"),
    "base_export": "base",
    "margins": "severity",
    **dict.fromkeys(("coupled_scenario", "verdict"), "coupled"),
    "coupon_report": "report",
}

# A rule that failed and its log, in the log of Snakemake
_FAILED = re.compile(
    r"^Error in rule (\w+):\n(?:(?!Error in rule| +log: ).*\n)* +log: (.*?)"
    r"(?: \(check log file.*)?$",
    re.MULTILINE,
)


def case_line(study: CouponStudy, folder: Path) -> str:
    """Return how many cases are done, left and failed in ``results/coupon``; empty for none."""
    cases = list(distinct_cases(study).values())
    failures: Counter[str] = Counter()
    done = 0
    for case in cases:
        try:
            runs = json.loads(case.outcome_file(folder).read_text(encoding="utf-8"))["runs"]
            failures.update([str(run["status"]) for run in runs if run["status"] != "ok"][:1])
        except (OSError, ValueError, KeyError, TypeError):
            continue
        done += 1
    text = f"{done} of {len(cases)} done, {len(cases) - done} left" if cases else ""
    names = ", ".join(f"{count} {name}" for name, count in failures.items())
    return f"{text}; {failures.total()} of them failed ({names})" if failures else text


def stages(study: CouponStudy, left: Mapping[str, int]) -> Iterator[str]:
    """Yield a line for each stage of a study: done, or which jobs of it are left."""
    by_stage: dict[str, list[str]] = {}
    for rule, count in left.items():
        by_stage.setdefault(STAGE_OF.get(rule, rule), []).append(f"{count} × {rule}")
    for name in stage_names(study):
        yield f"  {name:<11} {'left: ' + ', '.join(by_stage[name]) if name in by_stage else 'done'}"


def stage_names(study: CouponStudy) -> list[str]:
    """Return the stages that a study has, in the order in which they run."""
    # packings of coupled runs are poured with the coupons
    has = {"coupon": bool(study.coupons) or study.is_coupled}
    if isinstance(study, Study):
        has |= {
            "damping": bool(study.coupons),
            "panel": True,
            "sound": study.sound is not None,
            "coupled": study.is_coupled,
            "response": study.sound is not None,
            "energy": study.energy is not None,
            "severity": study.severity is not None or bool(study.limits),
            "base": study.base is not None,
            "optimise": study.optimise is not None,
            "margin": bool(study.uncertain),
            "measurement": bool(study.measurements),
        }
    return [*(name for name, is_there in has.items() if is_there), "report"]


def failed(folder: Path, name: str, left: Mapping[str, int]) -> list[str]:
    """Return a line for each job of a study that failed in the last run and is still left."""
    logs = (folder / ".snakemake" / "log").glob("*.log")
    log = max(logs, key=lambda log: log.stat().st_mtime, default=None)
    text = log.read_text(encoding="utf-8", errors="replace") if log else ""
    failures = [
        f"failed: {rule}, {job}: {last_line(folder / job) or 'no message'}"
        for rule, job in _FAILED.findall(text)
        if rule in left and job.startswith((f"results/{name}/", "results/coupon/"))
    ]
    return list(dict.fromkeys(failures))
