"""Mutation run: how many small errors in the formulas the tests notice.

    python tests/mutation [module …] [--sample 50] [--seed 0] [--jobs 2]

Without modules, all in `FORMULAS`. Every mutant (`mutants`) is run against the tests that execute
its statement, the fastest first, in a fork of a process that has imported numpy, scipy and the
like already. Tests that run LIGGGHTS are left out. A mutant that survives is listed with its
reason in ``accepted.toml``; one that is ``equivalent`` there cannot be told from the program by
any test and does not count. The command fails below `REQUIRED` of the others, where a survivor has
no reason, or where a reason is given for what is no mutant (any more). The result does not depend
on how fast the machine is: what runs away is ended by the CPU time that it takes, as a multiple of
what its tests take without it.
"""

from __future__ import annotations

import argparse
import ast
import csv
import gc
import importlib.machinery
import importlib.util
import json
import math
import os
import random
import resource
import shutil
import sys
import tempfile
import threading
import time
import tomllib
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest
from _pytest.runner import runtestprotocol
from mutants import Mutant, mutants_of

FORMULAS = {
    "": "damping_ratio",
    "spectra": "acceleration_table break_points third_octaves",
    "geometry": "cells plane_mesh plane_waves polygon sizes",
    "atlas": "groups",
    "coupon": "balance contact cycles drive geometry rows states",
    "damping": "atlas broadband coupled fit gaussian_process inelastic interpolation jump laws measured models sides "
    "surface surface_cases tables",
    "panel": "attachments basis checks connectivity eigen grid mindlin modes navier plate point_supports resolution section shapes "
    "stretching supports thin triangles",
    "sound": "chebyshev face field free_edges outline radiation rectangle spectrum surroundings table wavenumber_table",
    "solve": "bands basis_error dampers elements excitation layout lines maps mesh_error modal "
    "model motions panel power receptances search sharpness solvers source stress base_motion stretching uncertainty",
    "coupled": "coupled_panel estimate impedance integration linear own_force "
    "excited_panel scenario_runs segments softening force_record spectra variants",
    "response": "cases dampers extrapolation mapping model_error nastran panel stretching tables",
    "base": "basis_check random sine",
    "severity": "fatigue moments oscillators strength tables",
    "optimise": "fidelity objectives places proposal reduced_panel search variants",
    "measurement": "computed differences files units universal",
    "identify": "force_files next_tones posterior prediction",
    "report": "verdict",
}
"""Modules with formulas, by stage; first those of all stages."""

REQUIRED = 0.95
RUNS_AWAY = 10.0
"""Times its CPU time without a mutant, plus ``--spare``, after which a test is ended."""
MEMORY = 12 * 2**30
"""Bytes of address space of a mutant: one that asks for more fails."""

Executed = dict[str, dict[str, Any]]
"""By test: ``cpu`` [s] and ``lines``, executed lines by file."""

Lines = dict[str, set[int]]

Known = dict[tuple[str, str, str], dict[str, Any]]


def in_forks(
    work: Mapping[Any, Callable[[], Any]], folder: Path, jobs: int
) -> Iterator[tuple[Any, Any, float]]:
    """Run each piece of work in a fork of its own: its name, what it returns, its CPU time [s].

    None is returned by a fork that was killed.
    """
    waiting = list(work.items())
    running: dict[int, tuple[Any, Path]] = {}
    while waiting or running:
        while waiting and len(running) < jobs:
            name, piece = waiting.pop(0)
            answer = folder / f"{len(waiting)}.json"
            pid = os.fork()
            if pid == 0:
                ended = 1
                try:
                    quiet = os.open(os.devnull, os.O_WRONLY)
                    os.dup2(quiet, 1)
                    os.dup2(quiet, 2)
                    answer.write_text(json.dumps(piece()))
                    ended = 0
                finally:  # whatever happens, a fork never goes on as its parent
                    os._exit(ended)
            running[pid] = name, answer
        pid, status, usage = os.wait4(-1, 0)
        if pid in running:
            name, answer = running.pop(pid)
            found = json.loads(answer.read_text()) if status == 0 else None
            answer.unlink(missing_ok=True)
            shutil.rmtree(folder / str(pid), ignore_errors=True)
            yield name, found, usage.ru_utime + usage.ru_stime


def run_pytest(paths: Iterable[str], folder: Path, *plugins: object) -> int:
    """Exit code of pytest on some paths, with its files in a folder of its own."""
    options = ["-qx", "--tb=no", "-pno:cacheprovider", "-pno:unraisableexception"]
    options += ["-mnot liggghts"]
    options += ["--hypothesis-seed=0", f"--basetemp={folder / str(os.getpid())}"]
    return int(pytest.main([*options, *paths], plugins=list(plugins)))


class Profile:
    """Runs each test in a fork of its own and notes which lines it executes.

    What a file of tests executes when it is imported is executed by each of its tests.
    """

    def __init__(self, source: Path, folder: Path) -> None:
        self.source, self.folder = str(source), folder
        self.executed: Executed = {}
        self.imported: dict[Path, Lines] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_make_collect_report(self, collector: pytest.Collector) -> Iterator[None]:
        with traced(self.source) as lines:
            report = yield
        self.imported[collector.path] = lines
        return report

    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool:
        found = list(in_forks({item.nodeid: partial(self._one, item)}, self.folder, 1))
        for name, one, cpu in found:
            if one is None or one["failed"]:
                raise pytest.UsageError(f"{name} fails without any mutant")
            self.executed[name] = {"cpu": cpu, "lines": one["lines"]}
        return True

    def _one(self, item: pytest.Item) -> dict[str, Any]:
        with traced(self.source) as lines:
            reports = runtestprotocol(item, log=False, nextitem=None)
        for file, of in self.imported[item.path].items():
            lines[file] |= of
        return {
            "failed": any(report.failed for report in reports),
            "lines": {file: sorted(of) for file, of in lines.items()},
        }


@contextmanager
def traced(source: str) -> Iterator[Lines]:
    """Lines that are executed in files below ``source``."""
    lines: Lines = defaultdict(set)

    def on_line(frame: FrameType, event: str, _: object) -> Any:
        if event == "line":
            lines[frame.f_code.co_filename].add(frame.f_lineno)
        return on_line

    def on_call(frame: FrameType, _: str, __: object) -> Any:
        return on_line if frame.f_code.co_filename.startswith(source) else None

    sys.settrace(on_call)
    threading.settrace(on_call)
    try:
        yield lines
    finally:
        sys.settrace(None)
        threading.settrace(None)


def profile(source: Path, folder: Path, path: str) -> dict[str, Any]:
    """What each test of a path executes, and the modules that are imported for them."""
    plugin = Profile(source, folder)
    code = run_pytest([path], folder, plugin)
    tests = tuple(str(Path(path).resolve()) for path in [path])
    others = [
        name
        for name, module in list(sys.modules.items())
        if not str(getattr(module, "__file__", None) or "").startswith((str(source), *tests))
        and name.isidentifier() | ("." in name)
    ]
    return {"code": code, "executed": plugin.executed, "others": others}


class Chosen:
    """Keeps to some tests, in an order, ends what runs away, and remembers which one failed."""

    def __init__(self, seconds: Mapping[str, float]) -> None:
        self.seconds = seconds
        self.rank = {name: number for number, name in enumerate(seconds)}
        self.failed = ""

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        end = math.ceil(time.process_time() + self.seconds[nodeid])
        resource.setrlimit(resource.RLIMIT_CPU, (end, -1))

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = sorted(
            (item for item in items if item.nodeid in self.rank),
            key=lambda item: self.rank[item.nodeid],
        )

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed and not self.failed:
            self.failed = report.nodeid


class Mutated(importlib.machinery.SourceFileLoader):
    """Hands out the code of one module, mutated."""

    def __init__(self, name: str, path: str, code: CodeType) -> None:
        super().__init__(name, path)
        self.code = code

    def find_spec(self, fullname: str, path: object, target: object = None) -> Any:
        if fullname != self.name:
            return None
        return importlib.util.spec_from_file_location(fullname, self.path, loader=self)

    def get_code(self, fullname: str) -> CodeType:
        return self.code


def try_mutant(mutant: Mutant, path: Path, seconds: Mapping[str, float], folder: Path) -> str:
    """The test that fails with a mutant, empty where none does; ``seconds`` of CPU for each."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    mutant.apply()
    code = compile(mutant.tree, str(path), "exec")
    sys.meta_path.insert(0, Mutated(mutant.module, str(path), code))
    chosen = Chosen(seconds)
    ended = run_pytest(dict.fromkeys(test.partition("::")[0] for test in seconds), folder, chosen)
    return chosen.failed or ("" if ended == 0 else f"pytest ends with {ended}")


class Readers:
    """Lines of functions that read a name, by way of other constants too."""

    def __init__(self, files: Iterable[Path]) -> None:
        self.lines: dict[str, set[tuple[str, int]]] = defaultdict(set)
        self.passed_on: dict[str, set[str]] = defaultdict(set)
        for file in files:
            tree = ast.parse(file.read_bytes())
            for statement in tree.body:
                self._statement(str(file), statement)

    def _statement(self, file: str, statement: ast.stmt) -> None:
        inside = isinstance(statement, ast.FunctionDef | ast.ClassDef)
        names = [n for n in ast.walk(statement) if isinstance(n, ast.Name | ast.Attribute)]
        own = {n.id for n in names if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        for node in names:
            if isinstance(node.ctx, ast.Load):
                name = node.id if isinstance(node, ast.Name) else node.attr
                if inside:
                    self.lines[name].add((file, node.lineno))
                else:
                    self.passed_on[name] |= own

    def of(self, names: Iterable[str]) -> set[tuple[str, int]]:
        seen, waiting = set(), list(names)
        while waiting:
            name = waiting.pop()
            if name not in seen:
                seen.add(name)
                waiting += self.passed_on[name]
        return {line for name in seen for line in self.lines[name]}


@cache
def names_in(file: str) -> frozenset[str]:
    """Names that a file of tests imports."""
    tree = ast.parse(Path(file).read_bytes())
    return frozenset(
        alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    )


def tests_of(mutant: Mutant, path: Path, executed: Executed, readers: Readers) -> list[str]:
    """Tests that execute the statement of a mutant, the fastest first.

    What defines a constant is executed by those that execute a line which reads it, and by those
    in a file that names it, or the class whose default it is.
    """
    first, last = mutant.lines
    lines = {(str(path), line) for line in range(first, last + 1)}
    if mutant.constants:
        lines = readers.of(mutant.constants)
    named = {*mutant.constants, mutant.function.partition(".")[0]} if mutant.constants else set()
    by_file: dict[str, set[int]] = defaultdict(set)
    for file, line in lines:
        by_file[file].add(line)
    found = [
        name
        for name, one in executed.items()
        if any(by_file[file].intersection(of) for file, of in one["lines"].items())
        or names_in(name.partition("::")[0]).intersection(named)
    ]
    return sorted(found, key=lambda name: (executed[name]["cpu"], name))


def file_of(module: str) -> Path:
    """File of a module, found without importing the packages that it lies in."""
    top, *parts = module.split(".")
    spec = importlib.util.find_spec(top)
    if spec is None or spec.origin is None:
        raise SystemExit(f"no module {module}")
    return (
        Path(spec.origin).parent.joinpath(*parts).with_suffix(".py") if parts else Path(spec.origin)
    )


def survivors(table: Path) -> set[tuple[str, ...]]:
    """Keys of the mutants that an earlier run did not catch."""
    with table.open(newline="") as file:
        return {
            (row["module"], row["function"], row["mutation"])
            for row in csv.DictReader(file)
            if not row["caught_by"]
        }


def default_tests(modules: Iterable[str]) -> list[str]:
    """Tests of the stages that some modules are of, their own, and all examples."""
    names = dict.fromkeys(module.removeprefix("pidpanel.") for module in modules)
    stages = dict.fromkeys(name.partition(".")[0] for name in names if "." in name)
    own = [f"tests/test_{name}.py" for name in names if "." not in name]
    found = [f"tests/{stage}" for stage in stages] + [path for path in own if Path(path).is_file()]
    return [*found, "tests/test_doctests.py"]


def main() -> int:
    parser = argparse.ArgumentParser(prog="python tests/mutation", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)  # fmt: skip
    parser.add_argument(
        "modules", nargs="*", help="such as pidpanel.damping.laws, or a stage; all left out"
    )
    parser.add_argument("--tests", nargs="+", help="folders of tests; those of the stages")
    parser.add_argument("--sample", type=int, help="mutants drawn from each module")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--again", type=Path, help="only what survived in this earlier table")
    parser.add_argument("--spare", type=float, default=5.0, help="seconds of CPU, see RUNS_AWAY")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--accepted", type=Path, default=Path(__file__).parent / "accepted.toml")
    parser.add_argument("--out", type=Path, default=Path("results/mutants.csv"))
    options = parser.parse_args()
    asked = options.modules or list(FORMULAS)
    modules = [
        ".".join(filter(None, ("pidpanel", stage, name)))
        for stage in FORMULAS
        for name in FORMULAS[stage].split()
        if stage in asked
    ] + [module for module in asked if module not in FORMULAS]
    tests = options.tests or default_tests(modules)
    paths = {module: file_of(module) for module in modules}
    source = Path(os.path.commonpath([path.parent for path in paths.values()]))
    if (source.parent / "__init__.py").is_file():
        source = source.parent
    known = read_accepted(options.accepted)
    every = {mutant.key for module, path in paths.items() for mutant in mutants_of(module, path)}
    orphans = [key for key in known if key[0] in paths and key not in every]
    orphans += [key for key in known if key[0] not in paths and not file_of(key[0]).is_file()]
    for orphan in orphans:
        print(f"{options.accepted.name} names what is no mutant: {': '.join(orphan)}")

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.environ["HYPOTHESIS_STORAGE_DIRECTORY"] = name
        executed: Executed = {}
        cpu = 0.0
        others: dict[str, None] = {}
        for path in tests:
            (folder / path.replace("/", "_")).mkdir()
        work = {
            path: partial(profile, source, folder / path.replace("/", "_"), path) for path in tests
        }
        for path, found, seconds in in_forks(work, folder, options.jobs):
            if found is None or found["code"]:
                raise SystemExit(f"tests in {path} fail without any mutant")
            executed |= found["executed"]
            others |= dict.fromkeys(found["others"])
            cpu += seconds
        print(f"{len(executed)} tests, {cpu:.0f} s of CPU", flush=True)
        for other in others:
            try:
                importlib.import_module(other)
            except Exception:  # what cannot be imported here is imported by who needs it
                continue

        gc.freeze()  # what was imported is no litter
        left = survivors(options.again) if options.again else None
        readers = Readers(sorted(source.rglob("*.py")))
        trials, results = {}, []
        for module, path in paths.items():
            every = [m for m in mutants_of(module, path) if left is None or m.key in left]
            if options.sample and options.sample < len(every):
                drawn = random.Random(f"{options.seed} {module}").sample(
                    range(len(every)), options.sample
                )
                every = [every[number] for number in sorted(drawn)]
            for number, mutant in enumerate(every):
                names = tests_of(mutant, path, executed, readers)
                if not names:
                    results.append((mutant, "", "no test executes it"))
                    continue
                limits = {n: options.spare + RUNS_AWAY * executed[n]["cpu"] for n in names}
                trials[mutant, number] = partial(try_mutant, mutant, path, limits, folder)
        for count, ((mutant, _), by, seconds) in enumerate(
            in_forks(trials, folder, options.jobs), start=1
        ):
            cpu += seconds
            by = "runs away" if by is None else by
            results.append((mutant, by, ""))
            if not by:
                print(f"{count}/{len(trials)} survives: {mutant.module} {mutant.function}: "
                      f"{mutant.change}", flush=True)  # fmt: skip
    print(f"{cpu:.0f} s of CPU")
    return int(report(results, known, options.out) or bool(orphans))


def read_accepted(path: Path) -> Known:
    """Survivors with their reasons, by the key of the mutant."""
    entries = tomllib.loads(path.read_text()).get("mutant", []) if path.is_file() else []
    return {(one["module"], one["function"], one["change"]): one for one in entries}


def report(results: list[tuple[Mutant, str, str]], known: Known, out: Path) -> int:
    """Write the table, print the scores, and return 0 where they suffice."""
    order = {
        module: number for number, module in enumerate(dict.fromkeys(m.module for m, *_ in results))
    }
    results.sort(key=lambda one: (order[one[0].module], one[0].lines, one[0].change))
    out.parent.mkdir(parents=True, exist_ok=True)
    total, caught, unexplained = Counter[str](), Counter[str](), []
    with out.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["module", "line", "function", "mutation", "caught_by", "reason"])
        for mutant, by, why in results:
            entry = known.get(mutant.key, {})
            table.writerow([mutant.module, mutant.lines[0], mutant.function, mutant.change, by,
                            "" if by else entry.get("reason", why)])  # fmt: skip
            if not by and not entry:
                unexplained.append((mutant, why))
            if by or not entry.get("equivalent", False):
                total[mutant.module] += 1
                caught[mutant.module] += bool(by)
    for mutant, why in unexplained:
        print(f"{mutant.module}:{mutant.lines[0]} {mutant.function}: {mutant.change}"
              + f" ({why})" * bool(why))  # fmt: skip
    for module in total:
        share = caught[module] / total[module]
        print(f"{module:40} {caught[module]:5} of {total[module]:5} caught  {share:7.1%}")
    share = sum(caught.values()) / max(1, sum(total.values()))
    print(f"{'all':40} {sum(caught.values()):5} of {sum(total.values()):5} caught  {share:7.1%}")
    print(f"{len(unexplained)} survive without a reason; all are in {out}")
    return int(share < REQUIRED or bool(unexplained))


if __name__ == "__main__":
    raise SystemExit(main())
