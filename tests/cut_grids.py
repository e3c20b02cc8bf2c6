"""Grids with cuts, made by hand, for tests of cuts and haloes."""

import numpy as np

from meshcore import Cut, MultiBlock, StructuredGrid


def ring(n: int, layers: int, start: int = 0, ratio: float = 4.0) -> StructuredGrid:
    """A polar grid round the unit circle, clockwise, cut at point number ``start`` of n."""
    angle = -2 * np.pi * (start + np.arange(n + 1)) / n
    radius = ratio ** (np.arange(layers + 1) / layers)
    points = np.stack(np.broadcast_arrays(radius * np.cos(angle)[:, None], radius * np.sin(angle)[:, None]), axis=-1)
    points[-1] = points[0]
    return StructuredGrid(points, periodic=(True, False, False))


def c_shape(wake: int, around: int, layers: int, bend: float = 0.0) -> StructuredGrid:
    """A C-grid round the unit circle whose lines run on smoothly through the wake.

    With w = s + i t, the flow past the circle has the potential z + 1/z = w^2 - 2: the circle is t = 0, |s| <= 2, and
    w and -w are the same place. So t < 0 is beyond the wake, and odd functions of w bend the lines there smoothly, too.
    """
    half = around // 2
    s = 2.0 / half * np.arange(-(half + wake), half + wake + 1)
    points = parabolic(s, np.linspace(0, 1.5, layers + 1), bend)
    n = len(s) - 1
    points[wake, 0] = points[n - wake, 0] = [1, 0]
    points[n - wake :, 0] = points[: wake + 1, 0][::-1]
    cut = Cut(((0, 0, 0), (wake, 0, 0)), ((n, 0, 0), (n - wake, 0, 0)), (-1, -2, 3), name="wake")
    return StructuredGrid(points, cuts=(cut,))


def parabolic(s: np.ndarray, t: np.ndarray, bend: float = 0.0) -> np.ndarray:
    """(ns, nt, 2) places of w = s + i t of `c_shape`."""
    s = s[:, None]
    w = s * (1 + bend * (s**2 - 4 - t**2)) + 1j * t * (1 + bend * (0.3 * t**2 + s**2))
    z = outside(w**2 - 2, np.where(s < 0, -1, 1))
    return np.stack([z.real, z.imag], axis=-1)


def outside(zeta: np.ndarray, side: int | np.ndarray) -> np.ndarray:
    """The z outside the unit circle with z + 1/z = zeta; on the slit, below or above, the circle itself."""
    z = 0.5 * (zeta + np.sqrt(zeta - 2 + 0j) * np.sqrt(zeta + 2 + 0j))
    z = np.where(np.abs(z) < 1 - 1e-9, 1 / z, z)
    on = (np.abs(zeta.imag) < 1e-12) & (np.abs(zeta.real) <= 2 + 1e-9)
    return np.where(on, np.exp(1j * side * np.arccos(np.clip(zeta.real / 2, -1, 1))), z)


def h_cylinder(n: int, bend: float = 0.0) -> MultiBlock:
    """An H-grid of two blocks round the unit circle, whose lines run on smoothly through the cuts ahead and behind.

    With zeta = p + i q, the flow past the circle has the potential z + 1/z = zeta: the circle is the slit q = 0,
    |p| <= 2. Functions even in q along p, and odd along q, bend the lines smoothly, too. The slit has 2 n cells, the
    cuts n each, as many as there are layers on each side.
    """
    p = 2.0 / n * np.arange(-2 * n, 2 * n + 1)[:, None]
    blocks = []
    for side in (-1, 1):
        q = 0.5 * (side - 1) * 3.0 + np.linspace(0, 3, n + 1)
        zeta = p * (1 + bend * (p**2 - 4 - q**2)) + 1j * q * (1 + bend * (0.3 * q**2 + p**2))
        z = outside(zeta, side)
        z[np.abs(p[:, 0]) >= 2 - 1e-9, 0 if side > 0 else -1].imag = 0.0
        blocks.append(StructuredGrid(np.stack([z.real, z.imag], axis=-1)))
    ahead, end = n, 4 * n
    cuts = [Cut(((a, n, 0), (b, n, 0)), ((a, 0, 0), (b, 0, 0)), (1, 2, 3), 0, 1) for a, b in ((0, n), (3 * n, end))]
    assert np.abs(blocks[1].points[ahead, 0, 0] - [-1, 0, 0]).max() < 1e-12
    return MultiBlock(tuple(blocks), ("lower", "upper"), tuple(cuts))


def h_shape(n: int, bend: float = 0.0) -> MultiBlock:
    """Four blocks round a square hole, of n or 3 n by n cells, the corners belonging to those above and below.

    ::

        +---------------+       The lines are those of a smooth map of the plane, so that they run on through all cuts.
        |      top      |       The hole, with straight corners in the indices, is where differences are one-sided.
        +----+=====+----+
        |west||hole||east|
        +----+=====+----+
        |    bottom     |
        +---------------+
    """
    x = np.linspace(-3, 3, 3 * n + 1)

    def block(i: slice, j: slice) -> StructuredGrid:
        u, v = np.meshgrid(x[i], x[j], indexing="ij")
        return StructuredGrid(np.stack([u + bend * np.sin(v + 0.3 * u), v + bend * np.cos(u)], axis=-1))

    low, middle, high = slice(0, n + 1), slice(n, 2 * n + 1), slice(2 * n, None)
    every = slice(None)
    blocks = (block(every, low), block(low, middle), block(high, middle), block(every, high))
    m, end = n, 3 * n
    cuts = [
        Cut(((0, m, 0), (m, m, 0)), ((0, 0, 0), (m, 0, 0)), (1, 2, 3), 0, 1),
        Cut(((2 * m, m, 0), (end, m, 0)), ((0, 0, 0), (m, 0, 0)), (1, 2, 3), 0, 2),
        Cut(((0, m, 0), (m, m, 0)), ((0, 0, 0), (m, 0, 0)), (1, 2, 3), 1, 3),
        Cut(((0, m, 0), (m, m, 0)), ((2 * m, 0, 0), (end, 0, 0)), (1, 2, 3), 2, 3),
    ]
    return MultiBlock(blocks, ("bottom", "west", "east", "top"), tuple(cuts))


def quarter_turned(turn: int, width: int = 3, bend: float = 0.0) -> MultiBlock:
    """Two blocks side by side that share a line of ``width`` cells, the second turned by quarters, on a smooth map."""

    def block(x: np.ndarray) -> np.ndarray:
        u, v = np.meshgrid(x, np.arange(width + 1.0), indexing="ij")
        return np.stack([u + bend * np.sin(0.3 * v), v + bend * np.cos(0.2 * u)], axis=-1)

    first, second = block(np.arange(width + 2.0)), block(np.arange(width + 1.0, 2 * width + 2.0))
    number = np.rot90(np.arange((width + 1) ** 2).reshape(width + 1, width + 1), turn)

    def at(point: int) -> np.ndarray:
        return np.array([*np.argwhere(number == point)[0], 0])

    steps = [at(width + 1) - at(0), at(1) - at(0)]
    transform = (*(int(step @ [1, 2, 0]) for step in steps), 3)
    cut = Cut(((width + 1, 0, 0), (width + 1, width, 0)), (tuple(at(0)), tuple(at(width))), transform, 0, 1)
    return MultiBlock((StructuredGrid(first), StructuredGrid(np.rot90(second, turn))), cuts=(cut,))


def turned_volumes(order: tuple[int, int, int], back: tuple[bool, bool, bool]) -> MultiBlock:
    """Two blocks that share a face, the axes of the second in any order, each counted forwards or backwards."""

    def box(start: int, ni: int) -> np.ndarray:
        return np.stack(np.meshgrid(start + np.arange(ni), np.arange(4), np.arange(5), indexing="ij"), axis=-1) / 7

    plain = box(2, 6)
    turned = plain.transpose(*order, 3)[tuple(slice(None, None, -1 if b else 1) for b in back)]

    def at(i: int, j: int, k: int) -> tuple[int, ...]:
        return tuple(int(n) for n in np.argwhere((turned == plain[i, j, k]).all(axis=-1))[0])

    steps = np.array([at(1, 0, 0), at(0, 1, 0), at(0, 0, 1)]) - at(0, 0, 0)
    transform = tuple(int(step @ [1, 2, 3]) for step in steps)
    cut = Cut(((2, 0, 0), (2, 3, 4)), (at(0, 0, 0), at(0, 3, 4)), transform, 0, 1, name="middle")
    free = "ijk"[(order.index(0) + 1) % 3]  # an axis of the second block that lies along the face
    names = ({"imin": "in", "jmax": "side wall"}, {f"{free}min": "it's"})
    blocks = tuple(StructuredGrid(p, names=n) for p, n in zip((box(0, 3), turned), names, strict=True))
    return MultiBlock(blocks, cuts=(cut,))


def on_a_step() -> MultiBlock:
    """A box on the middle of another's face, whose rest is "step"."""

    def box(*axes: np.ndarray) -> np.ndarray:
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1) / 3

    low = box(np.arange(3), np.arange(6), np.arange(7))
    high = box(np.arange(2, 5), np.arange(1, 4), np.arange(2, 6))
    cut = Cut(((2, 1, 2), (2, 3, 5)), ((0, 0, 0), (0, 2, 3)), (1, 2, 3), 0, 1)
    blocks = StructuredGrid(low, names={"imax": "step", "imin": "floor"}), StructuredGrid(high, names={"imax": "roof"})
    return MultiBlock(blocks, cuts=(cut,))
