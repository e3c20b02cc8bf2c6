"""Layers of planar hyperbolic grids: dissipation, the implicit step, and what is done where a layer would fold.

The survey's equations (2.7.1), orthogonality and area, linearised about the last layer, read in the frame of the
front's tangent t and normal n, with spacing s along the front and height h (J. L. Steger, D. S. Chaussee, SIAM J. Sci.
Stat. Comput. 1 (1980); W. M. Chan, J. L. Steger, Appl. Math. Comput. 51 (1992)):

    d + (1 + theta) (h / s) (t n' + n t') d_xi - D d = n V / s + D r,      d = r(next layer) - r

with differences of the index xi. The area V is h s, times a share for the mean bending of the front and for what
dissipation takes from it, so that a circle gives the polar grid, and, if asked for, as cells get thick the mean of how
cells around have widened over how this one has. The dissipation

    D r = e r_xixi + c 2 s- s+ / (s- + s+) (t+ - t-)

has two parts. There is c everywhere, which straightens the front alone, by the difference of its edges' unit tangents
t- and t+, of lengths s- and s+: on a straight front it vanishes however points are spaced, while r_xixi would draw
lines along the wake of a C-grid by up to 66 degrees. And there is e where fronts are about to meet and where cells
folded, which spreads the points along the front, too; at concave corners c does the same, and is divided by the square
of the sine of half the corner's angle: Chan and Steger's a. Their S, which rises with the number of the layer, is
`weight` here, which rises with the cells' aspect ratio, so that layers do not depend on how many are asked for. Their
sensor d, of spacings that shrink from layer to layer, gained nothing beside the windows that look for fronts about to
meet; their S d a with r_xixi alone left 4 of 90 horseshoes, Cs and combs whole, where all are.
"""

import math

from ..._numba import kernel
from ._block_tridiagonal_kernels import solve
from ._collision_kernels import BAY, collisions, deepest_bay
from ._end_row_kernels import end_row, given_row, lean, point_at
from ._marching_front_kernels import (
    AFTER,
    ALONG,
    ASKED,
    BEFORE,
    BEST,
    BOOST,
    CLOSED,
    CORNERS,
    FIRST_SPACING,
    HEIGHT,
    LEAD,
    ON_CURVE,
    PIN,
    SPACING,
    SPARE,
    SPLAY,
    START,
    TANGENT,
    TINY,
    TOWARDS,
    TURN,
    TURNED,
    WALL,
    copy,
    fill,
    frame_of,
    ghosts,
    means,
    smoothed,
    worst_corner,
)

THIN = 2.4  # turn (radians) from which on an edge is so thin that its line must keep to the bisector for a layer
CAP = 0.2  # share of the height that dissipation may take at convex corners
PULL = 64.0  # heights by which dissipation may draw a front out of a bay in a step
CONCAVE = 0.2  # left turn (radians) from which on flat cells have all of the dissipation, too
THICK = 0.8  # aspect ratio, height over length, from which on cells have most of the dissipation
SPREAD = 4  # passes that smooth the dissipation along the front
AVERAGED = 4  # passes that average areas along the front
NARROWEST = 0.02  # square of the sine of half a corner's angle, by the inverse of which dissipation grows, at least
PARABOLIC = 1.0  # weight of the elliptic equation's r_xixi |r_eta|^2 / |r_xi|^2 on the way to an outer front
UNFOLDING = 4.0  # dissipation, in aspect ratios, that cells may have to unfold others: flat ones would only slide along
OBLIQUE = 2.0  # times the share of the way from which on heights are those along the normal, not along the line
FLAT = 1e-9  # sine of a corner's angle below which a cell counts as folded
SOUND = 0.05  # sine from which on a layer is taken as it is
ATTEMPTS = 7  # each with twice as many steps


@kernel
def march(
    out,
    heights,
    outer,
    kind,
    frame,
    curves,
    reached,
    base,
    theta,
    volume,
    averaging,
    drawing,
    r,
    d,
    scratch,
    blocks,
    info,
    first,
    last,
):
    """Layers ``first`` to ``last`` of a grid, out[j + 1] from out[j]; returns how many there are then.

    A layer that folds, or comes near to it, is tried again in twice as many steps, with more dissipation where it was.

    Parameters
    ----------
    out : (layers + 1, 2, n)
        The fronts.
    heights : (layers, 1 or n)
        Thickness of each layer; with an outer front, the share of the way to it that the layer ends at.
    outer : (2, n) or (2, 0)
        The front to end at, if there is one: from the wall on, orthogonality and areas give way to a parabolic
        equation, which smooths along the front while lines head for their points on the outer one.
    kind : (2,)
        Conditions at the ends, with their numbers in ``frame`` (2, 2) and ``curves`` (2, m, 3): x, y, and the length up
        to there, with an outer front as a share of the whole.
    reached : (2,)
        How far along their curves the ends are.
    base, theta, volume, averaging : float
        Dissipation in units of the cells' aspect ratio, implicitness beyond Euler's, shares of the areas' smoothing
        by the mean of all and by those around.
    drawing : float
        Share of the dissipation against collisions that draws points along the front, out of bays, instead of
        straightening the front only: where lines stand close beside lines that do not, they would all lean.
    r, d, scratch, blocks
        (2, n + 4), (n, 2), (ROWS, n + 4) and (4, n, 4) numbers of scratch.
    info : (2,) int
        Counts layers that were split; the cell at which the march ended.
    """
    n = d.shape[0]
    boost, corners = scratch[BOOST], scratch[CORNERS]
    start, best, pin = scratch[START : START + 2], scratch[BEST : BEST + 2], scratch[PIN : PIN + 2]
    closed = kind[0] == CLOSED
    before = 1.0
    load(out[0], start)
    ghosts(start, kind, frame)
    frame_of(start, scratch[TANGENT : TANGENT + 2], scratch[FIRST_SPACING], scratch[TURN])
    for c in range(2):
        scratch[WALL + c, 0], scratch[WALL + c, 1] = out[0, c, 0], out[0, c, n - 1]
    for j in range(first, last):
        load(out[j], start)
        best_possible = pin_thin_edges(start, kind, frame, scratch, pin)
        for k in range(n + 4):
            boost[k] = 0.0
        least, fault, steps = -2.0, 0, 1
        for attempt in range(ATTEMPTS):
            copy(start, r)
            for part in range(steps):
                ask(r, heights, outer, j, part, steps, kind, scratch)
                step(
                    r,
                    kind,
                    frame,
                    curves,
                    reached,
                    part + 1,
                    base,
                    theta,
                    volume,
                    averaging,
                    drawing,
                    d,
                    scratch,
                    blocks,
                )
                for k in range(n):
                    r[0, k + 2] += d[k, 0]
                    r[1, k + 2] += d[k, 1]
            if outer.shape[1] and j == heights.shape[0] - 1:
                load(outer, r)
            for k in range(n):
                d[k, 0] = r[0, k + 2] - start[0, k + 2]
                d[k, 1] = r[1, k + 2] - start[1, k + 2]
            worst, place = worst_corner(start, d, closed, corners)
            if worst > least:
                least, fault = worst, place
                copy(r, best)
            if least > min(SOUND, 0.7 * before, 0.7 * best_possible) or (attempt > 3 and least > FLAT):
                break
            steps *= 2
            strengthen(boost, corners, closed, attempt, steps)
        if steps > 1:
            info[0] += 1
        if not least > FLAT:
            info[1] = fault
            return j
        before = least
        for end in range(2):
            reached[end] += heights[j, 0 if end == 0 else heights.shape[1] - 1]
        for k in range(n):
            out[j + 1, 0, k], out[j + 1, 1, k] = best[0, k + 2], best[1, k + 2]
    return last


@kernel
def ask(r, heights, outer, j, part, steps, kind, scratch):
    """Heights of one step of a layer, and with an outer front how far lines head for it, and which way."""
    asked, lead = scratch[ASKED], scratch[LEAD]
    n, columns = asked.size - 4, heights.shape[1]
    for k in range(n):
        g = k + 2
        if outer.shape[1] == 0:
            asked[g] = heights[j, k % columns] / steps
            continue
        before = heights[j - 1, k % columns] if j > 0 else 0.0
        share = (heights[j, k % columns] - before) / steps
        at = before + part * share
        x, y = outer[0, k] - r[0, g], outer[1, k] - r[1, g]
        distance = math.sqrt(x * x + y * y) + TINY
        asked[g] = distance * share / (1 - at)
        lead[g] = at + share
        scratch[TOWARDS, g], scratch[TOWARDS + 1, g] = x / distance, y / distance
    fill(asked, kind)


@kernel
def load(layer, front):
    """Copy a layer (2, n) to a front without ghosts."""
    for k in range(layer.shape[1]):
        front[0, k + 2], front[1, k + 2] = layer[0, k], layer[1, k]


@kernel
def pin_thin_edges(start, kind, frame, scratch, pin):
    """Directions of lines that leave thin edges, zero elsewhere: beside a cusp only its bisector gives sound cells.

    Returns the sine of the corners there, which no line can better.
    """
    least = 1.0
    t, turn = scratch[TANGENT : TANGENT + 2], scratch[TURN]
    ghosts(start, kind, frame)
    frame_of(start, t, scratch[SPACING], turn)
    for k in range(2, turn.size - 2):
        thin = turn[k] < -THIN
        pin[0, k] = -t[1, k] if thin else 0.0
        pin[1, k] = t[0, k] if thin else 0.0
        if thin:
            least = min(least, math.cos(0.5 * turn[k]))
    return least


@kernel
def strengthen(boost, corners, closed, attempt, steps):
    """More dissipation, shared by the steps, around cells that are nearly folded; each attempt reaches farther."""
    n = boost.size - 4
    reach = min(4 * 2 ** min(attempt, 4), n // 2 - 1)
    strength = 0.5 * 2.0**attempt / steps
    for k in range(n):
        if not corners[k + 2] > SOUND:
            for q in range(k - reach, k + reach + 2):
                to = q
                if closed:
                    to = q + n if q < 0 else q - n if q >= n else q
                if 0 <= to < n:
                    boost[to + 2] = max(boost[to + 2], strength)


@kernel
def step(r, kind, frame, curves, reached, part, base, theta, volume, averaging, drawing, d, scratch, blocks):
    """Displacement ``d`` (n, 2) of a front by one step; ``part`` counts the steps of a layer."""
    n = d.shape[0]
    t = scratch[TANGENT : TANGENT + 2]
    s, turn, h, asked = scratch[SPACING], scratch[TURN], scratch[HEIGHT], scratch[ASKED]
    closed = kind[0] == CLOSED
    ghosts(r, kind, frame)
    frame_of(r, t, s, turn)
    dissipation(r, kind, base, drawing, scratch)
    mean_s, mean_turn = means(s, turn, closed)
    average = scratch[SPARE]
    average_areas(kind, averaging, scratch, average)
    sine, half = math.sin(-mean_turn), 2 * math.sin(-0.5 * mean_turn)
    lower, diagonal, upper, fill_in = blocks[0], blocks[1], blocks[2], blocks[3]
    for k in range(n):
        g = k + 2
        tx, ty, lead = t[0, g], t[1, g], scratch[LEAD, g]
        free = 1 - lead
        before, after = scratch[BEFORE, g], scratch[AFTER, g]
        a = 0.5 * (1 + theta) * h[g] / s[g] * free
        m0, m3 = -(1 + volume) * tx * ty * a, (1 + volume) * tx * ty * a
        m1, m2 = (tx * tx - volume * ty * ty) * a, (volume * tx * tx - ty * ty) * a
        lower[k, 0], lower[k, 1], lower[k, 2], lower[k, 3] = -m0 - before, -m1, -m2, -m3 - before
        upper[k, 0], upper[k, 1], upper[k, 2], upper[k, 3] = m0 - after, m1, m2, m3 - after
        both = 1 + before + after
        diagonal[k, 0], diagonal[k, 1], diagonal[k, 2], diagonal[k, 3] = both, 0.0, 0.0, both
        bend = h[g] / mean_s
        lost = base * narrowness(mean_turn) * weight(bend, mean_turn) * half * (1 + bend * half)
        forward = h[g] * average[g] * max(0.5, 1 + volume * (1 + theta) * bend * sine + lost) * free
        if lead > 0:  # or fronts whose lines head for a corner of the outer one would pass its sides
            straight = max(0.0, tx * scratch[TOWARDS + 1, g] - ty * scratch[TOWARDS, g])
            forward *= 1 - min(1.0, OBLIQUE * lead) * (1 - straight)
        ahead = h[g] * lead
        x, y = dissipated(r, g, before, after)
        d[k, 0] = -ty * forward + scratch[TOWARDS, g] * ahead + x
        d[k, 1] = tx * forward + scratch[TOWARDS + 1, g] * ahead + y
    for k in range(n):
        x, y = scratch[PIN, k + 2], scratch[PIN + 1, k + 2]
        if x != 0 or y != 0:
            given_row(k, x * asked[k + 2], y * asked[k + 2], lower, diagonal, upper, d)
    if not closed:
        for end in range(2):
            end_row(end, kind[end], frame[end], scratch, lower, diagonal, upper, d)
            k = 0 if end == 0 else n - 1
            if kind[end] == ON_CURVE:
                lead = scratch[LEAD, k + 2]
                x, y = point_at(curves[end], lead if lead > 0 else reached[end] + part * asked[k + 2])
                given_row(k, x - r[0, k + 2], y - r[1, k + 2], lower, diagonal, upper, d)
            if kind[end] == ALONG:
                side = h[k + 2] if -t[1, k + 2] * frame[end, 0] + t[0, k + 2] * frame[end, 1] > 0 else -h[k + 2]
                lean(end, side * frame[end, 0], side * frame[end, 1], r, scratch, d)
            elif kind[end] == ON_CURVE or kind[end] == SPLAY:
                lean(end, d[k, 0], d[k, 1], r, scratch, d)
    solve(lower, diagonal, upper, d, closed, fill_in)


@kernel
def dissipation(r, kind, base, drawing, scratch):
    """Heights that shrink before collisions, and dissipation: by aspect ratio, by collisions, and where asked for.

    It is kept as each point's weights of the differences to the points before and after. At convex corners it may take
    no more than a share of the height.
    """
    t = scratch[TANGENT : TANGENT + 2]
    s, turn, h, strength = scratch[SPACING], scratch[TURN], scratch[HEIGHT], scratch[BEFORE]
    asked, boost, turned, spare = scratch[ASKED], scratch[BOOST], scratch[TURNED], scratch[SPARE]
    n = h.size - 4
    run = 0.0
    for k in range(2, n + 2):
        run += turn[k]
        turned[k] = run
    collisions(r, t, turned, asked, kind[0] == CLOSED, strength, h, scratch[SPARE : SPARE + 4])
    smoothed(strength, spare, kind, SPREAD)
    for k in range(2, n + 2):
        h[k] *= asked[k]
        aspect, lead = h[k] / s[k], scratch[LEAD, k]
        concave = min(1.0, max(0.0, turn[k] / CONCAVE))
        drawn = drawing * strength[k]
        e = (1 - lead) * (drawn + PARABOLIC * lead * aspect * aspect + boost[k] * min(1.0, UNFOLDING * aspect))
        own = base * narrowness(turn[k]) * weight(aspect, turn[k]) * aspect
        c = (1 - lead) * (strength[k] - drawn + own)
        uneven = (1 - concave) * (after_over_mean(r, k) - 1)
        before, after = e + c * (1 + uneven), e + c * (1 - uneven)
        x, y = dissipated(r, k, before, after)
        inward, share = t[1, k] * x - t[0, k] * y, 1.0
        if inward > 0:
            share = min(share, CAP * weight(aspect, turn[k]) * h[k] / inward)
        elif inward < 0:
            share = min(share, PULL * asked[k] / -inward)
        scratch[BEFORE, k], scratch[AFTER, k] = share * before, share * after


@kernel(inline=True)
def narrowness(turn):
    """Chan and Steger's a: the inverse square of the sine of half a concave corner's angle, 1 elsewhere."""
    sine = math.cos(0.5 * max(0.0, turn))
    return 1 / max(NARROWEST, sine * sine)


@kernel
def average_areas(kind, averaging, scratch, area):
    """What averaging along the front makes of how cells have widened since the wall, over that; 1 where they are flat.

    Chan and Steger average areas. Where points are unevenly spaced that bends straight fronts; widening is one there.
    First heights are kept, and fronts round off as cells get thick, with mean heights as asked. In bays, where cells
    narrow, areas stay: fronts would only meet sooner.
    """
    s, wall, h, other = scratch[SPACING], scratch[FIRST_SPACING], scratch[HEIGHT], scratch[SPARE + 1]
    n = h.size - 4
    share = averaging * max(0.0, 1 - deepest_bay(scratch[TURNED], kind[0] == CLOSED) / BAY)
    for k in range(2, n + 2):
        area[k] = s[k] / wall[k]
    if share > 0:
        smoothed(area, other, kind, AVERAGED)
    for k in range(2, n + 2):
        area[k] = 1 + share * weight(h[k] / s[k], 0.0) * (area[k] * wall[k] / s[k] - 1)
    more = means(area, area, kind[0] == CLOSED)[0] - 1
    for k in range(2, n + 2):
        area[k] -= more


@kernel(inline=True)
def after_over_mean(r, k):
    """Length of the edge after a point, over the mean of that and the edge before: from 0 to 2."""
    bx, by = r[0, k] - r[0, k - 1], r[1, k] - r[1, k - 1]
    ax, ay = r[0, k + 1] - r[0, k], r[1, k + 1] - r[1, k]
    b, a = math.sqrt(bx * bx + by * by) + TINY, math.sqrt(ax * ax + ay * ay) + TINY
    return 2 * a / (a + b)


@kernel(inline=True)
def dissipated(r, k, before, after):
    """How far dissipation moves a point, given its weights."""
    return (
        after * (r[0, k + 1] - r[0, k]) - before * (r[0, k] - r[0, k - 1]),
        after * (r[1, k + 1] - r[1, k]) - before * (r[1, k] - r[1, k - 1]),
    )


@kernel(inline=True)
def weight(aspect, turn):
    """The share of dissipation that cells have: flat ones little, so that first heights are kept, but where concave."""
    concave = min(1.0, max(0.0, turn / CONCAVE))
    return (aspect + THICK * concave) / (aspect + THICK)
