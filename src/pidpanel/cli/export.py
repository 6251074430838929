"""Write the files for other programs.

The files are CSV with units, third octaves, Nastran tables and dampers, and UFF 58. They are in
results/<study>/response/export; --to copies them to another folder. --figures writes the figures of
the report as PNG, SVG or PDF to results/<study>/figures, or to that folder.
"""

import argparse
from pathlib import Path


def call(args: argparse.Namespace) -> int:
    import shutil

    from pidpanel.cli.results import make
    from pidpanel.study import load_study

    study = load_study(args.study)
    _ = study.acoustics  # of a shaker alone nothing is exported
    folder = make(study, args, "response/export", "export")
    if args.to is not None:
        args.to.mkdir(parents=True, exist_ok=True)
        ours = shutil.ignore_patterns(".*")  # Snakemake's time stamp
        folder = Path(shutil.copytree(folder, args.to, dirs_exist_ok=True, ignore=ours))
    if args.figures:
        from pidpanel.report.from_study import page_of
        from pidpanel.report.html import write_figures

        results = make(study, args, "report.html", "report").parent
        figures = args.to or results / "figures"
        write_figures(page_of(study, args.study, results), args.figures, figures)
        print(figures)
    for path in sorted(folder.glob("[!.]*")):
        print(path)
    return 0
