"""Spacing along curves and size fields in the plane and in space."""

from .spacing import cells_for_growth, cosine, geometric, hyperbolic_tangent, uniform

__all__ = ["cells_for_growth", "cosine", "geometric", "hyperbolic_tangent", "uniform"]
