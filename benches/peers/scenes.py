"""What is rendered: volumes, transfer functions and cameras, the same for every renderer.

World: the first sample of a file is at the origin, samples are `spacing` apart along x, y, z. Whatever orientation a
file has is dropped, since VTK's readers and splatvol's treat it differently.
"""

import dataclasses
import json
import math
from pathlib import Path

import numpy as np

SEMI_OPACITY = 0.03
"""Opacity per voxel at the top of the window of `semi`."""
FILL = 0.85
"""Share of the picture that the box of samples fills at first."""
FOV_DEGREES = 30.0
MARSCHNER_LOBB_SIDE = 41

KNOWN = {  # Iso-value and window: published choices, kept so that figures can be compared over time.
    "bonsai": (40, (0, 255)),
    "engine": (100, (0, 255)),
    "LIDC2": (90, (0, 255)),
    "tooth": (100, (0, 255)),
    "shells": (100, (0, 255)),
    "marschner-lobb": (0.5, (0, 1)),
}

VIEWS = {  # From the target to the eye, where the picture's up is +y.
    "front": (0.0, 0.0, 1.0),
    "side": (0.90, 0.25, 0.35),
    "diag": (1.0, 1.0, 1.0),
}
UP = np.array([0.0, 1.0, 0.0])


@dataclasses.dataclass
class Volume:
    """Samples `values[z, y, x]`; `iso` and `window` are data values."""

    name: str
    values: np.ndarray
    spacing: np.ndarray
    iso: float
    window: tuple[float, float]
    origin: float = 0.0
    """World x, y and z of the first sample."""

    @property
    def voxel(self):
        """The smallest spacing, world: the length to which opacities refer, and at which VTK takes samples."""
        return float(min(self.spacing))

    @property
    def extent(self):
        """World size of the box between the outermost sample positions."""
        return (np.array(self.values.shape[::-1]) - 1.0) * self.spacing

    def write_nrrd(self, path):
        """Writes a file whose axes are the world's."""
        kinds = {"u1": "uint8", "i1": "int8", "u2": "uint16", "i2": "int16", "u4": "uint32", "i4": "int32",
                 "f4": "float", "f8": "double"}
        values = self.values.astype(self.values.dtype.newbyteorder("<"), copy=False)
        header = [
            "NRRD0004", f"type: {kinds[values.dtype.str[1:]]}", "dimension: 3",
            "sizes: " + " ".join(map(str, values.shape[::-1])),
            "endian: little", "encoding: raw", "space dimension: 3",
            "space directions: " + " ".join(map(_vector, np.diag(self.spacing))),
            "space origin: " + _vector([self.origin] * 3), "", "",
        ]
        with Path(path).open("wb") as file:
            file.write("\n".join(header).encode())
            file.write(values.tobytes())


def _vector(numbers):
    return "(" + ",".join(repr(float(x)) for x in numbers) + ")"


def volume(reference, values, spacing):
    """The volume of an argument `FILE[@ISO]` or `sample:NAME[:SIZE][@ISO]`, whose samples have been read."""
    path, _, iso = reference.partition("@")
    name = path.split(":")[1] if path.startswith("sample:") else Path(path).name.split(".")[0]
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    default_iso, window = KNOWN.get(name, ((low + high) / 2, (low, high)))
    return Volume(name, values, np.array(spacing, float), float(iso) if iso else default_iso, window)


def marschner_lobb(refinement, whole_voxels):
    """Marschner and Lobb's function at `refinement` times the resolution of `sample:marschner-lobb`, in its world.

    VTK shows the box between the outermost sample positions, splatvol whole voxels: half a voxel more on each side.
    Each gets the same box of the finer function as it shows of the coarse samples. Vis '94, equation 3.
    """
    spacing = 1.0 / refinement
    side = MARSCHNER_LOBB_SIDE
    if whole_voxels:
        world = (np.arange(side * refinement) + 0.5) * spacing - 0.5
    else:
        world = np.arange((side - 1) * refinement + 1) * spacing
    unit = world / (side - 1) * 2 - 1
    radius = np.hypot(unit[:, None], unit[None, :])
    rings = np.cos(2 * np.pi * 6 * np.cos(np.pi / 2 * radius))
    ramp = 1 - np.sin(np.pi / 2 * unit)
    values = (ramp[:, None, None] + 0.25 * (1 + rings)) / 2.5
    spacings = np.full(3, spacing)
    return Volume("marschner-lobb-fine", values.astype(np.float32), spacings, *KNOWN["marschner-lobb"], world[0])


@dataclasses.dataclass
class TransferFunction:
    """Points `(value, opacity per unit distance)` and `(value, r, g, b)`, display colours, linear between."""

    unit_distance: float
    opacities: list[tuple[float, float]]
    colors: list[tuple[float, float, float, float]]

    def write_paraview(self, path):
        """Writes a ParaView preset."""
        points = [x for value, opacity in self.opacities for x in (value, opacity, 0.5, 0.0)]
        colors = [x for point in self.colors for x in point]
        preset = {"Name": Path(path).stem, "ColorSpace": "RGB", "Points": points, "RGBPoints": colors}
        Path(path).write_text(json.dumps([preset]))


MODES = {  # How values along a ray become a pixel, and the transfer functions that it is compared with.
    "composite": ["opaque", "semi"],
    "mip": ["ramp"],
}


def transfer_function(volume, kind):
    """`opaque`: a steep ramp at the iso-value, 4 % of the window wide; `semi`: a faint ramp over the window; `ramp`: from
    clear to opaque over the window, for values that are shown by themselves."""
    low, high = volume.window
    width = high - low
    opacities = {
        "opaque": [(volume.iso - 0.02 * width, 0.0), (volume.iso + 0.02 * width, 1.0)],
        "semi": [(low + 0.04 * width, 0.0), (high, SEMI_OPACITY)],
        "ramp": [(low, 0.0), (high, 1.0)],
    }
    colors = [(low, 0.10, 0.15, 0.60), (low + 0.30 * width, 0.20, 0.70, 0.80), (low + 0.60 * width, 0.95, 0.85, 0.45),
              (high, 0.90, 0.20, 0.12)]
    return TransferFunction(volume.voxel, opacities[kind], colors)


@dataclasses.dataclass
class Lighting:
    """Phong with a headlight, two-sided; `power` is that of the half vector (Blinn)."""

    ambient: float = 0.2
    diffuse: float = 0.7
    specular: float = 0.3
    power: float = 20.0


@dataclasses.dataclass
class Camera:
    """World positions; `height` is what a parallel projection shows, None in perspective."""

    eye: np.ndarray
    target: np.ndarray
    height: float | None

    def turned(self, degrees):
        """The camera after an orbit about the up axis through the target."""
        angle = math.radians(degrees)
        x, y, z = self.eye - self.target
        turned = np.array([x * math.cos(angle) + z * math.sin(angle), y, z * math.cos(angle) - x * math.sin(angle)])
        return dataclasses.replace(self, eye=self.target + turned)

    def pixels(self, points, size):
        """Columns and rows at which world points appear."""
        back = (self.eye - self.target) / np.linalg.norm(self.eye - self.target)
        right = np.cross(UP, back)
        right /= np.linalg.norm(right)
        seen = (points - self.eye) @ np.stack([right, np.cross(back, right), back], 1)
        half = self.height / 2 if self.height else -seen[:, 2:] * math.tan(math.radians(FOV_DEGREES / 2))
        return (seen[:, :2] / half * [1, -1] + 1) * size / 2


def camera(volume, view, orthographic):
    """The camera in which the box of samples fills `FILL` of the picture."""
    extent = volume.extent
    centre = extent / 2
    back = np.array(VIEWS[view]) / np.linalg.norm(VIEWS[view])
    corners = np.array(np.meshgrid(*[[0, side] for side in extent])).reshape(3, -1).T

    def share(distance, height=None):
        spots = Camera(centre + back * distance, centre, height).pixels(corners, 2.0)
        return np.abs(spots - 1).max()

    far = 100 * np.linalg.norm(extent)
    if orthographic:
        distance = 3 * np.linalg.norm(extent)
        return Camera(centre + back * distance, centre, share(distance, 1.0) / FILL)
    near = ((corners - centre) @ back).max() * 1.0001
    for _ in range(100):
        middle = (near + far) / 2
        near, far = (middle, far) if share(middle) > FILL else (near, middle)
    return Camera(centre + back * far, centre, None)


def interior(volume, camera, size, margin):
    """Mask of the pixels whose rays stay `margin` away from the sides of the box, seen along z."""
    low, high = np.full(3, margin), volume.extent - margin
    boxes = []
    for z in (0.0, volume.extent[2]):
        spots = camera.pixels(np.array([[low[0], low[1], z], [high[0], high[1], z]]), size)
        boxes.append((spots.min(0), spots.max(0)))
    first, last = np.max([b[0] for b in boxes], 0), np.min([b[1] for b in boxes], 0)
    centres = np.arange(size) + 0.5
    inside = [(first[axis] < centres) & (centres < last[axis]) for axis in (0, 1)]
    return inside[1][:, None] & inside[0][None, :]
