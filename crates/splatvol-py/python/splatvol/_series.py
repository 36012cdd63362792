"""Series: volumes over time."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from ._data import Data, Volume, read_item
from ._errors import InvalidValue


class Series(Data):
    """Volumes over time: one look, one place, and a volume for each time, made when it is asked for.

    Parameters
    ----------
    data : array or sequence
        An array with a time axis, or arrays, volumes or files, one for each time.
    axes : str
        Names of the array's axes with ``t``, as ``"tzyx"``; of each volume's axes where `data` is a sequence.
    times : sequence of float, optional
        The times; by default 0, 1, 2...
    **options
        Keywords of :class:`splatvol.Volume`: `spacing`, `origin`, `affine`, `unit`...

    Examples
    --------
    >>> import numpy as np, splatvol as sv
    >>> series = sv.Series(np.random.default_rng(1).random((3, 8, 8, 8)), axes="tzyx")
    >>> len(series), series[1].shape
    (3, (8, 8, 8))
    """

    def __init__(self, data: Any, *, axes: str = "tzyx", times: Sequence[float] | None = None, **options: Any) -> None:
        self._axes = axes.replace("t", "")
        self._options = options
        if isinstance(data, (list, tuple)):
            self._sources: Any = list(data)
        else:
            if axes.count("t") != 1 or len(axes) != np.ndim(data):
                message = f"axes={axes!r} does not name the {np.ndim(data)} axes of the array with t for time"
                raise InvalidValue(message, field="axes", value=axes)
            self._sources = np.moveaxis(data, axes.index("t"), 0) if axes[0] != "t" else data
        if len(self._sources) == 0:
            raise InvalidValue("data: a series has at least one volume", field="data")
        self.times = list(range(len(self._sources))) if times is None else [float(time) for time in times]
        if len(self.times) != len(self._sources):
            raise InvalidValue(f"times: {len(self.times)} times for {len(self._sources)} volumes", field="times")
        self._made: tuple[int, Volume] | None = None
        first = self[0]
        super().__init__(first._core, first._keys)

    def __len__(self) -> int:
        return len(self._sources)

    def __getitem__(self, index: int) -> Volume:
        index = range(len(self))[index]
        if self._made is None or self._made[0] != index:
            self._made = (index, self._volume(self._sources[index]))
        return self._made[1]

    def isel(self, t: int) -> Volume:
        """The volume with this number."""
        return self[t]

    def sel(self, time: float) -> Volume:
        """The volume of the nearest time."""
        return self[int(np.argmin(np.abs(np.asarray(self.times) - time)))]

    def _volume(self, source: Any) -> Volume:
        if isinstance(source, Volume):
            return source
        if isinstance(source, (str, os.PathLike)):
            data = read_item({"file": os.fspath(source)})
            if not isinstance(data, Volume):
                raise InvalidValue(f"{os.fspath(source)}: a series is of volumes, not of {data.kind}", field="data")
            return data
        return Volume(source, axes=self._axes, **self._options)

    def __reduce__(self) -> tuple[object, ...]:
        return _series_again, (self._sources, self._axes, self.times, self._options)

    def __repr__(self) -> str:
        return f"<splatvol.Series of {len(self)}: {self[0]!r}>"


def _series_again(sources: Any, axes: str, times: list[float], options: dict[str, Any]) -> Series:
    own = axes if isinstance(sources, list) else f"t{axes}"
    return Series(sources, axes=own, times=times, **options)
