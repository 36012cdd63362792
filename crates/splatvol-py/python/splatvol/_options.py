"""Keywords as tables of a document: those of the command, and Python's own for cameras, looks, light and clips."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from . import _checks, _core
from ._camera import Camera
from ._errors import InvalidValue
from ._look import CLIM, Light, TransferFunction, _rgb, clips, without_limits
from ._vocabulary import Keys, check, checked, is_allowed, plain, tables

if TYPE_CHECKING:
    from ._data import Data

#: Keywords beyond the document's keys.
OWN = ("camera", "clip", "norm", "vmin", "vmax")
#: Keywords of a look, and their keys in an item.
LOOK = {
    "tf": "tf",
    "cmap": "cmap",
    "clim": "clim",
    "vmin": "clim",
    "vmax": "clim",
    "norm": "transfer-function",
    "opacity": "opacity",
    "iso": "iso",
    "unit_distance": "unit-distance",
}
#: Keywords that go with a file of a transfer function.
BESIDE_FILE = ("clim", "vmin", "vmax", "unit_distance")
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


def document_of(options: Mapping[str, Any], data: Data | None, *, is_exact: bool = False) -> Keys:
    """Tables of keywords; the keys of an item are under ``"item"``. `is_exact`: surfaces lie at their exact places.

    Raises
    ------
    UnknownKeyword, InvalidValue
    """
    check(options, OWN)
    given = {name: value for name, value in options.items() if value is not None}
    if isinstance(given.get("clim"), str):
        word = given.pop("clim")
        if word != "auto":
            raise InvalidValue('clim: expected (low, high) or "auto"', field="clim", value=options["clim"])
    if "background" in given:
        given["background"] = _background(given["background"])
    own = {name: given.pop(name) for name in (*OWN, *LOOK, "light", "size", "color") if name in given}
    document = tables(given)
    item = document.setdefault("item", {})
    item.update(_look(own, data, is_exact=bool(given.get("iso_exact", is_exact))))
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


def item_keys(options: Mapping[str, Any], data: Data | None, *, is_exact: bool = False) -> tuple[Keys, Keys]:
    """Keys of an item, and the rest of the document, of keywords."""
    document = document_of(options, data, is_exact=is_exact)
    item: Keys = document.pop("item", {})
    return item, document


def _size(size: Any) -> str:
    """The document's form of a size: one number for both, or width and height."""
    if isinstance(size, str):
        return size
    numbers = plain(size)
    both = numbers if isinstance(numbers, list) else [numbers, numbers]
    if len(both) != 2 or not all(isinstance(number, int) and not isinstance(number, bool) for number in both):
        raise _checks.refused("size", size, "a whole number of pixels, or width and height")
    return "x".join(str(number) for number in both)


def _background(background: Any) -> Any:
    """The document's form of a background: its own names, or colours as they are written elsewhere."""
    if not isinstance(background, str) or is_allowed("background", background):
        return background
    try:
        return _rgb(background)
    except InvalidValue:
        # It is refused with the names that there are.
        return background


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


def over_look(said: Mapping[str, Any], options: Mapping[str, Any]) -> Keys:
    """The keywords of a look that is changed by others: these, and those that were said before and still hold.

    `None` leaves a keyword to be chosen from the data. A transfer function takes the place of all, another colour map
    or a surface that of a transfer function, and new limits those of a norm. What contradicts the rest is refused
    later, by :func:`document_of`.
    """
    asked = {name: options[name] for name in LOOK if name in options}
    if isinstance(asked.get("clim"), str) and asked["clim"] == "auto":
        asked["clim"] = None
    merged = {**_kept_limits(_kept_look(said, asked), asked), **asked}
    return {name: value for name, value in merged.items() if value is not None}


def _kept_look(said: Mapping[str, Any], asked: Keys) -> Keys:
    """What was said of a look, without that whose place others take."""
    new = {name for name, value in asked.items() if value is not None}
    gone: set[str] = set(LOOK) if "tf" in new else set()
    if "cmap" in new or ("iso" in new and "iso" not in said):
        gone.add("tf")
    if "iso" in new:
        gone.add("opacity")
    if "opacity" in new:
        gone.add("iso")
    return {name: value for name, value in said.items() if name not in gone}


def _kept_limits(said: Keys, asked: Keys) -> Keys:
    """What was said of a look, without limits that are said anew."""
    norm = asked.get("norm")
    ends = {end for end in ("vmin", "vmax") if "clim" in asked or end in asked}
    said_anew = ends | {end for end in ("vmin", "vmax") if getattr(norm, end, None) is not None}
    if not said_anew:
        return said
    if "clim" in said:
        said = {**said, **dict(zip(("vmin", "vmax"), said["clim"], strict=True))}
    if ends and norm is None and "norm" in said:
        said = {**said, "norm": without_limits(said["norm"], ends)}
    return {name: value for name, value in said.items() if name != "clim" and name not in said_anew}


def _look(own: Keys, data: Data | None, *, is_exact: bool) -> Keys:
    """Keys of colours and opacities: names go to the document as they are, all else as a transfer function."""
    given = {name: own[name] for name in LOOK if own.get(name) is not None}
    tf, cmap, norm = (given.get(name) for name in ("tf", "cmap", "norm"))
    opacity = plain(given["opacity"]) if "opacity" in given else None
    if tf is not None:
        _check_beside(tf, given, is_exact=is_exact)
    if isinstance(opacity, (int, float)):
        _checks.share(opacity, "opacity")
    unit = _checks.positive(given["unit_distance"], "unit_distance") if "unit_distance" in given else None
    if isinstance(tf, TransferFunction):
        return {"transfer-function": tf._document(), **_named({"iso": given.get("iso")})}
    limits = _limits(given)
    is_named = cmap is None or (isinstance(cmap, str) and _core.colormap(cmap, 2) is not None)
    is_plain = opacity is None or isinstance(opacity, (str, int, float))
    if norm is None and is_named and is_plain:
        clim = None if limits == (None, None) else list(_range(*limits, data))
        look = {"tf": tf, "cmap": cmap, "clim": clim, "opacity": opacity, "iso": given.get("iso")}
        return _named({**look, "unit_distance": unit})
    if "iso" in given and not is_exact:
        message = "iso: its surface has the colours of splatvol's maps; others, norms and points: beside iso_exact=True"
        raise InvalidValue(message, field="iso", value=repr(given["iso"]))
    made = TransferFunction.from_cmap(
        "viridis" if cmap is None else cmap,
        _range(*limits, data),
        "linear" if opacity is None else opacity,
        norm=norm,
        unit_distance=unit,
    )
    return {"transfer-function": made._document(), **_named({"iso": given.get("iso")})}


def _named(look: Keys) -> Keys:
    """Keys of keywords, as far as those were given."""
    return {LOOK[name]: checked(name, plain(value)) for name, value in look.items() if value is not None}


def _check_beside(tf: Any, given: Keys, *, is_exact: bool) -> None:
    """Refuses what is no transfer function, and the keywords that contradict it.

    Raises
    ------
    InvalidValue
    """
    is_function = isinstance(tf, TransferFunction)
    if not is_function and not isinstance(tf, str) and not hasattr(tf, "__fspath__"):
        raise _checks.refused("tf", tf, "a TransferFunction, or the path of a file with one")
    allowed = () if is_function else BESIDE_FILE
    # The surface at its exact place has the colour of its value in the transfer function.
    allowed = (*allowed, "iso") if is_function and is_exact else allowed
    for name in given:
        if name not in ("tf", *allowed):
            message = f"{name}: has no meaning beside tf=, which says that itself: write one of them (tf=None ends it)"
            raise InvalidValue(message, field=name, value=repr(given[name]))


def _limits(given: Keys) -> tuple[float | None, float | None]:
    """Ends of a colour map, as far as keywords or the norm say them.

    Raises
    ------
    InvalidValue
        Where they say different ones.
    """
    low, high = given.get("vmin"), given.get("vmax")
    names = ("vmin", "vmax")
    if "clim" in given:
        if low is not None or high is not None:
            raise InvalidValue("clim: write vmin and vmax, or clim", field="clim", value=repr(given["clim"]))
        low, high = _checks.pair(given["clim"], "clim", CLIM)
        names = ("clim", "clim")
    own = (getattr(given.get("norm"), end, None) for end in ("vmin", "vmax"))
    low, high = (_end(name, keyword, norms) for name, keyword, norms in zip(names, (low, high), own, strict=True))
    return low, high


def _end(name: str, keyword: Any, norms: Any) -> float | None:
    """One end, of a keyword or of the norm."""
    found = None if keyword is None else _checks.number(keyword, name)
    if norms is None:
        return found
    if found is not None and found != float(norms):
        message = f"{name}: {found:g} is not {float(norms):g}, which the norm says: write one of them"
        raise InvalidValue(message, field=name, value=repr(keyword))
    return _checks.number(norms, "norm")


def _range(low: float | None, high: float | None, data: Data | None) -> tuple[float, float]:
    """Ends of a colour map; those of the data where they are left out."""
    if low is None or high is None:
        if data is None or data._describe().get("range") is None:
            raise InvalidValue("clim: the data have no range of values: write clim=(low, high)", field="clim")
        least, most = data._describe()["range"]
        low, high = least if low is None else low, most if high is None else high
    return float(low), float(high)
