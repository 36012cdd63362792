"""The level of detail that is read: the finest one that a budget of bytes allows."""

from __future__ import annotations

from collections.abc import Sequence

from .._errors import InvalidValue, LimitError

#: Bytes of samples that are read where nobody says how many.
MOST_BYTES = 4 << 30


def choose_level(shapes: Sequence[Sequence[int]], itemsize: int, level: int | str | None, max_bytes: int | None) -> int:
    """Number of the level: the one that is asked for, or the finest of at most `max_bytes`.

    Raises
    ------
    InvalidValue
        A level that is not there.
    LimitError
        Levels that are all too large.
    """
    spelt = ", ".join(f"{i}: {' x '.join(map(str, shape))}" for i, shape in enumerate(shapes))
    if level is not None and level != "auto":
        if isinstance(level, str) or not 0 <= level < len(shapes):
            raise InvalidValue(f"level: {level!r} is not there (there are {spelt})", field="level", value=repr(level))
        return int(level)
    limit = MOST_BYTES if max_bytes is None else max_bytes
    sizes = [itemsize * _product(shape) for shape in shapes]
    for i, size in enumerate(sizes):
        if size <= limit:
            return i
    least = min(sizes)
    raise LimitError(f"the smallest level has {least} bytes, max_bytes={limit}: write max_bytes={least} ({spelt})")


def _product(shape: Sequence[int]) -> int:
    product = 1
    for size in shape:
        product *= int(size)
    return product
