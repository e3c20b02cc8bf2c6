"""Difference and finite-volume operators on curved grids, through cuts and blocks (survey 1.1, 2.2, figure 14)."""
