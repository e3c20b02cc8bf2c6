"""Kernels that change tetrahedra locally: some cells replaced by others; and compaction.

Every flip, removal of an edge and recovery of a facet ends in `replace_cavity`. It looks at the whole change before it
writes anything: what does not fit is refused, and leaves no trace. The layout stands in `_tetrahedra_kernels`.
"""

import numpy as np

from .._numba import kernel
from ._tetrahedra_kernels import (
    CONSTRAINED,
    DONE,
    END,
    FACET_A,
    FACET_B,
    FACET_C,
    FREE,
    FULL_CAVITY,
    FULL_CELLS,
    HINT,
    NEXT,
    U,
    marked,
    set_plane,
    side,
)

# Why a replacement is refused: facets do not match, a cell is flat or inverted, a constrained facet would be lost.
MISMATCH, INVERTED, LOST_FACET = 6, 7, 8

# An entry of the table of facets: three ascending corners; the word of the neighbour beyond, or `_KEPT` or `_INNER`;
# whether the corners turn as seen from the cell; one and the other new cell's facet (4 j + k) or -1; facet id, region.
_ENTRY = 9
_EMPTY = -2
_KEPT, _INNER = -2, -3


@kernel
def _sorted_facet(a, b, c):
    """Three corners in ascending order, and 1 if that is an odd permutation of them, else 0."""
    odd = 0
    if a > b:
        a, b = b, a
        odd = 1 - odd
    if b > c:
        b, c = c, b
        odd = 1 - odd
    if a > b:
        a, b = b, a
        odd = 1 - odd
    return a, b, c, odd


@kernel
def _entry_of(table, size, a, b, c):
    """The place of a facet in the table, or of the empty entry where it would be."""
    at = (((a + 1) * 73856093) ^ ((b + 1) * 19349663) ^ ((c + 1) * 83492791)) & (size - 1)
    while True:
        i = _ENTRY * at
        if table[i] == _EMPTY or (table[i] == a and table[i + 1] == b and table[i + 2] == c):
            return i
        at = (at + 1) & (size - 1)


@kernel
def _set_entry(table, i, a, b, c, word, odd, facet, region):
    """Fill an empty entry."""
    table[i], table[i + 1], table[i + 2], table[i + 3], table[i + 4] = a, b, c, word, odd
    table[i + 5] = table[i + 6] = -1
    table[i + 7], table[i + 8] = facet, region


@kernel
def _list_old_facets(cells, region, facet_id, old, table, size):
    """Put the facets around some marked cells, and the constrained ones between them, into the table."""
    for t in old:
        for k in range(4):
            word = np.int64(cells[16 * t + 4 + k])
            around = cells[16 * (word >> 3)] >= 0
            if not around and word & CONSTRAINED == 0:
                continue
            a = np.int64(cells[16 * t + FACET_A[k]])
            b = np.int64(cells[16 * t + FACET_B[k]])
            c = np.int64(cells[16 * t + FACET_C[k]])
            a = marked(a) if a < -1 else a
            b = marked(b) if b < -1 else b
            a, b, c, odd = _sorted_facet(a, b, c)
            i = _entry_of(table, size, a, b, c)
            if table[i] == _EMPTY:
                facet = facet_id[4 * t + k] if len(facet_id) > 0 else 0
                _set_entry(
                    table, i, a, b, c, word if around else _KEPT, odd, facet, region[t] if len(region) > 0 else 0
                )


@kernel
def _list_new_facets(points, new, table, size, work):
    """Put the infinite vertices last, and match the facets of the new cells; return `DONE`, `MISMATCH`, `INVERTED`."""
    for j in range(len(new) // 4):
        a, b, c, d = new[4 * j], new[4 * j + 1], new[4 * j + 2], new[4 * j + 3]
        if a < 0:
            a, b, c, d = d, c, b, a
        elif b < 0:
            a, b, c, d = c, d, a, b
        elif c < 0:
            a, b, c, d = b, a, d, c
        if min(a, b, c) < 0:
            return MISMATCH
        new[4 * j], new[4 * j + 1], new[4 * j + 2], new[4 * j + 3] = a, b, c, d
        if d >= 0 and not side(points, a, b, c, d, work) > 0.0:
            return INVERTED
        for k in range(4):
            a, b, c, odd = _sorted_facet(
                np.int64(new[4 * j + FACET_A[k]]), np.int64(new[4 * j + FACET_B[k]]), np.int64(new[4 * j + FACET_C[k]])
            )
            i = _entry_of(table, size, a, b, c)
            if table[i] == _EMPTY:
                _set_entry(table, i, a, b, c, _INNER, odd, 0, 0)
            if table[i + 5] < 0 and (table[i + 3] < 0 or table[i + 4] == odd):
                table[i + 4] = odd
                table[i + 5] = 4 * j + k
            elif table[i + 3] < 0 and table[i + 6] < 0 and table[i + 4] != odd:
                table[i + 6] = 4 * j + k
            else:
                return MISMATCH
    return DONE


@kernel
def _unmatched(table, size):
    """`DONE` if all facets around have a cell and all others two, else `LOST_FACET` or `MISMATCH`."""
    status = DONE
    for at in range(size):
        i = _ENTRY * at
        if table[i] != _EMPTY:
            if table[i + 3] == _KEPT and table[i + 6] < 0:
                return LOST_FACET
            if table[i + 5] < 0 or (table[i + 3] == _INNER and table[i + 6] < 0):
                status = MISMATCH
    return status


@kernel
def _link(cells, region, facet_id, made, table, size):
    """Write the neighbours of the new cells, and what their facets carry over from the old ones."""
    for at in range(size):
        i = _ENTRY * at
        if table[i] == _EMPTY:
            continue
        word = np.int64(table[i + 3])
        one, k = np.int64(made[table[i + 5] >> 2]), np.int64(table[i + 5]) & 3
        if word >= 0:
            cells[16 * one + 4 + k] = word
            cells[16 * (word >> 3) + 4 + (word & 3)] = one << 3 | (word & CONSTRAINED) | k
            if len(region) > 0:
                region[one] = table[i + 8]
        else:
            other, l = np.int64(made[table[i + 6] >> 2]), np.int64(table[i + 6]) & 3
            bit = CONSTRAINED if word == _KEPT else 0
            cells[16 * one + 4 + k] = other << 3 | bit | l
            cells[16 * other + 4 + l] = one << 3 | bit | k
            if len(facet_id) > 0:
                facet_id[4 * other + l] = table[i + 7]
        if len(facet_id) > 0:
            facet_id[4 * one + k] = table[i + 7]


@kernel
def _spread_regions(cells, region, made, unknown):
    """Give new cells without a facet of the old boundary the region of a neighbour on this side of all constraints."""
    changed = True
    while changed:
        changed = False
        for t in made:
            for k in range(4):
                word = np.int64(cells[16 * t + 4 + k])
                if region[t] == unknown and word & CONSTRAINED == 0 and region[word >> 3] != unknown:
                    region[t] = region[word >> 3]
                    changed = True


@kernel
def replace_cavity(points, cells, planes, region, facet_id, cell_of, old, new, made, table, state, work):
    """Replace some cells by others that fill the same cavity.

    Parameters
    ----------
    old : (n,) int32
        Live cells.
    new : (4 m,) int32
        Corners of the new cells, in positive order; the infinite vertex of a ghost anywhere. It is moved to the end.
    made : (m,) int32
        Receives the numbers of the new cells.
    table : (k,) int32
        Scratch, of at least 90 (n + m) entries.

    Returns
    -------
    int
        `DONE`; or, and then nothing has changed, `MISMATCH` if the facets around the old cells are not those around
        the new ones, or one is used twice, `INVERTED` if a finite new cell is not positive, `LOST_FACET` if a
        constrained facet inside is none of the new cells', `FULL_CELLS` or `FULL_CAVITY` if a buffer must grow.

    Notes
    -----
    Constraint bits and facet ids stay with their facets, around and inside. A new cell takes the region of the old
    cell inside a facet that it has of the old boundary, else that of a neighbour.
    """
    n_old, n_new = len(old), len(new) // 4
    size = 8
    while size < 5 * (n_old + n_new):
        size *= 2
    if _ENTRY * size > len(table):
        return FULL_CAVITY
    if state[NEXT] + n_new > state[END]:
        return FULL_CELLS
    for at in range(size):
        table[_ENTRY * at] = _EMPTY
    n_marked = 0
    for t in old:
        if cells[16 * t] < 0:
            break
        cells[16 * t] = marked(cells[16 * t])
        n_marked += 1
    status = MISMATCH
    if n_marked == n_old and n_old > 0:
        _list_old_facets(cells, region, facet_id, old, table, size)
        status = _list_new_facets(points, new, table, size, work)
        if status == DONE:
            status = _unmatched(table, size)
    for j in range(n_marked):
        cells[16 * old[j]] = marked(cells[16 * old[j]])
    if status != DONE:
        return status
    first_region = region[old[0]] if len(region) > 0 else 0
    unknown = -(2**31)
    for t in old:
        if len(cell_of) > 0:
            for k in range(4):
                if cells[16 * t + k] >= 0:
                    cell_of[cells[16 * t + k]] = -1
        cells[16 * t] = -1
        cells[16 * t + 4] = state[FREE]
        state[FREE] = t
    for j in range(n_new):
        t = state[FREE]
        if t >= 0:
            state[FREE] = cells[16 * t + 4]
        else:
            t = state[NEXT]
            state[NEXT] += 1
        made[j] = t
        for k in range(4):
            cells[16 * t + k] = new[4 * j + k]
            if len(facet_id) > 0:
                facet_id[4 * t + k] = 0
            if len(cell_of) > 0 and new[4 * j + k] >= 0:
                cell_of[new[4 * j + k]] = t
        if len(region) > 0:
            region[t] = unknown
        set_plane(points, cells, planes, t)
        if new[4 * j + 3] >= 0:
            state[HINT] = t
    _link(cells, region, facet_id, made, table, size)
    if len(region) > 0:
        _spread_regions(cells, region, made, unknown)
        for t in made:
            if region[t] == unknown:
                region[t] = first_region
    if cells[16 * state[HINT]] < 0:
        state[HINT] = made[0]
    return DONE


@kernel
def compact(cells, planes, region, facet_id, cell_of, state, number):
    """Move the live cells to the front, in their order; ``number`` receives the new number of each, or -1."""
    count = 0
    for t in range(state[NEXT]):
        number[U(t)] = -1
        if cells[U(16 * t)] >= 0:
            number[U(t)] = count
            count += 1
    for t in range(state[NEXT]):
        s = np.int64(number[U(t)])
        if s < 0:
            continue
        for k in range(4):
            word = np.int64(cells[U(16 * t + 4 + k)])
            cells[U(16 * s + k)] = cells[U(16 * t + k)]
            cells[U(16 * s + 4 + k)] = np.int64(number[U(word >> 3)]) << 3 | (word & 7)
            planes[U(8 * s + 4 + k)] = planes[U(8 * t + 4 + k)]
            if len(facet_id) > 0:
                facet_id[U(4 * s + k)] = facet_id[U(4 * t + k)]
        if len(region) > 0:
            region[U(s)] = region[U(t)]
    for v in range(len(cell_of)):
        if cell_of[U(v)] >= 0:
            cell_of[U(v)] = number[U(cell_of[U(v)])]
    state[NEXT], state[FREE] = count, -1
    state[HINT] = max(0, np.int64(number[U(state[HINT])]))
