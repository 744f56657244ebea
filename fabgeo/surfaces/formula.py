"""Design surfaces given by formulas x(u, v), y(u, v), z(u, v).

Formulas are read by Python's own parser, but nothing of Python is executed: only numbers, the
names u, v and earlier definitions, + - * / **, and the functions of `jets.FUNCTIONS` are allowed.
"""

from __future__ import annotations

import ast
import difflib
from collections.abc import Mapping, Sequence

import numpy as np

from fabgeo.arrays import FARTHEST, Array, checked_flag, checked_number, frozen
from fabgeo.errors import InputError
from fabgeo.surfaces.chart import Derivatives
from fabgeo.surfaces.jets import CONSTANTS, FUNCTIONS, Jet, Value, constant_like, variables
from fabgeo.surfaces.parametric import ParametricSurface
from fabgeo.surfaces.poles import pole_of

LONGEST = 4000
DEEPEST = 60
MOST_DEFINITIONS = 200
FINEST = 1e-9  # of a parameter: how much it must change over the domain
CURE = "change the formula or shrink the domain"


class Formula:
    """One expression, checked on construction and evaluated over jets.

    Parameters
    ----------
    name : str
        What it defines, for messages.
    text : str
        The expression.
    known : sequence of str
        Names that may occur besides functions and constants.

    Raises
    ------
    InputError
        If the text is no expression, too long, too deep, or uses a name that is not known.
    """

    def __init__(self, name: str, text: str, known: Sequence[str]) -> None:
        self.name = name
        self.text = str(text).strip()
        self._tree = self._parse()
        self._check(self._tree, set(known), 0)

    def __getstate__(self) -> dict[str, object]:
        return {"name": self.name, "text": self.text}

    def __setstate__(self, state: dict[str, str]) -> None:
        self.name, self.text = state["name"], state["text"]
        self._tree = self._parse()

    def _parse(self) -> ast.expr:
        where = f"formula {self.name}"
        if len(self.text) > LONGEST:
            raise InputError(
                where, f"is longer than {LONGEST} characters", "split it into definitions"
            )
        depth = deepest = 0
        for character in self.text:
            depth += (character in "([{") - (character in ")]}")
            deepest = max(deepest, depth)
        if deepest > DEEPEST:
            raise InputError(where, f"is nested deeper than {DEEPEST}", "split it into definitions")
        try:
            return ast.parse(" ".join(self.text.split()), mode="eval").body
        except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
            at = getattr(error, "offset", None)
            place = f" near character {at}" if at else ""
            raise InputError(
                where,
                f"is not an expression{place}: {self.text[:80]!r}",
                "write numbers, names, + - * / ** and functions, such as 2 * sin(u) ** 2",
            ) from error

    def _check(self, node: ast.expr, known: set[str], depth: int) -> None:
        where = f"formula {self.name}"
        if depth > 4 * DEEPEST:
            raise InputError(
                where, f"is nested deeper than {4 * DEEPEST}", "split it into definitions"
            )
        match node:
            case ast.Constant(value=bool() | str() | bytes() | complex() | None):
                raise InputError(where, f"expected a number, found {node.value!r}")
            case ast.Constant(value=int() | float() as value):
                if not np.isfinite(_number(value)):
                    raise InputError(where, "holds a number that is too large")
            case ast.Name(id=name):
                if name not in known and name not in CONSTANTS:
                    raise InputError(where, f"unknown name {name!r}", _did_you_mean(name, known))
            case ast.UnaryOp(op=ast.USub() | ast.UAdd()):
                self._check(node.operand, known, depth + 1)
            case ast.BinOp(op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div() | ast.Pow()):
                self._check(node.left, known, depth + 1)
                self._check(node.right, known, depth + 1)
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]):
                if name not in FUNCTIONS:
                    raise InputError(
                        where, f"unknown function {name!r}", _did_you_mean(name, FUNCTIONS)
                    )
                _, least, most = FUNCTIONS[name]
                if not least <= len(args) <= most:
                    raise InputError(
                        where, f"{name} takes {least} to {most} arguments, found {len(args)}"
                    )
                for argument in args:
                    self._check(argument, known, depth + 1)
            case _:
                raise InputError(
                    where,
                    f"{ast.unparse(node)[:60]!r} is not allowed",
                    "use numbers, names, + - * / ** and functions only",
                )

    def __call__(self, names: Mapping[str, Value]) -> Value:
        """The value over the given names."""
        return _evaluate(self._tree, names)


def _number(value: int | float) -> float:
    try:
        return float(value)
    except OverflowError:
        return float("inf")


def _evaluate(node: ast.expr, names: Mapping[str, Value]) -> Value:
    match node:
        case ast.Constant(value=int() | float() as value):
            return np.float64(_number(value))
        case ast.Name(id=name):
            return names[name] if name in names else np.float64(CONSTANTS[name])
        case ast.UnaryOp(op=ast.USub()):
            return -_evaluate(node.operand, names)
        case ast.UnaryOp():
            return _evaluate(node.operand, names)
        case ast.Call(func=ast.Name(id=name)):
            return FUNCTIONS[name][0](*(_evaluate(a, names) for a in node.args))
        case ast.BinOp(left=left, op=op, right=right):
            a, b = _evaluate(left, names), _evaluate(right, names)
            match op:
                case ast.Add():
                    return a + b
                case ast.Sub():
                    return a - b
                case ast.Mult():
                    return a * b
                case ast.Div():
                    return a / b
                case _:
                    return a**b
    raise InputError("formula", f"can't evaluate {type(node).__name__}")


def _did_you_mean(name: str, known: Sequence[str] | set[str] | Mapping[str, object]) -> str:
    names = sorted(known) + sorted(CONSTANTS)
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    return f"did you mean {close[0]!r}?" if close else f"known are: {', '.join(names)}"


class FormulaChart:
    """x, y, z over a rectangle of parameters (see `FormulaSurface`)."""

    spans = (24, 24)

    def __init__(
        self,
        x: str,
        y: str,
        z: str,
        u: tuple[float, float],
        v: tuple[float, float],
        define: Mapping[str, str | float],
        closed: tuple[bool, bool],
        scale: float,
    ) -> None:
        self.domain = frozen("formula domain", [u, v], (2, 2), most=FARTHEST)
        # As far apart as it takes to tell samples between them from each other.
        if not (
            np.diff(self.domain)[:, 0] > FINEST * np.abs(self.domain).max(axis=1, initial=1e-3)
        ).all():
            raise InputError("formula domain", f"expected u0 < u1 and v0 < v1, found {u} and {v}")
        first, second = (checked_flag("formula closed", way) for way in closed)
        self.closed = (first, second)
        self.scale = checked_number("formula scale", scale, above=0.0)
        if not isinstance(define, Mapping) or not all(isinstance(name, str) for name in define):
            raise InputError(
                "formula define", "expected expressions by their names", 'such as {"r": "u / 2"}'
            )
        if len(define) > MOST_DEFINITIONS:
            raise InputError("formula", f"has more than {MOST_DEFINITIONS} definitions")
        known = ["u", "v"]
        self.definitions: list[Formula] = []
        for name, text in define.items():
            if not name.isidentifier() or name in known or name in FUNCTIONS or name in CONSTANTS:
                raise InputError(f"formula {name}", "the name is taken or not a name", "rename it")
            self.definitions.append(Formula(name, str(text), known))
            known.append(name)
        self.coordinates = [Formula(n, t, known) for n, t in zip("xyz", (x, y, z), strict=True)]
        with np.errstate(all="ignore"):  # what isn't finite is found and named
            self._check_values()
            self._check_poles()

    def evaluate(self, u: Array, v: Array) -> Derivatives:
        """Points and exact derivatives (k, 3) at parameters (k,)."""
        jets = [f for _, f in self._values(u, v)[-3:]]
        columns = ([getattr(j, part) for j in jets] for part in ("f", "u", "v", "uu", "uv", "vv"))
        return Derivatives(*(self.scale * np.stack(c, axis=-1) for c in columns))

    def _values(self, u: Array, v: Array) -> list[tuple[Formula, Jet]]:
        ju, jv = variables(u, v)
        names: dict[str, Value] = {"u": ju, "v": jv}
        values: list[tuple[Formula, Jet]] = []
        with np.errstate(all="ignore"):  # what isn't finite is found and named afterwards
            for formula in (*self.definitions, *self.coordinates):
                value = formula(names)
                names[formula.name] = value
                values.append(
                    (formula, value if isinstance(value, Jet) else constant_like(ju, value))
                )
        return values

    def _check_values(self) -> None:
        grid = [np.linspace(low, high, 33) for low, high in self.domain]
        u, v = (g.ravel() for g in np.meshgrid(*grid, indexing="ij"))
        values = self._values(u, v)
        ends = {f.name: j for f, j in values[-3:]}
        bad = np.zeros(len(u), dtype=bool)
        for jet in ends.values():
            bad |= ~np.isfinite(np.stack([jet.f, jet.u, jet.v, jet.uu, jet.uv, jet.vv])).all(axis=0)
        if bad.any():
            at = int(np.argmax(bad))
            name = next(  # the first that has no value, else the first that has no derivative
                formula.name
                for parts in (("f",), ("u", "v", "uu", "uv", "vv"))
                for formula, jet in values
                if not all(np.isfinite(getattr(jet, part)[at]) for part in parts)
            )
            raise InputError(
                f"formula {name}",
                f"has no finite value or derivative at u = {u[at]:.6g}, v = {v[at]:.6g}",
                CURE,
            )
        for name, jet in ends.items():
            if (most := self.scale * float(np.abs(jet.f).max())) > FARTHEST:
                raise InputError(f"formula {name}", f"reaches {most:.3g} mm", CURE)

    def _check_poles(self) -> None:
        pole = pole_of(self)
        if pole is None:
            return
        d = self.evaluate(*np.array(pole)[:, None])
        steepest = np.argmax(np.nan_to_num(np.abs(d.u) + np.abs(d.v), nan=np.inf))
        raise InputError(
            f"formula {'xyz'[steepest]}",
            f"has no finite value or derivative near u = {pole[0]:.6g}, v = {pole[1]:.6g}",
            CURE,
        )


class FormulaSurface(ParametricSurface):
    """A design surface x(u, v), y(u, v), z(u, v) in closed form.

    Parameters
    ----------
    x, y, z : str
        Expressions of u, v and the definitions.
    u, v : (float, float)
        Domain.
    define : mapping of str to str, optional
        Named intermediate expressions in order; each may use the ones before it.
    closed_u, closed_v : bool
        Whether the surface closes on itself in that direction; found out if it plainly does.
    scale : float
        Factor from the formula's unit to millimetres.
    name : str
        For messages.

    Raises
    ------
    InputError
        For anything that is not an expression, an unknown name (with a suggestion), a value that
        is not finite, or a direction that is said to close and does not.
    """

    def __init__(
        self,
        x: str,
        y: str,
        z: str,
        u: tuple[float, float] = (0.0, 1.0),
        v: tuple[float, float] = (0.0, 1.0),
        define: Mapping[str, str | float] | None = None,
        closed_u: bool = False,
        closed_v: bool = False,
        scale: float = 1.0,
        name: str = "formula",
    ) -> None:
        chart = FormulaChart(
            x, y, z, u, v, {} if define is None else define, (closed_u, closed_v), scale
        )
        super().__init__(name, [chart])
