"""Names are nouns of the field: pronouns, prepositions and participles are rare, classes unique."""

import ast
from collections import Counter
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "src" / "pidpanel"
DONE = sorted(
    path.name
    for path in PACKAGE.iterdir()
    if path.suffix in ("", ".py") and not path.name.startswith("__")
)
ODD = frozenset(
    """one own found of at on under beyond alone few held told said asked taught solved widened
    agreeing beside rests made left_out seen wanted anew others other both each every with_ without_
    what which who whose then now here there nothing none_ something somewhere known given taken
    kept shown meant much many more most less least like so as by from_ into off over above below
    after before between within again still only also too already apart together alike along away
    none rest says some whole""".split()
)
SHARE = 0.01


def is_odd(name):
    return name in ODD or name.startswith("of_")


def bound_names(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name.strip("_").removeprefix("of_")  # `Patches.of_panel` makes one
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id


def odd_share(trees):
    names = [name.strip("_").lower() for tree in trees for name in bound_names(tree)]
    names = [name for name in names if name not in ("self", "cls")]
    odd = Counter(name for name in names if is_odd(name))
    return odd.total() / len(names), odd


def repeated_classes(trees):
    classes = (node.name for tree in trees for node in tree.body if isinstance(node, ast.ClassDef))
    return sorted(name for name, count in Counter(classes).items() if count > 1)


def parsed(*places):
    files = (file for place in places for file in sorted([place, *place.rglob("*.py")]))
    return [ast.parse(file.read_text()) for file in files if file.suffix == ".py"]


def test_names_are_nouns_of_the_field():
    for place in DONE:
        share, odd = odd_share(parsed(PACKAGE / place))
        assert share <= SHARE, (place, odd.most_common(9))


def test_no_class_name_occurs_twice():
    assert repeated_classes(parsed(*(PACKAGE / place for place in DONE))) == []
