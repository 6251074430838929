"""Puts Snakefile, workflow, templates and profiles into the package that a wheel installs."""

from pathlib import Path
from shutil import copytree, ignore_patterns

from setuptools import setup
from setuptools.command.build_py import build_py

FOLDERS = ("workflow", "templates", "profiles")
"""As they are in the checkout, beside the Snakefile; `pidpanel.paths.PROJECT` finds them."""


class WithProject(build_py):
    """Copies them to ``pidpanel/project``; an editable package finds them in the checkout."""

    def run(self) -> None:
        """Copy what setuptools knows of, and the project."""
        super().run()
        if self.editable_mode:
            return
        project = Path(self.build_lib) / "pidpanel" / "project"
        for name in FOLDERS:
            ignored = ignore_patterns("__pycache__", ".snakemake")
            copytree(name, project / name, ignore=ignored, dirs_exist_ok=True)
        self.copy_file("Snakefile", str(project / "Snakefile"))


setup(cmdclass={"build_py": WithProject})
