"""The commands of ``pidpanel``, in the order of use.

None imports a study or numpy before it is called, so that help and completion come at once.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

import click

from pidpanel.cli.new import new
from pidpanel.cli.options import (
    FILE,
    FOLDER,
    Commands,
    directory,
    force,
    jobs,
    print_next,
    study_argument,
)

EPILOG = """\
Results are in the folder results of the working folder, or of --directory. Paths in a study are
relative to the folder of the study. The name of a study that comes with pidpanel, such as
l_panel.yaml, also works, unless the working folder has a file of this name.

Exit codes:
  0    done; status: nothing is left
  1    a run failed or is incomplete; status: something failed or is left
  2    mistakes in the command, the study or one of its files, one per line
  3    the machine: LIGGGHTS is not installed, the disk is full, a folder is not writable
  130  stopped by Ctrl-C; the same command resumes"""


SETTINGS = {"max_content_width": 100, "help_option_names": ["-h", "--help"]}


@click.group(cls=Commands, no_args_is_help=False, epilog=EPILOG, context_settings=SETTINGS)
@click.version_option(package_name="pidpanel", message="%(prog)s %(version)s")
@click.pass_context
def pidpanel(context: click.Context) -> None:
    """From a study file to the acceleration PSDs of a panel with particle dampers.

    pidpanel new wing.yaml           write a commented study, then edit it
    pidpanel check wing.yaml         report mistakes, masses, natural frequencies, levels, time
    pidpanel run wing.yaml           compute it and write results/wing/report.html
    pidpanel status wing.yaml        show what is done, failed and left
    """
    if context.obj and context.invoked_subcommand != "run":
        raise click.UsageError("options after -- are for Snakemake and only allowed with run")


pidpanel.add_command(new)


@pidpanel.command()
@study_argument
@directory
def check(file: Path, directory: Path) -> None:
    """Check a study and print what it would run.

    Mistakes are reported one per line. The time is that of the LIGGGHTS runs that are not yet
    there, on a core of 2.5 GHz.
    """
    from pidpanel.check import checked_study
    from pidpanel.cli.study_overview import overview

    print(overview(checked_study(file), directory / "results"))
    print_next(file, directory, "run")


@pidpanel.command()
@study_argument
@jobs
@directory
@click.option("-n", "--dry-run", is_flag=True, help="print what would run, without running it")
@click.pass_obj
def run(options: Sequence[str], file: Path, jobs: int, directory: Path, dry_run: bool) -> int:
    """Run a study up to its report.

    Only changed results are computed again. Snakemake runs the study. A study without LIGGGHTS runs
    in this process, in seconds, unless options follow.

    A stopped run resumes with the same command. Options after `--` go to Snakemake, such as
    `-- --workflow-profile profiles/slurm`.
    """
    dry = ["--dry-run"] if dry_run else []
    status = run_study(file, directory, jobs, [*dry, *(options or ())])
    if status == 0 and not dry_run:
        print_next(file, directory, "report --open")
    return status


def run_study(file: Path, directory: Path, jobs: int, options: Sequence[str] = ()) -> int:
    """Run a study and print the path of its report; return the exit code."""
    from pidpanel.cli.snakemake import MachineError, check_memory, check_space, run_workflow

    check_memory()  # before what takes it is imported
    os.environ["OMP_NUM_THREADS"] = "1"
    # pages that numpy has freed are slow to come again
    os.environ["NUMPY_MADVISE_HUGEPAGE"] = "0"
    from pidpanel.check import check_machine, checked_study
    from pidpanel.study import Study, StudyError
    from pidpanel.workflow.in_process import compute, is_alone, is_up_to_date

    study, is_dry = checked_study(file), "--dry-run" in options[:1]
    folder, results = directory.absolute(), directory / "results"
    folder.mkdir(parents=True, exist_ok=True)
    if not is_dry:
        try:
            check_machine(study, results)
        except StudyError as error:
            raise MachineError(str(error)) from None
        if results.is_symlink():
            print(f"{results}: is a link; results go to {results.resolve()}", file=sys.stderr)
        check_space(results)
    status = 0
    if options or not is_alone(study):
        status = run_workflow(file, folder, jobs, options)
    elif is_up_to_date(study, folder):
        print("Nothing to be done: all files are present and up to date.", file=sys.stderr)
    else:
        compute(study, file.resolve(), folder, jobs)
    page = results / study.name / "report.html"
    if not (status or is_dry) and page.exists():
        if isinstance(study, Study) and study.limits:
            from pidpanel.report.inputs import read_by_point
            from pidpanel.report.margins_section import margin_lines

            margins = read_by_point(results / study.name / "severity" / "margins.csv")
            print(*margin_lines(study, margins), sep="\n")
        if isinstance(study, Study) and study.uncertain:
            from pidpanel.report.from_study import spread_of
            from pidpanel.report.margin_section import margin_headline
            from pidpanel.report.names import names_of

            print(margin_headline(spread_of(study, results / study.name), names_of(study)))
        print(page.absolute())
    return status


@pidpanel.command()
@study_argument
@jobs
@directory
@click.option("--write", metavar="FILE", type=FILE, help="study of the best layouts to write")
@force
def optimise(file: Path, jobs: int, directory: Path, write: Path | None, force: bool) -> int:
    """Propose layouts of dampers within a mass budget.

    The section `optimise` of the study states the budget and the options. The report is
    regenerated. `--write` writes a study of the best layouts. It computes their maps and stresses,
    and coupled runs of simulated particles.
    """
    from pidpanel.check import checked_study
    from pidpanel.cli.layouts import check_target, write_study
    from pidpanel.study import Study, StudyError

    study = checked_study(file)
    if not isinstance(study, Study) or study.optimise is None:
        raise StudyError(f"{file}: optimise: missing; the section has the mass budget")
    if write is not None:
        check_target(write, file, force=force)
    status = run_study(file, directory, jobs)
    if status == 0 and write is not None:
        write_study(file, directory / "results" / study.name / "optimise" / "layouts.csv", write)
        print(f"{write}: written")
        print_next(write, directory, "check")
    elif status == 0:
        print_next(file, directory, "optimise --write best.yaml")
    return status


@pidpanel.command()
@click.argument("file", type=FILE, help="YAML file of the measurement")
@directory
def identify(file: Path, directory: Path) -> None:
    """Identify particles from a measured damper.

    Restitution, friction and fill fraction are identified. The file states the cell, the particles
    and what was measured: C_e and m_a or a loss factor over tones, or force over acceleration in a
    universal file (docs/identify.md). LIGGGHTS is not run.
    """
    from pidpanel.identify.from_study import identify_file, write_tables
    from pidpanel.report.identify_page import answer_lines, write_identification

    result = identify_file(file)
    folder = directory / "results" / result.identification.name / "identify"
    print(*answer_lines(result), sep="\n")
    write_tables(result, file, folder)
    write_identification(result, folder / "report.html")
    print(folder / "report.html", folder / "identified.yaml", sep="\n")


@pidpanel.command()
@study_argument
@directory
def status(file: Path, directory: Path) -> int:
    """Show what is done, failed and left.

    It also works while the study runs, from any shell.
    """
    from pidpanel.cli import progress
    from pidpanel.cli.snakemake import is_running, jobs_left
    from pidpanel.study import load_any_study
    from pidpanel.workflow.in_process import is_alone, is_up_to_date

    study, results = load_any_study(file), directory / "results"
    if not results.is_dir():
        print(f"{study.name}: nothing is done; {results.absolute()} does not exist")
        return 1
    is_done = is_alone(study) and is_up_to_date(study, directory.absolute())
    left = {} if is_done else jobs_left(file, directory)
    runs = is_running(directory)
    failed = [] if runs else progress.failed(directory, study.name, left)
    state = "running" if runs else "complete" if not left else "not complete"
    lines = [f"{study.name}: {state}; {(results / study.name).absolute()}"]
    if cases := progress.case_line(study, results / "coupon"):
        lines.append(f"cases: {cases}")
    print(*lines, *progress.stages(study, left), *failed, sep="\n")
    if not runs:
        print_next(file, directory, "run" if left else "report --open")
    return 1 if left or failed else 0


@pidpanel.command()
@study_argument
@directory
@click.option("--again", "force", is_flag=True, help="regenerate it even if it is up to date")
@click.option("--open", "is_opened", is_flag=True, help="open it in the browser")
def report(file: Path, directory: Path, force: bool, is_opened: bool) -> None:
    """Regenerate the report of a study, and open it.

    Its path is printed.
    """
    from pidpanel.cli.results import make
    from pidpanel.study import Study, load_any_study

    study = load_any_study(file)
    rule = "report" if isinstance(study, Study) else "coupon_report"
    page = make(study, file, directory, "report.html", rule, force=force).absolute()
    print(page)
    if is_opened:
        click.launch(page.as_uri())
    else:
        print_next(file, directory, "report --open")


@pidpanel.command()
@click.argument("first", metavar="A", type=FILE, help="a study or the folder of its results")
@click.argument("second", metavar="B", type=FILE, help="another")
@directory
@click.option("--page", metavar="FILE", type=FILE, help="HTML page to write")
def compare(first: Path, second: Path, directory: Path, page: Path | None) -> None:
    """Compare two studies: tables, PSDs and maps side by side.

    Points and scenarios are those that both have. Differences larger than twice their standard
    error are listed. The page has tables, PSDs and maps. The arguments are studies or folders of
    results, results/<study>.
    """
    from pidpanel.cli.results import side_of
    from pidpanel.report.comparison import comparison_lines, write_comparison

    left, right = (side_of(name, directory / "results") for name in (first, second))
    if left.name == right.name:  # the same study in two folders
        left, right = left._replace(name=str(first)), right._replace(name=str(second))
    print(*comparison_lines(left, right), sep="\n")
    if page is not None:
        write_comparison(left, right, page)
        print(page.absolute())


FORMATS = click.Choice(["png", "svg", "pdf"])


@pidpanel.command()
@study_argument
@directory
@click.option("--to", metavar="FOLDER", type=FOLDER, help="folder to copy them to")
@click.option("--figures", type=FORMATS, metavar="FORMAT...", multiple=True,
              help="write the figures of the report too, as png, svg or pdf")  # fmt: skip
@click.argument("formats", metavar="", type=FORMATS, nargs=-1)
def export(
    file: Path, directory: Path, to: Path | None, figures: tuple[str, ...], formats: tuple[str, ...]
) -> None:
    """Write the files for other programs, such as Nastran tables.

    The files are CSV with units, third octaves, Nastran tables and dampers, and UFF 58. They are in
    results/<study>/response/export, those of random base motion in base/export; --to copies them
    to another folder. --figures writes the figures of the report as PNG, SVG or PDF to
    results/<study>/figures, or to that folder.
    """
    import shutil

    from pidpanel.cli.results import make
    from pidpanel.study import Study, StudyError, load_study

    if formats and not figures:
        raise click.UsageError(f"unexpected argument {formats[0]}")
    study = load_study(file)
    if not isinstance(study, Study) or not (study.sound or (study.base and study.base.random)):
        raise StudyError(f"{study.name}: only sound and base.random have files to export")
    stages = {"response": "export"} if study.sound else {}
    stages |= {"base": "base_export"} if study.base and study.base.random else {}
    folders = [
        make(study, file, directory, f"{stage}/export", rule) for stage, rule in stages.items()
    ]
    if to is not None:
        ours = shutil.ignore_patterns(".*")  # Snakemake's time stamp
        targets = [to] if len(folders) == 1 else [to / stage for stage in stages]
        for folder, target in zip(folders, targets, strict=True):
            shutil.copytree(folder, target, dirs_exist_ok=True, ignore=ours)
        folders = targets
    if figures:
        from pidpanel.report.from_study import page_of
        from pidpanel.report.html import write_figures

        results = make(study, file, directory, "report.html", "report").parent
        target = to or results / "figures"
        write_figures(page_of(study, file, results), [*figures, *formats], target)
        print(target)
    print(*(path for folder in folders for path in sorted(folder.glob("[!.]*"))), sep="\n")


@pidpanel.command()
@study_argument
@click.argument("case", required=False, help="label of the case, or its beginning")
@click.option("--seed", type=int, default=1, help="seed of the packing (default: 1)")
def deck(file: Path, case: str | None, seed: int) -> None:
    """Print the LIGGGHTS deck of a case, or list the cases.

    A case is given by its label, as in results/coupon; without a label, all cases are listed with
    their fill fraction, frequency and acceleration.
    """
    from pidpanel.check import checked_study
    from pidpanel.coupon.from_study import distinct_cases
    from pidpanel.study import StudyError

    study = checked_study(file)
    cases = distinct_cases(study)
    if not cases:
        raise StudyError(f"{file}: runs no LIGGGHTS, because no coupon is simulated")
    if case is None:
        for label, listed in cases.items():
            point = listed.point
            drive = f"{point.drive.frequency:g} Hz, {point.drive.gamma:.4g} g"
            print(f"{label}\tr = {point.fill_fraction:g}, {drive}")
        return
    labels = [case] if case in cases else [label for label in cases if label.startswith(case)]
    if len(labels) != 1:
        count = f"{len(labels)} cases" if labels else "no case"
        raise StudyError(f"{case}: {count} with this label; omit the label to list the cases")
    runs = {run.packing.seed: run for run in cases[labels[0]].with_reserve.runs}
    if seed not in runs:
        seeds = ", ".join(map(str, runs))
        raise StudyError(f"--seed {seed}: must be one of {seeds} for {labels[0]}")
    print(runs[seed].deck_text(), end="")


@pidpanel.command()
def schema() -> None:
    """Print the JSON schema of a study.

    Editors complete and check YAML with it (draft 2020-12).
    """
    from pidpanel.study.json_schema import schema_text

    print(schema_text(), end="")


@pidpanel.command()
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]), help="the shell")
def completion(shell: str) -> None:
    """Print a script for completion in bash, zsh or fish.

    It completes commands, options and files. In ~/.bashrc: eval "$(pidpanel completion bash)". In
    ~/.zshrc: eval "$(pidpanel completion zsh)". In ~/.config/fish/config.fish:
    pidpanel completion fish | source
    """
    from click.shell_completion import get_completion_class

    complete = get_completion_class(shell)
    if complete is not None:
        print(complete(pidpanel, {}, "pidpanel", VARIABLE).source())


VARIABLE = "_PIDPANEL_COMPLETE"  # with which the script of a shell asks for completions


@pidpanel.command(hidden=True, context_settings={"ignore_unknown_options": True})
@click.argument("arguments", nargs=-1)
def estimate(arguments: tuple[str, ...]) -> None:
    """Say what took the place of this command."""
    raise click.UsageError("estimate was removed: check prints the time of the LIGGGHTS runs")
