"""Pictures that were rendered."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _checks, _core
from ._errors import InvalidValue

#: A picture in a notebook's file has at most so many bytes.
REPR_BYTES = 300_000


class Frame:
    """A picture: its codes are those of the PNG that the command writes.

    ``np.asarray(frame)`` is an array of uint8, height x width x 4: sRGB, straight alpha, the top row first. It is the
    picture's own, and read-only; ``np.array(frame)`` is a copy to write to.
    """

    def __init__(self, core: _core.Frame, document: str, bits: int) -> None:
        self._core = core
        self._document = document
        self._bits = bits
        self._codes: npt.NDArray[np.uint8] | None = None

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self._core.size

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of the array: height, width, 4."""
        width, height = self.size
        return (height, width, 4)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        if self._codes is None:
            self._codes = np.frombuffer(self._core.codes(), np.uint8).reshape(self.shape)
            self._codes.flags.writeable = False
        codes: npt.NDArray[Any] = self._codes
        if dtype is not None and np.dtype(dtype) != codes.dtype:
            if copy is False:
                raise ValueError(f"a picture of uint8 becomes {np.dtype(dtype)} only as a copy")
            return codes.astype(dtype)
        return codes.copy() if copy else codes

    @property
    def linear(self) -> npt.NDArray[np.float32]:
        """float32, height x width x 4: linear, premultiplied, without background.

        Pictures of 3-D Gaussians alone are blended with their background as they were published, and so hold it:
        ``background="none"`` leaves it out.
        """
        return np.frombuffer(self._core.linear(), np.float32).reshape(self.shape)

    @property
    def alpha(self) -> npt.NDArray[np.float32]:
        """float32, height x width: opacity of what is shown, without background."""
        return self.linear[..., 3]

    @property
    def depth(self) -> npt.NDArray[np.float32]:
        """float32, height x width: mean depth along the view, world lengths; infinite where there is nothing."""
        return np.frombuffer(self._core.depth(), np.float32).reshape(self.shape[:2])

    @property
    def optical_depth(self) -> npt.NDArray[np.float32]:
        """float32, height x width: ``-ln`` of the transmittance, exact also where alpha rounds to 1."""
        return np.frombuffer(self._core.optical_depth(), np.float32).reshape(self.shape[:2])

    @property
    def stats(self) -> dict[str, Any]:
        """Times and counts of the render."""
        return self._core.statistics()

    @property
    def document(self) -> str:
        """All that the picture was made by, JSON: what its file carries."""
        return self._document

    def save(self, path: str | os.PathLike[str], *, bits: int | None = None, overwrite: bool = True) -> Path:
        """Writes the picture: ``.png`` over its background, or ``.exr`` with floats, alpha and depth.

        The file carries the document, so that :func:`splatvol.like` and the command's ``--like`` make it again.
        """
        path = Path(path)
        if path.exists() and not overwrite:
            raise FileExistsError(f"{path} exists: overwrite=True replaces it")
        _replace(path, self._encoded(path.suffix.removeprefix("."), bits))
        return path

    def over(self, color: Any) -> npt.NDArray[np.uint8]:
        """The codes over another background: uint8, height x width x 3."""
        from ._look import _rgb

        srgb = np.asarray(_rgb(color))
        below = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
        linear = self.linear
        mixed = np.clip(linear[..., :3] + (1.0 - linear[..., 3:]) * below, 0.0, 1.0)
        codes = np.where(mixed <= 0.0031308, mixed * 12.92, 1.055 * mixed ** (1 / 2.4) - 0.055)
        return (codes * 255.0).round().astype(np.uint8)

    def to_pil(self) -> Any:
        """The picture as one of Pillow's."""
        from PIL import Image

        return Image.fromarray(np.asarray(self))

    def _encoded(self, extension: str, bits: int | None = None) -> bytes:
        if not extension:
            raise InvalidValue("path: the name has no extension (.png or .exr)", field="path")
        # A picture that was blended of several has no document.
        record = (self._document, "splatvol for Python") if self._document else None
        if bits is not None and (isinstance(bits, bool) or bits not in (8, 16)):
            raise _checks.refused("bits", bits, "8 or 16")
        return self._core.encode(extension, self._bits if bits is None else bits, record)

    def _repr_png_(self) -> bytes:
        return shown(self)

    def __repr__(self) -> str:
        width, height = self.size
        return f"<splatvol.Frame {width}x{height}>"

    def __reduce__(self) -> tuple[object, ...]:
        return _restored, (self._core.planes(), self._document, self._bits)


def _restored(planes: tuple[Any, ...], document: str, bits: int) -> Frame:
    return Frame(_core.Frame.from_planes(*planes), document, bits)


def shown(frame: Frame) -> bytes:
    """A PNG for a notebook: smaller, by whole factors, where the file would be large."""
    png = frame._core.encode("png", 8, None)
    step = 1
    while len(png) > REPR_BYTES and min(frame.size) // step > 64:
        step += 1
        png = frame._core.reduced_png(step)
    return png


def _replace(path: Path, data: bytes) -> None:
    """Writes all bytes, or leaves what was there."""
    folder = path.parent
    if not folder.is_dir():
        raise FileNotFoundError(f"folder {folder} does not exist")
    handle, scratch = tempfile.mkstemp(prefix=f".{path.name}.", dir=folder)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        mode = 0o666 & ~_umask()
        os.chmod(scratch, mode)
        os.replace(scratch, path)
    except BaseException:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(scratch)
        raise


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current
