"""Design surfaces: closest point, normal, curvature, boundary; meshes, B-splines, formulas."""
