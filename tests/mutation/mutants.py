"""Mutants: small errors put into the formulas of a module, one at a time.

Mutated are arithmetic (``+ − * / **``, signs, ``~`` and ``not``), comparisons and what joins them,
numbers, switches (``lower=True``) and functions (`SWAPPED`, `REMOVED`, ``.real``, ``.conj()``).
Left alone is what decides no number: text, annotations, decorators, checks (a ``raise`` and the
condition before it, ``assert``), shapes of new arrays, and guards against rounding (`ROUNDING`).
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

ROUNDING = 1e-7
"""Floats up to this size are guards against rounding: any other as small would do."""

OPERATORS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult, ast.BitAnd: ast.BitOr,
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt,
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
BOUNDARIES: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt,
}  # fmt: skip
"""Mutated where a whole number or a length is compared; between floats they decide nothing."""

_PAIRS = (("sin", "cos"), ("sinh", "cosh"), ("min", "max"), ("minimum", "maximum"),
          ("argmin", "argmax"), ("floor", "ceil"), ("any", "all"), ("real", "imag"))  # fmt: skip
SWAPPED = {a: b for pair in _PAIRS for a, b in (pair, pair[::-1])}
REMOVED = {"sqrt", "exp", "log", "log10", "abs", "conj"}
NEW_ARRAYS = {"zeros", "ones", "empty", "full", "reshape", "broadcast_to"}
UNTOUCHED_KEYWORDS = {"axis", "axis1", "axis2", "dtype", "strict", "optimize", "copy"}


@dataclass(frozen=True)
class Mutant:
    """One change of one module.

    Attributes
    ----------
    module, function
        Dotted name, and the function or class in it; empty at the level of the module.
    change
        Text before and after, ``a * b → a / b``.
    lines
        First and last line of the statement that holds it.
    constants
        Names that the statement defines, outside of functions.
    apply
        Changes the syntax tree in place.
    tree
        Of the module.
    """

    module: str
    function: str
    change: str
    lines: tuple[int, int]
    constants: tuple[str, ...]
    apply: Callable[[], None]
    tree: ast.Module

    @property
    def key(self) -> tuple[str, str, str]:
        """What names a mutant whatever line it is in."""
        return self.module, self.function, self.change


def mutants_of(module: str, path: Path) -> list[Mutant]:
    """All mutants of a module, in the order of its text."""
    tree = ast.parse(path.read_bytes(), str(path))
    return list(_Walk(module, tree).block(tree.body))


class _Walk:
    """Goes through the statements of one module and tells where in it they are."""

    def __init__(self, module: str, tree: ast.Module) -> None:
        self.module, self.tree = module, tree
        self.function: list[str] = []
        self.lines = (1, 1)
        self.constants: tuple[str, ...] = ()
        self.inside = False

    def block(self, body: list[ast.stmt]) -> Iterator[Mutant]:
        for statement in body:
            if isinstance(statement, ast.FunctionDef | ast.ClassDef):
                yield from self._definition(statement)
            elif isinstance(statement, ast.Raise | ast.Assert | ast.Import | ast.ImportFrom):
                continue
            elif isinstance(statement, ast.If) and isinstance(statement.body[-1], ast.Raise):
                yield from self.block(statement.orelse)
            else:
                yield from self._statement(statement)

    def _definition(self, node: ast.FunctionDef | ast.ClassDef) -> Iterator[Mutant]:
        outer = self.inside
        self.function.append(node.name)
        if isinstance(node, ast.FunctionDef):
            self.inside = True
            self.lines = (node.body[0].lineno, node.body[-1].end_lineno or node.lineno)
            yield from self._expressions(node.args)
        yield from self.block(node.body)
        self.function.pop()
        self.inside = outer

    def _statement(self, node: ast.stmt) -> Iterator[Mutant]:
        blocks = [getattr(node, name, []) for name in ("body", "orelse", "finalbody")]
        end = blocks[0][0].lineno - 1 if blocks[0] else node.end_lineno
        self.lines = (node.lineno, max(node.lineno, end or 0))
        if not self.inside:
            targets = getattr(node, "targets", [getattr(node, "target", None)])
            self.constants = tuple(
                name.id for t in targets if t for name in ast.walk(t) if isinstance(name, ast.Name)
            )
        if isinstance(node, ast.AugAssign) and type(node.op) in OPERATORS:
            yield self._swap(node, node, "op", OPERATORS[type(node.op)]())
        yield from self._expressions(node)
        for body in blocks:
            yield from self.block(body)
        for handler in getattr(node, "handlers", []):
            yield from self.block(handler.body)
        self.constants = ()

    def _expressions(self, node: ast.AST) -> Iterator[Mutant]:
        """Mutants of the expressions right below a statement or an expression."""
        for field, value in ast.iter_fields(node):
            if field in ("annotation", "returns", "decorator_list", "body", "orelse", "finalbody"):
                if not isinstance(value, ast.expr) or field == "annotation":  # but a if b else c
                    continue
            for place, child in enumerate(value) if isinstance(value, list) else [(None, value)]:
                if isinstance(child, ast.expr | ast.comprehension | ast.withitem | ast.keyword):
                    yield from self._expression(node, field, place, child)

    def _expression(
        self, parent: ast.AST, field: str, place: int | None, node: ast.AST
    ) -> Iterator[Mutant]:
        if isinstance(node, ast.JoinedStr):
            return
        if isinstance(node, ast.keyword) and node.arg in UNTOUCHED_KEYWORDS:
            return
        if isinstance(parent, ast.Call) and field == "args" and _name(parent.func) in NEW_ARRAYS:
            if place == 0 or _name(parent.func) in ("reshape", "broadcast_to"):
                return

        def instead(new: ast.expr, shown: ast.AST = node) -> Mutant:
            return self._swap(shown, parent, field, new, place)

        match node:
            case ast.BinOp(left, op, right) if not (_is_text(left) or _is_text(right)):
                if type(op) in OPERATORS:
                    yield self._swap(node, node, "op", OPERATORS[type(op)]())
            case ast.BoolOp(op=joint):
                yield self._swap(node, node, "op", OPERATORS[type(joint)]())
            case ast.Compare(left, ops, comparators):
                sides = [left, *comparators]
                for index, kind in enumerate(type(relation) for relation in ops):
                    if kind not in OPERATORS or any(_is_text(side) for side in sides):
                        continue
                    yield self._swap(node, node, "ops", OPERATORS[kind](), index)
                    if kind in BOUNDARIES and any(_is_whole(side) for side in sides):
                        yield self._swap(node, node, "ops", BOUNDARIES[kind](), index)
            case ast.UnaryOp(op=ast.USub() | ast.Invert() | ast.Not(), operand=operand):
                yield instead(operand, parent if isinstance(parent, ast.expr) else node)
            case ast.Constant(value=value) if not isinstance(value, str | bytes | None):
                new = _other_value(value, isinstance(parent, ast.keyword))
                if new is not None:
                    yield instead(ast.Constant(new), parent)
            case ast.Attribute(value=value, attr=attr) if field != "func":
                if attr in ("real", "imag"):
                    yield instead(ast.Attribute(value, SWAPPED[attr], ast.Load()))
            case ast.Call(func=ast.Name(id=name), args=args, keywords=keywords):
                if name in SWAPPED:
                    yield instead(ast.Call(ast.Name(SWAPPED[name], ast.Load()), args, keywords))
                elif name in REMOVED and args:
                    yield instead(args[0])
            case ast.Call(func=ast.Attribute(value, name), args=args, keywords=keywords):
                if name in SWAPPED:
                    other = ast.Attribute(value, SWAPPED[name], ast.Load())
                    yield instead(ast.Call(other, args, keywords))
                elif name in REMOVED:
                    yield instead(args[0] if args else value)
        yield from self._expressions(node)

    def _swap(
        self, shown: ast.AST, parent: ast.AST, field: str, new: ast.AST, place: int | None = None
    ) -> Mutant:
        """The mutant that has ``new`` in a field of ``parent``; ``shown`` is what it tells of."""

        def put(value: ast.AST) -> ast.AST:
            if place is None:
                old = getattr(parent, field)
                setattr(parent, field, value)
            else:
                old = getattr(parent, field)[place]
                getattr(parent, field)[place] = value
            return old

        before = _parts(shown)
        old = put(new)
        after = _parts(new if shown is old else shown)
        put(old)
        if isinstance(shown, ast.arguments):  # the one default that differs
            changed = [pair for pair in zip(before, after, strict=True) if pair[0] != pair[1]]
            before, after = zip(*changed, strict=True)

        def apply() -> None:
            put(new)
            ast.fix_missing_locations(self.tree)

        return Mutant(self.module, ".".join(self.function), f"{before[0]} → {after[0]}", self.lines,
                      () if self.inside else self.constants, apply, self.tree)  # fmt: skip


def _parts(node: ast.AST) -> Sequence[str]:
    """Text of a node, or of each parameter with a default."""
    if not isinstance(node, ast.arguments):
        return [ast.unparse(node)]
    given = [*zip(node.args[::-1], node.defaults[::-1], strict=False)]
    given += [(a, d) for a, d in zip(node.kwonlyargs, node.kw_defaults, strict=True) if d]
    return [f"{parameter.arg}={ast.unparse(default)}" for parameter, default in given]


def _name(func: ast.expr) -> str:
    return getattr(func, "attr", "") or getattr(func, "id", "")


def _is_text(node: ast.expr) -> bool:
    """Whether an operand is text or a list, which ``+`` joins."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, str)
    if isinstance(node, ast.BinOp):
        return _is_text(node.left) or _is_text(node.right)
    return isinstance(node, ast.JoinedStr | ast.List | ast.Tuple | ast.ListComp)


def _is_whole(node: ast.expr) -> bool:
    if isinstance(node, ast.Constant):
        return type(node.value) is int and node.value != 0
    return isinstance(node, ast.Call) and _name(node.func) == "len"


def _other_value(value: object, is_keyword: bool) -> complex | None:
    if isinstance(value, bool):
        return not value if is_keyword else None
    if isinstance(value, complex):
        return -value
    if isinstance(value, int):
        return value + 1
    if isinstance(value, float) and abs(value) > ROUNDING:
        return float(f"{value * 1.1:.6g}")
    return 1.0 if value == 0 else None
