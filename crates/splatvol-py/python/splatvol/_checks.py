"""Values of keywords: numbers of Python's or numpy's, refused by the keyword's name."""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np

from ._errors import InvalidValue


def refused(field: str, value: Any, expected: str) -> InvalidValue:
    """The error of a keyword whose value is not what is expected."""
    return InvalidValue(f"{field}: {value!r} is not {expected}", field=field, value=repr(value), expected=expected)


def number(value: Any, field: str, expected: str = "a finite number") -> float:
    """A finite number.

    Raises
    ------
    InvalidValue
    """
    try:
        found = math.nan if isinstance(value, (str, bytes)) else float(value)
    except (TypeError, ValueError, OverflowError):
        found = math.nan
    if not math.isfinite(found):
        raise refused(field, value, expected)
    return found


def positive(value: Any, field: str) -> float:
    """A finite number above 0.

    Raises
    ------
    InvalidValue
    """
    expected = "a number above 0"
    found = number(value, field, expected)
    if found <= 0:
        raise refused(field, value, expected)
    return found


def share(value: Any, field: str) -> float:
    """A number from 0 to 1.

    Raises
    ------
    InvalidValue
    """
    expected = "a number from 0 to 1"
    found = number(value, field, expected)
    if not 0 <= found <= 1:
        raise refused(field, value, expected)
    return found


def whole(value: Any, field: str, least: int, most: int, expected: str) -> int:
    """A whole number in a range; ``True`` and ``False`` are none.

    Raises
    ------
    InvalidValue
    """
    try:
        found = None if isinstance(value, (bool, np.bool_)) else operator.index(value)
    except TypeError:
        found = None
    if found is None or not least <= found <= most:
        raise refused(field, value, expected)
    return found


def pair(values: Any, field: str, expected: str) -> tuple[float, float]:
    """Two finite numbers.

    Raises
    ------
    InvalidValue
    """
    try:
        first, second = values
    except (TypeError, ValueError):
        raise refused(field, values, expected) from None
    return number(first, field, expected), number(second, field, expected)


def memory(value: Any, field: str) -> int | None:
    """A number of bytes, or `None`.

    Raises
    ------
    InvalidValue
    """
    expected = "a whole number of bytes: 8 << 30 is 8 GiB"
    return None if value is None else whole(value, field, 0, (1 << 64) - 1, expected)
