//! OME-Zarr: folders of versions 2 and 3.

use serde_json::{Value, json};

use crate::coat::crc32c;
use crate::common::codecs;
use crate::common::gzip;
use crate::input::Input;

/// 4 x 4 x 4 in eight chunks.
pub(crate) fn zarr() -> Vec<Input> {
    let mut seeds = vec![version_2(), version_3()];
    for (name, stream) in [
        ("lz4", codecs::BLOSC_LZ4),
        ("zstd", codecs::BLOSC_ZSTD),
        ("zlib", codecs::BLOSC_ZLIB),
    ] {
        seeds.push(blosc(name, codecs::stream(stream)));
    }
    seeds
}

fn axes() -> Value {
    json!([{"name": "z", "type": "space", "unit": "micrometer"}, {"name": "y", "type": "space", "unit": "micrometer"},
        {"name": "x", "type": "space", "unit": "micrometer"}])
}

fn scale(step: f64) -> Value {
    json!([{"type": "scale", "scale": [2.0 * step, step, step]}])
}

fn text(name: &str, value: &Value) -> (String, Vec<u8>) {
    (name.to_owned(), value.to_string().into_bytes())
}

fn chunks() -> impl Iterator<Item = [usize; 3]> {
    (0..8).map(|i| [i / 4, i / 2 % 2, i % 2])
}

/// Two levels, gzip.
fn version_2() -> Input {
    let levels = json!([{"path": "0", "coordinateTransformations": scale(1.0)},
        {"path": "1", "coordinateTransformations": scale(2.0)}]);
    let image = json!([{"version": "0.4", "axes": axes(), "datasets": levels}]);
    let array = |size: usize| {
        json!({"zarr_format": 2, "shape": [size, size, size], "chunks": [2, 2, 2], "dtype": "<u2", "fill_value": 7,
            "compressor": {"id": "gzip", "level": 1}, "order": "C", "filters": null})
    };
    let mut files = vec![
        text(".zgroup", &json!({"zarr_format": 2})),
        text(
            ".zattrs",
            &json!({"multiscales": image, "omero": {"channels": [{"label": "DAPI"}]}}),
        ),
        text("0/.zarray", &array(4)),
        text("1/.zarray", &array(2)),
    ];
    let bytes: Vec<u8> = (0..8u16).flat_map(|i| (i * 300).to_le_bytes()).collect();
    files.extend(chunks().map(|[z, y, x]| (format!("0/{z}.{y}.{x}"), gzip(&bytes))));
    files.push(("1/0.0.0".to_owned(), gzip(&bytes)));
    Input::files("", files)
}

/// One level in one chunk, by Blosc.
fn blosc(name: &str, chunk: Vec<u8>) -> Input {
    let level = json!([{"path": "0", "coordinateTransformations": scale(1.0)}]);
    let image = json!([{"version": "0.4", "axes": axes(), "datasets": level}]);
    let array = json!({"zarr_format": 2, "shape": [2, 3, 4], "chunks": [2, 3, 4], "dtype": "<i2", "fill_value": 0,
        "compressor": {"id": "blosc", "cname": name, "clevel": 5, "shuffle": 1, "blocksize": 0}, "order": "C",
        "filters": null});
    let files = vec![
        text(".zgroup", &json!({"zarr_format": 2})),
        text(".zattrs", &json!({"multiscales": image})),
        text("0/.zarray", &array),
        ("0/0.0.0".to_owned(), chunk),
    ];
    Input::files("", files)
}

/// One shard.
fn version_3() -> Input {
    let level = json!([{"path": "s0", "coordinateTransformations": scale(1.0)}]);
    let image = json!({"axes": axes(), "datasets": level});
    let group = json!({"zarr_format": 3, "node_type": "group",
        "attributes": {"ome": {"version": "0.5", "multiscales": [image]}}});
    let little = json!({"name": "bytes", "configuration": {"endian": "little"}});
    let inner =
        json!([{"name": "transpose", "configuration": {"order": [2, 1, 0]}}, little, {"name": "crc32c"}]);
    let sharding = json!({"name": "sharding_indexed", "configuration": {"chunk_shape": [2, 2, 2], "codecs": inner,
        "index_codecs": [little, {"name": "crc32c"}]}});
    let array = json!({"zarr_format": 3, "node_type": "array", "shape": [4, 4, 4], "data_type": "uint16", "fill_value": 5,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [4, 4, 4]}}, "codecs": [sharding],
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}}});
    let (mut shard, mut index) = (Vec::new(), Vec::new());
    for [z, y, x] in chunks() {
        let chunk: Vec<u8> = (0..8)
            .flat_map(|i| ((i + 9 * z + 5 * y + x) as u16).to_le_bytes())
            .collect();
        index.extend((shard.len() as u64).to_le_bytes());
        index.extend(20u64.to_le_bytes());
        shard.extend(&chunk);
        shard.extend(crc32c(&chunk).to_le_bytes());
    }
    let sum = crc32c(&index).to_le_bytes();
    let shard = [shard, index, sum.to_vec()].concat();
    let files = vec![
        text("zarr.json", &group),
        text("s0/zarr.json", &array),
        ("s0/c/0/0/0".to_owned(), shard),
    ];
    Input::files("", files)
}
