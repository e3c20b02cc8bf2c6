"""Progress callbacks: fractions, parts and cancelling."""

import pytest

from meshcore.errors import Cancelled
from meshcore.progress import advance, part_of, silent


def test_false_cancels_and_none_does_not():
    advance(lambda fraction, message: None, 0.3, "smoothing")
    with pytest.raises(Cancelled, match="while smoothing"):
        advance(lambda fraction, message: False, 0.3, "smoothing")


@pytest.mark.parametrize(("told", "seen"), [(-1.0, 0.0), (0.25, 0.25), (7, 1.0)])
def test_fractions_stay_between_zero_and_one(told, seen):
    calls = []
    advance(lambda fraction, message: calls.append(fraction), told, "")
    assert calls == [seen]


def test_parts_nest():
    calls = []
    outer = part_of(lambda fraction, message: calls.append((fraction, message)), 0.5, 1.0)
    advance(part_of(outer, 0.0, 0.5), 1.0, "inner")
    assert calls == [(0.75, "inner")]


def test_a_part_passes_the_answer_on():
    assert part_of(lambda fraction, message: False, 0, 1)(0.5, "") is False
    assert part_of(silent, 0, 1)(0.5, "") is True
