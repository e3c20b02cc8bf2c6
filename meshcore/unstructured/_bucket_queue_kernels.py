"""Kernels of a queue of triangles in buckets: the highest bucket goes first, in a bucket the one that came first.

An entry is four words of ``queue``: the triangle's first half-edge, the stamp that its slot had, and the next entry of
its bucket; ``head`` and ``tail`` hold the first and the last of each bucket, -1 where there is none. Entries that were
taken are used again. Whether an entry is stale, the caller sees by the stamp.
"""

from .._numba import kernel
from ._half_edge_kernels import U

# Places in the caller's state, which goes on from `QUEUE_STATE`: entries ever made, head of the list of those to be
# used again, and a bucket above which all are empty.
QUEUED, RECYCLED, TOP = range(3)
QUEUE_STATE = 3


@kernel(inline=True)
def empty_queue(head, state):
    """Forget all entries."""
    state[QUEUED] = 0
    state[RECYCLED] = -1
    state[TOP] = -1
    head[:] = -1


@kernel(inline=True)
def push(bucket, slot, stamp, queue, head, tail, state):
    """Put a triangle at the end of a bucket; the caller has made room."""
    entry = state[RECYCLED]
    if entry >= 0:
        state[RECYCLED] = queue[U(4 * entry + 2)]
    else:
        entry = state[QUEUED]
        state[QUEUED] = entry + 1
    queue[U(4 * entry)] = slot
    queue[U(4 * entry + 1)] = stamp
    queue[U(4 * entry + 2)] = -1
    if head[U(bucket)] < 0:
        head[U(bucket)] = entry
    else:
        queue[U(4 * int(tail[U(bucket)]) + 2)] = entry
    tail[U(bucket)] = entry
    state[TOP] = max(state[TOP], bucket)


@kernel(inline=True)
def pop(queue, head, state):
    """Take the first entry of the highest bucket; its first word stands at the answer, which is -1 if all are empty."""
    bucket = int(state[TOP])
    while bucket >= 0 and head[U(bucket)] < 0:
        bucket -= 1
    state[TOP] = bucket
    if bucket < 0:
        return -1
    entry = int(head[U(bucket)])
    head[U(bucket)] = queue[U(4 * entry + 2)]
    queue[U(4 * entry + 2)] = state[RECYCLED]
    state[RECYCLED] = entry
    return 4 * entry
