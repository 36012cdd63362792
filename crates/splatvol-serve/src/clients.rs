//! Clients: the state of each page that is open. They share the data; cameras, looks and cuts are their own.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use splatvol_web::Shown;

/// Most clients whose state is kept; of more, those that asked longest ago begin anew.
const MOST: usize = 64;
/// Longest name.
const LONGEST: usize = 64;

/// A page that is open.
#[derive(Debug)]
pub(crate) struct Client {
    pub number: u64,
    pub shown: Mutex<Shown>,
}

/// All of them, by the names that pages give themselves.
#[derive(Debug)]
pub(crate) struct Clients {
    first: Shown,
    known: Mutex<Known>,
}

#[derive(Debug, Default)]
struct Known {
    next: u64,
    clients: HashMap<String, (Arc<Client>, Instant)>,
}

impl Clients {
    /// None yet; each begins with this.
    pub(crate) fn new(first: Shown) -> Self {
        Self {
            first,
            known: Mutex::default(),
        }
    }

    /// The client of a name, and one that is forgotten for it.
    pub(crate) fn of(&self, name: &str) -> Option<(Arc<Client>, Option<u64>)> {
        let is_name =
            (1..=LONGEST).contains(&name.len()) && name.bytes().all(|byte| byte.is_ascii_alphanumeric());
        if !is_name {
            return None;
        }
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((client, seen)) = known.clients.get_mut(name) {
            *seen = Instant::now();
            return Some((Arc::clone(client), None));
        }
        let oldest = known.clients.iter().min_by_key(|(_, (_, seen))| *seen);
        let oldest = oldest
            .map(|(name, _)| name.clone())
            .filter(|_| known.clients.len() >= MOST);
        let forgotten = oldest.and_then(|name| known.clients.remove(&name));
        let client = Arc::new(Client {
            number: known.next,
            shown: Mutex::new(self.first.clone()),
        });
        known.next += 1;
        let entry = (Arc::clone(&client), Instant::now());
        known.clients.insert(name.to_owned(), entry);
        Some((client, forgotten.map(|(client, _)| client.number)))
    }
}
