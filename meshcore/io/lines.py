"""Text files line by line: words where they are asked for, whole columns of numbers at once, rows of numbers written.

Numbers are turned from text, and into it, in bulk; only where that fails are lines looked at one by one, to read
what is odd but right, such as Fortran's exponents, or to name the line at fault.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Sequence
from typing import Union, overload

import numpy as np

from ..errors import InvalidInput
from .content import floats, whole

_CHUNK = 1 << 14  # rows written at a time: the words of all would need several times the memory of their text


class Lines(Sequence[tuple[int, list[str]]]):
    """Lines of a text without comments and blank ones; each is its number in the file, from 1, and its words.

    Parameters
    ----------
    texts : sequence of str
        The lines.
    numbers : sequence of int
        Their numbers.

    Examples
    --------
    >>> lines = Lines.of("3 0.5 # first\\n\\n4 1.5")
    >>> list(lines)
    [(1, ['3', '0.5']), (3, ['4', '1.5'])]
    >>> lines.whole(1, "a row")[:, 0], lines.table(1, "a row", first=1)[:, 0]
    (array([3, 4]), array([0.5, 1.5]))
    """

    def __init__(self, texts: Sequence[str], numbers: Sequence[int]):
        self.texts, self.numbers = texts, numbers

    @classmethod
    def of(cls, text: str, comment: str = "#") -> Lines:
        """The lines of a text; what follows ``comment`` does not count."""
        texts = text.split("\n")
        if comment in text:
            texts = [line.split(comment, 1)[0] if comment in line else line for line in texts]
        kept = [k for k, line in enumerate(texts) if line and not line.isspace()]
        return cls([texts[k] for k in kept] if len(kept) < len(texts) else texts, [k + 1 for k in kept])

    def __len__(self) -> int:
        return len(self.texts)

    @overload
    def __getitem__(self, k: int) -> tuple[int, list[str]]: ...
    @overload
    def __getitem__(self, k: Union[slice, np.ndarray]) -> Lines: ...
    def __getitem__(self, k: Union[int, slice, np.ndarray]) -> Union[tuple[int, list[str]], Lines]:
        if isinstance(k, slice):
            return Lines(self.texts[k], self.numbers[k])
        if isinstance(k, np.ndarray):
            return Lines([self.texts[n] for n in k.tolist()], [self.numbers[n] for n in k.tolist()])
        return self.numbers[k], self.texts[k].split()

    def table(self, columns: int, what: str, *, first: int = 0) -> np.ndarray:
        """(n, columns) float: words of each line as numbers.

        Parameters
        ----------
        columns : int
            How many words; a line may have more.
        what : str
            What a line is, for the message.
        first : int
            How many words of each line come before.

        Raises
        ------
        InvalidInput
            If a line has fewer words, or one that is no number.
        """
        found = self._loaded(columns, first, float)
        if found is None:
            found = np.array([floats(words, line) for line, words in self._words(columns, what, first)])
        return found

    def whole(self, columns: int, what: str, *, first: int = 0) -> np.ndarray:
        """(n, columns) int: like `table`, of whole numbers."""
        found = self.whole_or_none(columns, first=first)
        if found is not None:
            return found
        rows = [
            (line, [whole(word, line, what) for word in words]) for line, words in self._words(columns, what, first)
        ]
        for line, row in rows:
            if large := [n for n in row if abs(n) >= 2**62]:
                raise InvalidInput(f"line {line}: {large[0]} is too large for {what}")
        return np.array([row for _, row in rows], np.int64)

    def whole_or_none(self, columns: int, *, first: int = 0) -> np.ndarray | None:
        """(n, columns) int as `whole` gives them, or None if there are other words, or too few."""
        return self._loaded(columns, first, np.int64)

    def ragged(
        self, sizes: np.ndarray, what: str, *, first: Union[int, np.ndarray] = 0, real: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        """Numbers, of each line as many as ``sizes`` tells, one line after the other, and where each begins.

        Parameters
        ----------
        sizes : (n,) int
            How many words of each line.
        what : str
            What a line is, for the message.
        first : int or (n,) int
            How many words come before, in all lines or in each.
        real : bool
            Real numbers, or whole ones.

        Examples
        --------
        >>> Lines.of("3 7 8 9\\n2 7 8").ragged(np.array([3, 2]), "a face", first=1)
        (array([7, 8, 9, 7, 8]), array([0, 3, 5]))
        """
        first = np.broadcast_to(first, sizes.shape)
        self._hold(first + sizes, what)
        offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
        values = np.zeros(offsets[-1], float if real else np.int64)
        widest = first.max(initial=0) + 1
        group = sizes * widest + first
        for key in np.unique(group).tolist():
            where = np.flatnonzero(group == key)
            some, size = self if len(where) == len(self) else self[where], key // widest
            read = some.table if real else some.whole
            values[offsets[where][:, None] + np.arange(size)] = read(size, what, first=int(key % widest))
        return values, offsets

    def _hold(self, words: np.ndarray, what: str) -> None:
        """`InvalidInput` if a line is too short for so many words: what a file promises could take all memory."""
        room = np.fromiter(map(len, self.texts), np.int64, len(self))
        if (words > room).any():
            bad = int(np.argmax(words > room))
            line, found = self[bad]
            raise InvalidInput(f"line {line}: {what} needs {words[bad]} words, got {len(found)}")

    def _words(self, columns: int, what: str, first: int) -> list[tuple[int, list[str]]]:
        rows = []
        for line, words in self:
            if len(words) < first + columns:
                raise InvalidInput(f"line {line}: {what} needs {first + columns} words, got {' '.join(words)!r}")
            rows.append((line, words[first : first + columns]))
        return rows

    def _loaded(self, columns: int, first: int, dtype: type) -> np.ndarray | None:
        """Columns by numpy's reader; None if it finds a fault."""
        if not len(self) or not columns:
            return np.empty((len(self), columns), dtype)
        if first + columns > len(self.texts[0]):
            return None
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # older numpy reads 1.5 as a whole number, and warns
            try:
                wanted = range(first, first + columns)
                return np.loadtxt(self.texts, dtype, comments=None, usecols=wanted, ndmin=2)
            except (ValueError, OverflowError, Warning):
                return None


def rows_of(*columns: np.ndarray, form: str = "") -> str:
    """A line for each row of numbers, with every digit: the shortest text that reads back as the same of its type.

    Parameters
    ----------
    *columns : (n,) or (n, k) int or float
        What stands in a row, from left to right.
    form : str, optional
        The row, with %s for each number; by default they stand with blanks between.

    Examples
    --------
    >>> print(rows_of(np.array([4, 5]), np.array([[0.1, 1], [2e-7, 3]])), end="")
    4 0.1 1.0
    5 2e-07 3.0
    >>> print(rows_of(np.array([[1, 2]]), form="f %s %s"), end="")
    f 1 2
    """
    flat = [part for column in columns for part in (column.T if column.ndim > 1 else [column])]
    line = (form or " ".join(["%s"] * len(flat))) % tuple(_form(column.dtype) for column in flat) + "\n"
    parts = []
    for begin in range(0, len(columns[0]), _CHUNK):
        lists = [_listed(column[begin : begin + _CHUNK]) for column in flat]
        parts.append(line * len(lists[0]) % tuple(itertools.chain.from_iterable(zip(*lists, strict=True))))
    return "".join(parts)


def _form(dtype: np.dtype) -> str:
    return "%d" if dtype.kind != "f" else "%s" if dtype == np.float32 else "%r"


def _listed(column: np.ndarray) -> list:
    """Numbers for their form; only numpy knows the digits that single precision needs."""
    return list(map(str, column)) if column.dtype == np.float32 else column.tolist()


def wrapped(values: np.ndarray, width: int) -> str:
    """Numbers with every digit, ``width`` a line.

    Examples
    --------
    >>> print(wrapped(np.arange(5), 3), end="")
    0 1 2
    3 4
    """
    whole_lines = len(values) // width * width
    text = rows_of(values[:whole_lines].reshape(-1, width))
    return text + (rows_of(values[None, whole_lines:]) if whole_lines < len(values) else "")
