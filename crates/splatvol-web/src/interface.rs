//! The instance as a WebAssembly module, without bindings: a C interface of two functions.
//!
//! A message of `header` and `bytes` bytes is written to the address that [`splatvol_message`] returns, the header first.
//! [`splatvol_answer`] answers it, and returns the address of the answer: the lengths of its header and of its bytes, two
//! little-endian numbers of 32 bits, then the header and the bytes. Both stay where they are until the next message. The
//! module imports nothing.

use std::cell::RefCell;

use crate::Session;

/// The message that is written, its answer, and the instance.
#[derive(Default)]
struct Interface {
    /// Bytes of the header.
    header: usize,
    message: Vec<u8>,
    answer: Vec<u8>,
    session: Option<Session>,
}

thread_local! {
    static INTERFACE: RefCell<Interface> = RefCell::default();
}

/// Makes room for a message, and returns its address.
// SAFETY: no other function of the module has this name.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it")]
#[unsafe(no_mangle)]
pub(crate) extern "C" fn splatvol_message(header: usize, bytes: usize) -> *mut u8 {
    INTERFACE.with_borrow_mut(|interface| {
        interface.header = header;
        interface.answer = Vec::new();
        interface.message = vec![0; header.saturating_add(bytes)];
        interface.message.as_mut_ptr()
    })
}

/// Answers the message, and returns the address of the answer.
// SAFETY: no other function of the module has this name.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it")]
#[unsafe(no_mangle)]
pub(crate) extern "C" fn splatvol_answer() -> *const u8 {
    INTERFACE.with_borrow_mut(|interface| {
        let message = std::mem::take(&mut interface.message);
        let (header, bytes) = message.split_at(interface.header.min(message.len()));
        let (header, bytes) = interface.answered(header, bytes);
        let lengths = [header.len(), bytes.len()].map(|length| (length as u32).to_le_bytes());
        interface.answer = [lengths.as_flattened(), header.as_bytes(), &bytes].concat();
        interface.answer.as_ptr()
    })
}

impl Interface {
    fn answered(&mut self, header: &[u8], bytes: &[u8]) -> (String, Vec<u8>) {
        let refused = |why: String| (serde_json::json!({ "error": why }).to_string(), Vec::new());
        let Ok(header) = str::from_utf8(header) else {
            return refused("the message is not UTF-8".to_owned());
        };
        if self.session.is_none() {
            match Session::new() {
                Ok(session) => self.session = Some(session),
                Err(error) => return refused(error.to_string()),
            }
        }
        match &mut self.session {
            Some(session) => {
                let answer = session.answer(header, bytes);
                (answer.header, answer.bytes)
            }
            None => refused("the engine has not started".to_owned()),
        }
    }
}
