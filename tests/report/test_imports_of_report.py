"""Figures belong to no window: nothing in the report keeps the state of pyplot."""

import ast
import pkgutil
import subprocess
import sys

from pidpanel import report

MODULES = sorted(module.name for module in pkgutil.iter_modules(report.__path__))


def test_no_module_names_pyplot():
    # red: `import matplotlib.pyplot` in any function of any module
    for name in MODULES:
        (path,) = (f"{folder}/{name}.py" for folder in report.__path__)
        with open(path, encoding="utf-8") as file:
            nodes = list(ast.walk(ast.parse(file.read())))
        imported = [alias.name for n in nodes if isinstance(n, ast.Import) for alias in n.names]
        imported += [
            f"{n.module}.{alias.name}"
            for n in nodes
            if isinstance(n, ast.ImportFrom)
            for alias in n.names
        ]
        assert not [one for one in imported if "pyplot" in one or "pylab" in one], name


def test_importing_the_report_imports_no_pyplot():
    # red: `import matplotlib.pyplot` at the head of any module
    names = ", ".join(f"pidpanel.report.{name}" for name in MODULES)
    code = f"import sys, {names}; print('matplotlib.pyplot' in sys.modules)"
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout == "False\n"
