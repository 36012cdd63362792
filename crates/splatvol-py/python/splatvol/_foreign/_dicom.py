"""Data sets of pydicom: slices, one each or many in one, arranged as the command arranges files."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .._data import Volume
from .._errors import DataWarning, InvalidValue

#: Greatest distance of a slice from its place, in steps.
TOLERANCE = 0.25
Vector = npt.NDArray[np.float64]


def from_dicom(datasets: Any, *, time: int | None = None) -> Volume:
    """A volume of pydicom's data sets: slices in any order, or one data set of one or many frames.

    Parameters
    ----------
    datasets : pydicom.Dataset, or a list of them
        Of one series.
    time : int, optional
        Which of the slices at each place: 0, the first, by default.

    Raises
    ------
    InvalidValue
        Slices of different sizes or directions, colours, or gaps between slices.
    """
    sets = [datasets] if hasattr(datasets, "PixelData") or hasattr(datasets, "Rows") else list(datasets)
    frames = [frame for dataset in sets for frame in _frames(dataset)]
    if not frames:
        raise InvalidValue("data: a list of no data sets", field="data")
    first = frames[0]
    odd = next((frame for frame in frames if frame.pixels.shape != first.pixels.shape), None)
    if odd is not None:
        message = f"slices of {first.pixels.shape} and {odd.pixels.shape} pixels are not one series"
        raise InvalidValue(message, field="Rows, Columns", value=str(odd.pixels.shape))
    if any(not np.allclose(frame.directions, first.directions, atol=1e-3) for frame in frames):
        message = "slices of several directions are not one series: choose by ImageOrientationPatient"
        raise InvalidValue(message, field="ImageOrientationPatient")
    placed = first.is_oriented and all(frame.position is not None for frame in frames)
    ordered, step, start = _placed(frames, time) if placed else _numbered(frames)
    affine = np.eye(4)
    affine[:3, 0], affine[:3, 1] = first.directions * first.spacing[:, None]
    affine[:3, 2], affine[:3, 3] = step, start
    affine = np.diag([-1.0, -1.0, 1.0, 1.0]) @ affine
    array, rescale = _samples(ordered)
    name = str(getattr(sets[0], "SeriesDescription", "")) or None
    unit = "mm" if first.has_spacing else None
    columns = affine[:, [2, 1, 0, 3]]
    return Volume(array, axes="zyx", affine=columns, unit=unit, rescale=rescale, name=name, oriented=placed)


@dataclass(frozen=True)
class Frame:
    """Samples of a slice, and what its head says; directions and spacing are those of columns, then rows."""

    pixels: npt.NDArray[Any]
    position: Vector | None
    directions: Vector
    is_oriented: bool
    spacing: Vector
    has_spacing: bool
    thickness: float
    rescale: tuple[float, float]
    order: int

    @property
    def normal(self) -> Vector:
        """Across the slice."""
        across = np.cross(self.directions[0], self.directions[1])
        return np.asarray(across / np.linalg.norm(across))


def _frames(dataset: Any) -> list[Frame]:
    if int(getattr(dataset, "SamplesPerPixel", 1)) != 1:
        raise InvalidValue("the data set has colours: grey values are read", field="SamplesPerPixel")
    pixels = _stored(dataset)
    own = getattr(dataset, "PerFrameFunctionalGroupsSequence", None) or []
    shared = list(getattr(dataset, "SharedFunctionalGroupsSequence", None) or [])[:1]
    many = pixels if pixels.ndim == 3 else pixels[None]
    return [_frame(dataset, [*own[i : i + 1], *shared], frame, i) for i, frame in enumerate(many)]


def _stored(dataset: Any) -> npt.NDArray[Any]:
    """The samples of a data set, high ones bright."""
    pixels: npt.NDArray[Any] = dataset.pixel_array
    stored = int(dataset.BitsStored)
    spare = pixels.dtype.itemsize * 8 - stored
    if spare > 0 and int(dataset.HighBit) == stored - 1:
        # Bits above the stored ones may hold other things.
        pixels = (pixels << spare) >> spare
    if str(getattr(dataset, "PhotometricInterpretation", "")) == "MONOCHROME1":
        pixels = ~pixels if pixels.dtype.kind == "i" else pixels.dtype.type((1 << stored) - 1) - pixels
    return pixels


def _frame(dataset: Any, groups: list[Any], pixels: npt.NDArray[Any], index: int) -> Frame:
    def find(group: str, name: str) -> Any:
        for holder in groups:
            sequence = getattr(holder, group, None)
            if sequence and getattr(sequence[0], name, None) is not None:
                return getattr(sequence[0], name)
        return getattr(dataset, name, None)

    position = find("PlanePositionSequence", "ImagePositionPatient")
    directions = find("PlaneOrientationSequence", "ImageOrientationPatient")
    spacing = find("PixelMeasuresSequence", "PixelSpacing") or getattr(dataset, "ImagerPixelSpacing", None)
    steps = np.asarray(spacing or (1.0, 1.0), dtype=float)[::-1]
    measures = [find("PixelMeasuresSequence", name) for name in ("SpacingBetweenSlices", "SliceThickness")]
    lengths = [abs(float(length)) for length in measures if length]
    slope = find("PixelValueTransformationSequence", "RescaleSlope")
    intercept = find("PixelValueTransformationSequence", "RescaleIntercept")
    return Frame(
        pixels=pixels,
        position=None if position is None else np.asarray(position, dtype=float),
        directions=np.asarray(directions or (1, 0, 0, 0, 1, 0), dtype=float).reshape(2, 3),
        is_oriented=directions is not None,
        spacing=steps,
        has_spacing=spacing is not None,
        thickness=next((length for length in lengths if length > 0), float(steps[0])),
        rescale=(1.0 if slope is None else float(slope), 0.0 if intercept is None else float(intercept)),
        order=int(getattr(dataset, "InstanceNumber", None) or 0) + index,
    )


def _numbered(frames: list[Frame]) -> tuple[list[Frame], Vector, Vector]:
    """Slices without places, in the order of their numbers."""
    ordered = sorted(frames, key=lambda frame: frame.order)
    return ordered, np.array([0.0, 0.0, frames[0].thickness]), np.zeros(3)


def _placed(frames: list[Frame], time: int | None) -> tuple[list[Frame], Vector, Vector]:
    """Slices along the normal, one at each place; the mean step; the first place."""
    normal = frames[0].normal
    heights = np.array([frame.position @ normal for frame in frames])  # type: ignore[operator]
    same = 0.01 * np.ptp(heights) / len(frames)
    places: list[list[int]] = []
    for i in np.argsort(heights, kind="stable"):
        if places and heights[i] - heights[places[-1][0]] <= same:
            places[-1].append(int(i))
        else:
            places.append([int(i)])
    for place in places:
        place.sort(key=lambda i: (frames[i].order, i))
    times = min(map(len, places))
    if any(len(place) != times for place in places):
        left = len(frames) - len(places)
        warnings.warn(f"{left} slices lie where another one lies and are left out", DataWarning, stacklevel=4)
        times = 1
    if not 0 <= (time or 0) < times:
        raise InvalidValue(f"time: {time} is not there, there are {times}", field="time", value=str(time))
    ordered = [frames[place[time or 0]] for place in places]
    at = np.array([frame.position for frame in ordered])
    if len(ordered) == 1:
        return ordered, normal * ordered[0].thickness, at[0]
    step = (at[-1] - at[0]) / (len(ordered) - 1)
    away = np.linalg.norm(at - at[0] - step * np.arange(len(ordered))[:, None], axis=1)
    if away.max() > TOLERANCE * (step @ normal):
        gaps = ", ".join(f"{gap:g}" for gap in np.unique(np.round(np.diff(at @ normal), 3))[:6])
        message = f"the slices are not evenly spaced, their distances are {gaps}: one may be missing"
        raise InvalidValue(message, field="ImagePositionPatient", value=gaps)
    return ordered, step, at[0]


def _samples(frames: Iterable[Frame]) -> tuple[npt.NDArray[Any], tuple[float, float]]:
    """Stored samples and their scale; scaled ones where slices have scales of their own."""
    frames = list(frames)
    rescale = frames[0].rescale
    if rescale[0] != 0 and all(frame.rescale == rescale for frame in frames):
        return np.stack([frame.pixels for frame in frames]), rescale
    scaled = [frame.pixels * frame.rescale[0] + frame.rescale[1] for frame in frames]
    return np.stack(scaled).astype(np.float32), (1.0, 0.0)
