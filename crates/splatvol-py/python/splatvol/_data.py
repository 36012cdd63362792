"""Data: volumes, meshes, points, Gaussians, in memory."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
import numpy.typing as npt

from . import _arrays, _checks, _core
from ._errors import DataWarning, InvalidValue
from ._from_others import FromOthers

if TYPE_CHECKING:
    from ._frame import Frame
    from ._render_options import RenderOptions
    from ._widget import Widget

Progress = Callable[[float], object]

#: Names of types, as Rust has them and as numpy has them.
TYPES = {
    "u8": "uint8",
    "i8": "int8",
    "u16": "uint16",
    "i16": "int16",
    "u32": "uint32",
    "i32": "int32",
    "f32": "float32",
    "f64": "float64",
}


@dataclass(frozen=True)
class Rules:
    """What is refused when files are read: the command's flags of these names."""

    #: Whether oddities of a file are errors.
    strict: bool = False
    #: Whether links are followed that lead out of the folder of the file.
    allow_outside: bool = False
    #: Most bytes of samples; half of the machine's memory by default.
    max_memory: int | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "max_memory", _checks.memory(self.max_memory, "max_memory"))

    def _asked(self) -> dict[str, Any]:
        """The rules that somebody asked for."""
        return {field.name: value for field in fields(self) if (value := getattr(self, field.name)) != field.default}


#: The rules where nobody asks for others.
RULES = Rules()


#: Most bins of a histogram.
MOST_BINS = 1 << 24


class Data:
    """Data that can be shown: what :func:`splatvol.read` returns."""

    def __init__(self, core: _core.Data, keys: dict[str, Any], rules: Rules = RULES) -> None:
        self._core = core
        #: Keys by which a document names the data: the file, and how it is read.
        self._keys = keys
        self._rules = rules
        self._known: dict[str, Any] | None = None

    def _describe(self) -> dict[str, Any]:
        if self._known is None:
            self._known = self._core.describe()
        return self._known

    @property
    def kind(self) -> str:
        """volume, points, terrain, depth-images, gaussians or mesh."""
        return self._core.kind

    @property
    def name(self) -> str:
        """Name of the file or of the array."""
        return os.path.basename(str(self._keys["file"]).removeprefix("array:"))

    @property
    def source(self) -> str | None:
        """The file that the data were read from."""
        file = str(self._keys["file"])
        return None if file.startswith("array:") else file

    @property
    def warnings(self) -> list[str]:
        """Oddities of the file that did not prevent reading."""
        return list(self._describe()["warnings"])

    def render(self, **options: Unpack[RenderOptions]) -> Frame:
        """Renders the data: see :func:`splatvol.render`."""
        from ._scene import Scene

        return Scene(self, **options).render()

    def show(self, **options: Unpack[RenderOptions]) -> Widget:
        """Shows the data in a notebook: see :func:`splatvol.show`."""
        from ._verbs import show

        return show(self, **options)

    def __reduce__(self) -> tuple[object, ...]:
        if self.source is None:
            raise TypeError(f"{type(self).__name__} of arrays are not pickled: send the arrays")
        return _read_again, (self._keys, self._rules)


def _read_again(keys: dict[str, Any], rules: Rules = RULES) -> Data:
    return read_item(keys, rules)


def read_item(
    keys: dict[str, Any],
    rules: Rules = RULES,
    *,
    progress: Progress | None = None,
    stop: _core.Stop | None = None,
    in_chunks: Callable[[_core.Data, dict[str, Any]], Data] | None = None,
) -> Data:
    """Reads what the keys of an item name; with `in_chunks`, which makes them, volumes in chunks as the command."""
    limits = (rules.strict, rules.allow_outside, rules.max_memory)
    core, notes = _core.Data.read(json.dumps(keys), limits, stop, progress, lazy=in_chunks is not None)
    for is_warning, note in notes:
        if is_warning:
            warnings.warn(note, DataWarning, stacklevel=3)
    if in_chunks is not None and core.in_chunks:
        return in_chunks(core, keys)
    kinds: dict[str, type[Data]] = {"volume": Volume, "mesh": Mesh, "gaussians": Gaussians}
    found = kinds.get(core.kind, Points)
    data = found.__new__(found)
    Data.__init__(data, core, keys, rules)
    return data


class Volume(FromOthers, Data):
    """Samples on a regular grid.

    Parameters
    ----------
    data : array
        Samples. Arrays in C order with x last, or in Fortran order with x first, are not copied. Do not write to
        the array while a picture is made, and call :meth:`touch` after writing.
    axes : str
        What the array's axes are, in their order: ``"zyx"``, or ``"xyz"`` as in nibabel. Never guessed.
    spacing, origin : float, sequence or dict, optional
        World length between samples, and the world place of the first one: one number, one for each axis in the
        order of `axes`, or ``{"x": 0.5}``. By default 1, and the origin lies so that the volume is centred. Spacings
        are above 0.
    affine : array, optional
        4x4, world from index, with columns in the order of `axes`; the volume then lies as it says, z upwards.
    unit : str, optional
        ``"m"``, ``"mm"``, ``"um"`` or ``"nm"``.
    name : str, optional
        What it is called.
    copy : bool, optional
        Whether the array is copied: by default only where its memory cannot be shared; with ``False`` that is an error.
    rescale : (slope, intercept)
        Values are ``slope * sample + intercept``.
    oriented : bool, optional
        Whether the world's z is up: by default where an affine map is given. Otherwise a volume that stands on a
        heavy base across y is turned, as the command does it with files that do not say how they lie.

    Raises
    ------
    TypeError
        What holds no real numbers.
    InvalidValue
        A keyword that does not fit the array, or a number that is not finite.

    Examples
    --------
    >>> import numpy as np, splatvol as sv
    >>> ball = sv.Volume(np.hypot.outer(np.arange(-8, 9), np.hypot.outer(np.arange(-8, 9), np.arange(-8, 9))))
    >>> ball.shape, ball.is_shared
    ((17, 17, 17), True)
    """

    def __init__(
        self,
        data: Any,
        *,
        axes: str = "zyx",
        spacing: _arrays.Lengths = None,
        origin: _arrays.Lengths = None,
        affine: Any = None,
        unit: str | None = None,
        name: str | None = None,
        copy: bool | None = None,
        rescale: Sequence[float] | npt.NDArray[Any] = (1.0, 0.0),
        oriented: bool | None = None,
    ) -> None:
        data = _arrays.on_cpu(data)
        array = _arrays.samples_of(data, copy=copy)
        _arrays.check_axes(axes, array.ndim)
        if array.size == 0:
            raise InvalidValue(f"data: an array of shape {array.shape} has no samples", field="data")
        ordered = _arrays.in_order(array, axes)
        shared = isinstance(data, np.ndarray) and np.shares_memory(ordered, data)
        if copy is False and not shared:
            aligned = "" if array.flags.aligned else ", not aligned,"
            message = f"copy=False: {array.dtype.name} samples with strides {array.strides}{aligned} have to be copied"
            raise InvalidValue(message, field="copy", value="False")
        dims = (ordered.shape[2], ordered.shape[1], ordered.shape[0])
        if affine is None and origin is None:
            steps = _arrays.steps_of(spacing, axes)
            origin = {axis: -0.5 * (n - 1.0) * step for axis, n, step in zip("xyz", dims, steps, strict=True)}
        rows = _arrays.world_from_index(affine, axes, spacing, origin)
        is_oriented = affine is not None if oriented is None else oriented
        linear = _checks.pair(rescale, "rescale", "two finite numbers, (slope, intercept)")
        core = _core.Data.volume(ordered, ordered.dtype.name, dims, rows, is_oriented, linear, unit)
        super().__init__(core, {"file": f"array:{name or 'volume'}"})
        self._array = ordered
        self._shared = shared

    @property
    def shape(self) -> tuple[int, int, int]:
        """Samples along z, y, x."""
        x, y, z = self._describe()["dims"]
        return (z, y, x)

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the samples."""
        return np.dtype(TYPES[self._describe()["dtype"]])

    @property
    def spacing(self) -> tuple[float, float, float]:
        """World length between samples along z, y, x."""
        x, y, z = self._describe()["spacing"]
        return (z, y, x)

    @property
    def affine(self) -> npt.NDArray[np.float64]:
        """4x4, world from index x, y, z."""
        return np.vstack([np.asarray(self._describe()["affine"]), [0.0, 0.0, 0.0, 1.0]])

    @property
    def unit(self) -> str:
        """Unit of world lengths; empty where it is unknown."""
        return str(self._describe()["unit"])

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest finite value."""
        low, high = self._describe()["range"]
        return (low, high)

    @property
    def nbytes(self) -> int:
        """Bytes of the samples."""
        return int(self._describe()["nbytes"])

    @property
    def is_shared(self) -> bool:
        """Whether the samples are those of the array that was given, not a copy."""
        return getattr(self, "_shared", False)

    def stats(self) -> dict[str, float]:
        """Least, greatest and mean value, and the number of missing samples."""
        low, high = self.range
        known = self._describe()
        return {"min": low, "max": high, "mean": known["mean"], "missing": known["missing"]}

    def __getitem__(self, slices: Any) -> Volume:
        """A part, with or without steps, at its place: slices along z, y, x."""
        slices = slices if isinstance(slices, tuple) else (slices,)
        if len(slices) > 3 or not all(isinstance(part, slice) for part in slices):
            raise InvalidValue("a part of a volume is a volume: write slices, as volume[3:4, :, ::2]", field="slices")
        slices = (*slices, *[slice(None)] * (3 - len(slices)))
        ends = [part.indices(n) for part, n in zip(slices, self.shape, strict=True)]
        affine = self.affine
        starts = [start for start, _, _ in ends[::-1]]
        affine[:3, 3] += affine[:3, :3] @ starts
        affine[:3, :3] *= [step for _, _, step in ends[::-1]]
        known = self._describe()
        return Volume(
            np.asarray(self)[slices],
            affine=affine[:, [2, 1, 0, 3]],
            unit=self.unit or None,
            name=self.name,
            rescale=tuple(known["rescale"]),
            oriented=known["is_oriented"],
        )

    def touch(self) -> None:
        """Says that the array was written to: pictures show what it holds now.

        Raises
        ------
        InvalidValue
            The samples are a file's, or a copy of the array's: make a new `Volume` of it.
        """
        if self.source is not None:
            raise InvalidValue("a file's samples are not written to", field="data")
        if not self.is_shared:
            message = "the samples are a copy, which does not change with the array: make a new Volume of it"
            raise InvalidValue(message, field="data")
        again = self.__reduce__()
        rebuilt: Volume = _volume_again(*again[1])  # type: ignore[misc]
        self._core, self._known = rebuilt._core, None

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes the volume, ``.nrrd`` with its place or ``.npy`` without: samples as they are stored."""
        self._core.write(os.fspath(path))
        return Path(path)

    def histogram(self, bins: int = 256) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
        """Counts of the values in equal bins over their range, and the edges of the bins, as numpy's.

        Raises
        ------
        InvalidValue
            `bins` that is no whole number from 1 to 2^24.
        """
        bins = _checks.whole(bins, "bins", 1, MOST_BINS, "a whole number from 1 to 2^24")
        low, high = self.range
        return np.asarray(self._core.histogram(bins), dtype=np.int64), np.linspace(low, high, bins + 1)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        array = getattr(self, "_array", None)
        if array is None:
            array = np.frombuffer(self._core.sample_bytes(), self.dtype).reshape(self.shape)
            self._array = array
        result: npt.NDArray[Any] = array if dtype is None else array.astype(dtype, copy=False)
        return result.copy() if copy else result

    def __reduce__(self) -> tuple[object, ...]:
        if self.source is not None:
            return super().__reduce__()
        known = self._describe()
        return _volume_again, (
            np.asarray(self),
            self.affine,
            known["is_oriented"],
            tuple(known["rescale"]),
            self.unit,
            self._keys,
        )

    def __repr__(self) -> str:
        (nz, ny, nx), (dz, dy, dx), (low, high) = self.shape, self.spacing, self.range
        spacing = f"spacing z {dz:.4g} y {dy:.4g} x {dx:.4g} {self.unit}".rstrip()
        return f"<splatvol.Volume {self.name!r} {self.dtype}  z {nz} y {ny} x {nx}  {spacing}  {low:g} to {high:g}>"


def _volume_again(
    array: npt.NDArray[Any],
    affine: npt.NDArray[np.float64],
    is_oriented: bool,
    rescale: tuple[float, float],
    unit: str,
    keys: dict[str, Any],
) -> Volume:
    z, y, x = array.shape
    rows = affine[:3].tolist()
    array = np.ascontiguousarray(array)
    core = _core.Data.volume(array, array.dtype.name, (x, y, z), rows, is_oriented, rescale, unit)
    volume = Volume.__new__(Volume)
    Data.__init__(volume, core, keys)
    volume._array = array
    volume._shared = True
    return volume


class Points(Data):
    """Points of surfaces: rows of x y z, and where known colours, normals, and radii above 0.

    `rgb` are rows of red, green, blue, and opacity where there are four: whole numbers from 0 to 255, uint16 up to
    65535 if colours above 255 occur (as in LAS files), or numbers from 0 to 1. Coordinates are
    kept in 32 bits, around an origin of their own where they lie far from zero.

    `triangles`, rows of three indices of points, make them the corners of a surface: it becomes discs of the triangles'
    own places, sizes and normals, with colours and normals interpolated between the corners.

    Raises
    ------
    InvalidValue
        Other shapes or lengths, masked rows, colours outside their range.

    Examples
    --------
    >>> import numpy as np, splatvol as sv
    >>> sv.Points(np.random.default_rng(1).normal(size=(100, 3)))
    <splatvol.Points 'points' 100>
    """

    def __init__(
        self,
        xyz: Any,
        *,
        rgb: Any = None,
        radius: Any = None,
        normal: Any = None,
        triangles: Any = None,
        name: str | None = None,
    ) -> None:
        positions = _places(xyz, "xyz")
        count = len(positions)
        colors = None if rgb is None else _colors(rgb, count)
        normals = None if normal is None else _rows(normal, 3, "normal", count)
        radii = None if radius is None else _numbers(radius, count, "radius")
        if triangles is not None:
            if radius is not None:
                raise InvalidValue("radius: discs of triangles have the triangles' sizes", field="radius")
            triangles = _triangles(triangles, count)
        core = _core.Data.points(positions, colors, normals, radii, triangles)
        super().__init__(core, {"file": f"array:{name or 'points'}"})

    def __len__(self) -> int:
        return int(self._describe()["count"])

    def __repr__(self) -> str:
        return f"<splatvol.Points {self.name!r} {len(self)}>"


class Gaussians(Data):
    """3-D Gaussians: means, standard deviations along their own axes, quaternions w x y z, opacities, and colours.

    `colors` are rows of sRGB from 0 to 1, or coefficients of spherical harmonics, count x (degree + 1)^2 x 3, as `sh`.

    Raises
    ------
    InvalidValue
        Other shapes or lengths, masked rows.
    """

    #: The harmonic of degree 0.
    _CONSTANT = 0.28209479177387814

    def __init__(
        self,
        means: Any,
        quats_wxyz: Any,
        scales: Any,
        opacities: Any,
        *,
        sh: Any = None,
        colors: Any = None,
        name: str | None = None,
    ) -> None:
        means = _places(means, "means")
        count = len(means)
        if (sh is None) == (colors is None):
            raise InvalidValue("colors: write either colors or sh", field="colors")
        if sh is None:
            coefficients = (_rows(colors, 3, "colors", count)[:, None, :] - 0.5) / np.float32(self._CONSTANT)
        else:
            coefficients = _arrays.numbers(sh, np.float32, "sh")
        degree = round(coefficients.shape[1] ** 0.5) - 1 if coefficients.ndim == 3 else -1
        if degree < 0 or coefficients.shape != (count, (degree + 1) ** 2, 3):
            message = f"sh: its shape {coefficients.shape} is not ({count}, (degree + 1)^2, 3)"
            raise InvalidValue(message, field="sh")
        rotations = np.ascontiguousarray(_rows(quats_wxyz, 4, "quats_wxyz", count)[:, [1, 2, 3, 0]])
        core = _core.Data.gaussians(
            means,
            _rows(scales, 3, "scales", count),
            rotations,
            _numbers(opacities, count, "opacities"),
            (degree, np.ascontiguousarray(coefficients)),
        )
        super().__init__(core, {"file": f"array:{name or 'gaussians'}"})

    def __len__(self) -> int:
        return int(self._describe()["count"])

    def __repr__(self) -> str:
        return f"<splatvol.Gaussians {self.name!r} {len(self)}>"


class Mesh(Data):
    """Samples on an irregular grid: points, solid cells by VTK's types, and a value for each point or cell.

    `cells` are lists of points, `types` VTK's numbers of their kinds: 10 for tetrahedra, 12 for hexahedra. Without
    `types` cells of four points are tetrahedra, and of eight hexahedra.

    Raises
    ------
    InvalidValue
        Indices that are no points', other types than solid cells', or another number of types than of cells.
    """

    def __init__(self, points: Any, cells: Any, values: Any, *, types: Any = None, name: str = "values") -> None:
        positions = _places(points, "points")
        lists = [_indices(cell, len(positions)) for cell in cells]
        if types is None:
            known = {4: 10, 5: 14, 6: 13, 8: 12}
            unknown = next((len(cell) for cell in lists if len(cell) not in known), None)
            if unknown is not None:
                raise InvalidValue(f"cells: one has {unknown} points: write types=", field="types")
            types = [known[len(cell)] for cell in lists]
        codes = [_checks.whole(code, "types", 0, 255, "a type of VTK's cells, as 10 or 12") for code in types]
        if len(codes) != len(lists):
            raise InvalidValue(f"types: {len(codes)} types for {len(lists)} cells", field="types")
        offsets = np.cumsum([0, *map(len, lists)], dtype=np.uint32)
        connectivity = np.concatenate(lists) if lists else np.zeros(0, np.uint32)
        field = _arrays.numbers(values, np.float32, "values").ravel()
        of_cells = len(field) == len(lists) != len(positions)
        core = _core.Data.mesh(
            positions, (np.asarray(codes, dtype=np.uint8), offsets, connectivity), field, name, of_cells
        )
        super().__init__(core, {"file": f"array:{name}"})

    def __repr__(self) -> str:
        known = self._describe()
        return f"<splatvol.Mesh {self.name!r} {known['count']} cells {known['points']} points>"


def _places(values: Any, field: str) -> npt.NDArray[np.float64]:
    places: npt.NDArray[np.float64] = _arrays.numbers(values, np.float64, field)
    if places.ndim != 2 or places.shape[1] != 3:
        raise InvalidValue(f"{field}: its shape {places.shape} is not (count, 3)", field=field)
    return places


def _rows(values: Any, width: int, field: str, count: int | None = None) -> npt.NDArray[np.float32]:
    rows: npt.NDArray[np.float32] = _arrays.numbers(values, np.float32, field)
    if rows.ndim != 2 or rows.shape[1] != width:
        raise InvalidValue(f"{field}: its shape {rows.shape} is not (count, {width})", field=field)
    if count is not None and len(rows) != count:
        raise InvalidValue(f"{field}: there are {len(rows)} rows for {count}", field=field)
    return rows


def _indices(cell: Any, count: int) -> npt.NDArray[np.uint32]:
    """Points of a cell."""
    found = np.asarray(cell)
    if found.ndim != 1 or found.dtype.kind not in "iu" or found.size == 0:
        raise _checks.refused("cells", cell, "a list of the cell's points")
    if found.min() < 0 or found.max() >= count:
        message = f"cells: {found.min()} to {found.max()} are no indices of {count} points"
        raise InvalidValue(message, field="cells")
    return found.astype(np.uint32)


def _triangles(values: Any, count: int) -> npt.NDArray[np.uint32]:
    triangles = np.asarray(_arrays.unmasked(values, "triangles"))
    if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu":
        message = f"triangles: shape {triangles.shape} and type {triangles.dtype} are not (count, 3) of integers"
        raise InvalidValue(message, field="triangles")
    if triangles.size and not (triangles.min() >= 0 and triangles.max() < count):
        message = f"triangles: {triangles.min()} to {triangles.max()} are no indices of {count} points"
        raise InvalidValue(message, field="triangles")
    return np.ascontiguousarray(triangles, dtype=np.uint32)


def _numbers(values: Any, count: int, field: str) -> npt.NDArray[np.float32]:
    """A number for each, or one for all."""
    numbers = _arrays.numbers(values, np.float32, field)
    if numbers.shape not in ((), (1,), (count,)):
        message = f"{field}: its shape {numbers.shape} is not ({count},), or one number for all"
        raise InvalidValue(message, field=field)
    return np.ascontiguousarray(np.broadcast_to(numbers, (count,)))


def _colors(values: Any, count: int) -> npt.NDArray[np.uint8]:
    """Red, green, blue, opacity of points, uint8."""
    colors = np.asarray(_arrays.unmasked(values, "rgb"))
    if colors.shape not in ((count, 3), (count, 4)):
        raise InvalidValue(f"rgb: its shape {colors.shape} is not ({count}, 3) or ({count}, 4)", field="rgb")
    if colors.dtype.kind not in "fiu":
        message = f"rgb: its type {colors.dtype} is neither whole numbers nor numbers from 0 to 1"
        raise InvalidValue(message, field="rgb", value=str(colors.dtype))
    filled = np.full((count, 4), 255, dtype=np.uint8)
    filled[:, : colors.shape[1]] = _codes(colors)
    return filled


def _codes(colors: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Colours as numbers from 0 to 255."""
    if colors.dtype == np.uint16 and colors.size and colors[:, :3].max() > 255:
        return (colors / 65535 * 255).round()
    most = 1 if colors.dtype.kind == "f" else 255
    # Rounding leads a little out of the range.
    slack = 1e-5 if colors.dtype.kind == "f" else 0
    if not ((colors >= -slack) & (colors <= most + slack)).all():
        message = f"rgb: {colors.min()} to {colors.max()} of type {colors.dtype} are not all from 0 to {most}"
        raise InvalidValue(message, field="rgb", value=str(colors.dtype))
    return (np.clip(colors, 0, 1) * 255).round() if colors.dtype.kind == "f" else colors
