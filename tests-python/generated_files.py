"""Files written by nibabel, pynrrd, SimpleITK and numpy, that splatvol must read as they do."""

import itertools

import nibabel
import nrrd
import numpy as np
import SimpleITK

from comparison import compare
from other_readers import with_nibabel, with_numpy, with_pynrrd, with_simpleitk
from splatvol_cli import Refused, Volume

SHAPE_XYZ = (5, 6, 7)
TYPES = ["u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"]
ITK_TYPES = ["u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"]


def noise(dtype, seed=1, shape=SHAPE_XYZ):
    """Seeded samples that use the type's range."""
    generator = np.random.default_rng(seed)
    if np.dtype(dtype).kind == "f":
        return (generator.standard_normal(shape) * 1000).astype(dtype)
    limits = np.iinfo(dtype)
    return generator.integers(limits.min, limits.max, shape, endpoint=True, dtype=np.dtype(dtype).newbyteorder("="))


def rotation(seed):
    """A seeded rotation matrix."""
    q, r = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def oblique_affine(seed=2):
    """Rotated axes of different spacing, away from the origin."""
    affine = np.eye(4)
    affine[:3, :3] = rotation(seed) @ np.diag([0.75, 1.5, 2.25])
    affine[:3, 3] = [-41.5, 17.25, 103.0]
    return affine


def cases(splatvol, folder):
    """Named checks."""
    return Generator(splatvol, folder).cases()


class Generator:
    """Checks that write into `folder` and read back."""

    def __init__(self, splatvol, folder):
        self.splatvol = splatvol
        self.folder = folder

    def agree(self, reader, path, *options, exact=True):
        """splatvol and `reader` agree on a file."""
        compare(reader(path), self.splatvol.read(path, *options), exact)

    def cases(self):
        """Named checks."""
        yield from self.nifti_orientations()
        yield from self.nifti_types()
        yield from self.nifti_geometry()
        yield from self.nifti_series()
        yield from self.nrrd_files()
        yield from self.nrrd_spaces()
        yield from self.itk_files()
        yield from self.numpy_files()
        yield from self.refusals()

    # NIfTI by nibabel

    def nifti_orientations(self):
        """All 48 ways in which voxel axes can lie along the body's."""
        for order in itertools.permutations(range(3)):
            for signs in itertools.product([1, -1], repeat=3):
                affine = np.eye(4)
                affine[:3, :3] = 0
                for voxel_axis, (world_axis, sign) in enumerate(zip(order, signs)):
                    affine[world_axis, voxel_axis] = sign * [0.5, 1.25, 2.0][voxel_axis]
                affine[:3, 3] = [12.5, -7.0, 33.0]
                code = "".join(nibabel.aff2axcodes(affine))
                yield f"NIfTI orientation {code}", lambda affine=affine, code=code: self.orientation(affine, code)

    def orientation(self, affine, code):
        path = self.folder / f"{code}.nii"
        nibabel.save(nibabel.Nifti1Image(noise("i2"), affine), path)
        self.agree(with_nibabel, path)
        said = self.splatvol.run("info", path)
        assert f" {code} " in said, f"info does not name the orientation {code}:\n{said}"

    def nifti_types(self):
        """Types, byte orders, versions, and the three ways to store them."""
        versions = {1: (nibabel.Nifti1Image, nibabel.Nifti1Pair), 2: (nibabel.Nifti2Image, nibabel.Nifti2Pair)}
        for dtype, endian, version in itertools.product(TYPES, "<>", versions):
            for suffix in [".nii", ".nii.gz", ".img"]:
                image_class = versions[version][suffix == ".img"]
                name = f"v{version}_{dtype}_{'le' if endian == '<' else 'be'}{suffix}"
                yield f"NIfTI {name}", lambda n=name, c=image_class, d=dtype, e=endian: self.nifti_type(n, c, d, e)

    def nifti_type(self, name, image_class, dtype, endian):
        header = image_class.header_class(endianness=endian)
        header.set_data_dtype(np.dtype(endian + dtype))
        path = self.folder / name
        nibabel.save(image_class(noise(dtype), oblique_affine(), header), path)
        self.agree(with_nibabel, path)

    def nifti_geometry(self):
        """qform alone, sform alone, shear, neither; slope and intercept."""
        sheared = oblique_affine()
        sheared[:3, :3] = sheared[:3, :3] @ np.array([[1, 0.2, 0], [0, 1, 0.4], [0, 0, 1]])
        mirrored = oblique_affine() @ np.diag([1.0, 1.0, -1.0, 1.0])
        for name, affine, qform, sform in [
            ("qform", oblique_affine(), 1, 0),
            ("qform mirrored", mirrored, 1, 0),
            ("qform half turn", np.diag([-2.0, -3.0, 4.0, 1.0]), 1, 0),
            ("sform", oblique_affine(3), 0, 2),
            ("sform sheared", sheared, 0, 1),
        ]:
            yield f"NIfTI {name}", lambda n=name, a=affine, q=qform, s=sform: self.nifti_form(n, a, q, s)
        yield "NIfTI slope and intercept", self.nifti_rescaled

    def nifti_form(self, name, affine, qform, sform):
        image = nibabel.Nifti1Image(noise("u1"), None)
        image.header.set_qform(affine if qform else None, qform)
        image.header.set_sform(affine if sform else None, sform)
        path = self.folder / f"{name.replace(' ', '_')}.nii"
        image.to_filename(path)
        self.agree(with_nibabel, path)

    def nifti_rescaled(self):
        image = nibabel.Nifti1Image(noise("i2") / 32768 * 700 - 300, oblique_affine())
        image.header.set_data_dtype(np.int16)
        image.header.set_slope_inter(0.03125, -300.5)
        path = self.folder / "rescaled.nii.gz"
        image.to_filename(path)
        self.agree(with_nibabel, path, exact=False)

    def nifti_series(self):
        """Time points of a 4-D file."""
        path = self.folder / "series.nii.gz"
        nibabel.save(nibabel.Nifti1Image(noise("i2", 5, (*SHAPE_XYZ, 3)), oblique_affine()), path)
        for time in range(3):
            yield f"NIfTI time {time}", lambda t=time: self.agree(
                lambda path: with_nibabel(path, t), path, "--time", t
            )

    # NRRD by pynrrd

    def nrrd_files(self):
        """Types, byte orders, encodings, attached and detached."""
        for dtype, encoding, suffix in itertools.product(TYPES, ["raw", "gzip", "ASCII"], [".nrrd", ".nhdr"]):
            name = f"{dtype}_{encoding}{suffix}"
            yield f"NRRD {name}", lambda n=name, d=dtype, e=encoding: self.nrrd_file(n, noise(d), {"encoding": e})
        for dtype in ["u2", "i4", "f4", "f8"]:
            header = {"encoding": "raw", "endian": "big"}
            name = f"{dtype}_big.nrrd"
            yield f"NRRD {name}", lambda n=name, d=dtype, h=header: self.nrrd_file(n, noise(">" + d), h)
        yield "NRRD spacings", lambda: self.nrrd_file("spacings.nrrd", noise("i2"), {"spacings": [0.5, 2.0, 3.0]})
        yield "NRRD components", self.nrrd_components

    def nrrd_file(self, name, values, header):
        path = self.folder / name
        nrrd.write(str(path), values, header)
        self.agree(with_pynrrd, path)

    def nrrd_components(self):
        path = self.folder / "components.nrrd"
        values = noise("u1", 6, (3, *SHAPE_XYZ))
        nrrd.write(str(path), values, {"kinds": ["vector", "domain", "domain", "domain"]})
        for component in range(3):
            actual = self.splatvol.read(path, "--component", component)
            compare(Volume(values[component].T, np.eye(4)), actual)

    def nrrd_spaces(self):
        """Named spaces with oblique directions."""
        for space in ["right-anterior-superior", "left-anterior-superior", "left-posterior-superior", "LPS", "RAS"]:
            yield f"NRRD space {space}", lambda space=space: self.nrrd_space(space)

    def nrrd_space(self, space):
        affine = oblique_affine(7)
        header = {
            "space": space,
            "space directions": affine[:3, :3].T,
            "space origin": affine[:3, 3],
            "kinds": ["domain"] * 3,
        }
        path = self.folder / f"space_{space}.nrrd"
        nrrd.write(str(path), noise("i2"), header)
        self.agree(with_pynrrd, path)
        self.agree(with_simpleitk, path)

    # MetaImage, NRRD and VTK by ITK

    def itk_files(self):
        """Types and compression of every format that ITK writes and splatvol reads, in oblique position."""
        for suffix, dtype, compress in itertools.product([".mha", ".mhd", ".nrrd"], ITK_TYPES, [False, True]):
            name = f"itk_{dtype}_{'zip' if compress else 'raw'}{suffix}"
            yield f"ITK {name}", lambda n=name, d=dtype, c=compress: self.itk_file(n, d, c)
        for dtype in ["u1", "i2", "u2", "f4", "f8"]:
            name = f"itk_{dtype}.vtk"
            yield f"ITK {name}", lambda n=name, d=dtype: self.itk_file(n, d, False)

    def itk_file(self, name, dtype, compress):
        image = SimpleITK.GetImageFromArray(noise(dtype, 8).T)
        image.SetSpacing([0.75, 1.5, 2.25])
        image.SetOrigin([-41.5, 17.25, 103.0])
        if not name.endswith(".vtk"):
            image.SetDirection(rotation(9).flatten().tolist())
        path = self.folder / name
        SimpleITK.WriteImage(image, str(path), useCompression=compress)
        self.agree(with_simpleitk, path)

    # Arrays by numpy

    def numpy_files(self):
        """Types, byte orders, memory orders, archives."""
        for dtype, endian, order in itertools.product([*TYPES, "f2"], "<>", "CF"):
            name = f"{dtype}_{'le' if endian == '<' else 'be'}_{order}.npy"
            values = np.array(noise(dtype).astype(endian + dtype), order=order)
            yield f"numpy {name}", lambda n=name, v=values: self.numpy_file(n, v)
        for save in [np.savez, np.savez_compressed]:
            yield f"numpy {save.__name__}", lambda save=save: self.numpy_archive(save)

    def numpy_file(self, name, values):
        path = self.folder / name
        np.save(path, values)
        self.agree(with_numpy, path)

    def numpy_archive(self, save):
        path = self.folder / f"{save.__name__}.npz"
        save(path, first=noise("i2", 10), second=noise("f4", 11))
        for name in ["first", "second"]:
            self.agree(lambda path, name=name: with_numpy(path, name), path, "--array", name)

    # What must be refused

    def refusals(self):
        """Samples that are not real numbers, and files that end too soon."""
        complex_path = self.folder / "complex.nii"
        nibabel.save(nibabel.Nifti1Image(noise("f4").astype(np.complex64), np.eye(4)), complex_path)
        yield "refuse complex NIfTI", lambda: self.refuse(complex_path)
        whole = self.folder / "whole.nii"
        nibabel.save(nibabel.Nifti1Image(noise("f4"), np.eye(4)), whole)
        for size in [100, 348, 400]:
            cut = self.folder / f"cut_{size}.nii"
            cut.write_bytes(whole.read_bytes()[:size])
            yield f"refuse NIfTI cut at {size} bytes", lambda path=cut: self.refuse(path)

    def refuse(self, path):
        try:
            self.splatvol.read(path)
        except Refused as refused:
            assert refused.code == 3, f"exit code {refused.code}, expected 3"
        else:
            raise AssertionError("was read")
