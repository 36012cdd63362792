"""Volumes whose chunks are read when a picture needs them, from anything that has bytes or samples."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from . import _checks, _core
from ._arrays import Lengths, steps_of
from ._data import TYPES, Data
from ._errors import DataWarning, InvalidValue
from ._vocabulary import check, tables

#: ``get(key, start, length)``: bytes of a key of a Zarr store, or `None` where there is no such key.
Get = Callable[[str, int, "int | None"], "bytes | None"]

#: Samples along the edges of chunks of arrays that say nothing of their own.
CHUNK = 64


class LazyVolume(Data):
    """A volume in chunks, which are read when a picture needs them: what :func:`splatvol.lazy` returns."""

    def __init__(self, core: _core.Data, keys: dict[str, Any], memory: int | None = None) -> None:
        super().__init__(core, keys)
        self._memory = memory

    @property
    def levels(self) -> list[tuple[int, int, int]]:
        """Samples along z, y, x of every level, the finest first."""
        known = self._describe()
        return [(z, y, x) for x, y, z in known["levels"] or [known["dims"]]]

    @property
    def shape(self) -> tuple[int, int, int]:
        """Samples along z, y, x of the finest level."""
        return self.levels[0]

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the samples."""
        return np.dtype(TYPES[self._describe()["dtype"]])

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest finite value, as far as the volume knows them without reading all chunks."""
        low, high = self._describe()["range"]
        return (low, high)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray[Any, Any]:
        raise TypeError("a LazyVolume is not read whole: splatvol.read(...) is, or take the array that it was made of")

    def __reduce__(self) -> tuple[object, ...]:
        if self.source is None:
            raise TypeError("LazyVolume of a store or of arrays is not pickled: send what it was made of")
        return _read, (self._keys, self._memory)

    def __repr__(self) -> str:
        levels = ", ".join(" x ".join(map(str, level)) for level in self.levels)
        return f"<splatvol.LazyVolume {self.name!r}  z x y x x: {levels}>"


def lazy(
    source: Any,
    *,
    spacing: Lengths = None,
    name: str | None = None,
    memory: int | None = None,
    level: int | None = None,
    channel: int | None = None,
    time: int | None = None,
    series: str | None = None,
) -> LazyVolume:
    """A volume of any size, of which a picture reads the chunks that it shows.

    Parameters
    ----------
    source
        An OME-Zarr image: its folder or address (``"https://..."``, ``"s3://..."``); a mapping of its keys to bytes
        (fsspec's ``FSMap``, of which byte ranges are asked for; a store of Zarr 2; a dictionary); or a function
        ``get(key, start, length)`` that returns bytes from `start` on (the last ``-start`` where it is negative, all
        where `length` is `None`), or `None` where there is no such key.
        Or its samples: levels of detail, the finest first, each an array with axes z, y, x that gives samples of slices
        (dask, h5py, zarr, ``numpy.memmap``). Of one array, and of flat files and TIFF, coarser levels are made as
        pictures need them: all of it is read a few times before the first picture. Other files are read whole.
    spacing : float, sequence or dict, optional
        World length between samples of the finest array, along z, y, x; 1 by default. OME-Zarr says it itself.
    name : str, optional
        What it is called.
    memory : int, optional
        Bytes that the volume and its pictures may take; half of the machine's memory by default.
    level, channel, time, series : optional
        The finest level that is read; which channel, time point and image of a series: as for :func:`splatvol.read`.

    Raises
    ------
    FormatError
        A file or bytes that are no such image.
    InvalidValue
        Arrays that are no levels of a volume, or have masked samples; `memory` that is no number of bytes.

    Examples
    --------
    >>> import numpy as np, splatvol as sv
    >>> fine = np.random.default_rng(0).integers(0, 255, (40, 32, 32), np.uint8)
    >>> volume = sv.lazy([fine, fine[::2, ::2, ::2]], spacing={"z": 2})
    >>> volume.levels
    [(40, 32, 32), (20, 16, 16)]
    >>> volume.render(size=32).size
    (32, 32)
    """
    asked = {"level": level, "channel": channel, "time": time, "series": series}
    options = {name: value for name, value in asked.items() if value is not None}
    check(options)
    keys = tables(options).get("item", {})
    memory = _checks.memory(memory, "memory")
    if isinstance(source, (str, os.PathLike)):
        if spacing is not None or name is not None:
            raise InvalidValue("spacing, name: a file says them itself", field="spacing")
        return _read({"file": os.fspath(source), **keys}, memory)
    if callable(source):
        get, default = source, "store"
    elif hasattr(source, "fs") and hasattr(source, "root"):
        get, default = _of_file_system(source.fs, source.root), str(source.root)
    elif isinstance(source, Mapping):
        get, default = _of_mapping(source), "store"
    else:
        levels = source if isinstance(source, (list, tuple)) else [source]
        get, default = _Arrays(levels, spacing).get, "arrays"
        spacing = None
    if spacing is not None:
        raise InvalidValue("spacing: an OME-Zarr image says it itself", field="spacing")
    named = os.path.basename(name or default) or default
    item = {"file": f"array:{named}", **keys}
    return LazyVolume(_core.Data.of_keys(named, get, json.dumps(item), memory), item, memory)


def _read(keys: dict[str, Any], memory: int | None) -> LazyVolume:
    """A file or an address, by the keys of an item."""
    core, notes = _core.Data.read(json.dumps(keys), lazy=True, memory=memory)
    for is_warning, note in notes:
        if is_warning:
            warnings.warn(note, DataWarning, stacklevel=4)
    if core.kind != "volume":
        raise InvalidValue(f"source: {keys['file']} is a file of kind {core.kind}, which has no chunks", field="source")
    return LazyVolume(core, keys, memory)


def _of_mapping(mapping: Mapping[str, Any]) -> Get:
    """A mapping has whole objects only."""

    def get(key: str, start: int, length: int | None) -> bytes | None:
        found = mapping.get(key)
        if found is None:
            return None
        whole = bytes(found)
        return whole[start:] if length is None else whole[start : start + length]

    return get


def _of_file_system(fs: Any, root: str) -> Get:
    """A folder of fsspec: byte ranges are asked for."""

    def get(key: str, start: int, length: int | None) -> bytes | None:
        end = None if length is None else start + length
        try:
            return bytes(fs.cat_file(f"{root}/{key}", start=start or None, end=end))
        except (FileNotFoundError, IsADirectoryError, NotADirectoryError):
            return None

    return get


class _Arrays:
    """Arrays as the keys of an OME-Zarr image, of which samples are taken when a key is asked for."""

    def __init__(self, levels: Sequence[Any], spacing: Lengths) -> None:
        for number, level in enumerate(levels):
            shape, dtype = getattr(level, "shape", None), getattr(level, "dtype", None)
            if dtype is None or shape is None or len(shape) != 3 or 0 in shape:
                what = f"{type(level).__name__} of shape {shape}"
                raise InvalidValue(f"source: level {number} is no array with axes z, y, x, but {what}", field="source")
            _unmasked(level)
        if not levels:
            raise InvalidValue("source: no levels", field="source")
        self.levels = levels
        self.chunks = [self._chunk(level) for level in levels]
        x, y, z = steps_of(spacing, "zyx")
        self.spacing = (z, y, x)

    @staticmethod
    def _chunk(level: Any) -> tuple[int, ...]:
        own = getattr(level, "chunksize", None) or getattr(level, "chunks", None)
        if own is None or not all(isinstance(size, int) for size in own):
            own = (CHUNK,) * 3
        return tuple(min(int(size), side) for size, side in zip(own, level.shape, strict=True))

    def get(self, key: str, start: int, length: int | None) -> bytes | None:
        whole = self._whole(key)
        if whole is None:
            return None
        return whole[start:] if length is None else whole[start : start + length]

    def _whole(self, key: str) -> bytes | None:
        folder, _, file = key.rpartition("/")
        if key == ".zattrs":
            return json.dumps(self._attributes()).encode()
        if not folder.isdigit() or int(folder) >= len(self.levels):
            return None
        level, chunk = self.levels[int(folder)], self.chunks[int(folder)]
        if file == ".zarray":
            return json.dumps(self._metadata(level, chunk)).encode()
        numbers = file.split(".")
        if len(numbers) != 3 or not all(number.isdigit() for number in numbers):
            return None
        return self._samples(level, chunk, [int(number) for number in numbers])

    def _attributes(self) -> dict[str, Any]:
        def dataset(number: int) -> dict[str, Any]:
            ratios = [a / b for a, b in zip(self.levels[0].shape, self.levels[number].shape, strict=True)]
            scale = [step * ratio for step, ratio in zip(self.spacing, ratios, strict=True)]
            # All levels lie in the same box.
            offset = [0.5 * (own - step) for own, step in zip(scale, self.spacing, strict=True)]
            steps = [{"type": "scale", "scale": scale}, {"type": "translation", "translation": offset}]
            return {"path": str(number), "coordinateTransformations": steps}

        axes = [{"name": name, "type": "space"} for name in "zyx"]
        datasets = [dataset(number) for number in range(len(self.levels))]
        return {"multiscales": [{"version": "0.4", "axes": axes, "datasets": datasets}]}

    @staticmethod
    def _metadata(level: Any, chunk: tuple[int, ...]) -> dict[str, Any]:
        return {
            "zarr_format": 2,
            "shape": [int(side) for side in level.shape],
            "chunks": list(chunk),
            "dtype": _little(level.dtype).str,
            "compressor": None,
            "fill_value": 0,
            "filters": None,
            "order": "C",
        }

    @staticmethod
    def _samples(level: Any, chunk: tuple[int, ...], numbers: list[int]) -> bytes | None:
        starts = [number * size for number, size in zip(numbers, chunk, strict=True)]
        if any(start >= side for start, side in zip(starts, level.shape, strict=True)):
            return None
        slices = tuple(slice(start, start + size) for start, size in zip(starts, chunk, strict=True))
        found = level[slices]
        # numpy would take dask's masks off.
        found = _unmasked(found.compute() if hasattr(found, "compute") else found)
        found = np.asarray(found).astype(_little(level.dtype), copy=False)
        if found.shape == chunk:
            return found.tobytes()
        padded = np.zeros(chunk, found.dtype)
        padded[tuple(slice(side) for side in found.shape)] = found
        return padded.tobytes()


def _unmasked(samples: Any) -> Any:
    """Samples of which none is masked.

    Raises
    ------
    InvalidValue
    """
    if isinstance(samples, np.ma.MaskedArray) and np.ma.getmaskarray(samples).any():
        message = "source: some samples are masked, and volumes that miss some are read whole: splatvol.Volume(array)"
        raise InvalidValue(message, field="source")
    return samples


def _little(dtype: Any) -> np.dtype[Any]:
    little: np.dtype[Any] = np.dtype(dtype).newbyteorder("<")
    return little
