"""Arrays as volumes: names of axes, types, memory. Nothing is guessed, and nothing is copied that need not be."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _checks
from ._errors import DataWarning, InvalidValue

#: Types that the engine reads as they are.
AS_THEY_ARE = ("uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64")


def on_cpu(data: Any) -> Any:
    """Data that numpy reads: tensors as arrays of the same memory.

    Raises
    ------
    TypeError
        Tensors on a GPU; the message says what to write.
    """
    if getattr(getattr(data, "device", None), "type", "cpu") != "cpu":
        raise TypeError(f"the tensor is on {data.device}: write tensor.cpu() to bring it here")
    if hasattr(data, "__cuda_array_interface__"):
        raise TypeError("the array is on a GPU: write cupy.asnumpy(array), or .get(), to bring it here")
    if hasattr(data, "detach") and hasattr(data, "__dlpack__"):
        return np.from_dlpack(data.detach())
    return data


def samples_of(data: Any, *, copy: bool | None = None) -> np.ndarray[Any, Any]:
    """An array of a type that the engine reads; missing samples are NaN.

    Raises
    ------
    TypeError
        What holds no real numbers; the message says what to write.
    """
    mask = np.ma.getmaskarray(data) if isinstance(data, np.ma.MaskedArray) and data.mask is not np.ma.nomask else None
    array = np.asarray(data)
    array = _known_type(array)
    if mask is not None and mask.any():
        # Missing samples are NaN, which whole numbers do not have; float32 has all whole numbers of up to 24 bits.
        wide = array.dtype.kind == "f" or array.dtype.itemsize < 4
        array = array.astype(np.float32 if wide and array.dtype != np.float64 else np.float64)
        array[mask] = np.nan
    elif copy:
        array = array.copy()
    return array


def unmasked(values: Any, field: str) -> Any:
    """Numbers of which none is masked.

    Raises
    ------
    InvalidValue
    """
    if isinstance(values, np.ma.MaskedArray):
        if np.ma.getmaskarray(values).any():
            message = f"{field}: some are masked: leave those out, values[~mask], or write values.filled(...)"
            raise InvalidValue(message, field=field)
        return values.data
    return values


def numbers(values: Any, dtype: npt.DTypeLike, field: str) -> npt.NDArray[Any]:
    """An array of numbers, aligned and in C order, that are not masked.

    Raises
    ------
    InvalidValue
    """
    values = unmasked(values, field)
    try:
        return np.require(np.asarray(values, dtype=dtype), requirements=["C", "A"])
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidValue(f"{field}: {error}", field=field) from None


def _known_type(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    kind, name = array.dtype.kind, array.dtype.name
    if array.dtype.names is not None:
        fields = ", ".join(array.dtype.names)
        raise TypeError(f"a structured array is not a volume: choose a field, array['...'], of {fields}")
    if kind == "c":
        raise TypeError("complex samples have no colour of their own: write np.abs(array) or np.angle(array)")
    if kind in "OSUV":
        raise TypeError(f"an array of dtype {name} holds no numbers: write array.astype(np.float32)")
    if kind in "mM":
        raise TypeError(f"an array of dtype {name} holds times: write array.astype(np.float64)")
    if not array.dtype.isnative:
        array = array.astype(array.dtype.newbyteorder("="))
    # A type that spells this processor's byte order out is the same type, but not to the buffer protocol.
    array = array.view(array.dtype.newbyteorder("="))
    if kind == "b":
        return array.view(np.uint8)
    if name == "float16":
        return array.astype(np.float32)
    if name in ("int64", "uint64"):
        return _narrowed(array)
    if name not in AS_THEY_ARE:
        return array.astype(np.float64)
    return array


def _narrowed(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """64-bit whole numbers in 32 bits, where they fit."""
    if array.size == 0:
        return array.astype(np.int32)
    low, high = array.min(), array.max()
    for narrow in (np.uint32, np.int32):
        if np.iinfo(narrow).min <= low and high <= np.iinfo(narrow).max:
            return array.astype(narrow)
    warnings.warn(f"{array.dtype.name} values beyond 32 bits become float64", DataWarning, stacklevel=4)
    return array.astype(np.float64)


def check_axes(axes: str, ndim: int) -> None:
    """Refuses names of axes that are not x, y and z in some order, or not as many as the array has.

    Raises
    ------
    InvalidValue
        With what to write.
    """
    if not isinstance(axes, str):
        raise _checks.refused("axes", axes, 'x, y and z in some order, as "zyx"')
    if len(axes) != ndim:
        choose = "choose one, array[0], or write splatvol.Series" if ndim > 3 else "a volume has three"
        message = f"axes={axes!r} names {len(axes)} axes, and the array has {ndim}: {choose}"
        raise InvalidValue(message, field="axes", value=axes)
    if sorted(axes) != ["x", "y", "z"]:
        message = f'axes={axes!r} is not x, y and z in some order: the default is "zyx", nibabel\'s is "xyz"'
        raise InvalidValue(message, field="axes", value=axes)


def in_order(array: np.ndarray[Any, Any], axes: str) -> np.ndarray[Any, Any]:
    """The array with axes z, y, x in C order, aligned; a view where its memory allows one."""
    turned = array.transpose([axes.index(axis) for axis in "zyx"])
    return np.require(turned, requirements=["C", "A"])


Lengths = float | Sequence[float] | Mapping[str, float] | npt.NDArray[Any] | None


def by_axis(lengths: Lengths, axes: str, default: float, name: str) -> list[float]:
    """One number for x, y and z each: from one for all, one for each of `axes`, or by the axes' names.

    Raises
    ------
    InvalidValue
        Another number of numbers, or names of other axes.
    """
    if lengths is None:
        return [default] * 3
    if isinstance(lengths, Mapping):
        unknown = sorted(set(lengths) - set("xyz"))
        if unknown:
            raise InvalidValue(f"{name}: {unknown[0]!r} is no axis (x, y or z)", field=name, value=str(unknown[0]))
        return [_checks.number(lengths.get(axis, default), name) for axis in "xyz"]
    given: list[Any] = [lengths] if np.ndim(lengths) == 0 else list(lengths)  # type: ignore[arg-type]
    each = [_checks.number(length, name) for length in given]
    if len(each) == 1:
        each *= 3
    if len(each) != 3:
        message = f"{name}: {len(each)} numbers are not one for each axis of {axes!r}"
        raise InvalidValue(message, field=name, value=str(lengths))
    return [each[axes.index(axis)] for axis in "xyz"]


def steps_of(spacing: Lengths, axes: str) -> list[float]:
    """World lengths between samples along x, y, z; 1 by default.

    Raises
    ------
    InvalidValue
        As for :func:`by_axis`, and lengths that are not above 0: an affine map mirrors.
    """
    steps = by_axis(spacing, axes, 1.0, "spacing")
    if not all(step > 0 for step in steps):
        raise _checks.refused("spacing", spacing, "above 0 (affine= mirrors)")
    return steps


def world_from_index(affine: Any, axes: str, spacing: Lengths, origin: Lengths) -> list[list[float]]:
    """Rows of the map from an index x, y, z to the world.

    `affine` is 4x4 or 3x4 with columns in the order of `axes`, and then the origin.

    Raises
    ------
    InvalidValue
        An affine map of another shape, or beside spacing or origin.
    """
    if affine is None:
        steps = steps_of(spacing, axes)
        first = by_axis(origin, axes, 0.0, "origin")
        return [[steps[row] * (row == column) for column in range(3)] + [first[row]] for row in range(3)]
    if spacing is not None or origin is not None:
        raise InvalidValue("affine= says spacing and origin already: leave those out", field="affine")
    rows = numbers(affine, float, "affine")
    if rows.shape not in ((4, 4), (3, 4)):
        raise InvalidValue(f"affine: its shape {rows.shape} is not (4, 4) or (3, 4)", field="affine")
    columns = [axes.index(axis) for axis in "xyz"] + [3]
    ordered: list[list[float]] = rows[:3, columns].tolist()
    return ordered
