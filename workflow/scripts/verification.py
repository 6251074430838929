"""The page of verification and its figures from the rows of all cases."""

import sys
from pathlib import Path

from pidpanel.report import html, style, verification
from pidpanel.verification import read_rows

if __name__ == "__main__":
    output, figures, *files = sys.argv[1:]
    rows = [row for file in files for row in read_rows(Path(file))]
    steps = [
        ("From the root of the project:", "make verification"),
        (
            "The rows behind this page lie in results/verification/<stage>/<case>.csv, one row a "
            "number, the figures in results/verification/figures/.",
            "",
        ),
    ]
    with style.context():
        page = verification.page(rows, steps)
    Path(figures).mkdir(exist_ok=True)
    for picture in page.pictures:
        (Path(figures) / f"{picture.name}.png").write_bytes(picture.png)
    Path(output).write_text(html.render(page), encoding="utf-8")
