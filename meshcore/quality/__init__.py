"""Measures of quality, their report, and the validity of meshes."""
