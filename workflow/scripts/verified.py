"""Fail where a number misses its truth; else say how many are held."""

import sys
from pathlib import Path

from pidpanel.verification import read_rows

if __name__ == "__main__":
    output, *files = sys.argv[1:]
    held = [row for file in files for row in read_rows(Path(file)) if row.held]
    missed = [row for row in held if not row.met]
    for row in missed:
        print(
            f"{row.case}, {row.quantity}: {row.computed:g} {row.unit} against {row.reference:g}, "
            f"{row.error:+.2%}, allowed {row.tolerance:.2%}",
            file=sys.stderr,
        )
    if missed:
        sys.exit(f"{len(missed)} of {len(held)} numbers miss their truth")
    Path(output).write_text(f"{len(held)} of {len(held)} numbers within their tolerance\n")
