"""Exceptions: what went wrong, with path, field and value apart."""

from __future__ import annotations


class SplatvolError(Exception):
    """Base of what splatvol raises on its own account.

    Attributes
    ----------
    path : str or None
        File that it is about.
    field : str or None
        Field of the file, key of the document or keyword.
    value : str or None
        Offending value, as it was written.
    expected : str or None
        Accepted values.
    offset : str or None
        Position in the file, bytes.
    """

    def __init__(
        self,
        message: str,
        *,
        path: str | None = None,
        field: str | None = None,
        value: str | None = None,
        expected: str | None = None,
        offset: str | None = None,
    ) -> None:
        super().__init__(message)
        self.path = path
        self.field = field
        self.value = value
        self.expected = expected
        self.offset = offset

    def __reduce__(self) -> tuple[object, ...]:
        return _rebuilt, (type(self), self.args, self.__dict__)


def _rebuilt(kind: type[SplatvolError], args: tuple[str, ...], state: dict[str, str | None]) -> SplatvolError:
    error = kind(*args)
    error.__dict__.update(state)
    return error


class FormatError(SplatvolError, ValueError):
    """A file is malformed, contradicts itself, or has a feature that is not read."""


class InvalidValue(SplatvolError, ValueError):
    """A keyword, a key or a value that has no meaning."""


class Combination(SplatvolError, ValueError):
    """Settings that exclude each other, or that a kind of data does not support."""


class LimitError(SplatvolError, MemoryError):
    """More memory is needed than is allowed or free."""


class Cancelled(SplatvolError):
    """The work was stopped by `cancel`, or because `progress` returned ``False``."""


class InternalError(SplatvolError, RuntimeError):
    """A bug in splatvol: please report it."""


class UnknownKeyword(SplatvolError, TypeError):
    """A keyword that splatvol does not have; the message says what to write instead."""


class DataWarning(UserWarning):
    """Something odd in data that did not prevent reading or showing them."""
