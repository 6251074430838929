"""Progress of a run: its cases, its stages, failed jobs."""

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from pidpanel.coupon.from_study import distinct_cases
from pidpanel.coupon.liggghts.failures import BY_INPUTS
from pidpanel.progress import last_line
from pidpanel.provenance.locks import hold
from pidpanel.study import CouponStudy, Study

# Stage of a rule, where it is not the rule's own name.
STAGE_OF = {
    **dict.fromkeys(("pour", "loosen", "shake", "cases", "damper_cases"), "coupon"),
    **dict.fromkeys(("film", "damper_film"), "coupon"),
    **dict.fromkeys(("maps", "export"), "response"),
    **dict.fromkeys(("coupled_scenario", "verdict"), "coupled"),
    "damper_damping": "damping",
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

    @property
    def of_machine(self) -> int:
        """Failed ones that need not fail again."""
        return sum(n for name, n in self.failures.items() if name not in BY_INPUTS)

    def __str__(self) -> str:
        failed = sum(self.failures.values())
        names = ", ".join(f"{count} {name}" for name, count in self.failures.items())
        text = f"{self.done} of {self.total} done, {self.total - self.done} left"
        return f"{text}; {failed} of them failed ({names})" if failed else text


def cases_of(study: CouponStudy, folder: Path) -> Cases:
    """Count the cases of a study by their state in ``results/coupon``."""
    failures: Counter[str] = Counter()
    total = done = 0
    for cases in distinct_cases(study).values():
        for case in cases:
            total += 1
            ended = [_status(path) for path in case.outcomes(folder)]
            done += None not in ended
            failed = [status for status in ended if status not in (None, "ok")]
            failures.update(failed[:1])
    return Cases(total, done, failures)


def _status(outcome: Path) -> str | None:
    """Return how a run ended; None where it has not, or where that cannot be read."""
    try:
        return str(json.loads(outcome.read_text(encoding="utf-8"))["status"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def stages(study: CouponStudy, left: Mapping[str, int]) -> Iterator[str]:
    """Yield a line for each stage of a study: done, or which jobs of it are left."""
    by_stage: dict[str, list[str]] = {}
    for rule, count in left.items():
        by_stage.setdefault(STAGE_OF.get(rule, rule), []).append(f"{count} × {rule}")
    names = ["report"]
    if isinstance(study, Study):
        coupled = ["coupled"] if study.is_coupled else []
        base = [] if study.base is None else ["base"]
        sound = [[], []] if study.sound is None else [["sound"], ["response"]]
        optional = [name for name in ("optimise", "severity") if getattr(study, name) is not None]
        optional += ["measurement"] if study.measurements else []
        names = ["panel", *sound[0], *coupled, *sound[1], *base, *optional, *names]
        if study.surfaces:
            names.insert(0, "damping")
    if study.coupons or study.is_coupled:  # whose packings are poured with the coupons
        names.insert(0, "coupon")
    width = max(9, *map(len, names))
    for name in names:
        state = "left: " + ", ".join(by_stage[name]) if name in by_stage else "done"
        yield f"  {name:<{width}} {state}"


def is_running(results: Path) -> bool:
    """Return whether a process runs the workflow on a folder of results."""
    if not results.is_dir():
        return False
    lock = hold(results)
    if lock is None:
        return True
    lock.close()
    return False


def failed(folder: Path, name: str, left: Mapping[str, int]) -> list[str]:
    """Return a line for each job of a study that failed in the last run and is still left."""
    logs = [*(folder / ".snakemake" / "log").glob("*.log"), folder / "results" / name / "run.log"]
    logs = sorted((log for log in logs if log.exists()), key=lambda log: log.stat().st_mtime)
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
