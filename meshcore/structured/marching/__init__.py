"""Marching grids: hyperbolic and parabolic layers off curves and surfaces (survey 2.7)."""
