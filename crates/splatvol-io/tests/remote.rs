//! Zarr at addresses: servers that are slow, busy, broken or foreign. The samples are those of the folder, or an error names the chunk.
#![cfg(feature = "remote")]
#![allow(clippy::unwrap_used, reason = "panics are how tests fail")]

mod common;

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use common::images::{chunks, image};
use splatvol_io::{OmeVersion, Opened, ReadOptions, open_volume, state_of_files};

/// What a server does wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fault {
    Nothing,
    /// Every fifth answer: busy.
    Busy,
    /// Every fifth answer breaks off in the middle.
    Cut,
    /// Every answer takes its time.
    Slow,
    /// Ranges are ignored.
    NoRanges,
    /// All chunks are denied.
    Denied,
    /// Everything that is not there is denied.
    Secretive,
}

/// A server of a folder on this machine: its address, and the number of requests so far.
fn serve(folder: PathBuf, fault: Fault) -> (String, Arc<AtomicUsize>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}/a.ome.zarr", listener.local_addr().unwrap());
    let requests = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&requests);
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let (folder, counted) = (folder.clone(), Arc::clone(&counted));
            std::thread::spawn(move || answer(stream, &folder, fault, &counted));
        }
    });
    (address, requests)
}

/// Answers the requests of a connection, one after the other.
fn answer(stream: TcpStream, folder: &Path, fault: Fault, counted: &AtomicUsize) {
    let mut lines = BufReader::new(stream.try_clone().unwrap()).lines();
    let mut stream = stream;
    loop {
        let mut request = Vec::new();
        for line in lines.by_ref() {
            match line {
                Ok(line) if line.is_empty() => break,
                Ok(line) => request.push(line),
                Err(_) => return,
            }
        }
        let Some(first) = request.first() else { return };
        let number = counted.fetch_add(1, Ordering::Relaxed) + 1;
        if fault == Fault::Slow {
            std::thread::sleep(Duration::from_millis(30));
        }
        let path = first.split(' ').nth(1).unwrap_or("/").trim_start_matches('/');
        let range = request.iter().find_map(|line| {
            let (name, value) = line.split_once(": ")?;
            name.eq_ignore_ascii_case("range")
                .then(|| value.strip_prefix("bytes=").unwrap_or_default().to_owned())
        });
        let (head, body) = respond(&folder.join(path), range.as_deref(), (fault, number));
        let sent = match fault == Fault::Cut && number.is_multiple_of(5) {
            true => &body[..body.len() / 2],
            false => &body[..],
        };
        if stream
            .write_all(head.as_bytes())
            .and_then(|()| stream.write_all(sent))
            .is_err()
            || sent.len() < body.len()
        {
            return;
        }
    }
}

/// Head and body of an answer.
fn respond(path: &Path, range: Option<&str>, (fault, number): (Fault, usize)) -> (String, Vec<u8>) {
    let plain = |status: &str, body: Vec<u8>| {
        let head = format!(
            "HTTP/1.1 {status}\r\nContent-Length: {}\r\nLast-Modified: Wed, 25 Nov 2026 10:00:00 GMT\r\n\r\n",
            body.len()
        );
        (head, body)
    };
    let is_chunk = path.to_string_lossy().contains("/c/");
    if fault == Fault::Busy && number.is_multiple_of(5) {
        return plain("503 Service Unavailable", Vec::new());
    }
    if fault == Fault::Denied && is_chunk {
        return plain("403 Forbidden", Vec::new());
    }
    let Some(all) = path.is_file().then(|| std::fs::read(path).unwrap()) else {
        return match fault {
            Fault::Secretive => plain("403 Forbidden", Vec::new()),
            _ => plain("404 Not Found", Vec::new()),
        };
    };
    let Some(range) = range.filter(|_| fault != Fault::NoRanges) else {
        return plain("200 OK", all);
    };
    let (from, to) = range.split_once('-').unwrap();
    let (start, end) = match (from, to) {
        ("", last) => (
            all.len() - last.parse::<usize>().unwrap().min(all.len()),
            all.len(),
        ),
        (from, to) => {
            let end: usize = to.parse().unwrap_or(all.len() - 1);
            (from.parse().unwrap(), (end + 1).min(all.len()))
        }
    };
    let head = format!(
        "HTTP/1.1 206 Partial Content\r\nContent-Length: {}\r\nContent-Range: bytes {start}-{}/{}\r\n\
         Last-Modified: Wed, 25 Nov 2026 10:00:00 GMT\r\n\r\n",
        end - start,
        end - 1,
        all.len()
    );
    (head, all[start..end].to_vec())
}

fn open(path: &Path) -> Opened {
    open_volume(path, &ReadOptions::default()).unwrap().unwrap()
}

#[test]
fn servers_have_the_samples_of_their_folders_whatever_goes_wrong() {
    let folder = tempfile::tempdir().unwrap();
    for (version, faults) in [
        (OmeVersion::V04, &[Fault::Nothing][..]),
        (
            OmeVersion::V05,
            &[
                Fault::Nothing,
                Fault::Busy,
                Fault::Cut,
                Fault::Slow,
                Fault::Secretive,
            ],
        ),
    ] {
        let local = open(&image(folder.path(), version));
        let expected = chunks(&*local.source).unwrap();
        for &fault in faults {
            let (address, requests) = serve(folder.path().to_owned(), fault);
            let remote = open(Path::new(&address));
            assert_eq!(remote.source.identity().name, address);
            assert!(
                chunks(&*remote.source).unwrap() == expected,
                "{fault:?} {version:?}"
            );
            assert!(requests.load(Ordering::Relaxed) > 10, "{fault:?}");
        }
    }
}

#[test]
fn what_a_server_refuses_is_named_by_chunk() {
    let folder = tempfile::tempdir().unwrap();
    image(folder.path(), OmeVersion::V05);
    for (fault, expected) in [(Fault::Denied, "403"), (Fault::NoRanges, "ange")] {
        let (address, _) = serve(folder.path().to_owned(), fault);
        let remote = open(Path::new(&address));
        let error = chunks(&*remote.source).unwrap_err().to_string();
        assert!(error.contains("level 0, chunk 0,0,0, key c/0/0/0"), "{error}");
        assert!(error.contains(expected), "{error}");
    }
    let (address, _) = serve(folder.path().join("nothing"), Fault::Nothing);
    let error = open_volume(Path::new(&address), &ReadOptions::default()).unwrap_err();
    assert!(
        error.to_string().contains("neither multiscales nor an array"),
        "{error}"
    );
}

#[test]
fn the_state_of_a_store_is_that_of_its_metadata() {
    let folder = tempfile::tempdir().unwrap();
    let path = image(folder.path(), OmeVersion::V05);
    let (address, _) = serve(folder.path().to_owned(), Fault::Nothing);
    let state = || state_of_files(&[PathBuf::from(&address)]).unwrap();
    let before = state();
    assert_eq!(before, state());
    let metadata = path.join("zarr.json");
    let text = std::fs::read_to_string(&metadata).unwrap();
    std::fs::write(&metadata, text + " ").unwrap();
    assert_ne!(before, state());
}
