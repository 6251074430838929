"""Figures belong to no window: nothing in the report keeps the state of pyplot."""

import pkgutil
import subprocess
import sys

from pidpanel import report

MODULES = sorted(module.name for module in pkgutil.iter_modules(report.__path__))


def test_importing_the_report_imports_no_pyplot():
    names = ", ".join(f"pidpanel.report.{name}" for name in MODULES)
    code = f"import sys, {names}; print('matplotlib.pyplot' in sys.modules)"
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout == "False\n"
