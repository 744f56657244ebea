"""Nesting: every layout is sound, whatever the time; what fits nowhere is named."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from sheet_parts import shared_panels, wavy_part

from fabgeo.errors import InputError
from fabgeo.panels.flat import FlatPart
from fabgeo.panels.unfold import flat_polygon
from fabgeo.sheets.biarc import part_contour
from fabgeo.sheets.boards import congruence, cut_boards
from fabgeo.sheets.nest import nest
from fabgeo.sheets.packing import alike
from fabgeo.sheets.pieces import piece_of, safe_polygon
from fabgeo.sheets.preview import nest_figures, sheet_png, sheet_svg
from fabgeo.sheets.shelf import shelves
from fabgeo.sheets.stock import Nest, Stock
from fabgeo.sheets.strip import ENGINES, nest_strip
from fabgeo.sheets.verify import check_nest

STOCK = Stock("S", "al", 3.0, 3000.0, 1500.0)


def problems(parts: list[FlatPart], nests: list[Nest]) -> list[str]:
    contours = {part.mark: part_contour(part) for part in parts}
    return [p for made in nests for p in check_nest(made, contours)]


def box(mark: str, length: float, width: float, material: str = "al") -> FlatPart:
    corners = np.array([[0, 0], [length, 0], [length, width], [0, width]])
    return flat_polygon(mark, material, 3.0, corners, grain="along")


@pytest.mark.parametrize("seed", range(3))
def test_rows_are_sound_at_once(seed: int) -> None:
    random = np.random.default_rng(seed)
    parts = [box(f"B-{k}", *random.uniform(50.0, 900.0, 2)) for k in range(60)]
    made = nest(parts, [STOCK], seconds=0.0)
    assert problems(parts, made) == []
    assert made[0].utilisation > 0.5


def test_steps_give_the_same_layout_and_beat_rows(shared_data: Path) -> None:
    parts = shared_panels(shared_data, 14)
    rows = nest(parts, [STOCK], seconds=0.0)[0]
    once, again = (nest(parts, [STOCK], steps=1, seed=3)[0] for _ in range(2))
    assert once == again
    assert problems(parts, [once]) == []
    assert len(once.sheets) < len(rows.sheets)


def test_several_stocks_and_groups_within_the_time() -> None:
    parts = [box(f"B-{k}", 700.0 + 13 * k, 300.0) for k in range(12)]
    parts += [box("T-1", 500.0, 300.0, "steel"), wavy_part("P-1", "steel")]
    stocks = [
        STOCK,
        Stock("small", "al", 3.0, 1600.0, 800.0),
        Stock("rest", "steel", 3.0, 2000.0, 1000.0),
    ]
    start = time.monotonic()
    made = nest(parts, stocks, seconds=4.0)
    assert time.monotonic() - start < 8.0
    assert [(n.material, n.thickness) for n in made] == [("al", 3.0), ("steel", 3.0)]
    assert problems(parts[:12], made[:1]) == []
    assert problems(parts[12:], made[1:]) == []


def test_what_fits_nowhere_is_named_with_the_reason() -> None:
    parts = [box("long", 3200.0, 100.0), box("fine", 300.0, 200.0), box("alien", 10, 10, "zinc")]
    al, zinc = nest(parts, [STOCK], seconds=0.0)
    assert "3200 x 100 mm fits no stock" in al.unplaced["long"]
    assert [p.mark for p in al.sheets[0].placements] == ["fine"]
    assert zinc.unplaced == {"alien": "there is no stock of its material and thickness"}


def test_remnants_are_used_first_and_only_as_often_as_they_are_there() -> None:
    rest = Stock("remnant", "al", 3.0, 700.0, 400.0, quantity=1, cost=0.0)
    parts = [box(f"B-{k}", 600.0, 300.0) for k in range(3)]
    (made,) = nest(parts, [STOCK, rest], seconds=0.0)
    names = [sheet.stock.name for sheet in made.sheets]
    assert names.count("remnant") == 1
    assert problems(parts, [made]) == []
    (scarce,) = nest(parts, [rest], seconds=0.0)
    assert len(scarce.unplaced) == 2
    assert "no sheet of the stock is left" in next(iter(scarce.unplaced.values()))


def test_quantities() -> None:
    part = box("K-1", 120.0, 80.0)
    (made,) = nest([part], [STOCK], seconds=0.0, quantities={"K-1": 25})
    assert sum(len(sheet.placements) for sheet in made.sheets) == 25
    assert check_nest(made, {"K-1": part_contour(part)}, quantities={"K-1": 25}) == []


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match=r"B-1.*repeats"):
        nest([box("B-1", 10, 10), box("B-1", 20, 20)], [STOCK])
    with pytest.raises(InputError, match="spacing"):
        nest([box("B-1", 10, 10)], [STOCK], spacing=-1.0)


def test_engine_polygons_hold_the_part_with_few_vertices() -> None:
    contour = part_contour(wavy_part())
    points = safe_polygon(contour)
    assert len(points) <= 40
    grown, exact = shapely.Polygon(points), shapely.Polygon(contour.points(1e-3))
    assert shapely.contains(grown, exact)
    assert shapely.hausdorff_distance(grown, exact) < 5.0


def test_strips_by_both_engines_are_sound() -> None:
    parts = [box(f"B-{k}", 300.0 + 40 * k, 200.0) for k in range(6)]
    pieces = [piece_of(part) for part in parts]
    strip = nest_strip(pieces, 450.0, spacing=5.0, seconds=4.0, engines=ENGINES)
    assert len(strip.placements) == 6
    area = sum(piece.area for piece in pieces)
    assert strip.density == pytest.approx(area / (strip.length * 450.0))
    rows, _ = shelves(pieces, [Stock("x", "", 0, 9000.0, 450.0)], 5.0, 0.0)
    assert rows
    assert strip.length <= 1650.0 + 2.0 * 3, "two rows of three side by side"


@pytest.mark.parametrize("engine", ENGINES)
def test_equal_pieces_are_one_kind_to_the_engine_and_each_placed_once(engine: str) -> None:
    pieces = [piece_of(box(f"B-{k}", 300.0, 200.0)) for k in range(6)]
    pieces.append(piece_of(box("C-0", 500.0, 100.0)))
    assert sorted(len(kind) for kind in alike(pieces)) == [1, 6]
    strip = nest_strip(pieces, 410.0, spacing=5.0, seconds=2.0, engines=[engine])
    assert sorted(p.mark for p in strip.placements) == sorted(piece.mark for piece in pieces)
    assert strip.engine == engine


def test_thin_brackets_find_room_on_a_strip_that_begins_short() -> None:
    # Each reaches 300 mm along the strip, yet twice their area is a length of 165 mm only.
    corner = np.array([[0, 0], [300, 0], [300, 20], [20, 20], [20, 300], [0, 300]], dtype=float)
    parts = [flat_polygon(f"L-{k}", "al", 3.0, corner, grain="along") for k in range(6)]
    strip = nest_strip(
        [piece_of(part) for part in parts], 420.0, 5.0, 4.0, engines=["packingsolver"]
    )
    assert sorted(p.mark for p in strip.placements) == [part.mark for part in parts]
    assert strip.engine == "packingsolver"
    assert strip.length < 600.0  # two by two, one in the other's angle


def test_planks_and_boards() -> None:
    parts = [box(f"S-{k}", 1900.0, 140.0) for k in range(4)]
    (boards,) = cut_boards(parts, [Stock("board", "al", 3.0, 4000.0, 150.0)], seconds=0.0)
    assert len(boards.sheets) == 2
    assert all(p.rotation in (0.0, np.pi) for s in boards.sheets for p in s.placements)


def test_equal_edges_are_congruent_and_others_are_not() -> None:
    edge = wavy_part().outline[0]
    c, s = np.cos(0.4), np.sin(0.4)
    turn = np.array([[c, s], [-s, c]])
    moved = replace(
        edge,
        points=edge.points[::-1] @ turn + 7.0,
        tangents=-edge.tangents[::-1] @ turn,
        arc=edge.arc[-1] - edge.arc[::-1],
    )
    assert congruence(edge, moved) < 1e-6
    mirror = np.array([1.0, -1.0])
    mirrored = replace(moved, points=moved.points * mirror, tangents=moved.tangents * mirror)
    assert congruence(edge, mirrored) > 10.0


def test_previews_and_figures(tmp_path: Path) -> None:
    parts = {f"P-{k}": wavy_part(f"P-{k}") for k in range(2)}
    (made,) = nest(list(parts.values()), [STOCK], seconds=0.0)
    svg = sheet_svg(made.sheets[0], parts)
    assert svg.count("<path") == len(made.sheets[0].placements)
    assert "A9.000 9.000" in svg, "holes stay circles"
    sheet_png(made.sheets[0], parts, tmp_path / "sheet.png")
    assert (tmp_path / "sheet.png").stat().st_size > 5000
    figures = nest_figures(made, parts, density=2700.0)
    assert figures["pierces"] == 2 * 3
    mass = 2 * parts["P-0"].area * 3.0 * 2700e-9
    assert figures["parts_mass_kg"] == pytest.approx(mass)
    bought = len(made.sheets) * 4.5e6
    assert figures["utilisation"] == pytest.approx(2 * parts["P-0"].area / bought)
