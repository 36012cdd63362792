//! Volumes whose chunks Python gives when they are drawn.

use std::io;
use std::sync::Arc;

use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use splatvol_document::input::options;
use splatvol_document::keys::ItemKeys;
use splatvol_document::{Held, ReadRules};
use splatvol_io::{ByteRange, KeyStore, open_volume_in, too_many_bytes};

use crate::chunks::chunk_rules;
use crate::data::Data;
use crate::error::Raise;
use crate::work::{self, Stop};

/// A function of Python: `get(key, start, length)` returns bytes, or `None` where there is no such key. From `start` on, or where
/// that is negative the last `-start` bytes; all of them where `length` is `None`.
#[derive(Debug)]
struct Getter {
    name: String,
    get: Py<PyAny>,
}

/// A place in a key's bytes; a damaged index may name any.
fn signed(place: u64) -> io::Result<i64> {
    let outside = |_| {
        io::Error::new(
            io::ErrorKind::InvalidData,
            format!("byte {place} lies behind all that a key can have"),
        )
    };
    i64::try_from(place).map_err(outside)
}

impl KeyStore for Getter {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn read(&self, key: &str, bytes: ByteRange, most: u64) -> io::Result<Option<Vec<u8>>> {
        let (start, length) = match bytes {
            ByteRange::All => (0, None),
            ByteRange::From { start, length } => (signed(start)?, Some(length)),
            ByteRange::Last(length) => (-signed(length)?, None),
        };
        let got = Python::attach(|py| {
            let answer = self.get.bind(py).call1((key, start, length))?;
            if answer.is_none() {
                return Ok(None);
            }
            let buffer = PyBuffer::<u8>::get(&answer)?;
            match buffer.len_bytes() as u64 {
                found if found > most => Ok(Some(Err(too_many_bytes(found, most)))),
                _ => buffer.to_vec(py).map(|bytes| Some(Ok(bytes))),
            }
        });
        let raised = |error: PyErr| io::Error::other(format!("the store's get raised {error}"));
        got.map_err(raised)?.transpose()
    }
}

impl Data {
    /// See `of_keys`.
    pub(crate) fn of_getter(
        py: Python<'_>,
        (name, get): (String, Py<PyAny>),
        item: &str,
        memory: Option<u64>,
        stop: Option<&Stop>,
    ) -> PyResult<Self> {
        let keys: ItemKeys = serde_json::from_str(item).map_err(Raise::raised)?;
        let options = options(&keys, ReadRules::default()).map_err(Raise::raised)?;
        let store: Arc<dyn KeyStore> = Arc::new(Getter { name, get });
        work::run(py, (stop, None), |_| {
            let opened = open_volume_in(store, &options).map_err(Raise::raised)?;
            let held = Held::in_chunks(opened, chunk_rules(memory)).map_err(Raise::raised)?;
            Ok(Self { held })
        })
    }
}
