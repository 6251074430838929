"""Identify restitution, friction and fill fraction of particles from a measured damper.

The file states the cell, the particles and what was measured: C_e and m_a or a loss factor over
tones, or force over acceleration in a universal file (docs/identify.md). LIGGGHTS is not run.
"""

import argparse


def call(args: argparse.Namespace) -> int:
    from pidpanel.identify.from_study import identify_file, write_tables
    from pidpanel.report.identify_page import answer_lines, write_identification

    result = identify_file(args.file)
    folder = args.directory / "results" / result.identification.name / "identify"
    for line in answer_lines(result):
        print(line)
    write_tables(result, args.file, folder)
    page = folder / "report.html"
    write_identification(result, page)
    print(page)
    return 0
