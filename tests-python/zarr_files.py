"""Zarr arrays and OME-Zarr images written by zarr, that splatvol must read as zarr does."""

import itertools

import numcodecs
import numpy as np
import zarr
from zarr.codecs import BloscCodec, BytesCodec, Crc32cCodec, GzipCodec, ShardingCodec, TransposeCodec, ZstdCodec

from comparison import compare
from generated_files import noise
from splatvol_cli import Refused, Volume

TYPES = ["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f2", "f4", "f8"]
SHAPE = (9, 14, 11)
CHUNKS = (4, 5, 6)  # The last of each axis are cut.

BLOSC = list(itertools.product(["blosclz", "lz4", "lz4hc", "zlib", "zstd"], ["noshuffle", "shuffle", "bitshuffle"]))
V2 = {
    "none": None,
    "gzip": numcodecs.GZip(5),
    "zlib": numcodecs.Zlib(5),
    "zstd": numcodecs.Zstd(3),
    "LZ4": numcodecs.LZ4(),
    **{
        f"Blosc {name} {shuffle}": numcodecs.Blosc(name, 5, ["noshuffle", "shuffle", "bitshuffle"].index(shuffle))
        for name, shuffle in BLOSC
    },
}
V3 = {
    "none": None,
    "gzip": GzipCodec(level=5),
    "zstd": ZstdCodec(level=3),
    "zstd with checksum": ZstdCodec(level=3, checksum=True),
    "crc32c": Crc32cCodec(),
    "zstd, crc32c": [ZstdCodec(), Crc32cCodec()],
    **{f"Blosc {name} {shuffle}": BloscCodec(cname=name, clevel=5, shuffle=shuffle) for name, shuffle in BLOSC},
}
# World axes x, y, z of 4 levels.
SCALE, TRANSLATION = np.array([0.5, 0.75, 2.0]), np.array([10.0, -20.0, 30.0])
UNITS = {"micrometer": "um", "millimeter": "mm", "nanometer": "nm", "meter": "m"}


def cases(splatvol, folder):
    """Named checks."""
    return Zarr(splatvol, folder).cases()


class Zarr:
    """Checks that write into `folder` and read back."""

    def __init__(self, splatvol, folder):
        self.splatvol = splatvol
        self.folder = folder / "zarr"
        self.folder.mkdir()

    def cases(self):
        for version, endian, dtype in itertools.product([2, 3], "<>", TYPES):
            name = f"{version} {dtype} {'little' if endian == '<' else 'big'}-endian"
            yield f"Zarr {name}", lambda n=name, v=version, t=dtype, e=endian: self.typed(n, v, t, e)
        for order, separator, codec, dtype in itertools.product("CF", "./", V2, ["u1", "i2", "f8"]):
            name = f"2 {codec} {order} {dtype} by {'slash' if separator == '/' else 'dot'}"
            options = {"order": order, "compressors": V2[codec], "chunk_key_encoding": separator}
            yield f"Zarr {name}", lambda n=name, d=dtype, o=options: self.version_2(n, d, o)
        for separator, codec, dtype in itertools.product("./", V3, ["u1", "i2", "f8"]):
            name = f"3 {codec} {dtype} by {'slash' if separator == '/' else 'dot'}"
            options = {"compressors": V3[codec], "chunk_key_encoding": {"name": "default", "separator": separator}}
            yield f"Zarr {name}", lambda n=name, d=dtype, o=options: self.version_3(n, d, o)
        yield from self.transposed()
        yield from self.sharded()
        yield from self.holes()
        yield from self.images()
        yield from self.refusals()

    def agree(self, path):
        """Samples by zarr itself, as it reads them back."""
        values = zarr.open_array(path, mode="r")[...]
        compare(Volume(values, np.eye(4)), self.splatvol.read(path))

    def create(self, name, values, **options):
        path = self.folder / f"{name.replace(' ', '_')}.zarr"
        options = {"chunks": CHUNKS, "filters": None, **options}
        if options["filters"] is None:
            del options["filters"]
        array = zarr.create_array(path, shape=values.shape, dtype=values.dtype, **options)
        array[...] = values
        return path

    def typed(self, name, version, dtype, endian):
        values = noise(dtype, 1, SHAPE)
        if version == 2:
            self.agree(self.create(name, values.astype(endian + dtype), zarr_format=2, compressors=None))
        else:
            serializer = BytesCodec(endian="little" if endian == "<" else "big")
            self.agree(self.create(name, values, compressors=None, serializer=serializer))

    def version_2(self, name, dtype, options):
        encoding = {"name": "v2", "separator": options.pop("chunk_key_encoding")}
        self.agree(self.create(name, alike(dtype), zarr_format=2, chunk_key_encoding=encoding, **options))

    def version_3(self, name, dtype, options):
        self.agree(self.create(name, alike(dtype), **options))

    # What version 3 adds

    def transposed(self):
        for order in itertools.permutations(range(3)):
            name = f"3 transposed {''.join(map(str, order))}"
            options = {"filters": [TransposeCodec(order=order)], "compressors": ZstdCodec()}
            yield f"Zarr {name}", lambda n=name, o=options: self.version_3(n, "i2", o)

    def sharded(self):
        for codec, dtype in itertools.product(["none", "gzip", "zstd", "Blosc lz4 shuffle"], ["u1", "f4"]):
            name = f"3 shards {codec} {dtype}"
            options = {"shards": (8, 10, 12), "compressors": V3[codec]}
            yield f"Zarr {name}", lambda n=name, d=dtype, o=options: self.version_3(n, d, o)
        for location, checksum in itertools.product(["start", "end"], [False, True]):
            index = [BytesCodec(), Crc32cCodec()] if checksum else [BytesCodec()]
            codec = ShardingCodec(
                chunk_shape=CHUNKS, codecs=[BytesCodec(), ZstdCodec()], index_codecs=index, index_location=location
            )
            name = f"3 shards, index at {location}{' with checksum' if checksum else ''}"
            options = {"chunks": (8, 10, 12), "serializer": codec, "compressors": None}
            yield f"Zarr {name}", lambda n=name, o=options: self.version_3(n, "u2", o)

    def holes(self):
        """Chunks that were never written are the fill value, also inside shards."""
        fills = {"u1": 7, "i2": -300, "f4": 1.5, "f8": float("nan")}
        for version, dtype, shards in [
            *itertools.product([2, 3], fills, [None]),
            (3, "u1", (8, 10, 12)),
            (3, "f8", (8, 10, 12)),
        ]:
            name = f"{version} holes {dtype}{' in shards' if shards else ''}"
            yield f"Zarr {name}", lambda n=name, v=version, d=dtype, s=shards: self.with_holes(n, v, d, s, fills[d])

    def with_holes(self, name, version, dtype, shards, fill):
        path = self.folder / f"{name.replace(' ', '_')}.zarr"
        options = {"shards": shards} if shards else {}
        array = zarr.create_array(
            path, shape=SHAPE, chunks=CHUNKS, dtype=dtype, zarr_format=version, fill_value=fill, **options
        )
        array[:4, 5:10] = noise(dtype, 2, SHAPE)[:4, 5:10]
        self.agree(path)

    # OME

    def images(self):
        for version, axes in itertools.product(["0.4", "0.5"], ["zyx", "czyx", "tzyx", "tczyx"]):
            yield f"OME-Zarr {version} {axes}", lambda v=version, a=axes: self.image(v, a)
        for version, unit in itertools.product(["0.4", "0.5"], UNITS):
            yield f"OME-Zarr {version} {unit}", lambda v=version, u=unit: self.image(v, "zyx", u)

    def image(self, version, axes, unit="micrometer"):
        """Two levels; every channel and time."""
        path = self.folder / f"image_{version}_{axes}_{unit}.zarr"
        zarr_format = 2 if version == "0.4" else 3
        group = zarr.open_group(path, mode="w", zarr_format=zarr_format)
        sizes = {"t": 2, "c": 3, "z": 9, "y": 14, "x": 11}
        levels = []
        for level in range(2):
            shape = tuple(-(-sizes[a] // 2**level) if a in "zyx" else sizes[a] for a in axes)
            values = noise("u2", 3 + level, shape)
            chunks = tuple(5 if a in "zyx" else 1 for a in axes)
            group.create_array(str(level), shape=shape, chunks=chunks, dtype="u2")[...] = values
            levels.append(values)
        multiscales = self.metadata(version, axes, unit, len(levels))
        named = [{"label": f"stain {i}", "color": "FFFFFF", "window": {"start": 0, "end": 1}} for i in range(3)]
        attributes = {"multiscales": [multiscales], "omero": {"channels": named}}
        group.attrs.update(attributes if zarr_format == 2 else {"ome": {"version": version, **attributes}})
        for level, values in enumerate(levels):
            self.planes(path, values, axes, level, UNITS[unit])

    def metadata(self, version, axes, unit, levels):
        kinds = {"t": {"type": "time", "unit": "second"}, "c": {"type": "channel"}}
        space = {"type": "space", "unit": unit}

        def along(spatial, other):
            return [float(spatial["xyz".index(a)]) if a in "xyz" else other for a in axes]

        datasets = [
            {
                "path": str(level),
                "coordinateTransformations": [
                    {"type": "scale", "scale": along(SCALE * 2**level, 1.0)},
                    {"type": "translation", "translation": along(TRANSLATION + level, 0.0)},
                ],
            }
            for level in range(levels)
        ]
        listed = [{"name": a, **kinds.get(a, space)} for a in axes]
        return {"name": "noise", "axes": listed, "datasets": datasets} | (
            {"version": version} if version == "0.4" else {}
        )

    def planes(self, path, values, axes, level, unit):
        affine = np.diag([*(SCALE * 2**level), 1.0])
        affine[:3, 3] = TRANSLATION + level
        flags = [{"c": "--channel", "t": "--time"}[a] for a in axes if a not in "zyx"]
        for place in np.ndindex(values.shape[:-3]):
            options = [part for pair in zip(flags, place, strict=True) for part in pair]
            actual = self.splatvol.read(path, "--level", level, *options)
            compare(Volume(values[place], affine), actual)
            assert actual.unit == unit, f"unit {actual.unit!r}, expected {unit!r}"

    # What must be refused

    def refusals(self):
        delta = {"zarr_format": 2, "filters": [numcodecs.Delta("i2")], "compressors": None}
        yield "refuse Zarr 2 delta", lambda: self.refuse("2 delta", alike("i2"), delta)
        bz2 = {"zarr_format": 2, "compressors": numcodecs.BZ2()}
        yield "refuse Zarr 2 bzip2", lambda: self.refuse("2 bzip2", alike("i2"), bz2)
        yield "refuse Zarr 3 complex", lambda: self.refuse("3 complex", alike("f4").astype("c8"), {})

    def refuse(self, name, values, options):
        path = self.create(name, values, **options)
        try:
            self.splatvol.read(path)
        except Refused as refused:
            assert refused.code == 3, f"exit code {refused.code}, expected 3"
        else:
            raise AssertionError("was read")


def alike(dtype):
    """Noise between rows of one value, for compressors to find."""
    values = noise(dtype, 4, SHAPE)
    values[:, ::3] = values[0, 0, 0]
    return values
