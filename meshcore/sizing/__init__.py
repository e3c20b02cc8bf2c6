"""Spacing along curves and size fields in the plane and in space."""
