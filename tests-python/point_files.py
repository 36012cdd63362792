"""Clouds of points, meshes and Gaussians written by laspy, plyfile and pypcd4, that splatvol must read as they do.

The command says how many points there are and where they lie; files of one point each say where every single one lies.
"""

import itertools

import imagecodecs
import laspy
import numpy as np
from plyfile import PlyData, PlyElement
from pypcd4 import Encoding, PointCloud

from generated_files import rotation
from vtk_files import agree_on_surface

COUNT = 500
# Points that are also written into files of their own.
ALONE = range(0, COUNT, 125)
PLY = {"ascii": (True, "="), "little-endian": (False, "<"), "big-endian": (False, ">")}
LAS_VERSIONS = {
    **{form: "1.2" for form in range(4)},
    **{form: "1.3" for form in (4, 5)},
    **{form: "1.4" for form in range(6, 11)},
}
PCD = {"ascii": Encoding.ASCII, "binary": Encoding.BINARY, "compressed": Encoding.BINARY_COMPRESSED}
COLORED_LAS = {2, 3, 5, 7, 8, 10}
# lazrs codes no waveforms.
LAZ_FORMATS = [0, 1, 2, 3, 6, 7, 8]


def cases(splatvol, folder):
    """Named checks."""
    return Clouds(splatvol, folder).cases()


class Clouds:
    """Checks that write into `folder` and read back."""

    def __init__(self, splatvol, folder):
        self.splatvol = splatvol
        self.folder = folder / "points"
        self.folder.mkdir()

    def cases(self):
        for form, offset in itertools.product(LAS_VERSIONS, [0.0, 5.0e6]):
            name = f"{form}{' far away' if offset else ''}"
            yield f"LAS format {name}", lambda n=name, f=form, o=offset: self.las(n, f, o, ".las")
        for form, offset in itertools.product(LAZ_FORMATS, [0.0, 5.0e6]):
            name = f"{form}{' far away' if offset else ''}"
            yield f"LAZ format {name}", lambda n=name, f=form, o=offset: self.las(n, f, o, ".laz")
        yield "LAZ of several chunks", lambda: self.las("chunks", 7, 0.0, ".laz", 120_000)
        for coding, dtype in itertools.product(PLY, ["f4", "f8", "i4", "u2", "i1"]):
            yield f"PLY {coding} {dtype}", lambda c=coding, d=dtype: self.ply(f"{c} {d}", c, d)
        for coding, extra in itertools.product(PLY, ["normals", "colours", "16-bit colours", "float colours", "lists"]):
            yield f"PLY {coding} with {extra}", lambda c=coding, e=extra: self.ply(f"{c} {e}", c, "f4", e)
        for coding, corners in itertools.product(PLY, [3, 4, 6]):
            yield f"PLY {coding} faces of {corners}", lambda c=coding, n=corners: self.ply_faces(c, n)
        for coding, degree in itertools.product(PLY, range(4)):
            yield f"PLY {coding} Gaussians of degree {degree}", lambda c=coding, d=degree: self.gaussians(c, d)
        for coding, fields in itertools.product(PCD, PCD_FIELDS):
            yield f"PCD {coding} {fields}", lambda c=coding, f=fields: self.pcd(c, f)

    def path(self, name, suffix):
        return self.folder / f"{name.replace(' ', '_')}{suffix}"

    def agree(self, path, positions, colors=False, normals=False, kind="points"):
        """Number of points and their bounds; what each point has, where that is known."""
        said = self.splatvol.info(path)
        assert said["kind"] == kind, f"kind {said['kind']}"
        assert said["count"] == len(positions), f"{said['count']} points, expected {len(positions)}"
        found, wanted = np.array([said["min"], said["max"]]), np.array([positions.min(0), positions.max(0)])
        # Far from zero, positions are kept from an origin of their own.
        size = max(np.ptp(wanted, axis=0).max(), np.abs(wanted).max() if np.abs(wanted).max() < 1e4 else 1.0)
        assert np.abs(found - wanted).max() <= 1e-6 * size, f"bounds {found.tolist()}, expected {wanted.tolist()}"
        assert colors is None or said["has-colors"] == colors, f"colours: {said['has-colors']}"
        assert said["has-normals"] == normals, f"normals: {said['has-normals']}"
        return said

    def agree_on_color(self, path, color):
        """A picture of a single point has its colour."""
        picture = self.folder / "picture.png"
        options = ["--radius", 10, "--orthographic=2", "--background", "none", "--size", "8x8"]
        self.splatvol.run("render", path, "-o", picture, "--overwrite", *options)
        pixel = imagecodecs.png_decode(picture.read_bytes())[4, 4]
        assert pixel[3] > 0, "no point in the picture"
        assert np.abs(pixel[:3] - np.round(color)).max() <= 1, f"colour {pixel[:3]}, expected {color}"

    # LAS and LAZ

    def las(self, name, form, offset, suffix, count=COUNT):
        data = laspy.LasData(header(form, offset))
        data.xyz = positions(count) + [offset / 10, offset, 0.0]
        generator = np.random.default_rng(1)
        data.intensity = generator.integers(0, 1 << 16, count)
        data.classification = generator.integers(0, 32, count)
        if form in COLORED_LAS:
            for channel in ["red", "green", "blue"]:
                data[channel] = generator.integers(0, 1 << 16, count)
        path = self.path(f"{name} {count}", suffix)
        data.write(path)
        # Without colours of their own, points are coloured by their classes.
        written = laspy.read(path)
        self.agree(path, written.xyz, colors=True)
        for index in ALONE if count == COUNT else []:
            alone = self.path(f"{name} alone {index}", suffix)
            one = laspy.LasData(data.header, data.points[index : index + 1])
            one.write(alone)
            read = laspy.read(alone)
            self.agree(alone, read.xyz, colors=form in COLORED_LAS or None)
            if form in COLORED_LAS:
                self.agree_on_color(alone, [read[name][0] / 257 for name in ["red", "green", "blue"]])

    # PLY

    def ply(self, name, coding, dtype, extra=None):
        vertices = vertices_of(dtype, extra)
        path = self.path(name, ".ply")
        elements = [PlyElement.describe(vertices, "vertex")]
        if extra == "lists":
            # Rows of different lengths before and after the vertices.
            lists = np.empty(3, [("numbers", object), ("weight", "f4")])
            lists["numbers"] = [np.arange(n, dtype="i4") for n in (0, 2, 5)]
            lists["weight"] = 1.5
            elements = [PlyElement.describe(lists, "before"), *elements, PlyElement.describe(lists, "after")]
        write_ply(elements, coding, path)
        written = PlyData.read(path)["vertex"]
        places = np.stack([written[axis] for axis in "xyz"], -1).astype(np.float64)
        self.agree(path, places, "colours" in (extra or ""), extra == "normals")
        for index in ALONE:
            alone = self.path(f"{name} alone {index}", ".ply")
            write_ply([PlyElement.describe(vertices[index : index + 1], "vertex")], coding, alone)
            self.agree(alone, places[index : index + 1], "colours" in (extra or ""), extra == "normals")
            if "colours" in (extra or ""):
                scale = {"colours": 1, "16-bit colours": 1 / 257, "float colours": 255}[extra]
                self.agree_on_color(alone, [vertices[name][index] * scale for name in ["red", "green", "blue"]])

    def ply_faces(self, coding, corners):
        """Polygons on a bent sheet; a fan of triangles each."""
        vertices = vertices_of("f8", None)[: 8 * corners]
        angles = 2 * np.pi * np.arange(corners) / corners
        ring = np.stack([np.cos(angles), np.sin(angles), 0 * angles], -1)
        places = np.concatenate([ring @ rotation(i).T + [3.0 * i, 0.0, 0.0] for i in range(8)])
        for axis, name in enumerate("xyz"):
            vertices[name] = places[:, axis]
        faces = np.empty(8, [("vertex_indices", "i4", (corners,))])
        faces["vertex_indices"] = np.arange(8 * corners).reshape(8, corners)
        path = self.path(f"{coding} faces {corners}", ".ply")
        write_ply([PlyElement.describe(vertices, "vertex"), PlyElement.describe(faces, "face")], coding, path)
        said = self.splatvol.info(path)
        agree_on_surface(said, 8 * (corners - 2), np.array([places.min(0), places.max(0)]).T)

    def gaussians(self, coding, degree):
        names = ["x", "y", "z", "nx", "ny", "nz", *[f"f_dc_{i}" for i in range(3)]]
        names += [f"f_rest_{i}" for i in range(3 * ((degree + 1) ** 2 - 1))]
        names += ["opacity", *[f"scale_{i}" for i in range(3)], *[f"rot_{i}" for i in range(4)]]
        rows = np.zeros(COUNT, [(name, "f4") for name in names])
        generator = np.random.default_rng(2)
        for name in names:
            rows[name] = generator.normal(size=COUNT)
        for axis, name in enumerate("xyz"):
            rows[name] = positions()[:, axis]
        for axis in range(3):
            rows[f"scale_{axis}"] -= 12.0  # Tiny, so that bounds are those of the centres.
        path = self.path(f"{coding} Gaussians {degree}", ".ply")
        write_ply([PlyElement.describe(rows, "vertex")], coding, path)
        said = self.splatvol.info(path)
        assert said["kind"] == "gaussians", f"kind {said['kind']}"
        assert (said["count"], said["degree"]) == (COUNT, degree), f"{said['count']} of degree {said['degree']}"

    # PCD

    def pcd(self, coding, fields):
        names, types = PCD_FIELDS[fields]
        generator = np.random.default_rng(3)
        columns = [positions()[:, "xyz".index(n)] if n in "xyz" else generator.integers(1, 100, COUNT) for n in names]
        if fields == "colours":
            columns[3] = PointCloud.encode_rgb(generator.integers(0, 256, (COUNT, 3), dtype="u1"))
        columns = [np.asarray(c).astype(t) for c, t in zip(columns, types, strict=True)]
        path = self.path(f"{coding} {fields}", ".pcd")
        PointCloud.from_points(columns, names, types).save(path, PCD[coding])
        places = PointCloud.from_path(path).numpy(("x", "y", "z")).astype(np.float64)
        self.agree(path, places, fields == "colours" or "intensity" in names, fields == "normals")


PCD_FIELDS = {
    "floats": (("x", "y", "z"), (np.float32,) * 3),
    "doubles": (("x", "y", "z"), (np.float64,) * 3),
    "another order": (("label", "z", "x", "y"), (np.uint16, np.float32, np.float64, np.float32)),
    "intensities": (("x", "y", "z", "intensity"), (np.float32,) * 4),
    "colours": (("x", "y", "z", "rgb"), (np.float32,) * 4),
    "normals": (("x", "y", "z", "normal_x", "normal_y", "normal_z"), (np.float32,) * 6),
}


def positions(count=COUNT):
    """A seeded cloud, away from the origin."""
    return np.random.default_rng(4).uniform([-100.0, 20.0, -7.5], [100.0, 60.0, 12.5], (count, 3))


def header(form, offset):
    made = laspy.LasHeader(point_format=form, version=LAS_VERSIONS[form])
    made.scales, made.offsets = [0.001, 0.002, 0.0005], [offset / 10, offset, -3.25]
    return made


def vertices_of(dtype, extra):
    fields = [(axis, dtype) for axis in "xyz"]
    color = {"colours": "u1", "16-bit colours": "u2", "float colours": "f4"}.get(extra)
    fields += [(name, color) for name in ["red", "green", "blue"] if color]
    fields += [(name, "f4") for name in ["nx", "ny", "nz"] if extra == "normals"]
    rows = np.zeros(COUNT, fields)
    for axis, name in enumerate("xyz"):
        rows[name] = (
            positions()[:, axis] * (600 if dtype == "u2" else 1)
            if dtype != "u2"
            else np.abs(positions()[:, axis] * 600)
        )
    generator = np.random.default_rng(5)
    for name, kind in fields[3:]:
        rows[name] = (
            generator.uniform(0, 1, COUNT) if kind == "f4" else generator.integers(0, np.iinfo(kind).max, COUNT)
        )
    return rows


def write_ply(elements, coding, path):
    text, order = PLY[coding]
    PlyData(elements, text=text, byte_order=order, comments=["by plyfile"]).write(path)
