//! Two WebAssembly modules without bindings, each a C interface of two functions: the engine, and the readers of files.
//!
//! A message of `header` and `bytes` bytes is written to the address that [`splatvol_message`] returns, the header first.
//! [`splatvol_answer`], of the engine, or [`splatvol_read`], of the readers, answers it, and returns the address of the answer: the
//! lengths of its header and of its bytes, two little-endian numbers of 32 bits, then the header and the bytes. Both stay where they
//! are until the next message.
//!
//! The engine imports nothing. The readers import a function of the page that reads bytes of the files that it was given; their
//! message is a [`FilesGiven`], their answer's header a [`FilesRead`].

use std::cell::RefCell;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use splatvol_document::{ReadRules, items};
use splatvol_io::files::{GivenBytes, GivenFile, give};

use crate::files::{FilesGiven, FilesRead, read_files};
use crate::{Answer, Session, WebError};

#[link(wasm_import_module = "page")]
// SAFETY: the page gives a function of this type; it writes to so many bytes from the address on, and to nothing else.
#[expect(unsafe_code, reason = "a function of the page")]
unsafe extern "C" {
    /// Reads bytes of a file, by its number, from a position on; 0 if it cannot.
    fn read_file(file: u32, position: f64, address: *mut u8, length: usize) -> u32;
}

/// A message, and its answer.
#[derive(Default)]
struct Conversation {
    /// Bytes of the header.
    header: usize,
    message: Vec<u8>,
    answer: Vec<u8>,
}

thread_local! {
    static CONVERSATION: RefCell<Conversation> = RefCell::default();
    static SESSION: RefCell<Option<Session>> = const { RefCell::new(None) };
}

/// Makes room for a message, and returns its address.
// SAFETY: no other function of the module has this name.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it")]
#[unsafe(no_mangle)]
pub(crate) extern "C" fn splatvol_message(header: usize, bytes: usize) -> *mut u8 {
    CONVERSATION.with_borrow_mut(|talk| {
        talk.header = header;
        talk.answer = Vec::new();
        talk.message = vec![0; header.saturating_add(bytes)];
        talk.message.as_mut_ptr()
    })
}

/// Answers the message by the engine, and returns the address of the answer.
// SAFETY: no other function of the module has this name.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it")]
#[unsafe(no_mangle)]
pub(crate) extern "C" fn splatvol_answer() -> *const u8 {
    answered(|header, bytes| {
        SESSION.with_borrow_mut(|session| {
            let session = match session {
                Some(session) => session,
                None => session.insert(Session::new()?),
            };
            Ok(session.answer(header, bytes))
        })
    })
}

/// Reads the files of the message, and returns the address of the answer.
// SAFETY: no other function of the module has this name.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it")]
#[unsafe(no_mangle)]
pub(crate) extern "C" fn splatvol_read() -> *const u8 {
    answered(|header, _| {
        let (read, bytes) = read_given(serde_json::from_str(header)?)?;
        let header = serde_json::to_string(&read)?;
        Ok(Answer { header, bytes })
    })
}

/// Answers the message, and returns the address of the answer.
fn answered(answer: impl FnOnce(&str, &[u8]) -> Result<Answer, WebError>) -> *const u8 {
    CONVERSATION.with_borrow_mut(|talk| {
        let message = std::mem::take(&mut talk.message);
        let (header, bytes) = message.split_at(talk.header.min(message.len()));
        let answered = match str::from_utf8(header) {
            Ok(header) => answer(header, bytes).unwrap_or_else(|error| Answer::refusal(&error)),
            Err(_) => Answer::refusal(&"the message is not UTF-8"),
        };
        let lengths =
            [answered.header.len(), answered.bytes.len()].map(|length| (length as u32).to_le_bytes());
        talk.answer = [
            lengths.as_flattened(),
            answered.header.as_bytes(),
            &answered.bytes,
        ]
        .concat();
        talk.answer.as_ptr()
    })
}

/// A file that the page reads, by its number.
struct PageFile(u32);

impl GivenBytes for PageFile {
    #[expect(unsafe_code, reason = "the page fills the bytes")]
    fn read_at(&self, bytes: &mut [u8], position: u64) -> io::Result<()> {
        // SAFETY: the address is that of so many bytes, which nobody else has meanwhile.
        let read = unsafe { read_file(self.0, position as f64, bytes.as_mut_ptr(), bytes.len()) };
        match read {
            0 => Err(io::Error::other("the browser cannot read it")),
            _ => Ok(()),
        }
    }
}

/// Reads files that the page was given.
fn read_given(given: FilesGiven) -> Result<(FilesRead, Vec<u8>), WebError> {
    let options = items::options(&given.keys, ReadRules::default())?;
    let paths: Vec<PathBuf> = given.files.iter().map(|file| file.path.clone()).collect();
    give((0..).zip(given.files).map(|(number, file)| GivenFile {
        path: file.path,
        length: file.length,
        bytes: Arc::new(PageFile(number)),
    }));
    Ok(read_files(Path::new(""), &paths, &options)?)
}
