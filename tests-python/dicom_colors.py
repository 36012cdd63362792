"""Coloured and tabulated DICOM files written by pydicom, whose channels and real values are as pydicom has them."""

import imagecodecs
import jpeg_ls
import numpy as np
import pydicom
from pydicom.encaps import encapsulate
from pydicom.pixels import apply_color_lut, apply_modality_lut, convert_color_space
from pydicom.sequence import Sequence
from pydicom.uid import (
    ExplicitVRBigEndian,
    ExplicitVRLittleEndian,
    JPEG2000Lossless,
    JPEGExtended12Bit,
    JPEGLSLossless,
    JPEGLSNearLossless,
    RLELossless,
)

from comparison import compare
from dicom_files import COLUMNS, ROUNDING, ROWS, SLICES, SPACING, STEP, Form, image, item, jpeg_pixels, save, smooth
from splatvol_cli import Volume

SYNTAXES = {
    "native": ExplicitVRLittleEndian,
    "big": ExplicitVRBigEndian,
    "RLE": RLELossless,
    "JPEG2000": JPEG2000Lossless,
    "JPEG-LS": JPEGLSLossless,
}
BYTES = Form(8, 8)


def cases(splatvol, folder):
    """Named checks."""
    return Colors(splatvol, folder).cases()


class Colors:
    """Checks that write into `folder` and read back."""

    def __init__(self, splatvol, folder):
        self.splatvol = splatvol
        self.folder = folder / "dicom colours"
        self.folder.mkdir()

    def cases(self):
        for name in SYNTAXES:
            yield f"DICOM colours, {name}", lambda n=name: self.rgb(n)
        for interleave, name in enumerate(["planes", "lines", "samples"]):
            for near in [0, 3]:
                label = f"DICOM colours, JPEG-LS by {name}, near {near}"
                yield label, lambda i=interleave, n=near: self.jpeg_ls(i, n)
        for space in ["RGB", "YBR_FULL"]:
            for planes in [0, 1]:
                name = f"DICOM colours, {space}, {'planes' if planes else 'pixels'}"
                yield name, lambda s=space, p=planes: self.native(s, p)
        for bits in [8, 16]:
            yield f"DICOM palette of {bits} bits", lambda b=bits: self.palette(b)
        yield "DICOM modality table", self.modality
        yield "DICOM JPEG of 12 bits", self.jpeg_12
        yield "DICOM one bit", self.one_bit

    def rgb(self, name):
        """Frames of noise in each coding."""
        dataset = colored(noise(1))
        if SYNTAXES[name] in (RLELossless, JPEG2000Lossless, JPEGLSLossless):
            dataset.compress(SYNTAXES[name], generate_instance_uid=False)
        dataset.file_meta.TransferSyntaxUID = SYNTAXES[name]
        self.agree(dataset, name, noise(1))

    def jpeg_ls(self, interleave, near):
        """Components one after the other, line by line, and sample by sample; runs where the left third is even."""
        values = noise(3)
        values[:, :, : COLUMNS // 3] = 77
        # Planes are planes in memory, too; lines and samples are pixels there.
        place = 1 if interleave == 0 else 3
        ordered = np.ascontiguousarray(np.moveaxis(values, -1, place))
        coded = [jpeg_ls.encode_array(frame, near, interleave) for frame in ordered]
        dataset = colored(values)
        dataset.PixelData = encapsulate([bytes(frame) for frame in coded])
        dataset["PixelData"].VR = "OB"
        dataset["PixelData"].is_undefined_length = True
        dataset.file_meta.TransferSyntaxUID = JPEGLSNearLossless if near else JPEGLSLossless
        decoded = [np.frombuffer(jpeg_ls.decode_pixel_data(bytes(frame))[0], "u1") for frame in coded]
        expected = np.moveaxis(np.stack(decoded).reshape(ordered.shape), place, -1)
        assert np.abs(expected.astype(int) - values).max() <= near, "CharLS reads other samples"
        self.agree(dataset, f"jpeg-ls {interleave} {near}", expected)

    def native(self, space, planes):
        values = noise(2)
        dataset = colored(np.moveaxis(values, -1, 1) if planes else values)
        dataset.Rows, dataset.Columns = ROWS, COLUMNS
        dataset.PlanarConfiguration, dataset.PhotometricInterpretation = planes, space
        expected = values if space == "RGB" else np.stack([convert_color_space(v, space, "RGB") for v in values])
        self.agree(dataset, f"{space} {planes}", expected, 0 if space == "RGB" else ROUNDING)

    def agree(self, dataset, name, expected, tolerance=0):
        """Each channel of each frame."""
        path = self.folder / f"{name.replace(' ', '_')}.dcm"
        save(dataset, path)
        for channel in range(3):
            actual = self.splatvol.read(path, "--channel", channel)
            wanted = expected[..., channel]
            if tolerance:
                error = np.abs(wanted.astype(int) - actual.values.astype(int)).max()
                assert error <= tolerance, f"channel {channel} is off by {error}"
            else:
                compare(Volume(wanted, None), actual)

    def palette(self, bits):
        indices = noise(3)[..., 0]
        dataset = image(BYTES, indices)
        frames(dataset)
        dataset.PhotometricInterpretation = "PALETTE COLOR"
        generator = np.random.default_rng(4)
        for color in ["Red", "Green", "Blue"]:
            table = generator.integers(0, 1 << bits, 256).astype(f"<u{bits // 8}")
            setattr(dataset, f"{color}PaletteColorLookupTableDescriptor", [256, 0, bits])
            setattr(dataset, f"{color}PaletteColorLookupTableData", table.tobytes())
        self.agree(dataset, f"palette {bits}", apply_color_lut(indices, dataset))

    def modality(self):
        """A table in place of slope and intercept."""
        form = Form(16, 12)
        values = form.noise(5)
        dataset = image(form, values)
        frames(dataset)
        table = item(
            LUTDescriptor=[4096, 0, 16],
            ModalityLUTType="US",
            LUTData=np.random.default_rng(6).integers(0, 1 << 16, 4096).astype("<u2").tobytes(),
        )
        table["LUTDescriptor"].VR, table["LUTData"].VR = "US", "OW"
        dataset.ModalityLUTSequence = Sequence([table])
        path = self.folder / "modality.dcm"
        save(dataset, path)
        expected = apply_modality_lut(values, pydicom.dcmread(path))
        compare(Volume(expected, None), self.splatvol.read(path))

    def jpeg_12(self):
        """Decoders may round their cosines differently."""
        form = Form(16, 12)
        dataset = image(form, smooth(form)[None])
        dataset.PixelData = encapsulate([imagecodecs.jpeg8_encode(smooth(form), level=90, bitspersample=12)])
        dataset["PixelData"].VR = "OB"
        dataset["PixelData"].is_undefined_length = True
        dataset.file_meta.TransferSyntaxUID = JPEGExtended12Bit
        path = self.folder / "jpeg 12.dcm"
        save(dataset, path)
        wanted = jpeg_pixels(pydicom.dcmread(path))
        error = np.abs(wanted - self.splatvol.read(path).values[0].astype(int)).max()
        assert error <= ROUNDING, f"samples are off by {error}"

    def one_bit(self):
        """Bits of a mask, the lowest of each byte first; frames do not end on bytes."""
        bits = np.random.default_rng(7).integers(0, 2, (SLICES, ROWS, COLUMNS), dtype="u1")
        dataset = image(BYTES, bits)
        frames(dataset)
        dataset.BitsAllocated = dataset.BitsStored = 1
        dataset.HighBit = 0
        packed = np.packbits(bits.reshape(-1), bitorder="little").tobytes()
        dataset.PixelData = packed + b"\0" * (len(packed) % 2)
        path = self.folder / "bits.dcm"
        save(dataset, path)
        assert (pydicom.dcmread(path).pixel_array == bits).all(), "pydicom reads other bits"
        compare(Volume(bits, None), self.splatvol.read(path))


def noise(seed):
    return np.random.default_rng(seed).integers(0, 256, (SLICES, ROWS, COLUMNS, 3), dtype="u1")


def frames(dataset):
    dataset.NumberOfFrames = SLICES
    dataset.PixelSpacing = list(SPACING)
    dataset.SpacingBetweenSlices = STEP


def colored(values):
    """Frames of red, green and blue."""
    dataset = image(BYTES, values)
    frames(dataset)
    dataset.Rows, dataset.Columns = ROWS, COLUMNS
    dataset.SamplesPerPixel, dataset.PhotometricInterpretation, dataset.PlanarConfiguration = 3, "RGB", 0
    return dataset
