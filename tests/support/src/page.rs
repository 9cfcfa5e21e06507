//! A client of the live page's server.

use crate::PATIENCE;
use std::io::{Error, ErrorKind, Read, Result, Write};
use std::net::TcpStream;

/// The address of a page: its server, and the token that requests carry.
#[derive(Debug, Clone)]
pub struct PageClient {
    /// Name or number of the host, and the port.
    pub host: String,
    /// The token.
    pub token: String,
}

/// An answer of the page's server.
#[derive(Debug)]
pub struct PageAnswer {
    /// The status of HTTP.
    pub status: u16,
    /// The header in lower case.
    pub head: String,
    /// The content.
    pub body: Vec<u8>,
}

impl PageClient {
    /// The client of a page's address, such as `http://127.0.0.1:8080/#TOKEN`.
    pub fn at(address: &str) -> Self {
        let parts = address.trim().strip_prefix("http://").and_then(|rest| rest.split_once("/#"));
        let (host, token) = parts.unwrap_or_else(|| panic!("{address:?}, expected http://HOST:PORT/#TOKEN"));
        PageClient { host: host.to_owned(), token: token.to_owned() }
    }

    /// The client with another token.
    #[must_use]
    pub fn with_token(&self, token: &str) -> Self {
        PageClient { host: self.host.clone(), token: token.to_owned() }
    }

    /// A connection on which nothing was sent yet.
    ///
    /// # Errors
    /// Those of the connection.
    pub fn connect(&self) -> Result<TcpStream> {
        let stream = TcpStream::connect(&self.host)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        Ok(stream)
    }

    /// Sends a request, such as `GET /api/scene`, and waits for the answer.
    ///
    /// # Errors
    /// Those of the connection; [`ErrorKind::InvalidData`] for an answer that is none of HTTP.
    pub fn ask(&self, request: &str, body: &str) -> Result<PageAnswer> {
        let PageClient { host, token } = self;
        let (mut stream, length) = (self.connect()?, body.len());
        let head = format!(
            "{request} HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {token}\r\nContent-Length: {length}\r\n\
             Connection: close\r\n\r\n"
        );
        stream.write_all(head.as_bytes())?;
        stream.write_all(body.as_bytes())?;
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes)?;
        let end = bytes.windows(4).position(|four| four == b"\r\n\r\n");
        let head = end.map(|end| String::from_utf8_lossy(&bytes[..end]).to_ascii_lowercase()).unwrap_or_default();
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok());
        let (Some(end), Some(status)) = (end, status) else {
            return Err(Error::new(ErrorKind::InvalidData, "the page's server sent half an answer"));
        };
        Ok(PageAnswer { status, head, body: bytes.split_off(end + 4) })
    }
}

impl PageAnswer {
    /// The facts of a picture, JSON, and its PNG; `None` if the body has no such facts.
    pub fn picture(&self) -> Option<(&[u8], &[u8])> {
        let (length, rest) = self.body.split_first_chunk()?;
        rest.split_at_checked(u32::from_le_bytes(*length) as usize)
    }
}
