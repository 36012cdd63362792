//! Stores at addresses by the crate `object_store`: HTTP servers, and S3 with what speaks its protocol.

use std::collections::VecDeque;
use std::io::{Error, ErrorKind};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use object_store::aws::AmazonS3Builder;
use object_store::http::HttpBuilder;
use object_store::path::Path;
use object_store::{
    BackoffConfig, ClientOptions, GetOptions, GetRange, ObjectStore, ObjectStoreExt as _, RetryConfig,
};
use tokio::runtime::{Builder, Runtime};

use crate::key_store::{ByteRange, KeyStore, too_many_bytes};

/// Times after which a request is given up, and after which no other is tried.
#[derive(Debug, Clone, Copy)]
struct Patience {
    request: Duration,
    all_tries: Duration,
}

const USUAL: Patience = Patience {
    request: Duration::from_secs(30),
    all_tries: Duration::from_secs(120),
};
/// Further tries of a request.
const TRIES: usize = 5;
/// Pause before the first further try of an answer that broke off; each next one is twice as long.
const PAUSE: Duration = Duration::from_millis(100);
/// Answers that are kept until somebody reads them.
const MOST_AHEAD: usize = 64;
/// Threads that wait for servers.
const THREADS: usize = 2;

/// A store at an address.
#[derive(Debug)]
struct Objects {
    name: String,
    store: Arc<dyn ObjectStore>,
    /// Before all keys.
    prefix: Path,
    /// Requests that were announced, the oldest first.
    ahead: Mutex<VecDeque<(Request, Answer)>>,
}

/// A key and its bytes.
type Request = (String, ByteRange);
/// What becomes of a request.
type Answer = Receiver<std::io::Result<Option<Vec<u8>>>>;

/// Opens the store at an address that has a host.
pub(super) fn open(address: &str) -> Result<Arc<dyn KeyStore>, String> {
    open_within(address, USUAL)
}

fn open_within(address: &str, patience: Patience) -> Result<Arc<dyn KeyStore>, String> {
    runtime().map_err(|error| error.to_string())?;
    let options = ClientOptions::new()
        .with_timeout(patience.request)
        .with_allow_http(true);
    let retry = RetryConfig {
        backoff: BackoffConfig::default(),
        max_retries: TRIES,
        retry_timeout: patience.all_tries,
    };
    let address = address.trim_end_matches('/');
    let (store, prefix): (Arc<dyn ObjectStore>, &str) = match address.strip_prefix("s3://") {
        Some(rest) => {
            let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
            let is_signed = std::env::var_os("AWS_ACCESS_KEY_ID").is_some();
            let store = AmazonS3Builder::from_env()
                .with_bucket_name(bucket)
                .with_skip_signature(!is_signed)
                .with_client_options(options)
                .with_retry(retry)
                .build()
                .map_err(|error| error.to_string())?;
            (Arc::new(store), prefix)
        }
        None => {
            let store = HttpBuilder::new()
                .with_url(address)
                .with_client_options(options)
                .with_retry(retry)
                .build()
                .map_err(|error| error.to_string())?;
            (Arc::new(store), "")
        }
    };
    Ok(Arc::new(Objects {
        name: address.to_owned(),
        store,
        prefix: Path::parse(prefix).map_err(|error| error.to_string())?,
        ahead: Mutex::default(),
    }))
}

/// The threads that wait for servers; they are started once.
fn runtime() -> std::io::Result<&'static Runtime> {
    static RUNTIME: OnceLock<Runtime> = OnceLock::new();
    if let Some(runtime) = RUNTIME.get() {
        return Ok(runtime);
    }
    // An error says that the program has installed a provider of its own.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let started = Builder::new_multi_thread()
        .worker_threads(THREADS)
        .thread_name("splatvol-remote")
        .enable_all()
        .build()?;
    Ok(RUNTIME.get_or_init(|| started))
}

impl Objects {
    /// Asks for bytes. It waits on another thread, so that this works within a program's own runtime, too.
    fn ask(&self, key: &str, bytes: ByteRange, most: u64) -> std::io::Result<Answer> {
        let location = Path::parse(format!("{}/{key}", self.prefix))
            .map_err(|error| Error::new(ErrorKind::InvalidInput, error.to_string()))?;
        let store = Arc::clone(&self.store);
        let (answer, answered) = channel();
        runtime()?.spawn(async move {
            // Nobody listens where the caller has gone.
            let _ = answer.send(fetch(&*store, &location, bytes, most).await);
        });
        Ok(answered)
    }

    /// Takes the answer to a request that was announced.
    fn announced(&self, key: &str, bytes: ByteRange) -> Option<Answer> {
        let mut ahead = self.ahead.lock().unwrap_or_else(PoisonError::into_inner);
        let at = ahead
            .iter()
            .position(|((of, range), _)| of == key && *range == bytes)?;
        ahead.remove(at).map(|(_, answer)| answer)
    }
}

impl KeyStore for Objects {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn read(&self, key: &str, bytes: ByteRange, most: u64) -> std::io::Result<Option<Vec<u8>>> {
        let answered = match self.announced(key, bytes) {
            Some(answered) => answered,
            None => self.ask(key, bytes, most)?,
        };
        answered
            .recv()
            .map_err(|_| Error::other("the request was dropped"))?
    }

    fn will_read(&self, requests: &[(String, ByteRange, u64)]) {
        let mut ahead = self.ahead.lock().unwrap_or_else(PoisonError::into_inner);
        for (key, bytes, most) in requests {
            if ahead.iter().any(|((of, range), _)| of == key && range == bytes) {
                continue;
            }
            let Ok(answer) = self.ask(key, *bytes, *most) else {
                return;
            };
            ahead.push_back(((key.clone(), *bytes), answer));
            if ahead.len() > MOST_AHEAD {
                ahead.pop_front();
            }
        }
    }
}

async fn fetch(
    store: &dyn ObjectStore,
    location: &Path,
    bytes: ByteRange,
    most: u64,
) -> std::io::Result<Option<Vec<u8>>> {
    let options = GetOptions {
        range: match bytes {
            ByteRange::All => None,
            ByteRange::From { length: 0, .. } | ByteRange::Last(0) => {
                return Ok(store.head(location).await.ok().map(|_| Vec::new()));
            }
            ByteRange::From { start, length } => Some(GetRange::Bounded(start..start.saturating_add(length))),
            ByteRange::Last(length) => Some(GetRange::Suffix(length)),
        },
        ..GetOptions::default()
    };
    let mut tries = TRIES;
    loop {
        match once(store, location, options.clone(), most).await {
            Err(Failure::BrokenOff(_)) if tries > 0 => {
                tokio::time::sleep(PAUSE * 2u32.pow((TRIES - tries) as u32)).await;
                tries -= 1;
            }
            Err(Failure::BrokenOff(error) | Failure::Final(error)) => return Err(error),
            Ok(bytes) => return Ok(bytes),
        }
    }
}

/// Why there are no bytes.
enum Failure {
    /// The answer began, and did not end.
    BrokenOff(Error),
    Final(Error),
}

/// One answer; the crate has tried again where there was none.
async fn once(
    store: &dyn ObjectStore,
    location: &Path,
    options: GetOptions,
    most: u64,
) -> Result<Option<Vec<u8>>, Failure> {
    let answer = match store.get_opts(location, options).await {
        Ok(answer) => answer,
        Err(object_store::Error::NotFound { .. }) => return Ok(None),
        Err(error) => return Err(Failure::Final(failed(&error))),
    };
    let length = answer.range.end.saturating_sub(answer.range.start);
    if length > most {
        return Err(Failure::Final(too_many_bytes(length, most)));
    }
    let body = answer.bytes().await;
    let body = body.map_err(|error| Failure::BrokenOff(failed(&error)))?;
    match body.len() as u64 {
        found if found > most => Err(Failure::Final(too_many_bytes(found, most))),
        _ => Ok(Some(body.into())),
    }
}

fn failed(error: &object_store::Error) -> Error {
    let kind = match error {
        object_store::Error::PermissionDenied { .. } | object_store::Error::Unauthenticated { .. } => {
            ErrorKind::PermissionDenied
        }
        object_store::Error::NotSupported { .. } => ErrorKind::Unsupported,
        _ => ErrorKind::Other,
    };
    Error::new(kind, with_causes(error))
}

/// An error and its causes, of which the last says what is wrong: a name that nobody knows, a certificate.
fn with_causes(error: &object_store::Error) -> String {
    let mut text = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(error) = cause {
        let own = error.to_string();
        if !text.contains(&own) {
            text = format!("{text}: {own}");
        }
        cause = error.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use splatvol_testing::server::{Fault, serve};

    use super::*;

    const SHORT: Patience = Patience {
        request: Duration::from_millis(300),
        all_tries: Duration::from_secs(3),
    };

    /// Reads eight keys of a server, with a pause that nobody bears.
    fn read(fault: Fault) -> Vec<std::io::Result<Option<Vec<u8>>>> {
        let folder = tempfile::tempdir().unwrap();
        for key in 0..8u8 {
            std::fs::write(folder.path().join(key.to_string()), [key; 5]).unwrap();
        }
        let server = serve(folder.path().to_owned(), fault);
        let store = open_within(&server.address, SHORT).unwrap();
        let one = |key: usize| store.read(&key.to_string(), ByteRange::From { start: 1, length: 3 }, 100);
        (0..8).map(one).collect()
    }

    #[test]
    fn answers_that_do_not_come_are_asked_for_again() {
        for (key, answer) in read(Fault::Stalls).into_iter().enumerate() {
            assert_eq!(answer.unwrap().unwrap(), [key as u8; 3]);
        }
    }

    #[test]
    fn a_server_that_never_answers_is_given_up_and_said() {
        let start = Instant::now();
        for answer in read(Fault::Mute) {
            let error = answer.unwrap_err().to_string();
            assert!(error.contains("time"), "{error}");
        }
        assert!(start.elapsed() < 8 * 2 * SHORT.all_tries, "{:?}", start.elapsed());
    }
}
