"""What operations on blocks ask alike of the edges' points: their parameters, each declared once."""

from __future__ import annotations

from typing import Annotated

from ...operation import Length, Param

BlockCellsIParam = Annotated[int | None, Param("Cells along i; by default as points are given", min=1, soft_max=200)]
BlockCellsJParam = Annotated[int | None, Param("Cells along j; by default as points are given", min=1, soft_max=200)]
BlockCellsKParam = Annotated[int | None, Param("Cells along k; by default as points are given", min=1, soft_max=200)]
SpacingIMinParam = Annotated[Length | None, Param("Height of the cells at imin", group="Spacing")]
SpacingIMaxParam = Annotated[Length | None, Param("Height of the cells at imax", group="Spacing")]
SpacingJMinParam = Annotated[Length | None, Param("Height of the cells at jmin", group="Spacing")]
SpacingJMaxParam = Annotated[Length | None, Param("Height of the cells at jmax", group="Spacing")]
SpacingKMinParam = Annotated[Length | None, Param("Height of the cells at kmin", group="Spacing")]
SpacingKMaxParam = Annotated[Length | None, Param("Height of the cells at kmax", group="Spacing")]
