"""DICOM files written by pydicom, whose samples pydicom and whose places ITK (GDCM) reads as splatvol does.

Compressed frames come from encoders of their own: pydicom's (RLE), OpenJPEG (JPEG 2000), CharLS (JPEG-LS) and
libjpeg-turbo (JPEG).
"""

import itertools
from dataclasses import dataclass

import imagecodecs
import numpy as np
import pydicom
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.encaps import encapsulate, generate_frames
from pydicom.pixels import apply_rescale
from pydicom.sequence import Sequence
from pydicom.uid import (
    JPEG2000,
    CTImageStorage,
    DeflatedExplicitVRLittleEndian,
    EnhancedCTImageStorage,
    ExplicitVRBigEndian,
    ExplicitVRLittleEndian,
    ImplicitVRLittleEndian,
    JPEG2000Lossless,
    JPEGBaseline8Bit,
    JPEGExtended12Bit,
    JPEGLossless,
    JPEGLosslessSV1,
    JPEGLSLossless,
    JPEGLSNearLossless,
    RLELossless,
    generate_uid,
)

from comparison import LPS_TO_RAS, compare
from generated_files import rotation
from other_readers import with_simpleitk
from splatvol_cli import Volume

PLAIN = {
    "implicit": ImplicitVRLittleEndian,
    "explicit": ExplicitVRLittleEndian,
    "big": ExplicitVRBigEndian,
    "deflated": DeflatedExplicitVRLittleEndian,
}
LOSSLESS = {
    "RLE": RLELossless,
    "JPEG2000": JPEG2000Lossless,
    "JPEG-LS": JPEGLSLossless,
    "JPEG_lossless": JPEGLosslessSV1,
}
# Where decoders' inverse cosine transforms may differ by rounding (ISO 10918-2 allows one).
ROUNDING = 1
# OpenJPEG's five wavelet levels need 32 samples along each axis.
SLICES, ROWS, COLUMNS = 4, 33, 37
SPACING = (0.75, 0.5)  # Between rows, between columns.
STEP = 2.25
POSITION = np.array([-41.5, 17.25, 103.0])


@dataclass(frozen=True)
class Form:
    """How samples are stored."""

    allocated: int = 16
    stored: int = 16
    signed: bool = False
    photometric: str = "MONOCHROME2"
    slope: float = 1.0
    intercept: float = 0.0

    @property
    def dtype(self):
        return np.dtype(f"{'i' if self.signed else 'u'}{self.allocated // 8}")

    def noise(self, seed=1, shape=(SLICES, ROWS, COLUMNS)):
        """Samples that use all bits; neighbours are alike, so that predictors and runs have work."""
        low, high = (
            (-(1 << (self.stored - 1)), (1 << (self.stored - 1)) - 1) if self.signed else (0, (1 << self.stored) - 1)
        )
        generator = np.random.default_rng(seed)
        values = generator.integers(low, high, shape, endpoint=True, dtype=np.int64)
        values[..., ::3] = low + (high - low) // 3
        values.flat[:2] = [low, high]
        return values.astype(self.dtype)

    def __str__(self):
        sign = "i" if self.signed else "u"
        rest = "" if self.photometric == "MONOCHROME2" else f" {self.photometric}"
        scale = "" if (self.slope, self.intercept) == (1.0, 0.0) else " rescaled"
        return f"{sign}{self.stored} in {self.allocated}{rest}{scale}"


UNSIGNED_8, UNSIGNED_12, UNSIGNED_16 = Form(8, 8), Form(16, 12), Form()
SIGNED_8, SIGNED_12, SIGNED_16 = Form(8, 8, True), Form(16, 12, True), Form(16, 16, True)
FORMS = [
    *[UNSIGNED_8, UNSIGNED_12, UNSIGNED_16, SIGNED_8, SIGNED_12, SIGNED_16],
    *[Form(32, 32), Form(32, 32, True), Form(16, 10)],
    Form(16, 12, False, "MONOCHROME2", 1.0, -1024.0),
    Form(16, 16, True, "MONOCHROME2", 0.03125, -300.5),
    *[Form(8, 8, False, "MONOCHROME1"), Form(16, 12, False, "MONOCHROME1"), Form(16, 16, True, "MONOCHROME1")],
    Form(16, 12, False, "MONOCHROME1", 2.0, -1024.0),
]


def cases(splatvol, folder):
    """Named checks."""
    return Dicom(splatvol, folder).cases()


class Dicom:
    """Checks that write into `folder` and read back."""

    def __init__(self, splatvol, folder):
        self.splatvol = splatvol
        self.folder = folder / "dicom"
        self.folder.mkdir()

    def cases(self):
        for name, form in itertools.product(PLAIN, FORMS):
            yield f"DICOM {name}, {form}", lambda n=name, f=form: self.series(f"{n} {f}", f, PLAIN[n])
        for name, form in itertools.product(LOSSLESS, FORMS):
            if form.allocated <= 16:
                yield f"DICOM {name}, {form}", lambda n=name, f=form: self.series(f"{n} {f}", f, LOSSLESS[n])
        for predictor in range(1, 8):
            yield f"DICOM JPEG lossless, predictor {predictor}", lambda p=predictor: self.predictor(p)
        yield "DICOM JPEG-LS near-lossless", lambda: self.lossy(UNSIGNED_12, JPEGLSNearLossless)
        yield "DICOM JPEG 2000 lossy", lambda: self.lossy(UNSIGNED_12, JPEG2000)
        for decibels in [30, 40, 60]:
            yield f"DICOM JPEG 2000 cut to {decibels} dB", lambda d=decibels: self.truncated_wavelets(d)
        yield "DICOM JPEG baseline", lambda: self.lossy(UNSIGNED_8, JPEGBaseline8Bit)
        for name, syntax in {**PLAIN, **LOSSLESS}.items():
            yield f"DICOM multi-frame, {name}", lambda n=name, s=syntax: self.multi_frame(n, s)
            yield f"DICOM enhanced, {name}", lambda n=name, s=syntax: self.enhanced(n, s)
        yield "DICOM fragments by the table of offsets", self.fragments
        yield "DICOM rescale per slice", self.rescale_per_slice
        for seed in range(3):
            yield f"DICOM oblique {seed}", lambda s=seed: self.series(f"oblique {s}", SIGNED_16, seed=s)
        yield "DICOM without preamble", self.without_preamble
        yield "DICOM private elements and sequences", self.nested

    # Series of files

    def series(self, name, form, syntax=ExplicitVRLittleEndian, seed=0):
        """A folder of slices in any order."""
        values, directions = form.noise(seed), rotation(seed + 20)
        folder = self.folder / name.replace(" ", "_")
        folder.mkdir()
        for index in np.random.default_rng(seed).permutation(SLICES):
            dataset = self.slice(form, values[index], directions, index)
            encode(dataset, syntax)
            save(dataset, folder / f"{(index * 7) % 5}.dcm")
        self.agree(folder, form)
        # GDCM cannot deflate all of these; what it reads must lie where we say.
        if syntax in (ImplicitVRLittleEndian, ExplicitVRLittleEndian):
            self.agree_on_places(folder)

    def slice(self, form, values, directions, index):
        dataset = image(form, values)
        x, y, z = directions.T
        dataset.ImageOrientationPatient = decimals([*x, *y])
        dataset.ImagePositionPatient = decimals(POSITION + z * STEP * index)
        dataset.PixelSpacing = list(SPACING)
        dataset.InstanceNumber = int(index) + 1
        return dataset

    def agree(self, path, form=None, tolerance=0):
        """Samples and places by pydicom."""
        expected, actual = with_pydicom(path), self.splatvol.read(path)
        assert actual.unit == "mm", f"unit {actual.unit!r}"
        if tolerance:
            assert expected.values.shape == actual.values.shape, f"{actual.values.shape}"
            error = np.abs(expected.values - actual.values.astype(np.float64)).max()
            assert error <= tolerance, f"samples are off by {error:g}"
            expected = Volume(actual.values, expected.ras_from_voxel)
        compare(expected, actual, exact=form is None or form.slope == int(form.slope))

    def agree_on_places(self, folder):
        actual = self.splatvol.read(folder)
        compare(Volume(actual.values, gdcm_affine(folder)), actual)

    def single(self, name, form, coded, syntax, tolerance=0):
        """A file of one coded frame, read as another decoder does."""
        self.agree(self.coded_slice(name, form, coded, syntax), form, tolerance)

    def coded_slice(self, name, form, coded, syntax):
        dataset = self.slice(form, form.noise(3)[0], rotation(30), 0)
        dataset.PixelData = encapsulate([coded])
        dataset["PixelData"].VR = "OB"
        dataset["PixelData"].is_undefined_length = True
        dataset.file_meta.TransferSyntaxUID = syntax
        dataset.SliceThickness = STEP
        path = self.folder / f"{name}.dcm"
        save(dataset, path)
        return path

    def predictor(self, number):
        """The seven ways in which JPEG predicts a sample from its neighbours."""
        coded = imagecodecs.jpeg8_encode(UNSIGNED_16.noise(3)[0], lossless=True, predictor=number, bitspersample=16)
        self.single(f"predictor {number}", UNSIGNED_16, coded, JPEGLossless)

    def lossy(self, form, syntax):
        """What comes back is what another decoder reads, not what was written."""
        values = smooth(form)
        if syntax == JPEGLSNearLossless:
            self.single(syntax.name, form, imagecodecs.jpegls_encode(values, level=5), syntax)
        elif syntax == JPEG2000:
            coded = imagecodecs.jpeg2k_encode(
                values, level=0, codecformat="j2k", bitspersample=form.stored, reversible=False
            )
            self.single(syntax.name, form, coded, syntax, ROUNDING)
        else:
            self.single(syntax.name, form, imagecodecs.jpeg8_encode(values, level=80), syntax, ROUNDING)

    def truncated_wavelets(self, decibels):
        """Decoders may guess what was cut off (ISO 15444-1, E.1.1.2); they must be as near as OpenJPEG."""
        form, values = UNSIGNED_12, smooth(UNSIGNED_12)
        coded = imagecodecs.jpeg2k_encode(
            values, level=decibels, codecformat="j2k", bitspersample=form.stored, reversible=False
        )
        path = self.coded_slice(f"truncated {decibels}", form, coded, JPEG2000)

        def error(decoded):
            return np.sqrt(np.mean((decoded - values.astype(np.float64)) ** 2))

        wanted, found = error(imagecodecs.jpeg2k_decode(coded)), error(self.splatvol.read(path).values[0])
        assert found <= 1.1 * wanted, f"root mean square error {found:.2f}, OpenJPEG's is {wanted:.2f}"

    # Several frames in a file

    def multi_frame(self, name, syntax):
        """Frames without places of their own."""
        dataset = image(UNSIGNED_12, UNSIGNED_12.noise(4))
        dataset.NumberOfFrames = SLICES
        dataset.PixelSpacing = list(SPACING)
        dataset.SpacingBetweenSlices = STEP
        encode(dataset, syntax)
        path = self.folder / f"frames_{name}.dcm"
        save(dataset, path)
        expected = Volume(pixels(pydicom.dcmread(path)), None)
        actual = self.splatvol.read(path)
        compare(expected, actual)
        spacing = np.linalg.norm(actual.ras_from_voxel[:3, :3], axis=0)
        assert np.allclose(spacing, [SPACING[1], SPACING[0], STEP], rtol=1e-12), f"spacing {spacing}"

    def enhanced(self, name, syntax):
        """Frames whose places and scales are in functional groups, stored in no order."""
        path = self.folder / f"enhanced_{name}.dcm"
        dataset = self.enhanced_dataset(UNSIGNED_12)
        encode(dataset, syntax)
        save(dataset, path)
        self.agree(path)

    def enhanced_dataset(self, form):
        order = [2, 0, 3, 1]
        dataset = image(form, form.noise(5)[order])
        dataset.SOPClassUID = dataset.file_meta.MediaStorageSOPClassUID = EnhancedCTImageStorage
        dataset.NumberOfFrames = SLICES
        x, y, z = rotation(40).T
        measures = item(PixelSpacing=list(SPACING), SliceThickness=9.0)
        scale = item(RescaleSlope=2.0, RescaleIntercept=-1024.0)
        shared = item(
            PixelMeasuresSequence=Sequence([measures]),
            PlaneOrientationSequence=Sequence([item(ImageOrientationPatient=decimals([*x, *y]))]),
            PixelValueTransformationSequence=Sequence([scale]),
        )
        dataset.SharedFunctionalGroupsSequence = Sequence([shared])
        dataset.PerFrameFunctionalGroupsSequence = Sequence(
            [
                item(PlanePositionSequence=Sequence([item(ImagePositionPatient=decimals(POSITION + z * STEP * place))]))
                for place in order
            ]
        )
        return dataset

    def fragments(self):
        """Frames in several fragments each, told apart by the basic table of offsets."""
        form = UNSIGNED_16
        values = form.noise(6)
        dataset = image(form, values)
        dataset.NumberOfFrames = SLICES
        dataset.PixelSpacing = list(SPACING)
        dataset.SpacingBetweenSlices = STEP
        coded = [imagecodecs.jpegls_encode(frame) for frame in values]
        dataset.PixelData = encapsulate(coded, fragments_per_frame=3, has_bot=True)
        dataset["PixelData"].VR = "OB"
        dataset["PixelData"].is_undefined_length = True
        dataset.file_meta.TransferSyntaxUID = JPEGLSLossless
        path = self.folder / "fragments.dcm"
        save(dataset, path)
        compare(Volume(pixels(pydicom.dcmread(path)), None), self.splatvol.read(path))

    # What else headers say

    def rescale_per_slice(self):
        """Positron emission: each slice has a slope of its own."""
        folder = self.folder / "per slice"
        folder.mkdir()
        values = UNSIGNED_16.noise(7)
        for index in range(SLICES):
            dataset = self.slice(UNSIGNED_16, values[index], np.eye(3), index)
            dataset.RescaleSlope, dataset.RescaleIntercept = 0.125 * (index + 1), float(index)
            save(dataset, folder / f"{index}.dcm")
        self.agree(folder, Form(slope=0.125))

    def without_preamble(self):
        """A bare data set, as old programs wrote them."""
        dataset = self.slice(SIGNED_16, SIGNED_16.noise(8)[0], np.eye(3), 0)
        dataset.SliceThickness = STEP
        path = self.folder / "bare.dcm"
        del dataset.file_meta
        dataset.save_as(path, implicit_vr=True, little_endian=True, enforce_file_format=False)
        expected = SIGNED_16.noise(8)[:1]
        compare(Volume(expected, None), self.splatvol.read(path))

    def nested(self):
        """Elements that mean nothing here, before and after those that do, of known and unknown length."""
        dataset = self.slice(SIGNED_16, SIGNED_16.noise(9)[0], np.eye(3), 0)
        dataset.SliceThickness = STEP
        block = dataset.private_block(0x0011, "TESTS", create=True)
        block.add_new(0x01, "OB", bytes(range(256)) * 3)
        block.add_new(0x02, "UN", b"\x28\x00\x10\x00US\x02\x00\x01\x00")
        inner = item(Rows=1, Columns=1, PixelSpacing=[9.0, 9.0], ImagePositionPatient=[9.0, 9.0, 9.0])
        dataset.ReferencedImageSequence = Sequence([inner, inner])
        dataset["ReferencedImageSequence"].is_undefined_length = True
        inner.is_undefined_length_sequence_item = True
        icon = item(Rows=2, Columns=2, BitsAllocated=8, PixelData=b"\x01\x02\x03\x04")
        dataset.IconImageSequence = Sequence([icon])
        path = self.folder / "nested.dcm"
        save(dataset, path)
        self.agree(path)


def smooth(form):
    """A slice that lossy codes are made for."""
    y, x = np.mgrid[:ROWS, :COLUMNS]
    values = ((1 << form.stored) - 1) * (0.5 + 0.4 * np.sin(x / 3.0) * np.cos(y / 4.0))
    return values.astype(form.dtype)


def item(**elements):
    """A data set of these elements."""
    dataset = Dataset()
    for name, value in elements.items():
        setattr(dataset, name, value)
    return dataset


def decimals(values):
    """Decimal strings have 16 characters at most."""
    return [f"{value:.12f}"[:16] for value in values]


SERIES_UID = generate_uid(entropy_srcs=["splatvol", "series"])


def image(form, values):
    """The elements that every image has, native little-endian."""
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = CTImageStorage
    meta.MediaStorageSOPInstanceUID = generate_uid(entropy_srcs=["splatvol", values.tobytes().hex()])
    meta.TransferSyntaxUID = ExplicitVRLittleEndian
    dataset = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
    dataset.SOPClassUID, dataset.SOPInstanceUID = meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID
    dataset.SeriesInstanceUID = SERIES_UID
    dataset.StudyInstanceUID = generate_uid(entropy_srcs=["splatvol", "study"])
    dataset.Modality = "CT"
    dataset.SamplesPerPixel, dataset.PhotometricInterpretation = 1, form.photometric
    dataset.Rows, dataset.Columns = values.shape[-2:]
    dataset.BitsAllocated, dataset.BitsStored, dataset.HighBit = form.allocated, form.stored, form.stored - 1
    dataset.PixelRepresentation = int(form.signed)
    if (form.slope, form.intercept) != (1.0, 0.0):
        dataset.RescaleSlope, dataset.RescaleIntercept = form.slope, form.intercept
    dataset.PixelData = values.astype(form.dtype.newbyteorder("<")).tobytes()
    dataset["PixelData"].VR = "OW" if form.allocated > 8 else "OB"
    return dataset


def encode(dataset, syntax):
    """Codes the pixels as a transfer syntax wants them."""
    if syntax in (RLELossless, JPEG2000Lossless, JPEGLSLossless):
        # Instances are compressed independently; they keep their identity.
        dataset.compress(syntax, generate_instance_uid=False)
    elif syntax == JPEGLosslessSV1:
        encode_jpeg_lossless(dataset)
    elif syntax == ExplicitVRBigEndian:
        size = dataset.BitsAllocated // 8
        if size > 1:
            dataset.PixelData = np.frombuffer(dataset.PixelData, f"<u{size}").astype(f">u{size}").tobytes()
    dataset.file_meta.TransferSyntaxUID = syntax


def encode_jpeg_lossless(dataset):
    size = dataset.BitsAllocated // 8
    # JPEG knows no signs: it codes the stored bits as they are (PS3.5, section 8.2.1).
    words = np.frombuffer(dataset.PixelData, f"<u{size}") & ((1 << dataset.BitsStored) - 1)
    frames = words.astype(f"u{size}").reshape(-1, dataset.Rows, dataset.Columns)
    coded = [
        imagecodecs.jpeg8_encode(frame, lossless=True, predictor=1, bitspersample=dataset.BitsStored)
        for frame in frames
    ]
    dataset.PixelData = encapsulate(coded)
    dataset["PixelData"].VR = "OB"
    dataset["PixelData"].is_undefined_length = True


def save(dataset, path):
    big = dataset.file_meta.TransferSyntaxUID == ExplicitVRBigEndian
    implicit = dataset.file_meta.TransferSyntaxUID == ImplicitVRLittleEndian
    pydicom.dcmwrite(path, dataset, implicit_vr=implicit, little_endian=not big, enforce_file_format=True)


def with_pydicom(path):
    """A file or a folder of slices of one series, sorted along their normal."""
    paths = sorted(path.iterdir()) if path.is_dir() else [path]
    slices = [frame for name in paths for frame in frames_of(pydicom.dcmread(name))]
    normal = np.cross(slices[0].x, slices[0].y)
    slices.sort(key=lambda frame: frame.position @ normal)
    first, last = slices[0], slices[-1]
    step = (last.position - first.position) / (len(slices) - 1) if len(slices) > 1 else normal * first.thickness
    affine = np.eye(4)
    affine[:3, :3] = np.array([first.x * first.spacing[1], first.y * first.spacing[0], step]).T
    affine[:3, 3] = first.position
    return Volume(np.stack([frame.values for frame in slices]), LPS_TO_RAS @ affine)


@dataclass
class Frame:
    """One frame: real values, and where it lies in the patient's space (LPS, mm)."""

    values: np.ndarray
    position: np.ndarray
    x: np.ndarray
    y: np.ndarray
    spacing: list
    thickness: float


def frames_of(dataset):
    values = pixels(dataset)
    count = int(dataset.get("NumberOfFrames", 1))
    for index, frame in enumerate(values.reshape(count, *values.shape[-2:])):
        shared = dataset.get("SharedFunctionalGroupsSequence", [None])[0]
        if shared is None:
            measures = orientation = position = scale = dataset
        else:
            own = dataset.PerFrameFunctionalGroupsSequence[index]
            measures, orientation = shared.PixelMeasuresSequence[0], shared.PlaneOrientationSequence[0]
            position, scale = own.PlanePositionSequence[0], shared.PixelValueTransformationSequence[0]
        cosines = np.array(orientation.ImageOrientationPatient, float)
        yield Frame(
            apply_rescale(frame, scale),
            np.array(position.ImagePositionPatient, float),
            cosines[:3],
            cosines[3:],
            [float(length) for length in measures.PixelSpacing],
            float(measures.get("SliceThickness", 0)),
        )


def pixels(dataset):
    """Stored samples; those of MONOCHROME1 turned round, as splatvol documents it."""
    if dataset.file_meta.TransferSyntaxUID in (JPEGBaseline8Bit, JPEGExtended12Bit, JPEGLossless, JPEGLosslessSV1):
        values = jpeg_pixels(dataset)
    else:
        values = dataset.pixel_array
    if dataset.PhotometricInterpretation != "MONOCHROME1":
        return values
    return ~values if dataset.PixelRepresentation else (1 << dataset.BitsStored) - 1 - values.astype(np.int64)


def jpeg_pixels(dataset):
    """Pydicom's own decoders of JPEG are under the GPL; libjpeg-turbo decodes, pydicom finds the frames."""
    count = int(dataset.get("NumberOfFrames", 1))
    frames = [imagecodecs.jpeg8_decode(frame) for frame in generate_frames(dataset.PixelData, number_of_frames=count)]
    values = np.stack(frames).astype(np.int64)
    if dataset.PixelRepresentation:
        values -= (values >> (dataset.BitsStored - 1)) << dataset.BitsStored
    return values if count > 1 else values[0]


def gdcm_affine(folder):
    """The place of a series as ITK stacks it."""
    import SimpleITK

    reader = SimpleITK.ImageSeriesReader()
    reader.SetFileNames(SimpleITK.ImageSeriesReader.GetGDCMSeriesFileNames(str(folder)))
    return with_simpleitk(reader.Execute()).ras_from_voxel
