"""VTK's files, written by VTK in every coding, that splatvol must read as VTK reads them back.

Images are compared sample by sample. Of grids and polygons the command says how many points and cells there are, where
they lie, and the range of every component of every array.
"""

import itertools
import re

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from comparison import compare
from generated_files import noise, rotation
from splatvol_cli import Refused, Volume

TYPES = ["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"]
MODES = {"ascii": "SetDataModeToAscii", "binary": "SetDataModeToBinary", "appended": "SetDataModeToAppended"}
COMPRESSORS = {"plain": None, "zlib": vtk.vtkZLibDataCompressor, "LZ4": vtk.vtkLZ4DataCompressor}
DIMS = (5, 6, 7)
LEGACY_VERSIONS = {"4.2": 42, "5.1": 51}


def cases(splatvol, folder):
    """Named checks."""
    return Vtk(splatvol, folder).cases()


class Vtk:
    """Checks that write into `folder` and read back."""

    def __init__(self, splatvol, folder):
        self.splatvol = splatvol
        self.folder = folder / "vtk"
        self.folder.mkdir()

    def cases(self):
        for coding in codings():
            for dtype in TYPES:
                yield f"VTI {dtype} {coding.name}", lambda d=dtype, c=coding: self.image(d, c)
        yield "VTI direction, extent and origin", self.oblique
        yield "VTI cell data", self.cell_data
        yield "VTI components", self.components
        for dtype, binary, version in itertools.product(TYPES, [False, True], LEGACY_VERSIONS):
            name = f"legacy VTK {version} image {dtype} {'binary' if binary else 'ascii'}"
            yield name, lambda d=dtype, b=binary, v=version: self.legacy_image(d, b, v)
        for kind, coding in itertools.product(GRIDS, codings()):
            yield f"VTK XML {kind} {coding.name}", lambda k=kind, c=coding: self.grid(k, c)
        for kind, binary, version in itertools.product(GRIDS, [False, True], LEGACY_VERSIONS):
            name = f"legacy VTK {version} {kind} {'binary' if binary else 'ascii'}"
            yield name, lambda k=kind, b=binary, v=version: self.legacy_grid(k, b, v)
        for kind, coding in itertools.product(["points", "triangles", "strips"], codings()):
            yield f"VTP {kind} {coding.name}", lambda k=kind, c=coding: self.polygons(k, c)
        for kind, binary, version in itertools.product(
            ["points", "triangles", "strips"], [False, True], LEGACY_VERSIONS
        ):
            name = f"legacy VTK {version} {kind} {'binary' if binary else 'ascii'}"
            yield name, lambda k=kind, b=binary, v=version: self.legacy_polygons(k, b, v)
        yield "refuse VTI LZMA", self.refuse_lzma

    def path(self, name, suffix):
        return self.folder / f"{name.replace(' ', '_')}{suffix}"

    # Images

    def image(self, dtype, coding):
        path = self.path(f"{dtype} {coding.name}", ".vti")
        coding.write(vtk.vtkXMLImageDataWriter(), image(dtype), path)
        self.agree(path, vtk.vtkXMLImageDataReader())

    def agree(self, path, reader, *options):
        data = read(reader, path)
        compare(volume(data, data.GetPointData().GetArray("noise")), self.splatvol.read(path, *options))

    def oblique(self):
        data = vtk.vtkImageData()
        data.SetExtent(-3, 1, 10, 15, 2, 8)
        place(data, rotation(50))
        attach(data.GetPointData(), "noise", noise("f4", 2, DIMS[::-1]))
        path = self.path("oblique", ".vti")
        Coding("appended", "plain").write(vtk.vtkXMLImageDataWriter(), data, path)
        self.agree(path, vtk.vtkXMLImageDataReader())

    def cell_data(self):
        """Samples of cells lie at their centres."""
        data = image("u1")
        data.GetPointData().Initialize()
        values = noise("i2", 3, tuple(size - 1 for size in DIMS[::-1]))
        attach(data.GetCellData(), "cells", values)
        path = self.path("cells", ".vti")
        Coding("binary", "zlib").write(vtk.vtkXMLImageDataWriter(), data, path)
        found = read(vtk.vtkXMLImageDataReader(), path)
        expected = volume(found, None)
        expected.values = values
        expected.ras_from_voxel[:3, 3] += expected.ras_from_voxel[:3, :3] @ [0.5, 0.5, 0.5]
        compare(expected, self.splatvol.read(path))

    def components(self):
        data = image("u1")
        vectors = noise("f4", 4, (*DIMS[::-1], 3))
        attach(data.GetPointData(), "flow", vectors)
        path = self.path("components", ".vti")
        Coding("appended", "LZ4").write(vtk.vtkXMLImageDataWriter(), data, path)
        affine = volume(data, None).ras_from_voxel
        for component in range(3):
            actual = self.splatvol.read(path, "--array", "flow", "--component", component)
            compare(Volume(vectors[..., component], affine), actual)

    def legacy_image(self, dtype, binary, version):
        path = self.path(f"{dtype} {binary} {version}", ".vtk")
        # This format has no directions.
        data = image(dtype, np.eye(3))
        write_legacy(vtk.vtkStructuredPointsWriter(), data, path, binary, version)
        self.agree(path, vtk.vtkStructuredPointsReader())

    def refuse_lzma(self):
        path = self.path("lzma", ".vti")
        Coding("appended", "LZMA", compressor=vtk.vtkLZMADataCompressor).write(
            vtk.vtkXMLImageDataWriter(), image("u1"), path
        )
        try:
            self.splatvol.read(path)
        except Refused as refused:
            assert refused.code == 3, f"exit code {refused.code}, expected 3"
        else:
            raise AssertionError("was read")

    # Grids

    def grid(self, kind, coding):
        make, writer, reader, suffix, *_ = GRIDS[kind]
        path = self.path(f"{kind} {coding.name}", suffix)
        coding.write(writer(), make(), path)
        # Ranges of every array in one form of each coding; in the others of one scalar and one vector.
        names = None if (coding.endian, coding.words) == ("little", 32) else ["energy", "flux"]
        self.agree_on_grid(path, read(reader(), path), names)

    def legacy_grid(self, kind, binary, version):
        make, *_, writer, reader = GRIDS[kind]
        path = self.path(f"{kind} {binary} {version}", ".vtk")
        write_legacy(writer(), make(), path, binary, version)
        self.agree_on_grid(path, read(reader(), path))

    def agree_on_grid(self, path, expected, names=None):
        said = self.splatvol.info(path)
        assert said["kind"] == "mesh", f"kind {said['kind']}"
        assert said["count"] == expected.GetNumberOfPoints(), f"{said['count']} points"
        assert said["cells"] == expected.GetNumberOfCells(), f"{said['cells']} cells"
        if hasattr(expected, "GetExtent"):
            dims = [int(size) for size in np.diff(np.array(expected.GetExtent()).reshape(3, 2))[:, 0] + 1]
            assert said["blocks"] == [dims], f"blocks {said['blocks']}"
        agree_on_bounds(said, np.array(expected.GetBounds()).reshape(3, 2))
        for attributes, association in [(expected.GetPointData(), "point"), (expected.GetCellData(), "cell")]:
            for index in range(attributes.GetNumberOfArrays()):
                array = attributes.GetArray(index)
                if names is None or array.GetName() in names:
                    self.agree_on_ranges(path, array, association)

    def agree_on_ranges(self, path, array, association):
        values = vtk_to_numpy(array).astype(np.float64).reshape(array.GetNumberOfTuples(), -1)
        name, components = array.GetName(), values.shape[1]
        parts = {f"{name}:{i}": values[:, i] for i in range(components)} if components > 1 else {name: values[:, 0]}
        if components > 1:
            parts[f"{name}:magnitude"] = np.linalg.norm(values, axis=1)
        for asked, wanted in parts.items():
            said = self.splatvol.info(path, "--array", asked)
            assert said["association"] == association, f"{asked} of a {said['association']}"
            expected = np.float32([wanted.min(), wanted.max()])
            assert np.allclose(said["range"], expected, rtol=1e-6, atol=0), (
                f"{asked}: {said['range']}, expected {expected}"
            )

    # Polygons

    def polygons(self, kind, coding):
        path = self.path(f"{kind} {coding.name}", ".vtp")
        coding.write(vtk.vtkXMLPolyDataWriter(), POLYGONS[kind](), path)
        self.agree_on_polygons(kind, path, read(vtk.vtkXMLPolyDataReader(), path))

    def legacy_polygons(self, kind, binary, version):
        path = self.path(f"{kind} {binary} {version}", ".vtk")
        write_legacy(vtk.vtkPolyDataWriter(), POLYGONS[kind](), path, binary, version)
        self.agree_on_polygons(kind, path, read(vtk.vtkPolyDataReader(), path))

    def agree_on_polygons(self, kind, path, expected):
        said = self.splatvol.info(path)
        assert said["kind"] == "points", f"kind {said['kind']}"
        bounds = np.array(expected.GetBounds()).reshape(3, 2)
        if kind == "points":
            assert said["count"] == expected.GetNumberOfPoints(), f"{said['count']} points"
            agree_on_bounds(said, bounds)
            return
        agree_on_surface(said, triangle_count(expected), bounds)


class Coding:
    """How an XML file holds its arrays."""

    def __init__(self, mode, compression, endian="little", words=32, base64=True, compressor=None):
        self.name = f"{mode} {compression} {endian}-endian {words}{' base64' if base64 and mode == 'appended' else ''}"
        self.mode, self.endian, self.words, self.base64 = mode, endian, words, base64
        self.compressor = compressor or COMPRESSORS[compression]

    def write(self, writer, data, path):
        writer.SetFileName(str(path))
        writer.SetInputData(data)
        getattr(writer, MODES[self.mode])()
        writer.SetEncodeAppendedData(self.base64)
        writer.SetCompressor(self.compressor() if self.compressor else None)
        # Several blocks, of which the last is shorter.
        writer.SetBlockSize(256)
        getattr(writer, "SetByteOrderToLittleEndian" if self.endian == "little" else "SetByteOrderToBigEndian")()
        getattr(writer, f"SetHeaderTypeToUInt{self.words}")()
        assert writer.Write(), f"VTK cannot write {path}"


def codings():
    """All that VTK writes and splatvol reads."""
    yield Coding("ascii", "plain")
    for compression, endian, words in itertools.product(COMPRESSORS, ["little", "big"], [32, 64]):
        yield Coding("binary", compression, endian, words)
        yield Coding("appended", compression, endian, words)
        yield Coding("appended", compression, endian, words, base64=False)


def write_legacy(writer, data, path, binary, version):
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    writer.SetFileType(vtk.VTK_BINARY if binary else vtk.VTK_ASCII)
    writer.SetFileVersion(LEGACY_VERSIONS[version])
    assert writer.Write(), f"VTK cannot write {path}"


def read(reader, path):
    """A file as VTK reads it back, with every array."""
    reader.SetFileName(str(path))
    for kind in ["Scalars", "Vectors", "Fields"]:
        if hasattr(reader, f"ReadAll{kind}On"):
            getattr(reader, f"ReadAll{kind}On")()
    reader.Update()
    return reader.GetOutput()


def volume(data, array):
    """An image as a volume. VTK does not say which space it means."""
    affine = np.eye(4)
    directions = np.array([[data.GetDirectionMatrix().GetElement(i, j) for j in range(3)] for i in range(3)])
    affine[:3, :3] = directions * np.array(data.GetSpacing())
    affine[:3, 3] = np.array(data.GetOrigin()) + affine[:3, :3] @ np.array(data.GetExtent()[::2])
    values = vtk_to_numpy(array).reshape(data.GetDimensions()[::-1]) if array is not None else None
    return Volume(values, affine)


def image(dtype, directions=None):
    data = vtk.vtkImageData()
    data.SetDimensions(*DIMS)
    place(data, np.eye(3) if directions is None else directions)
    attach(data.GetPointData(), "noise", noise(dtype, 1, DIMS[::-1]))
    data.GetPointData().SetActiveScalars("noise")
    return data


def place(data, directions):
    data.SetSpacing(0.75, 1.5, 2.25)
    data.SetOrigin(-41.5, 17.25, 103.0)
    for i, j in np.ndindex(3, 3):
        data.GetDirectionMatrix().SetElement(i, j, directions[i, j])


def attach(attributes, name, values):
    """Adds an array; its last axis are components if there are more axes than those of a grid."""
    components = values.shape[-1] if values.ndim in (2, 4) else 1
    flat = np.ascontiguousarray(values.reshape(-1, components) if components > 1 else values.reshape(-1))
    array = numpy_to_vtk(flat, deep=True)
    array.SetName(name)
    attributes.AddArray(array)


def attach_all(data):
    """Arrays of points and cells, scalars and vectors, that VTK's writers know by name."""
    points, cells = data.GetNumberOfPoints(), data.GetNumberOfCells()
    for name, dtype, seed in [("density", "f4", 1), ("energy", "f8", 2), ("label", "i4", 3), ("byte", "u1", 4)]:
        attach(data.GetPointData(), name, noise(dtype, seed, (points,)))
    attach(data.GetPointData(), "velocity", noise("f4", 5, (points, 3)))
    attach(data.GetCellData(), "volume", noise("f4", 6, (cells,)))
    attach(data.GetCellData(), "flux", noise("f8", 7, (cells, 3)))
    return data


def rectilinear():
    data = vtk.vtkRectilinearGrid()
    data.SetDimensions(*DIMS)
    generator = np.random.default_rng(60)
    for axis, size in zip("XYZ", DIMS, strict=True):
        places = np.cumsum(generator.uniform(0.5, 2.0, size)) - 3.0
        getattr(data, f"Set{axis}Coordinates")(numpy_to_vtk(places, deep=True))
    return attach_all(data)


def bent_positions():
    z, y, x = np.meshgrid(*[np.arange(size, dtype=np.float64) for size in DIMS[::-1]], indexing="ij")
    bent = np.stack([x + 0.2 * np.sin(y), 1.5 * y + 0.1 * z, 2.0 * z + 0.1 * np.cos(x)], -1)
    return bent.reshape(-1, 3) @ rotation(61).T + [10.0, -20.0, 30.0]


def points(positions):
    made = vtk.vtkPoints()
    made.SetDataTypeToDouble()
    made.SetData(numpy_to_vtk(np.ascontiguousarray(positions), deep=True))
    return made


def structured():
    data = vtk.vtkStructuredGrid()
    data.SetDimensions(*DIMS)
    data.SetPoints(points(bent_positions()))
    return attach_all(data)


def unstructured():
    """Hexahedra, voxels, wedges, pyramids and tetrahedra."""
    data = vtk.vtkUnstructuredGrid()
    data.SetPoints(points(bent_positions()))
    nx, ny, nz = DIMS
    kinds = itertools.cycle(["hexahedron", "voxel", "wedge", "pyramid", "tetrahedron"])
    for k, j, i in np.ndindex(nz - 1, ny - 1, nx - 1):
        corner = i + nx * (j + ny * k)
        low = [corner, corner + 1, corner + nx + 1, corner + nx]
        high = [vertex + nx * ny for vertex in low]
        cell, vertices = {
            "hexahedron": (vtk.VTK_HEXAHEDRON, [*low, *high]),
            "voxel": (vtk.VTK_VOXEL, [low[0], low[1], low[3], low[2], high[0], high[1], high[3], high[2]]),
            "wedge": (vtk.VTK_WEDGE, [low[0], low[3], low[1], high[0], high[3], high[1]]),
            "pyramid": (vtk.VTK_PYRAMID, [*low, high[0]]),
            "tetrahedron": (vtk.VTK_TETRA, [low[0], low[1], low[3], high[0]]),
        }[next(kinds)]
        data.InsertNextCell(cell, len(vertices), vertices)
    return attach_all(data)


# Maker, XML writer and reader, suffix, legacy writer and reader.
GRIDS = {
    "rectilinear": (
        rectilinear,
        vtk.vtkXMLRectilinearGridWriter,
        vtk.vtkXMLRectilinearGridReader,
        ".vtr",
        vtk.vtkRectilinearGridWriter,
        vtk.vtkRectilinearGridReader,
    ),
    "structured": (
        structured,
        vtk.vtkXMLStructuredGridWriter,
        vtk.vtkXMLStructuredGridReader,
        ".vts",
        vtk.vtkStructuredGridWriter,
        vtk.vtkStructuredGridReader,
    ),
    "unstructured": (
        unstructured,
        vtk.vtkXMLUnstructuredGridWriter,
        vtk.vtkXMLUnstructuredGridReader,
        ".vtu",
        vtk.vtkUnstructuredGridWriter,
        vtk.vtkUnstructuredGridReader,
    ),
}


def cloud():
    data = vtk.vtkPolyData()
    data.SetPoints(points(bent_positions()))
    cells = vtk.vtkCellArray()
    for index in range(data.GetNumberOfPoints()):
        cells.InsertNextCell(1, [index])
    data.SetVerts(cells)
    return data


def sphere():
    source = vtk.vtkSphereSource()
    source.SetCenter(10.0, -20.0, 30.0)
    source.SetRadius(4.0)
    source.Update()
    return source.GetOutput()


def strips():
    stripper = vtk.vtkStripper()
    stripper.SetInputData(sphere())
    stripper.Update()
    return stripper.GetOutput()


POLYGONS = {"points": cloud, "triangles": sphere, "strips": strips}


def triangle_count(data):
    triangles = vtk.vtkTriangleFilter()
    triangles.SetInputData(data)
    triangles.PassVertsOff()
    triangles.PassLinesOff()
    triangles.Update()
    return triangles.GetOutput().GetNumberOfPolys()


def agree_on_bounds(said, bounds):
    """To the rounding of 32 bits."""
    found = np.array([said["min"], said["max"]]).T
    scale = np.abs(bounds).max()
    assert np.abs(found - bounds).max() <= 1e-6 * scale, f"bounds {found.tolist()}, expected {bounds.tolist()}"


def agree_on_surface(said, triangles, bounds):
    """Faces become small discs: as many triangles, centres inside the bounds and almost as far out."""
    counted = re.search(r"(\d+) triangles as (\d+) surfels", said["stored-type"])
    assert counted, f"no triangles in {said['stored-type']!r}"
    assert int(counted[1]) == triangles, f"{counted[1]} triangles, expected {triangles}"
    assert int(counted[2]) == said["count"], f"{counted[2]} surfels, {said['count']} points"
    found = np.array([said["min"], said["max"]]).T
    inset = (found - bounds) * [1, -1]
    size = np.ptp(bounds, axis=1).max()
    assert (inset >= -1e-6 * np.abs(bounds).max()).all(), f"bounds {found.tolist()} exceed {bounds.tolist()}"
    # The centre of a disc is not nearer to an edge than its radius.
    assert (inset <= max(0.02 * size, 2 * said["radii"][1])).all(), (
        f"bounds {found.tolist()}, expected {bounds.tolist()}"
    )
