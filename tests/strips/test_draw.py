"""The picture shows strips and marks the worst place where it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fabgeo import draw
from fabgeo.strips import exact


def test_one_call_draws_model_worst_places_and_history(tmp_path: Path) -> None:
    model = exact.meridians(
        8000.0, 5000.0, np.linspace(0.0, 1.2, 6), -0.6, 0.9, segments=8
    ).interpolant()
    bent = np.array(model.control)
    bent[3, 5] += (0.0, 0.0, 150.0)
    history = [{"developability": 10.0**k, "twist_deg": 3.0**-k} for k in range(8)]
    model = model.with_control(bent, info={"history": history})
    path = tmp_path / "model.png"
    figure = draw(model, path=path)
    assert path.stat().st_size > 20_000
    pixels = np.asarray(figure.canvas.buffer_rgba())[..., :3]
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 100
    labels = [t.get_text() for t in figure.axes[0].get_legend().get_texts()]
    assert any(
        (label.startswith("twist") and "strip 2" in label) or "strip 3" in label for label in labels
    )
    (twist, _) = figure.axes[-2].get_lines()
    assert twist.get_label() == "twist, deg"
    np.testing.assert_allclose(twist.get_ydata(), 3.0 ** -np.arange(8))
