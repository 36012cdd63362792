//! Guard: who may ask. Any page in a browser can send requests to this machine, so each has to know the token, has to
//! name this machine (else another's name may lead here: DNS rebinding), and has to come from a page of this server.

use std::fmt::Write;
use std::net::{IpAddr, SocketAddr};

use crate::http::Request;

/// Bytes of a token.
const TOKEN: usize = 24;

/// Who may ask.
#[derive(Debug)]
pub(crate) struct Guard {
    /// Made anew each time: in the address that is opened first, then in a cookie.
    token: String,
    /// Name of the cookie: servers on other ports have others.
    cookie: String,
    /// Names of this machine beside the loopback's; of all, the first is the one that the printed address has.
    names: Vec<String>,
}

/// Names of the loopback.
const LOOPBACK: [&str; 3] = ["localhost", "127.0.0.1", "[::1]"];

/// An address as the host of a URL.
fn host_of(address: IpAddr) -> String {
    match address {
        IpAddr::V4(address) => address.to_string(),
        IpAddr::V6(address) => format!("[{address}]"),
    }
}

/// Without the port.
fn name(host: &str) -> &str {
    match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    }
}

/// Compares in a time that does not depend on where they differ.
fn is_same(a: &str, b: &str) -> bool {
    let differences = a.bytes().zip(b.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
    a.len() == b.len() && differences == 0
}

impl Guard {
    /// A guard of an address that is listened on, with a new token. Beside the loopback's and the given names the address is
    /// one, unless it stands for all of the machine's.
    ///
    /// # Errors
    /// A system without random numbers.
    pub(crate) fn new(address: SocketAddr, mut names: Vec<String>) -> std::io::Result<Self> {
        let mut bytes = [0; TOKEN];
        getrandom::fill(&mut bytes).map_err(|error| std::io::Error::other(error.to_string()))?;
        let mut token = String::new();
        for byte in bytes {
            // Writing to text does not fail.
            let _ = write!(token, "{byte:02x}");
        }
        match address.ip() {
            ip if ip.is_loopback() => names.insert(0, host_of(ip)),
            ip if ip.is_unspecified() => (),
            ip => names.push(host_of(ip)),
        }
        Ok(Self {
            token,
            cookie: format!("splatvol-{}", address.port()),
            names,
        })
    }

    /// The name by which it is asked first.
    pub(crate) fn first_name(&self) -> &str {
        self.names.first().map_or(LOOPBACK[0], String::as_str)
    }

    pub(crate) fn token(&self) -> &str {
        &self.token
    }

    /// The cookie that stands for the token.
    pub(crate) fn cookie(&self) -> String {
        format!(
            "{}={}; Path=/; HttpOnly; SameSite=Strict",
            self.cookie, self.token
        )
    }

    /// Whether a query has the token.
    pub(crate) fn is_invited(&self, query: &str) -> bool {
        let tokens = query.split('&').filter_map(|pair| pair.strip_prefix("token="));
        tokens.into_iter().any(|token| is_same(token, &self.token))
    }

    /// Why a request is refused, whatever it asks.
    pub(crate) fn refusal(&self, request: &Request) -> Option<&'static str> {
        let host = request.header("host").filter(|_| request.count("host") == 1);
        let is_here = host.is_some_and(|host| {
            let name = name(host);
            LOOPBACK.contains(&name) || self.names.iter().any(|own| own.eq_ignore_ascii_case(name))
        });
        if !is_here {
            return Some("the request names another host: --host NAME allows one");
        }
        let origin = request.header("origin");
        let is_own = origin.is_none_or(|origin| {
            let of = origin.strip_prefix("http://").or(origin.strip_prefix("https://"));
            of == host && request.count("origin") == 1
        });
        if is_own {
            None
        } else {
            Some("the request comes from another page")
        }
    }

    /// Whether a request has the cookie.
    pub(crate) fn is_known(&self, request: &Request) -> bool {
        let cookies = request.header("cookie").unwrap_or_default().split(';');
        let own = cookies.filter_map(|pair| pair.trim().split_once('='));
        own.into_iter()
            .any(|(name, value)| name == self.cookie && is_same(value, &self.token))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guard(address: IpAddr, port: u16, names: &[&str]) -> Guard {
        let names = names.iter().map(|&name| name.to_owned()).collect();
        Guard::new(SocketAddr::new(address, port), names).unwrap()
    }

    #[test]
    fn the_printed_name_is_allowed() {
        let v6 = "fe80::1".parse().unwrap();
        for (address, names, first) in [
            ([127, 0, 0, 1].into(), &[][..], "127.0.0.1"),
            ([127, 0, 0, 1].into(), &["lab.example.org"], "127.0.0.1"),
            ([192, 168, 1, 7].into(), &[], "192.168.1.7"),
            ([192, 168, 1, 7].into(), &["lab.example.org"], "lab.example.org"),
            (v6, &[], "[fe80::1]"),
            ([0, 0, 0, 0].into(), &[], "localhost"),
            ([0, 0, 0, 0].into(), &["lab.example.org"], "lab.example.org"),
        ] {
            let guard = guard(address, 8080, names);
            assert_eq!(guard.first_name(), first);
            let asks = |host: &str| Request {
                method: "GET".to_owned(),
                target: "/".to_owned(),
                headers: vec![("host".to_owned(), host.to_owned())],
                body: Vec::new(),
            };
            assert_eq!(guard.refusal(&asks(&format!("{first}:8080"))), None, "{first}");
            assert!(guard.refusal(&asks("0.0.0.0:8080")).is_some());
            assert!(guard.refusal(&asks("evil.example.org:8080")).is_some());
        }
    }

    #[test]
    fn tokens_are_new_and_are_compared_whole() {
        let [a, b] = [1, 2].map(|port| guard([127, 0, 0, 1].into(), port, &[]));
        assert_ne!(a.token(), b.token());
        assert!(a.is_invited(&format!("x=1&token={}", a.token())));
        for wrong in ["", "token=", "token", &format!("token={}", &a.token()[1..])] {
            assert!(!a.is_invited(wrong), "{wrong}");
        }
        assert_eq!(
            [name("localhost:80"), name("[::1]:80"), name("[::1]")],
            ["localhost", "[::1]", "[::1]"]
        );
    }
}
