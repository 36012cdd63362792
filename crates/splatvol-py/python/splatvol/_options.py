"""Keywords as tables of a document: those of the command, and Python's own for cameras, looks, light and clips."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from . import _core
from ._camera import Camera
from ._errors import InvalidValue
from ._look import Light, TransferFunction, _rgb, clips
from ._vocabulary import Keys, check, checked, plain, tables

if TYPE_CHECKING:
    from ._data import Data

#: Keywords beyond the document's keys.
OWN = ("camera", "clip", "norm", "vmin", "vmax")
#: Keywords that say how a file is read.
READING = [
    "kind",
    "dims",
    "dtype",
    "spacing",
    "endian",
    "offset",
    "array",
    "component",
    "channel",
    "time",
    "level",
    "series",
    "solution",
    "drape",
    "posts",
]


def document_of(options: Mapping[str, Any], data: Data | None) -> Keys:
    """Tables of keywords; the keys of an item are under ``"item"``.

    Raises
    ------
    UnknownKeyword, InvalidValue
    """
    check(options, OWN)
    given = {name: value for name, value in options.items() if value is not None}
    own = {name: given.pop(name) for name in (*OWN, "tf", "cmap", "opacity", "light", "size", "color") if name in given}
    if isinstance(given.get("clim"), str):
        word = given.pop("clim")
        if word != "auto":
            raise InvalidValue('clim: expected (low, high) or "auto"', field="clim", value=options["clim"])
    document = tables(given)
    item = document.setdefault("item", {})
    _add_look(item, own, data)
    if "color" in own:
        item["color"] = _rgb(own["color"])
    if "size" in own:
        document["size"] = checked("size", _size(own["size"]))
    if "camera" in own:
        document["camera"] = {**document.get("camera", {}), **_camera(own["camera"])}
    if "clip" in own:
        document["effects"] = {**document.get("effects", {}), **clips(own["clip"])}
    if "light" in own:
        document["settings"] = {**document.get("settings", {}), **_light(own["light"])}
    return {table: keys for table, keys in document.items() if keys != {}}


def item_keys(options: Mapping[str, Any], data: Data | None) -> tuple[Keys, Keys]:
    """Keys of an item, and the rest of the document, of keywords."""
    document = document_of(options, data)
    item: Keys = document.pop("item", {})
    return item, document


def _size(size: Any) -> str:
    """The document's form of a size: one number for both, or width and height."""
    if isinstance(size, str):
        return size
    numbers = plain(size)
    both = [numbers, numbers] if isinstance(numbers, int) else list(numbers)
    return "x".join(str(number) for number in both)


def _camera(camera: Any) -> Keys:
    if isinstance(camera, Camera):
        return camera._keys()
    raise InvalidValue(
        f"camera: expected a splatvol.Camera, not {type(camera).__name__}: Camera(position, target, up)",
        field="camera",
    )


def _light(light: Any) -> Keys:
    if isinstance(light, Light):
        return light._keys()
    if isinstance(light, bool):
        return {"shade": light}
    return Light(direction=checked("light", plain(light)))._keys()


def _add_look(item: Keys, own: Keys, data: Data | None) -> None:
    """Colours and opacities: names go to the document as they are, all else as a transfer function."""
    if "vmin" in own or "vmax" in own:
        if "clim" in item:
            raise InvalidValue("clim: write vmin and vmax, or clim", field="clim")
        item["clim"] = list(_range(own.get("vmin"), own.get("vmax"), data))
    tf, cmap, opacity, norm = (own.get(name) for name in ("tf", "cmap", "opacity", "norm"))
    if isinstance(tf, TransferFunction):
        item["transfer-function"] = tf._document()
        return
    if tf is not None:
        item["tf"] = plain(tf)
    named = cmap is None or (isinstance(cmap, str) and _core.colormap(cmap, 2) is not None)
    plain_opacity = opacity is None or isinstance(opacity, (str, int, float))
    if norm is None and named and plain_opacity:
        plain_look = {"cmap": cmap, "opacity": opacity}
        item.update({key: checked(key, value) for key, value in plain_look.items() if value is not None})
        return
    clim = tuple(item.pop("clim", None) or _range(getattr(norm, "vmin", None), getattr(norm, "vmax", None), data))
    made = TransferFunction.from_cmap(
        "viridis" if cmap is None else cmap,
        (clim[0], clim[1]),
        "linear" if opacity is None else opacity,
        norm=norm,
        unit_distance=item.pop("unit-distance", None),
    )
    item["transfer-function"] = made._document()


def _range(low: Any, high: Any, data: Data | None) -> tuple[float, float]:
    """Ends of a colour map; those of the data where they are left out."""
    if low is None or high is None:
        if data is None or data._describe().get("range") is None:
            raise InvalidValue("clim: the data have no range of values: write clim=(low, high)", field="clim")
        least, most = data._describe()["range"]
        low, high = least if low is None else low, most if high is None else high
    return float(low), float(high)
