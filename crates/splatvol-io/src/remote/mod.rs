//! Zarr at an address: `https://`, `http://`, `s3://` (feature `remote`).
//!
//! Addresses are folders of keys. Requests ask for byte ranges, are tried again where a server is busy or breaks off, and
//! are given up after some time. Credentials come from the environment alone; an address that holds any is refused, so that none
//! gets into recipes, parts or pictures.

#[cfg(feature = "remote")]
mod objects;

use std::path::Path;
use std::sync::Arc;

use crate::IoError;
use crate::key_store::KeyStore;

/// Beginnings of addresses.
const SCHEMES: [&str; 3] = ["https://", "http://", "s3://"];

/// The address that a path is, if it is one.
pub fn address(path: &Path) -> Option<&str> {
    let text = path.to_str()?;
    SCHEMES
        .iter()
        .any(|scheme| text.starts_with(scheme))
        .then_some(text)
}

/// Opens the store at an address; nothing is read.
///
/// # Errors
/// Addresses that have no host, or that hold credentials or a query; a program without the feature `remote`.
pub fn open(address: &str) -> Result<Arc<dyn KeyStore>, IoError> {
    let refused = |what: &str| IoError::Unsupported {
        format: "address",
        what: what.to_owned(),
        path: address.split(['?', '#']).next().unwrap_or_default().into(),
    };
    let rest = address.split_once("://").map_or("", |(_, rest)| rest);
    let host = rest.split('/').next().unwrap_or_default();
    if host.is_empty() {
        return Err(refused("it names no host"));
    }
    if host.contains('@') {
        return Err(IoError::Unsupported {
            format: "address",
            what: "it holds credentials, which belong into the environment".to_owned(),
            path: host.rsplit('@').next().unwrap_or_default().into(),
        });
    }
    if rest.contains(['?', '#']) {
        return Err(refused("it has a query, and folders of keys have none"));
    }
    #[cfg(feature = "remote")]
    return objects::open(address).map_err(|what| refused(&what));
    #[cfg(not(feature = "remote"))]
    Err(refused(
        "this program reads no addresses: it was built without the feature remote",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_no_addresses() {
        for path in [
            "a.ome.zarr",
            "/data/http/a",
            "https:/a",
            "file:///a",
            "sample:head",
        ] {
            assert_eq!(address(Path::new(path)), None, "{path}");
        }
        let known = "s3://bucket/a.zarr";
        assert_eq!(address(Path::new(known)), Some(known));
    }

    #[test]
    fn secrets_are_refused_and_not_repeated() {
        for (text, expected) in [
            ("https://", "no host"),
            ("https:///a", "no host"),
            ("https://me:word@host/a.zarr", "credentials"),
            ("https://host/a.zarr?signature=word", "query"),
        ] {
            let error = open(text).unwrap_err().to_string();
            assert!(error.contains(expected) && !error.contains("word"), "{error}");
        }
    }
}
