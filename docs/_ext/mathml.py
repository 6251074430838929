"""Formulas as MathML, which browsers draw themselves: no script, no font, no network."""

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging

LOGGER = logging.getLogger(__name__)


def _formula(node, **how):
    try:
        return tex2mathml(node.astext(), **how)
    except MathError as error:
        LOGGER.warning("%s: %s", error, node.astext(), location=node)
        return f"<code>{node.astext()}</code>"


def _inline(writer, node):
    writer.body.append(_formula(node))
    raise nodes.SkipNode


def _block(writer, node):
    writer.body.append(f'<div class="math">{_formula(node, as_block=True)}</div>')
    raise nodes.SkipNode


def setup(app):
    """Make it known to Sphinx."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
