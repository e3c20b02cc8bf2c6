"""Geometry beneath the generators: exact predicates, curves and surfaces."""
