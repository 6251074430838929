"""The documents, built once as `make docs` builds them."""

import subprocess
import sys

import pytest
from reference_pages import DOCS


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """Folder of the pages, and what the build said."""
    folder = tmp_path_factory.mktemp("pages")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html"]
    done = subprocess.run(
        [*command, "-d", folder / "trees", DOCS, folder / "html"],
        capture_output=True,
        text=True,
        check=False,
    )
    return folder / "html", done
