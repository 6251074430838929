"""The examples in the docstrings hold."""

import doctest

import pytest

from pidpanel.response import linearisation, lines


@pytest.mark.parametrize("module", [linearisation, lines], ids=lambda module: module.__name__)
def test_examples_in_docstrings_hold(module):
    # red: a changed figure in any example
    result = doctest.testmod(module)
    assert result.attempted > 0
    assert result.failed == 0
