"""Sentences of the documents are short; code, tables, headings and equations are left out."""

import re

from reference_pages import DOCS

from pidpanel.paths import PROJECT

PAGES = sorted(
    [
        PROJECT / "README.md",
        PROJECT / "CONTRIBUTING.md",
        PROJECT / "CHANGELOG.md",
        *DOCS.rglob("*.md"),
    ]
)
END = re.compile(
    r"(?<!Eq\.)(?<!Fig\.)(?<!al\.)(?<=[.?!])[*)\]\"]*\s+(?=\W*(?:[^\Wa-z]|\w\b)|symbol)"
)
"""A full stop before a capital, a number or a variable."""


def sentences(text):
    """Prose of a Markdown text, sentence by sentence."""
    text = re.sub(
        r"<!--.*?-->|^```.*?^```|\$\$.*?\$\$", "\n\n", text, flags=re.DOTALL | re.MULTILINE
    )
    text = re.sub(r"\]\([^)]*\)", "]", text)
    text = re.sub(r"`[^`\n]*`|\$[^$\n]*\$", "symbol", text)
    text = re.sub(r"^\s*(?:[-*] |\d+\. |> )", "\n\n", text, flags=re.MULTILINE)
    for paragraph in re.split(r"\n\s*\n", text):
        if not paragraph.lstrip().startswith(("#", "|", "!")):
            yield from re.split(END, paragraph.strip())


def lengths(text):
    """Words of each sentence."""
    counts = [len(re.findall(r"[^\W_][\w'’.,/·−–-]*", part)) for part in sentences(text)]
    return [count for count in counts if count]


def test_sentences_have_17_words_in_the_mean_and_few_have_more_than_40():
    counts = [count for page in PAGES for count in lengths(page.read_text(encoding="utf-8"))]
    assert len(counts) > 500
    assert sum(counts) <= 17 * len(counts)
    assert sum(count > 40 for count in counts) <= 0.02 * len(counts)
