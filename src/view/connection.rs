//! HTTP over one socket: requests with a body of JSON, and answers. Every step has a deadline, so
//! that nobody holds a thread by being slow.

use super::answer_memory::AnswerMemory;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// Most bytes of a request's head, with the cookies that other programs of this host have left, and
/// of its body.
const MAX_HEAD: usize = 64 << 10;
const MAX_BODY: usize = 16 << 10;

/// Most headers of a request.
const MAX_HEADERS: usize = 64;

/// Time that a connection may be idle before and after its first request, and that a later request
/// may take to arrive. The first one has as much as its connection before it.
const BRIEF: Duration = Duration::from_millis(250);
const UNKNOWN: Duration = Duration::from_secs(5);
const IDLE: Duration = Duration::from_secs(60);
const ARRIVAL: Duration = Duration::from_secs(10);

/// Time that an answer may take to leave, and a second more for as many bytes.
const DEPARTURE: Duration = Duration::from_secs(10);
const MIN_BYTES_PER_S: u64 = 64 << 10;

/// Time and bytes for which a connection is read whose last answer has been sent.
const LINGER: Duration = Duration::from_millis(500);
const MAX_LINGER: usize = 1 << 18;

/// A request.
pub(super) struct Request {
    pub(super) is_post: bool,
    pub(super) path: String,
    pub(super) host: String,
    pub(super) origin: Option<String>,
    pub(super) body: Vec<u8>,
    pub(super) keep_alive: bool,
}

/// An answer.
pub(super) struct Response {
    status: u16,
    content_type: &'static str,
    headers: Vec<(&'static str, String)>,
    body: Vec<u8>,
    _memory: Option<AnswerMemory>,
}

impl Response {
    pub(super) fn new(status: u16, content_type: &'static str, body: Vec<u8>) -> Response {
        Response {
            status,
            content_type,
            headers: Vec::new(),
            body,
            _memory: None,
        }
    }

    /// The answer, which holds this memory until it has been sent.
    pub(super) fn holding(self, memory: AnswerMemory) -> Response {
        let _memory = Some(memory);
        Response { _memory, ..self }
    }

    /// The answer with one more header, whose value has no line ends.
    pub(super) fn with_header(mut self, name: &'static str, value: String) -> Response {
        self.headers.push((name, value));
        self
    }
}

/// The reason why a request cannot be read: the status that answers it, or none if nobody waits.
pub(super) struct BadRequest(pub(super) Option<u16>);

impl From<io::Error> for BadRequest {
    fn from(error: io::Error) -> BadRequest {
        let is_slow = matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock);
        BadRequest(is_slow.then_some(408))
    }
}

/// A socket, with the bytes that arrived behind the last request.
pub(super) struct Connection {
    stream: TcpStream,
    ahead: Vec<u8>,
    idle: Duration,
    /// True if the last request wants no body.
    is_head: bool,
}

impl Connection {
    pub(super) fn new(stream: TcpStream, is_crowded: bool) -> io::Result<Connection> {
        // On some systems it is that of the listening socket.
        stream.set_nonblocking(false)?;
        stream.set_nodelay(true)?;
        Ok(Connection {
            stream,
            ahead: Vec::new(),
            idle: if is_crowded { BRIEF } else { UNKNOWN },
            is_head: false,
        })
    }

    /// The next request; `None` if the other side closes, or stays idle.
    pub(super) fn receive(&mut self) -> Result<Option<Request>, BadRequest> {
        if self.ahead.is_empty()
            && let Ok(0) | Err(_) = self.read_more(Instant::now() + self.idle)
        {
            return Ok(None);
        }
        let deadline = Instant::now() + self.idle.min(ARRIVAL);
        let mut seen = 0;
        let (mut request, head, body) = loop {
            self.is_head = self.ahead.starts_with(b"HEAD ");
            // A head that arrives byte by byte is not parsed for each of them.
            if ends_head(&self.ahead[seen..])
                && let Some(parsed) = parse_head(&self.ahead)?
            {
                break parsed;
            }
            seen = self.ahead.len().saturating_sub(3);
            if self.ahead.len() > MAX_HEAD {
                return Err(BadRequest(Some(431)));
            }
            if self.read_more(deadline)? == 0 {
                return Err(BadRequest(None));
            }
        };
        if body > MAX_BODY {
            return Err(BadRequest(Some(413)));
        }
        while self.ahead.len() < head + body {
            if self.read_more(deadline)? == 0 {
                return Err(BadRequest(None));
            }
        }
        request.body = self.ahead[head..head + body].to_vec();
        self.ahead.drain(..head + body);
        self.idle = IDLE;
        Ok(Some(request))
    }

    /// Reads what is there, and waits for it until the deadline. Returns 0 at the end.
    fn read_more(&mut self, deadline: Instant) -> io::Result<usize> {
        let mut chunk = [0; 4096];
        self.stream.set_read_timeout(Some(time_to(deadline)?))?;
        let count = self.stream.read(&mut chunk)?;
        self.ahead.extend(&chunk[..count]);
        Ok(count)
    }

    /// Sends an answer, and says whether the connection stays open.
    pub(super) fn send(&mut self, response: &Response, keep_alive: bool) -> io::Result<()> {
        let more = response.body.len() as u64 * 1000 / MIN_BYTES_PER_S;
        let deadline = Instant::now() + DEPARTURE + Duration::from_millis(more);
        self.write(&head(response, keep_alive), deadline)?;
        let sent = if self.is_head { 0 } else { response.body.len() };
        self.write(&response.body[..sent], deadline)
    }

    fn write(&mut self, mut bytes: &[u8], deadline: Instant) -> io::Result<()> {
        while !bytes.is_empty() {
            self.stream.set_write_timeout(Some(time_to(deadline)?))?;
            match self.stream.write(bytes)? {
                0 => return Err(ErrorKind::WriteZero.into()),
                count => bytes = &bytes[count..],
            }
        }
        Ok(())
    }

    /// Sends a last answer. What is still arriving is read for a while, or else the system would
    /// discard the answer together with it.
    pub(super) fn send_last(mut self, response: &Response) -> io::Result<()> {
        self.send(response, false)?;
        self.stream.shutdown(Shutdown::Write)?;
        let deadline = Instant::now() + LINGER;
        while self.ahead.len() < MAX_LINGER && self.read_more(deadline)? > 0 {}
        Ok(())
    }

    /// Returns false if the other side has closed the connection, so that nobody waits for an
    /// answer.
    pub(super) fn is_open(&self) -> bool {
        let peek = || {
            self.stream.set_nonblocking(true)?;
            let seen = self.stream.peek(&mut [0]);
            self.stream.set_nonblocking(false)?;
            seen
        };
        match peek() {
            Ok(count) => count > 0,
            Err(error) => error.kind() == ErrorKind::WouldBlock,
        }
    }
}

/// The time left until a deadline.
fn time_to(deadline: Instant) -> io::Result<Duration> {
    let left = deadline.saturating_duration_since(Instant::now());
    if left.is_zero() { Err(ErrorKind::TimedOut.into()) } else { Ok(left) }
}

/// Returns true if there is an empty line.
fn ends_head(bytes: &[u8]) -> bool {
    bytes.windows(2).any(|end| end == b"\n\n") || bytes.windows(3).any(|end| end == b"\n\r\n")
}

/// A request without its body, and the lengths of head and body; `None` if bytes are missing.
fn parse_head(bytes: &[u8]) -> Result<Option<(Request, usize, usize)>, BadRequest> {
    let bad = BadRequest(Some(400));
    let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
    let mut parsed = httparse::Request::new(&mut headers);
    let head = match parsed.parse(bytes) {
        Ok(httparse::Status::Complete(head)) => head,
        Ok(httparse::Status::Partial) => return Ok(None),
        Err(_) => return Err(bad),
    };
    let mut request = Request {
        is_post: match parsed.method {
            Some("POST") => true,
            Some("GET" | "HEAD") => false,
            _ => return Err(BadRequest(Some(405))),
        },
        path: parsed.path.unwrap_or_default().to_owned(),
        host: String::new(),
        origin: None,
        body: Vec::new(),
        keep_alive: parsed.version == Some(1),
    };
    let mut length = None;
    for header in parsed.headers.iter() {
        // No other header matters: a cookie may have any bytes.
        let value = str::from_utf8(header.value).unwrap_or("\u{fffd}");
        match header.name.to_ascii_lowercase().as_str() {
            "host" if request.host.is_empty() => request.host = value.to_owned(),
            "origin" if request.origin.is_none() => request.origin = Some(value.to_owned()),
            "content-length" if length.is_none() && !value.starts_with('+') => {
                length = Some(value.parse().map_err(|_| BadRequest(Some(400)))?);
            }
            // Twice, or a body whose end lies elsewhere: two readers might read two requests.
            "host" | "origin" | "content-length" | "transfer-encoding" => return Err(bad),
            "connection" if value.eq_ignore_ascii_case("close") => request.keep_alive = false,
            _ => {}
        }
    }
    Ok(Some((request, head, length.unwrap_or(0))))
}

fn head(response: &Response, keep_alive: bool) -> Vec<u8> {
    let connection = if keep_alive { "keep-alive" } else { "close" };
    let mut head = format!(
        "HTTP/1.1 {} \r\nContent-Type: {}\r\nContent-Length: {}\r\nConnection: {connection}\r\n\
         Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\n",
        response.status,
        response.content_type,
        response.body.len(),
    );
    for (name, value) in &response.headers {
        head += &format!("{name}: {value}\r\n");
    }
    head += "\r\n";
    head.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_ends_at_an_empty_line_wherever_it_was_cut() {
        let text = b"GET / HTTP/1.1\r\nA: b\r\n\r\n";
        for (end, start) in (1..=text.len()).flat_map(|end| (0..end).map(move |start| (end, start)))
        {
            let seen = start.saturating_sub(3);
            let is_complete = end == text.len();
            assert_eq!(ends_head(&text[seen..end]), is_complete, "{seen} {end}");
        }
        assert!(ends_head(b"GET / HTTP/1.1\n\n"));
    }

    fn status_of(text: &str) -> Option<u16> {
        match parse_head(text.as_bytes()) {
            Ok(_) => None,
            Err(BadRequest(status)) => status,
        }
    }

    #[test]
    fn a_request_has_one_length_and_one_host() {
        let plain = "POST /t/frame HTTP/1.1\r\nHost: localhost:1\r\nContent-Length: 2\r\n\r\n{}";
        let (request, head, body) = parse_head(plain.as_bytes()).ok().flatten().unwrap();
        assert_eq!((head + body, request.is_post), (plain.len(), true));
        assert_eq!(
            (&request.path[..], &request.host[..]),
            ("/t/frame", "localhost:1")
        );
        assert!(request.keep_alive && request.origin.is_none());
        assert!(parse_head(&plain.as_bytes()[..50]).ok().flatten().is_none());
        for (more, status) in [
            ("Host: evil\r\n", 400),
            ("Content-Length: 3\r\n", 400),
            ("Transfer-Encoding: chunked\r\n", 400),
            ("Origin: a\r\nOrigin: b\r\n", 400),
            ("X: \u{e9}\r\n: y\r\n", 400),
        ] {
            let text = plain.replace("\r\n\r\n", &format!("\r\n{more}\r\n"));
            assert_eq!(status_of(&text), Some(status), "{more}");
        }
        assert_eq!(status_of("PUT / HTTP/1.1\r\n\r\n"), Some(405));
        assert_eq!(
            status_of("POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n"),
            Some(400)
        );
    }
}
