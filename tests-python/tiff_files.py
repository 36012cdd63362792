"""TIFF files written by tifffile, that splatvol must read as tifffile does."""

import itertools

import numpy as np
import tifffile

from comparison import compare
from generated_files import noise
from splatvol_cli import Refused, Volume

TYPES = ["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f2", "f4", "f8"]
SHAPE = (4, 21, 37)
LOSSLESS = {
    "none": {},
    "deflate": {"compression": "adobe_deflate"},
    "old deflate": {"compression": "deflate"},
    "LZW": {"compression": "lzw"},
    "PackBits": {"compression": "packbits"},
    "zstd": {"compression": "zstd"},
}
FORMS = {
    "a strip": {},
    "strips": {"rowsperstrip": 5},
    "tiles": {"tile": (16, 32)},
}
REFUSED = {
    **{code: {"compression": code} for code in ["lzma", "jpeg2000", "jpegxl", "lerc", "png"]},
    "12 bits": {"bitspersample": 12},
}


def with_tags(file, values):
    """A little-endian TIFF with other values of short tags, in all of its pages."""
    file = bytearray(file)
    at = int.from_bytes(file[4:8], "little")
    while at:
        count = int.from_bytes(file[at : at + 2], "little")
        for entry in range(at + 2, at + 2 + 12 * count, 12):
            tag = int.from_bytes(file[entry : entry + 2], "little")
            if tag in values:
                size = {3: 2, 4: 4}[int.from_bytes(file[entry + 2 : entry + 4], "little")]
                file[entry + 8 : entry + 8 + size] = values[tag].to_bytes(size, "little")
        end = at + 2 + 12 * count
        at = int.from_bytes(file[end : end + 4], "little")
    return bytes(file)


def cases(splatvol, folder):
    """Named checks."""
    return Tiff(splatvol, folder).cases()


class Tiff:
    """Checks that write into `folder` and read back."""

    def __init__(self, splatvol, folder):
        self.splatvol = splatvol
        self.folder = folder / "tiff"
        self.folder.mkdir()

    def cases(self):
        yield from self.layouts()
        yield from self.predictors()
        yield from self.photometric()
        yield from self.imagej()
        yield from self.ome()
        yield "TIFF folder of slices", self.slices
        for name, options in REFUSED.items():
            yield f"refuse TIFF {name}", lambda n=name, o=options: self.refuse(n, **o)

    def write(self, name, values, **options):
        path = self.folder / f"{name.replace(' ', '_')}.tif"
        tifffile.imwrite(path, values, **options)
        return path

    def agree(self, path, *options):
        """Samples by tifffile, and spacing 1 without a unit, as plain TIFF has none."""
        actual = self.splatvol.read(path, *options)
        compare(Volume(tifffile.imread(path), np.eye(4)), actual)
        assert actual.unit == "", f"unit {actual.unit!r}"

    # Layout and compression

    def layouts(self):
        for dtype, endian, big in itertools.product(TYPES, "<>", [False, True]):
            name = f"{dtype} {'little' if endian == '<' else 'big'}-endian{', BigTIFF' if big else ''}"
            options = {"byteorder": endian, "bigtiff": big, "photometric": "minisblack", "metadata": None}
            yield f"TIFF {name}", lambda n=name, d=dtype, o=options: self.layout(n, d, o)
        for compression, form, dtype, endian in itertools.product(LOSSLESS, FORMS, ["u1", "i2", "f4"], "<>"):
            name = f"{dtype} {compression}, {form}, {endian.replace('<', 'little').replace('>', 'big')}"
            options = {**LOSSLESS[compression], **FORMS[form], "byteorder": endian, "metadata": None}
            yield f"TIFF {name}", lambda n=name, d=dtype, o=options: self.layout(n, d, o)

    def layout(self, name, dtype, options):
        values = noise(dtype, 1, SHAPE)
        values[:, ::3] = values[:, :1]  # Something to compress.
        self.agree(self.write(name, values, **{"photometric": "minisblack", **options}))

    def predictors(self):
        kinds = [("u1", 2), ("i2", 2), ("u4", 2), ("f2", 3), ("f4", 3), ("f8", 3)]
        for (dtype, predictor), compression, endian in itertools.product(kinds, ["deflate", "LZW", "zstd"], "<>"):
            name = f"{dtype} {compression}, predictor {predictor}, {endian.replace('<', 'little').replace('>', 'big')}"
            options = {**LOSSLESS[compression], "predictor": predictor, "byteorder": endian, "metadata": None}
            yield f"TIFF {name}", lambda n=name, d=dtype, o=options: self.layout(n, d, o)

    # Meaning of samples

    def photometric(self):
        for dtype, compression in itertools.product(["u1", "u2"], ["none", "LZW"]):
            for planes in ["contig", "separate"]:
                name = f"TIFF colours {dtype} {compression} {planes}"
                yield name, lambda d=dtype, c=compression, p=planes: self.colors(d, c, p)
        for bits in [1, 2, 4]:
            yield f"TIFF {bits} bits", lambda b=bits: self.bits(b)
        for compression in ["none", "LZW"]:
            yield f"TIFF palette {compression}", lambda c=compression: self.palette(c)
        for dtype, compression in itertools.product(["u1", "u2", "i2", "f4"], ["none", "LZW", "zstd"]):
            name = f"TIFF white is zero, {dtype} {compression}"
            yield name, lambda d=dtype, c=compression: self.white_is_zero(d, c)
        yield "TIFF JPEG", self.jpeg

    def colors(self, dtype, compression, planes):
        """Components of one pixel behind each other, or each component in strips of its own."""
        values = noise(dtype, 2, (*SHAPE, 3))
        stored = values if planes == "contig" else np.moveaxis(values, -1, 1)
        options = {**LOSSLESS[compression], "rowsperstrip": 5, "metadata": None}
        name = f"colours {dtype} {compression} {planes}"
        path = self.write(name, stored, photometric="rgb", planarconfig=planes, **options)
        for channel in range(3):
            compare(Volume(values[..., channel], np.eye(4)), self.splatvol.read(path, "--channel", channel))

    def bits(self, bits):
        """Rows of several samples per byte, the highest bits first; 37 columns do not fill the last byte."""
        values = noise("u1", 6, SHAPE) >> (8 - bits)
        rows = np.unpackbits(values[..., None], axis=-1)[..., -bits:].reshape(*SHAPE[:2], -1)
        packed = np.packbits(rows, axis=-1)
        path = self.write(f"{bits} bits", packed, photometric="minisblack", metadata=None)
        file = path.read_bytes()
        path.write_bytes(with_tags(file, {256: SHAPE[2], 258: bits}))
        compare(Volume(values, np.eye(4)), self.splatvol.read(path))

    def palette(self, compression):
        """Samples are the palette's indices."""
        path = self.write(
            f"palette {compression}",
            noise("u1", 3, SHAPE),
            photometric="palette",
            colormap=noise("u2", 4, (3, 256)),
            metadata=None,
            **LOSSLESS[compression],
        )
        self.agree(path)

    def white_is_zero(self, dtype, compression):
        """Samples are what is stored; a transfer function says what they look like."""
        options = {"photometric": "miniswhite", "metadata": None, **LOSSLESS[compression]}
        self.agree(self.write(f"white {dtype} {compression}", noise(dtype, 5, SHAPE), **options))

    def jpeg(self):
        """Decoders may round their cosines differently, by one."""
        z, y, x = np.mgrid[: SHAPE[0], : SHAPE[1], : SHAPE[2]]
        values = (127 + 100 * np.sin(x / 5.0 + z) * np.cos(y / 4.0)).astype("u1")
        path = self.write("jpeg", values, photometric="minisblack", compression="jpeg", metadata=None)
        wanted, found = tifffile.imread(path).astype(int), self.splatvol.read(path).values.astype(int)
        error = np.abs(wanted - found).max()
        assert error <= 1, f"samples are off by {error}"

    # ImageJ

    def imagej(self):
        for axes, shape in [
            ("ZYX", (4, 21, 37)),
            ("TZYX", (2, 4, 21, 37)),
            ("ZCYX", (4, 3, 21, 37)),
            ("TZCYX", (2, 4, 3, 21, 37)),
        ]:
            for dtype, compressed in itertools.product(["u1", "u2", "f4"], [False, True]):
                name = f"ImageJ {axes} {dtype}{' deflate' if compressed else ''}"
                yield (
                    f"TIFF {name}",
                    lambda n=name, a=axes, s=shape, d=dtype, c=compressed: self.hyperstack(n, a, s, d, c),
                )
        for unit, factor, said in [
            ("um", 1.0, "um"),
            ("micron", 1.0, "um"),
            ("mm", 1.0, "mm"),
            ("cm", 10.0, "mm"),
            ("nm", 1.0, "nm"),
        ]:
            yield f"TIFF ImageJ unit {unit}", lambda u=unit, f=factor, s=said: self.imagej_unit(u, f, s)

    def hyperstack(self, name, axes, shape, dtype, compressed):
        values = noise(dtype, 7, shape)
        options = {"compression": "zlib"} if compressed else {}
        metadata = {"axes": axes, "spacing": 2.5, "unit": "um"}
        path = self.write(name, values, imagej=True, resolution=(4.0, 2.0), metadata=metadata, **options)
        self.planes(path, values, axes, np.diag([0.25, 0.5, 2.5, 1.0]), "um")

    def planes(self, path, values, axes, affine, unit):
        """Every channel and time."""
        sizes = dict(zip(axes, values.shape, strict=True))
        whole = np.moveaxis(values, [axes.index(a) for a in axes if a not in "ZYX"], range(len(axes) - 3))
        order = [a for a in axes if a not in "ZYX"]
        for place in itertools.product(*[range(sizes[a]) for a in order]):
            options = [
                part for a, i in zip(order, place, strict=True) for part in ({"C": "--channel", "T": "--time"}[a], i)
            ]
            actual = self.splatvol.read(path, *options)
            compare(Volume(whole[place], affine), actual)
            assert actual.unit == unit, f"unit {actual.unit!r}, expected {unit!r}"

    def imagej_unit(self, unit, factor, said):
        values = noise("u1", 8, SHAPE)
        path = self.write(
            f"unit {unit}",
            values,
            imagej=True,
            resolution=(4.0, 2.0),
            metadata={"spacing": 2.5, "unit": unit, "axes": "ZYX"},
        )
        self.planes(path, values, "ZYX", np.diag([0.25 * factor, 0.5 * factor, 2.5 * factor, 1.0]), said)

    # OME

    def ome(self):
        for axes in [
            "ZYX",
            "CZYX",
            "ZCYX",
            "TZYX",
            "ZTYX",
            *("".join(p) + "YX" for p in itertools.permutations("TCZ")),
        ]:
            for options in [{}, {"compression": "zlib", "tile": (16, 16)}, {"bigtiff": True, "byteorder": ">"}]:
                name = f"OME {axes} {' '.join(options)}".strip()
                yield f"TIFF {name}", lambda n=name, a=axes, o=options: self.ome_file(n, a, o)
        for unit, said in [("µm", "um"), ("mm", "mm"), ("nm", "nm"), ("m", "m"), ("pixel", "")]:
            yield f"TIFF OME unit {unit}", lambda u=unit, s=said: self.ome_unit(u, s)

        for companion in [False, True]:
            name = f"TIFF OME over files{', described by another' if companion else ''}"
            yield name, lambda c=companion: self.ome_set(c)

    def ome_set(self, companion):
        """A file for each channel, whose pages are its slices; described in each of them, or in a file of its own."""
        folder = self.folder / f"set {companion}"
        folder.mkdir()
        values = noise("u2", 13, (2, 3, 21, 37))
        names = ["a.ome.tif", "b.ome.tif"]
        planes = "".join(
            f'<TiffData FirstC="{channel}" FirstZ="{z}" IFD="{z}" PlaneCount="1">'
            f'<UUID FileName="{name}">urn:uuid:{channel}</UUID></TiffData>'
            for channel, name in enumerate(names)
            for z in range(3)
        )
        described = (
            '<?xml version="1.0"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06" UUID="urn:uuid:0">'
            '<Image ID="Image:0"><Pixels ID="Pixels:0" DimensionOrder="XYZCT" Type="uint16" SizeX="37" SizeY="21"'
            ' SizeZ="3" SizeC="2" SizeT="1" PhysicalSizeX="0.25" PhysicalSizeY="0.5" PhysicalSizeZ="2.5">'
            '<Channel ID="Channel:0:0" SamplesPerPixel="1"/><Channel ID="Channel:0:1" SamplesPerPixel="1"/>'
            f"{planes}</Pixels></Image></OME>"
        )
        text = described
        if companion:
            (folder / "set.companion.ome").write_text(described)
            text = '<?xml version="1.0"?><OME><BinaryOnly MetadataFile="set.companion.ome" UUID="urn:uuid:9"/></OME>'
        for name, channel in zip(names, values, strict=True):
            tifffile.imwrite(folder / name, channel, description=text, metadata=None, photometric="minisblack")
        for name in names:
            self.planes(folder / name, values, "CZYX", np.diag([0.25, 0.5, 2.5, 1.0]), "um")

    def ome_file(self, name, axes, options):
        sizes = {"T": 2, "C": 3, "Z": 4, "Y": 21, "X": 37}
        values = noise("u2", 9, tuple(sizes[a] for a in axes))
        path = self.folder / f"{name.replace(' ', '_')}.ome.tif"
        metadata = {
            "axes": axes,
            **{f"PhysicalSize{a}": size for a, size in zip("XYZ", [0.25, 0.5, 2.5], strict=True)},
            **{f"PhysicalSize{a}Unit": "µm" for a in "XYZ"},
        }
        tifffile.imwrite(path, values, ome=True, photometric="minisblack", metadata=metadata, **options)
        self.planes(path, values, axes, np.diag([0.25, 0.5, 2.5, 1.0]), "um")

    def ome_unit(self, unit, said):
        values = noise("u1", 10, SHAPE)
        path = self.folder / f"unit_{said}.ome.tif"
        metadata = {"axes": "ZYX", "PhysicalSizeX": 2.0, "PhysicalSizeXUnit": unit}
        for axis in "YZ":
            metadata |= {f"PhysicalSize{axis}": 3.0, f"PhysicalSize{axis}Unit": unit}
        tifffile.imwrite(path, values, ome=True, photometric="minisblack", metadata=metadata)
        self.planes(path, values, "ZYX", np.diag([2.0, 3.0, 3.0, 1.0]), said)

    # Folders, and what is refused

    def slices(self):
        """A file for each slice; numbers are ordered as numbers."""
        folder = self.folder / "slices"
        folder.mkdir()
        values = noise("u2", 11, (12, 21, 37))
        for index, plane in enumerate(values):
            tifffile.imwrite(folder / f"slice{index}.tif", plane, metadata=None)
        compare(Volume(values, np.eye(4)), self.splatvol.read(folder))

    def refuse(self, name, dtype="u1", shape=SHAPE, **options):
        values = noise(dtype, 12, shape)
        if "bitspersample" in options:
            values = (values >> 4).astype("u2" if options["bitspersample"] > 8 else "u1") & (
                (1 << options["bitspersample"]) - 1
            )
        path = self.write(name, values, **{"photometric": "minisblack", "metadata": None, **options})
        try:
            self.splatvol.read(path)
        except Refused as refused:
            assert refused.code == 3, f"exit code {refused.code}, expected 3"
        else:
            raise AssertionError("was read")
