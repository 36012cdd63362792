"""Ways to a volume from other packages' objects, as methods of its class."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._data import Volume


class FromOthers:
    """Class methods of :class:`splatvol.Volume`: ``Volume.from_nibabel(image)`` and so on."""

    @classmethod
    def from_nibabel(cls, image: Any) -> Volume:
        """A volume of a nibabel image: see :func:`splatvol.from_nibabel`."""
        from ._foreign import from_nibabel

        return from_nibabel(image)

    @classmethod
    def from_itk(cls, image: Any) -> Volume:
        """A volume of an image of SimpleITK or itk: see :func:`splatvol.from_itk`."""
        from ._foreign import from_itk

        return from_itk(image)

    @classmethod
    def from_vtk(cls, grid: Any, array: str | None = None) -> Volume:
        """A volume of VTK's or PyVista's image data: see :func:`splatvol.from_vtk`.

        Raises
        ------
        TypeError
            A data set that is not a regular grid: `splatvol.from_vtk` makes a mesh or points of it.
        """
        from ._data import Volume
        from ._foreign import from_vtk

        data = from_vtk(grid, array)
        if not isinstance(data, Volume):
            raise TypeError(f"{type(grid).__name__} is no regular grid, but {data.kind}: write splatvol.from_vtk(grid)")
        return data

    @classmethod
    def from_xarray(cls, array: Any) -> Volume:
        """A volume of a DataArray: see :func:`splatvol.from_xarray`."""
        from ._foreign import from_xarray

        return from_xarray(array)

    @classmethod
    def from_dask(cls, array: Any, **options: Any) -> Volume:
        """A volume of a dask array or of a list of levels: see :func:`splatvol.from_dask`."""
        from ._foreign import from_dask

        return from_dask(array, **options)

    @classmethod
    def from_zarr(cls, node: Any, **options: Any) -> Volume:
        """A volume of one of zarr's arrays or groups: see :func:`splatvol.from_zarr`."""
        from ._foreign import from_zarr

        return from_zarr(node, **options)

    @classmethod
    def from_dicom(cls, datasets: Any, **options: Any) -> Volume:
        """A volume of pydicom's data sets: see :func:`splatvol.from_dicom`."""
        from ._foreign import from_dicom

        return from_dicom(datasets, **options)

    @classmethod
    def from_napari(cls, layer: Any, *, max_bytes: int = 1 << 30) -> Volume:
        """A volume of one of napari's image or labels layers: see :func:`splatvol.from_napari`."""
        from ._foreign import from_napari

        return from_napari(layer, max_bytes=max_bytes)
