"""Elliptic grids: the transformed Laplace and Poisson equations, their control and their solvers (survey 2.5, 2.6)."""
