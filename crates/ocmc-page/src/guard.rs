//! Guard of the server, which answers only the page that it has served itself.
//!
//! Every program on a computer reaches the loopback, and any site that a browser shows may send
//! requests there. A token in the address that nobody can guess keeps both out; `Host` and `Origin`
//! keep out sites that make their name point to the loopback.

use crate::http::{Refusal, Request};
use std::fmt::Write;
use std::net::SocketAddr;

/// Bytes of a token.
const TOKEN_BYTES: usize = 16;

/// Requirements on a request.
#[derive(Clone, Debug)]
pub(crate) struct Guard {
    token: String,
    hosts: [String; 2],
}

impl Guard {
    /// A guard of a server at an address, with a token of its own.
    ///
    /// # Errors
    /// Where the system has no random numbers.
    pub(crate) fn new(address: SocketAddr) -> Result<Self, getrandom::Error> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes)?;
        let mut token = String::new();
        for byte in bytes {
            let _ = write!(token, "{byte:02x}");
        }
        let port = address.port();
        Ok(Self { token, hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")] })
    }

    /// The address for the browser.
    pub(crate) fn address(&self) -> String {
        format!("http://{}/{}/", self.hosts[0], self.token)
    }

    /// The path of a request behind the token.
    ///
    /// # Errors
    /// A refusal that says no more than that.
    pub(crate) fn admit<'a>(&self, request: &'a Request) -> Result<&'a str, Refusal> {
        let forbidden = Refusal(403, "not from the page that this server shows");
        let is_host = |name: &str| self.hosts.iter().any(|host| host == name);
        if !request.header("host").is_some_and(is_host) {
            return Err(forbidden);
        }
        let is_own = |origin: &str| origin.strip_prefix("http://").is_some_and(is_host);
        if !request.header("origin").is_none_or(is_own) {
            return Err(forbidden);
        }
        let is_same = |site: &str| matches!(site, "same-origin" | "none");
        if !request.header("sec-fetch-site").is_none_or(is_same) {
            return Err(forbidden);
        }
        let rest = request.path.strip_prefix('/').ok_or(Refusal(404, "no such page"))?;
        let (token, path) = rest.split_once('/').ok_or(forbidden)?;
        // as long for a wrong token as for the right one
        let differ = token.bytes().zip(self.token.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b));
        if token.len() != self.token.len() || differ != 0 {
            return Err(forbidden);
        }
        Ok(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guard() -> Guard {
        Guard::new(SocketAddr::from(([127, 0, 0, 1], 4000))).expect("random numbers")
    }

    fn request(path: String, headers: &[(&str, &str)]) -> Request {
        let headers = headers.iter().map(|(name, value)| (name.to_string(), value.to_string()));
        Request { method: "GET".to_owned(), path, headers: headers.collect(), body_bytes: 0 }
    }

    #[test]
    fn only_the_page_itself_is_answered() {
        let guard = &guard();
        let token = &guard.token;
        let path = |token: &str| format!("/{token}/ask");
        let right = ("host", "127.0.0.1:4000");
        let allowed: &[&[(&str, &str)]] = &[
            &[right],
            &[("host", "localhost:4000"), ("origin", "http://localhost:4000")],
            &[right, ("origin", "http://127.0.0.1:4000"), ("sec-fetch-site", "same-origin")],
            &[right, ("sec-fetch-site", "none")],
        ];
        for headers in allowed {
            let request = &request(path(token), headers);
            assert_eq!(guard.admit(request).expect("the page"), "ask", "{headers:?}");
        }
        let refused: &[&[(&str, &str)]] = &[
            &[],
            &[("host", "evil.example:4000")],
            &[("host", "127.0.0.1")],
            &[("host", "127.0.0.1:4001")],
            &[right, ("origin", "http://evil.example")],
            &[right, ("origin", "https://127.0.0.1:4000")],
            &[right, ("origin", "null")],
            &[right, ("sec-fetch-site", "cross-site")],
            &[right, ("sec-fetch-site", "same-site")],
        ];
        for headers in refused {
            assert!(guard.admit(&request(path(token), headers)).is_err(), "{headers:?}");
        }
        for other in ["", "0", &token[1..], &format!("{token}0"), &token.replace(&token[..1], "x")]
        {
            assert!(guard.admit(&request(path(other), &[right])).is_err(), "{other}");
        }
        assert!(guard.admit(&request(format!("/{token}"), &[right])).is_err());
    }

    #[test]
    fn tokens_are_not_used_twice() {
        assert_ne!(guard().token, guard().token);
        assert_eq!(guard().token.len(), 2 * TOKEN_BYTES);
    }
}
