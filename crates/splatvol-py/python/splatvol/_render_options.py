"""Keywords, their types and their meaning. Written by tools/render_options.py; do not edit."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Literal, TypedDict

from ._camera import Camera
from ._look import Clip, Light, TransferFunction

class ReadOptions(TypedDict, total=False):
    """Keywords of :func:`splatvol.read`: how a file is read."""

    kind: str | None
    """Kind of the file: volume, points, terrain, depth-images, gaussians or mesh."""
    dims: Sequence[int] | None
    """Layout of a headerless file: samples along x, y, z."""
    dtype: str | None
    """Layout of a headerless file: `u8`, `i16`, ..."""
    spacing: Sequence[float] | None
    """Layout of a headerless file: world length per voxel."""
    endian: str | None
    """Layout of a headerless file: `little` or `big`."""
    offset: int | None
    """Layout of a headerless file: bytes before the first sample."""
    array: str | None
    """Array of a file that holds several."""
    component: int | None
    """Component of vector-valued samples."""
    channel: int | None
    """Channel, from 0."""
    time: int | None
    """Time point, from 0."""
    level: int | None
    """Level of detail, 0 being the finest."""
    series: str | None
    """Series of a folder."""
    solution: str | None
    """Solution of a PLOT3D grid."""
    drape: str | None
    """Picture that is laid over terrain."""
    posts: Sequence[int] | None
    """Posts to the east and to the north that heights of terrain are interpolated to."""


class RenderOptions(TypedDict, total=False):
    """Keywords of pictures: the command's flags with ``_`` for ``-``."""

    size: int | str | Sequence[int] | None
    """Size of the picture, pixels: one number, or width and height."""
    background: str | Sequence[float] | None
    """Background: a name, #rrggbb, none, or sRGB and alpha from 0 to 1."""
    camera: Camera | None
    """Camera, in place of the keywords of cameras."""
    clip: Clip | Sequence[Clip] | None
    """What is cut away."""
    light: bool | Light | Sequence[float] | None
    """Whether surfaces are lit, a light, or the direction to one."""
    norm: Any | None
    """One of matplotlib's norms: how values become places in the colour map."""
    vmin: float | None
    """Value at the lower end of the colour map; the data's least by default."""
    vmax: float | None
    """Value at the upper end of the colour map; the data's greatest by default."""
    cmap: str | Any | None
    """Colour map: a name of splatvol's or matplotlib's, or one of matplotlib's maps."""
    clim: tuple[float, float] | Sequence[float] | Literal["auto"] | None
    """Data values at the ends of colour map and opacity curve."""
    tf: TransferFunction | str | os.PathLike[str] | None
    """Transfer function, or a file with one."""
    opacity: str | float | Sequence[tuple[float, float]] | None
    """Opacity curve of values, by its name or as points of value and opacity; opacity of points, 0..1."""
    color: str | Sequence[float] | None
    """Colour of points without colours."""
    bits: int | None
    """Bits per channel of a PNG: 8 or 16."""
    iso: float | None
    """Data value whose surface is shown."""
    labels: bool | None
    """Whether values are names of kinds, which are never interpolated."""
    radius: float | None
    """Radius of points, in the file's lengths."""
    rotate: Sequence[Any] | Sequence[Sequence[float]] | None
    """Rotation, after the scale."""
    scale: float | Sequence[float] | None
    """Factor on lengths, or one for each axis."""
    translate: Sequence[float] | None
    """Shift, after the rotation, world."""
    unit_distance: float | None
    """World length to which opacities refer."""
    up: Literal["x", "y", "z", "-x", "-y", "-z"] | None
    """Axis of the file that is up: it is turned to z."""
    visible: bool | None
    """Whether it is in the picture."""
    azimuth: float | None
    """Turn around the target, to the camera's right, degrees."""
    elevation: float | None
    """Turn over the target, upwards, degrees."""
    fit: Literal["visible", "volume"] | None
    """Subject of an automatic camera."""
    fov: float | None
    """Vertical field of view, degrees. Excludes `orthographic`."""
    orthographic: float | bool | None
    """Parallel projection: world units from top to bottom, or `true` for what fits."""
    camera_position: Sequence[float] | None
    """Position of the eye, world."""
    camera_target: Sequence[float] | None
    """Point looked at, world; the middle of what is shown by default."""
    camera_up: Sequence[float] | None
    """Direction that is up in the picture, world."""
    view: Literal["front", "back", "left", "right", "top", "bottom", "iso"] | None
    """Side to look from. Excludes `position`."""
    zoom: float | None
    """Enlargement of the picture's middle."""
    absorption: Literal["exp", "linear"] | None
    """How light is lost on its way through material."""
    alignment: Literal["sheet", "affine", "exact", "grid", "ray", "ray-ideal", "switch", "auto"] | None
    """Along which lines a kernel is integrated to its footprint."""
    alignment_budget: float | None
    """Largest error of a footprint with `alignment = "auto"`, share of its peak."""
    alignment_switch: float | None
    """How far behind the depth where voxels are a pixel apart `alignment = "switch"` switches, mean voxel spacings."""
    ambient: float | None
    """Share of the colour that needs no light."""
    blit_radius: int | None
    """Largest radius of a footprint that `hybrid` draws as `blit-2d`, pixels, 1 to 64."""
    classification: Literal["pre", "post"] | None
    """Whether colours are splatted, or data that get colours on each sheet."""
    compositing: Literal["image-sheets", "xray", "mip", "minip", "mean", "per-splat", "per-splat-back-to-front", "axis-sheets"] | None
    """Kind of picture."""
    coverage: Literal["off", "adaptive"] | None
    """Anti-aliasing of edges."""
    coverage_contrast: float | None
    """Difference of neighbouring pixels above which they get several samples, share of white."""
    coverage_samples: int | None
    """Samples per pixel and axis with `coverage = "adaptive"`, 2 to 8."""
    diffuse: float | None
    """Share of the colour under full light."""
    extract_density: Sequence[float] | None
    """Least and greatest value of voxels that are splatted."""
    extract_gradient: float | None
    """Least gradient of voxels that are splatted, value ranges per voxel."""
    filter: Literal["none", "ewa", "matched", "swan", "swan-alpha"] | None
    """Low-pass filter against aliasing in the picture."""
    flatness: float | None
    """How much thinner kernels get along the gradient, where they stand for surfaces."""
    gaussians: Literal["auto", "3dgs", "volumetric"] | None
    """How 3-D Gaussians are composited."""
    gradient: Literal["analytic", "differences"] | None
    """Gradients by which sheets are lit."""
    gradient_floor: float | None
    """Gradient at which light from a direction has half its effect, value ranges per voxel."""
    kernel: Literal["gaussian", "crawfis-max", "cubic-bspline", "kaiser-bessel"] | None
    """Reconstruction kernel."""
    kernel_alpha: float | None
    """Shape of the Kaiser-Bessel kernel, broad at 0."""
    kernel_edge: Literal["smooth", "raw"] | None
    """The edge of the Gaussian kernel's footprint, where it is cut."""
    kernel_radius: float | None
    """Cut-off of the Gaussian or Kaiser-Bessel kernel, voxels."""
    kernel_sigma: float | None
    """Standard deviation of the Gaussian kernel, voxels."""
    level_bias: float | None
    """Octaves by which the level of detail is coarser than the picture asks: 1 halves the resolution."""
    occlusion: Literal["auto", "none", "sat", "box"] | None
    """How hidden voxels are found and left out."""
    pixel_sigma: float | None
    """Standard deviation of the filters `ewa` and `matched`, pixels."""
    prefilter: bool | None
    """Whether the reconstruction interpolates the samples, or smooths them."""
    preset: Literal["best", "balanced", "fast", "draft", "swan1997", "mueller1998", "ewa2001", "fastsplats2000"] | None
    """Quality or speed; other keys go over it. `balanced` by default."""
    rasterizer: Literal["auto", "linear-1d", "square-1d", "ellipse-1d", "rlut", "blit-2d", "hybrid"] | None
    """How footprints are drawn."""
    reconstruction: Literal["volume", "surface", "mixed"] | None
    """Meaning of the kernels."""
    shade: bool | None
    """Whether the picture is lit."""
    sheet: Literal["section", "sample"] | None
    """Contribution of a kernel to a sheet."""
    sheet_precision: Literal["u8", "u16", "f32"] | None
    """Number format of a sheet's pixels."""
    sheet_thickness: float | None
    """Thickness of a sheet, mean voxel spacings."""
    sheet_values: Literal["mean", "sum"] | None
    """The value of a pixel on a sheet of sections."""
    specular: float | None
    """Strength of the white highlight."""
    specular_power: float | None
    """Exponent of the highlight."""
    stretch: Literal["box", "trapezoid"] | None
    """How the filter `swan` stretches kernels."""
    subpixels: int | None
    """Places per pixel and axis that centres are rounded to by `rlut`, `blit-2d` and `hybrid`."""
    surface_gradient: float | None
    """Least gradient of a surface, value ranges per voxel."""
    table_entries: int | None
    """Entries of a footprint table, 32 to 1024."""
    table_precision: Literal["u8", "u16", "f32"] | None
    """Number format of a table's entries."""
    table_sections: int | None
    """Parts into which a table cuts the kernel along depth, 1 to 128."""
    termination: float | None
    """Transmittance below which a pixel is finished."""
    bump: str | None
    """Picture that embosses surfaces: a file."""
    bump_height: float | None
    """How far the bump raises white, share of the volume's diagonal; negative engraves."""
    clip_box: Sequence[float] | None
    """Box that is kept, world: x0, x1, y0, y1, z0, z1."""
    clip_inside: bool | None
    """Whether the outside of the box is kept instead."""
    clip_plane: Sequence[dict[str, Any]] | None
    """Planes whose normals' side is kept, world."""
    environment: str | None
    """Surroundings that are mirrored: an equirectangular picture, a file."""
    environment_share: float | None
    """Share of the light that the reflection replaces."""
    gradient_opacity: Sequence[dict[str, Any]] | None
    """Factors on opacity by the magnitude of the gradient, data units per world length."""
    iso_exact: bool | None
    """Whether the surface of `iso` is shown at its exact place, infinitely thin."""
    regions: Sequence[dict[str, Any]] | None
    """Transfer function of value and gradient magnitude: soft rectangles of both."""
    texture: Literal["marble", "wood"] | None
    """Colours the material as if it were cut from a block of this."""
    texture_scale: float | None
    """Distance between veins of marble, share of the volume's diagonal."""
    tf2d: str | None
    """Transfer function of value and gradient magnitude: a file."""
    motion_blur: Literal["none", "capsule", "exact", "subframes"] | None
    """How motion is blurred."""
    spin: float | None
    """Angle by which everything spins, degrees."""
    spin_axis: Sequence[float] | None
    """Axis of the spin, world; the camera's up by default."""
    spin_centre: Sequence[float] | None
    """Centre of the spin, world; that of everything by default."""
    subframes: int | None
    """Number of pictures averaged by `motion-blur = "subframes"`."""
    velocity: Sequence[float] | None
    """Way that everything moves, world lengths."""
