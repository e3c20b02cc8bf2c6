"""Geometry beneath the generators: exact predicates and curves."""
