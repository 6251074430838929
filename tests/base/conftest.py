"""Panels on moving supports."""

import pytest
from moving import POINT_MASS, panel_of

from pidpanel.panel.attachments import Attachment


@pytest.fixture(scope="session")
def panel(tmp_path_factory):
    return panel_of(tmp_path_factory.mktemp("base"))


@pytest.fixture(scope="session")
def loaded_panel(tmp_path_factory):
    """The same with a mass between the nodes of its mesh."""
    return panel_of(tmp_path_factory.mktemp("base"), [Attachment([(0.33, 0.77)], POINT_MASS)])
