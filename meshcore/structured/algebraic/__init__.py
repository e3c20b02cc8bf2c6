"""Algebraic grids: the boundaries of patches and blocks, and transfinite interpolation between them (survey 2.4)."""
