"""Puts Snakefile, workflow, templates and profiles into the package that a wheel installs.

A release sets ``PIDPANEL_URL`` to the address of its repository and tag, such as
``https://host/owner/pidpanel/blob/v0.1.0``: links and figures of the README then work elsewhere.
"""

import os
import re
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


def readme(url: str) -> str:
    """Return the README, with its relative links below an address if there is one."""
    text = Path(__file__).with_name("README.md").read_text(encoding="utf-8")
    if not url:
        return text
    # the page of a picture is no picture
    raw = url.rstrip("/").replace("/blob/", "/raw/")
    text = re.sub(r"(!\[[^\]]*\]\()(?!https?:)", rf"\1{raw}/", text)
    return re.sub(r"\]\((?!https?:|#)", f"]({url.rstrip('/')}/", text)


URL = os.environ.get("PIDPANEL_URL", "")
setup(
    cmdclass={"build_py": WithProject},
    long_description=readme(URL),
    long_description_content_type="text/markdown",
    project_urls={"Source": URL.split("/blob/")[0], "Documentation": URL} if URL else {},
)
