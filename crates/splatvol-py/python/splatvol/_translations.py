"""Keywords of other programs, and what to write here."""

from __future__ import annotations

#: Keyword, the program that has it, and what to write instead.
TABLE = {
    # PyVista
    "opacity_unit_distance": "write unit_distance=, in world lengths",
    "blending": 'write compositing="mip", "minip", "mean" or "xray"; leave it out for a volume\'s light and shade',
    "n_colors": "not needed: colour maps are continuous",
    "scalars": "write array=, the name of the file's or grid's array",
    "resolution": "write spacing= where the volume is made: Volume(array, spacing=...)",
    "cpos": "write camera=Camera(position, target, up)",
    "shade_volume": "write shade=True",
    "window_size": "write size=(width, height)",
    "off_screen": "not needed: nothing ever opens a window",
    "screenshot": "write .save(path) after render(...)",
    "show_scalar_bar": "not needed: write the bar with matplotlib",
    "parallel_projection": "write orthographic=True",
    "jupyter_backend": "not needed: show() works in every notebook",
    "clipping": "write clip=Clip.plane(point, normal) or clip=Clip.box(...)",
    "mapper": "not needed: there is one engine, on the CPU",
    # napari
    "contrast_limits": "write clim=(low, high)",
    "colormap": "write cmap=, a name or a matplotlib colour map",
    "rendering": 'write compositing="mip", "minip", "mean" or "xray", or iso=VALUE for a surface',
    "iso_threshold": "write iso=VALUE",
    "attenuation": "write unit_distance=, in world lengths",
    "channel_axis": "write Volume(array[channel], axes='zyx')",
    "gamma": "write norm=matplotlib.colors.PowerNorm(gamma)",
    "ndisplay": "not needed: pictures are of volumes",
    "multiscale": "write level= where the data are read",
    # matplotlib and others
    "alpha": "write opacity=, a curve's name or [(value, opacity), ...]",
    "colors": "write cmap=, or tf=TransferFunction(colors, opacities)",
    "color_map": "write cmap=, a name or a matplotlib colour map",
    "figsize": "write size=(width, height), in pixels",
    "dpi": "write size=(width, height), in pixels",
    "facecolor": "write background=",
    "bgcolor": "write background=",
    "azim": "write azimuth=",
    "elev": "write elevation=",
    "vrange": "write clim=(low, high)",
    "data_min": "write clim=(low, high)",
    "data_max": "write clim=(low, high)",
    # yt, ipyvolume, k3d, vedo, ParaView
    "transfer_function": "write tf=, a TransferFunction or the path of a file",
    "level_width": "write tf=TransferFunction(colors, opacities)",
    "color_range": "write clim=(low, high)",
    "alpha_coef": "write unit_distance=, in world lengths",
    "opacity_function": "write opacity=, a curve's name or [(value, opacity), ...]",
    "color_function": "write tf=TransferFunction(colors, opacities)",
    "threshold": "write iso=VALUE for a surface",
    "isovalue": "write iso=VALUE",
    "level_set": "write iso=VALUE",
    "samples": "write sheet_thickness=: sheets per voxel are its inverse",
    "step_size": "write sheet_thickness=, in voxels",
    "sampling_distance": "write sheet_thickness=, in voxels",
    "view_angle": "write fov=, degrees",
    "lighting": "write shade=True or shade=False",
    "quality": 'write preset="draft", "fast", "balanced" or "best"',
    "width": "write size=(width, height)",
    "height": "write size=(width, height)",
}


def of(keyword: str) -> str | None:
    """What to write instead of another program's keyword."""
    return TABLE.get(keyword)
