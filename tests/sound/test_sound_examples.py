"""The examples in the docstrings hold."""

import doctest

import pytest

from pidpanel.sound import field, spectrum


@pytest.mark.parametrize("module", [field, spectrum], ids=lambda module: module.__name__)
def test_examples_in_docstrings_hold(module):
    # red: a changed figure in any example
    result = doctest.testmod(module)
    assert result.attempted > 0
    assert result.failed == 0
