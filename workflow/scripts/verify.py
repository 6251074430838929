"""Hold one case of a stage to its truth: its rows as CSV."""

import importlib
import sys
import tempfile
from pathlib import Path

from pidpanel.verification import write_rows

if __name__ == "__main__":
    stage, case, output = sys.argv[1:]
    cases = importlib.import_module(f"pidpanel.{stage}.verification").CASES
    with tempfile.TemporaryDirectory() as folder:
        write_rows(Path(output), cases[case](Path(folder)))
