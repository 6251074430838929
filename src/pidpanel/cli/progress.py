"""Progress of a run: its cases, its stages, failed jobs."""

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
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

_ERROR = re.compile(r"^Error in rule (\w+):")
_LOG = re.compile(r"^ +log: (.*?)(?: \(check log file.*)?$")


@dataclass(frozen=True)
class Cases:
    """Numbers of cases of a study by outcome."""

    total: int
    done: int  # whose runs have all ended
    failures: Mapping[str, int]  # by the name of the failure

    def __str__(self) -> str:
        failed = sum(self.failures.values())
        names = ", ".join(f"{count} {name}" for name, count in self.failures.items())
        text = f"{self.done} of {self.total} done, {self.total - self.done} left"
        return f"{text}; {failed} of them failed ({names})" if failed else text


def cases_of(study: CouponStudy, folder: Path) -> Cases:
    """Count the cases of a study by their state in ``results/coupon``."""
    failures: Counter[str] = Counter()
    cases = list(distinct_cases(study).values())
    done = 0
    for case in cases:
        try:
            runs = json.loads(case.outcome_file(folder).read_text(encoding="utf-8"))["runs"]
            failed = [str(run["status"]) for run in runs if run["status"] != "ok"]
        except (OSError, ValueError, KeyError, TypeError):
            continue
        done += 1
        failures.update(failed[:1])
    return Cases(len(cases), done, failures)


def stages(study: CouponStudy, left: Mapping[str, int]) -> Iterator[str]:
    """Yield a line for each stage of a study: done, or which jobs of it are left."""
    by_stage: dict[str, list[str]] = {}
    for rule, count in left.items():
        by_stage.setdefault(STAGE_OF.get(rule, rule), []).append(f"{count} × {rule}")
    for name in stage_names(study):
        yield f"  {name:<11} {'left: ' + ', '.join(by_stage[name]) if name in by_stage else 'done'}"


def stage_names(study: CouponStudy) -> list[str]:
    """Return the stages that a study has, in the order in which they run."""
    has = {"coupon": bool(study.coupons)}
    if isinstance(study, Study):
        has = {
            # whose packings are poured with the coupons
            "coupon": bool(study.coupons) or study.is_coupled,
            "damping": bool(study.coupons),
            "panel": True,
            "sound": study.sound is not None,
            "coupled": study.is_coupled,
            "response": study.sound is not None,
            "severity": study.severity is not None or bool(study.limits),
            "base": study.base is not None,
            "optimise": study.optimise is not None,
            "measurement": bool(study.measurements),
        }
    return [*(name for name, is_there in has.items() if is_there), "report"]


def failed(folder: Path, name: str, left: Mapping[str, int]) -> list[str]:
    """Return a line for each job of a study that failed in the last run and is still left."""
    logs = sorted(
        (folder / ".snakemake" / "log").glob("*.log"), key=lambda log: log.stat().st_mtime
    )
    failures: dict[str, None] = {}
    rule = ""
    for line in logs[-1].read_text(encoding="utf-8", errors="replace").splitlines() if logs else []:
        begun = _ERROR.match(line)
        log_match = _LOG.match(line)
        if begun:
            rule = begun[1]
        elif log_match and rule:
            ours = log_match[1].startswith((f"results/{name}/", "results/coupon/"))
            if ours and rule in left:
                why = last_line(folder / log_match[1])
                failures[f"failed: {rule}, {log_match[1]}: {why or 'no message'}"] = None
            rule = ""
    return list(failures)
