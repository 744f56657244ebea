"""Formula surfaces: exact derivatives, safe reading, the Great Court's published values."""

import tomllib

import numpy as np
import pytest

from fabgeo.errors import InputError
from fabgeo.surfaces.formula import Formula, FormulaSurface
from fabgeo.surfaces.jets import FUNCTIONS, variables

ONE_ARGUMENT = sorted(name for name, (_, _, most) in FUNCTIONS.items() if most == 1)


def formula(text: str):
    return Formula("f", text, ["u", "v"])


def derivatives(text: str, u: float, v: float) -> np.ndarray:
    ju, jv = variables(np.array([u]), np.array([v]))
    jet = formula(text)({"u": ju, "v": jv})
    return np.array([jet.f, jet.u, jet.v, jet.uu, jet.uv, jet.vv])[:, 0]


def by_differences(text: str, u: float, v: float, h: float = 1e-4) -> np.ndarray:
    def f(a: float, b: float) -> float:
        return derivatives(text, a, b)[0]

    return np.array(
        [
            f(u, v),
            (f(u + h, v) - f(u - h, v)) / (2 * h),
            (f(u, v + h) - f(u, v - h)) / (2 * h),
            (f(u + h, v) - 2 * f(u, v) + f(u - h, v)) / h**2,
            (f(u + h, v + h) - f(u + h, v - h) - f(u - h, v + h) + f(u - h, v - h)) / (4 * h**2),
            (f(u, v + h) - 2 * f(u, v) + f(u, v - h)) / h**2,
        ]
    )


@pytest.mark.parametrize(
    "text",
    [
        *(f"{name}(0.2 + 0.3*u + 0.2*u*v)" for name in ONE_ARGUMENT),
        "u / (1 + v**2) - 2 / u",
        "u**3 * v**-1.5 + 2**u + u**v",
        "atan2(v, u) + atan2(0.3, u*v) + atan2(u, 2)",
        "hypot(u, v) + hypot(u, 3, v)",
        "max(u, v, 0.1) * min(u, 2*v) - -u",
        "pi * u + e * v",
    ],
)
def test_first_and_second_derivatives(text):
    exact = derivatives(text, 0.7, 0.45)
    assert exact == pytest.approx(by_differences(text, 0.7, 0.45), rel=1e-5, abs=1e-6)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sinn(u)", "did you mean 'sin'"),
        ("u + w", "unknown name 'w'"),
        ("__import__('os')", "unknown function"),
        ("u.real", "is not allowed"),
        ("(lambda: 1)()", "is not allowed"),
        ("[u for u in v]", "is not allowed"),
        ("'text'", "expected a number"),
        ("1e999", "too large"),
        ("1" * 400, "too large"),
        ("u +", "is not an expression"),
        ("(" * 200 + "u" + ")" * 200, "nested deeper"),
        ("-" * 1500 + "u", "nested deeper"),
        ("u+" * 4000 + "u", "longer than"),
        ("sin(u, v)", "takes 1 to 1 arguments"),
        ("u if v else 1", "is not allowed"),
        ("sin(x=u)", "is not allowed"),
        ("", "is not an expression"),
        ("\x00", "is not an expression"),
    ],
)
def test_bad_expressions_are_refused(text, message):
    with pytest.raises(InputError, match=message) as error:
        formula(text)
    assert "formula f" in str(error.value)


def test_a_value_that_is_not_finite_is_named_with_its_place():
    with pytest.raises(InputError, match=r"formula r: has no finite value .* u = 0, v = 0"):
        FormulaSurface("u", "v", "r", define={"r": "1 / (u + v)"})


def test_a_definition_may_not_take_a_known_name():
    with pytest.raises(InputError, match="the name is taken"):
        FormulaSurface("u", "v", "u", define={"sin": "u"})


def test_a_direction_said_to_close_must_close():
    with pytest.raises(InputError, match="said to close in u"):
        FormulaSurface("u", "v", "u*v", closed_u=True)


def great_court(fixtures) -> FormulaSurface:
    table = tomllib.loads((fixtures / "great-court" / "project.toml").read_text())["surface"]
    assert table.pop("unit") == "m"
    return FormulaSurface(**table, scale=1000.0, name="great-court")


def published_height(x, y):
    """The formula of ../shared/data/README.md as printed, in metres (Williams 2001)."""
    a, b, c, d, lam, mu, centre, edge = 22.245, 36.625, 46.025, 51.125, 0.5, 14.0, 20.955, 19.71
    r, t = np.hypot(x, y), np.arctan2(y, x)
    psi = (1 - x / b) * (1 + x / b) * (1 - y / c) * (1 + y / d)
    eta = psi / (
        (1 - a * x / (r * b))
        * (1 + a * x / (r * b))
        * (1 - a * y / (r * c))
        * (1 + a * y / (r * d))
    )
    alpha = (r / a - 1) * psi
    p, q = (1 - np.cos(2 * t)) / 2 + np.sin(t), (1 - np.cos(2 * t)) / 2 - np.sin(t)
    z2 = alpha * (
        (1 - lam)
        * ((35 + 10 * psi) * (1 + np.cos(2 * t)) / 2 + 12 * p + (7.5 + 12 * psi) * q / 2 - 1.6)
        - 5 * (1 + np.cos(2 * t))
        + 10 * (p / 2) ** 2 * (1 - 3 * alpha)
        + 2.5 * (q / 2) ** 2 * (r / a - 1) ** 2
    )
    corners = sum(np.hypot(s, w) / (s * w) for s in (b - x, b + x) for w in (c - y, d + y))
    beta = (1 - a / r) / corners
    z3 = beta * (
        lam * (1.75 * (1 + np.cos(2 * t)) + 1.5 * (1 - np.cos(2 * t)) + 0.3 * np.sin(t))
        + 1.05
        * (np.exp(-mu * (1 - x / b)) + np.exp(-mu * (1 + x / b)))
        * (np.exp(-mu * (1 - y / c)) + np.exp(-mu * (1 + y / d)))
    )
    return (centre - edge) * eta + edge + z2 + z3


def test_great_court_is_the_published_formula(fixtures):
    roof = great_court(fixtures)
    at = roof.sample(3000).point / 1000.0
    assert np.abs(at[:, 2] - published_height(at[:, 0], at[:, 1])).max() < 1e-9
    inner = min(roof.loops, key=lambda loop: np.linalg.norm(np.ptp(loop, axis=0))) / 1000.0
    assert np.hypot(inner[:, 0], inner[:, 1]) == pytest.approx(22.245)
    assert inner[:, 2] == pytest.approx(20.955)
    assert len(roof.loops) == 2
    # Stated: 6.6 m from the edge at 19.71 m to the crown.
    assert roof.sample(20000).point[:, 2].max() / 1000.0 - 19.71 == pytest.approx(6.6, abs=0.05)


def test_great_court_formula_reaches_the_edge_height(fixtures):
    table = tomllib.loads((fixtures / "great-court" / "project.toml").read_text())["surface"]
    table.pop("unit")
    # v where the ray u = 0 meets the building's edge x = b.
    v = (36.625 - 22.245) / (0.97 * 36.625 - 22.245)
    table["v"] = [0.0, v]
    roof = FormulaSurface(**table)
    assert roof.evaluate(np.array([0.0]), np.array([v])).point[0] == pytest.approx(
        [36.625, 0.0, 19.71]
    )


@pytest.mark.parametrize(
    ("given", "words"),
    [
        *[({"scale": x}, "formula scale: expected a finite") for x in (0, -1, np.nan, "a", None)],
        *[({"define": x}, "formula define: expected") for x in ([("a", "1")], {1: "1"}, "a")],
    ],
)
def test_scale_and_definitions_are_checked(given: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        FormulaSurface("u", "v", "u*v", **given)
