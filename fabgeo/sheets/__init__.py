"""Flat parts on stock: biarcs, DXF, nesting."""
