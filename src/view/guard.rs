//! The secret in the page's address, and the places that requests may come from.

use super::connection::Request;
use std::io;
use std::net::IpAddr;

/// The name that a request asks for whose path ends with the token.
pub(super) const NO_SLASH: &str = "/";

/// The secret that a request must know.
pub(super) struct Guard {
    token: String,
}

/// 128 random bits in hexadecimal digits.
pub(super) fn random_hex() -> io::Result<String> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

impl Guard {
    /// A new secret.
    pub(super) fn new() -> io::Result<Guard> {
        Ok(Guard {
            token: random_hex()?,
        })
    }

    /// The path of the page.
    pub(super) fn path(&self) -> String {
        format!("/{}/", self.token)
    }

    /// The name of what a request asks for, if it knows the token and comes from the page itself.
    ///
    /// The host catches DNS rebinding, the origin other pages. The port is not compared, since it
    /// may be forwarded.
    pub(super) fn admitted<'r>(&self, request: &'r Request) -> Option<&'r str> {
        let is_port = |text: &str| text.bytes().all(|digit| digit.is_ascii_digit());
        let port = request.host.rsplit_once(':');
        let port = port.filter(|(_, port)| is_port(port));
        let host = port.map_or(&request.host[..], |(name, _)| name);
        let address = host.trim_matches(['[', ']']).parse();
        let is_here = host == "localhost" || address.is_ok_and(|ip: IpAddr| ip.is_loopback());
        let own = format!("http://{}", request.host);
        let is_own = request.origin.as_ref().is_none_or(|origin| *origin == own);
        let path = request.path.strip_prefix('/')?;
        let (token, name) = path.split_once('/').unwrap_or((path, NO_SLASH));
        let same = token.len() == self.token.len();
        // Every byte is compared, so that time tells nothing.
        let pairs = token.bytes().zip(self.token.bytes());
        let differing = pairs.fold(0, |all, (a, b)| all | (a ^ b));
        (is_here && is_own && same && differing == 0).then_some(name)
    }
}
