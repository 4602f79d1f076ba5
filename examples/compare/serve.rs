//! The pages of studies, served to browsers on this machine while they fill.
//!
//! A server for one reader, which waits for nobody: who is slow or sends nonsense loses the
//! connection, and the study goes on. Other websites that the reader's browser shows can neither
//! read pages, since requests must name this server as their host, nor stop the study, since they
//! do not know the token.

use serde_json::json;
use std::collections::hash_map::RandomState;
use std::fmt::Display;
use std::hash::{BuildHasher, Hasher};
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// The port that is tried first if none is asked for: a reader's tab finds the next study there.
const PORT: u16 = 8327;

/// The shortest time from one page to the next, and the part of the time that pages may take, one
/// over.
const UPDATE: Duration = Duration::from_secs(5);
const PART: u32 = 10;

/// Connections at a time, bytes and headers of a request, and times to send one and to take the
/// answer.
const MOST_CONNECTIONS: usize = 32;
const MOST_BYTES: usize = 16 << 10;
const MOST_HEADERS: usize = 64;
const REQUEST_TIME: Duration = Duration::from_secs(5);
const ANSWER_TIME: Duration = Duration::from_secs(30);

/// The bar that is added to a page: state, progress, a button.
const BAR: &str = include_str!("bar.html");
/// The page of a study that has no results yet.
const EMPTY: &str = "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\">\
    <meta name=\"color-scheme\" content=\"light dark\"><link rel=\"icon\" href=\"data:,\">\
    <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
    <title>Error against run time</title><style>body { font-family: system-ui }</style></head>\
    <body><p>Results will be here when a run is finished.</p></body></html>";
/// Pages have all that they need in them.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
    img-src data: 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; \
    frame-ancestors 'none'";

/// An address of this machine that others cannot reach: `PORT` or `HOST:PORT`.
pub fn parse_loopback(text: &str) -> Result<SocketAddr, String> {
    let port = text.strip_prefix("localhost:").unwrap_or(text).parse::<u16>();
    let address = match port {
        Ok(port) => Ok((Ipv4Addr::LOCALHOST, port).into()),
        Err(_) => text.parse::<SocketAddr>(),
    };
    match address {
        Ok(address) if address.ip().is_loopback() => Ok(address),
        Ok(address) => Err(format!(
            "{} can be reached from other machines; pages are served on this one alone, at \
             127.0.0.1, [::1] or localhost, and elsewhere through a tunnel with the same port at both \
             ends, such as that of ssh -L",
            address.ip()
        )),
        Err(_) => Err(format!("{text:?} is not PORT or HOST:PORT, such as 127.0.0.1:{PORT}")),
    }
}

/// A server of the pages of studies.
#[derive(Debug)]
pub struct Server {
    shared: Arc<Shared>,
    address: SocketAddr,
    due: Instant,
}

#[derive(Debug)]
struct Shared {
    /// The names of the server in requests.
    hosts: [String; 2],
    /// A secret that only pages from here know.
    token: String,
    studies: Mutex<Studies>,
    is_stopped: AtomicBool,
    is_done: AtomicBool,
    is_closed: AtomicBool,
    connections: AtomicUsize,
}

/// The studies so far, of which the last one is under way.
#[derive(Debug, Default)]
struct Studies {
    all: Vec<Shown>,
    label: String,
    fraction: f64,
}

#[derive(Debug)]
struct Shown {
    name: String,
    page: Arc<[u8]>,
    version: u32,
    directory: PathBuf,
    /// True if the files are those of this study, and not of the one before it.
    is_saved: bool,
}

impl Server {
    /// Starts to serve, at the address that is asked for or, without one, where it can.
    pub fn start(address: Option<SocketAddr>) -> Result<Self, String> {
        let listener = match address {
            Some(address) => TcpListener::bind(address),
            None => TcpListener::bind((Ipv4Addr::LOCALHOST, PORT))
                .or_else(|_| TcpListener::bind((Ipv4Addr::LOCALHOST, 0))),
        };
        let bound = listener.and_then(|listener| Ok((listener.local_addr()?, listener)));
        let asked = address.unwrap_or((Ipv4Addr::LOCALHOST, 0).into());
        let failure = |error: io::Error| format!("--serve: {asked}: {error}");
        let (address, listener) = bound.map_err(failure)?;
        // The keys of these hashes come from the system's source of random numbers.
        let random = || RandomState::new().build_hasher().finish();
        let shared = Arc::new(Shared {
            hosts: [address.to_string(), format!("localhost:{}", address.port())],
            token: format!("{:016x}{:016x}", random(), random()),
            studies: Mutex::default(),
            is_stopped: AtomicBool::new(false),
            is_done: AtomicBool::new(false),
            is_closed: AtomicBool::new(false),
            connections: AtomicUsize::new(0),
        });
        let own = Arc::clone(&shared);
        let accept = move || listen(&listener, &own);
        thread::Builder::new().name("serve".to_owned()).spawn(accept).map_err(failure)?;
        Ok(Self { shared, address, due: Instant::now() })
    }

    /// The address of the pages.
    pub fn url(&self) -> impl Display {
        format!("http://{}/", self.address)
    }

    /// True if a reader has asked for the end of the study.
    pub fn is_stopped(&self) -> bool {
        self.shared.is_stopped.load(Ordering::Relaxed)
    }

    /// Begins the page of another study, whose files will be in this directory.
    pub fn begin(&mut self, name: &str, directory: &Path) {
        let (name, directory) = (name.to_owned(), directory.to_owned());
        let mut studies = self.shared.studies();
        let page = self.shared.page(EMPTY, studies.all.len() + 1, 0);
        studies.all.push(Shown { name, page, version: 0, directory, is_saved: false });
        self.due = Instant::now();
    }

    /// Tells what is under way, and how far it is.
    pub fn tell(&self, label: &str, fraction: f64) {
        let mut studies = self.shared.studies();
        studies.label.clear();
        studies.label.push_str(label);
        studies.fraction = fraction;
    }

    /// Makes and shows a page of what is there by now, if it is time for one.
    pub fn update(&mut self, page: impl FnOnce() -> Option<String>) {
        let start = Instant::now();
        if start < self.due {
            return;
        }
        if let Some(page) = page() {
            self.show(&page, false);
            self.due = Instant::now() + UPDATE.max(start.elapsed() * PART);
        }
    }

    /// Shows the page of a study whose files have been written.
    pub fn finish(&self, page: &str) {
        self.show(page, true);
    }

    fn show(&self, page: &str, is_saved: bool) {
        let mut studies = self.shared.studies();
        let number = studies.all.len();
        if let Some(shown) = studies.all.last_mut() {
            shown.version += 1;
            shown.page = self.shared.page(page, number, shown.version);
            shown.is_saved = is_saved;
        }
    }

    /// Goes on serving when all is done, until a reader or an interrupt closes the server.
    pub fn wait(&self, interrupted: &AtomicBool) {
        self.shared.is_done.store(true, Ordering::Relaxed);
        let is_closed = || self.shared.is_closed.load(Ordering::Relaxed);
        while !is_closed() && !interrupted.load(Ordering::Relaxed) {
            thread::sleep(Duration::from_millis(20));
        }
        // The answer to the one who closed it is on its way.
        let start = Instant::now();
        let is_busy = || self.shared.connections.load(Ordering::Relaxed) > 0;
        while is_busy() && start.elapsed() < Duration::from_secs(1) {
            thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Takes connections, each to a thread of its own.
fn listen(listener: &TcpListener, shared: &Arc<Shared>) {
    for stream in listener.incoming() {
        let Ok(stream) = stream else {
            // Such as too many open files, which may end.
            thread::sleep(Duration::from_millis(50));
            continue;
        };
        let connection = Connection::new(Arc::clone(shared));
        let Some(connection) = connection else { continue };
        // A thread that cannot be started leaves the connection to its end.
        let _ = thread::Builder::new().spawn(move || connection.answer(stream));
    }
}

/// A connection, which counts while it lives.
struct Connection(Arc<Shared>);

impl Connection {
    /// A connection, if there are not too many.
    fn new(shared: Arc<Shared>) -> Option<Self> {
        let others = shared.connections.fetch_add(1, Ordering::Relaxed);
        let connection = Self(shared);
        (others < MOST_CONNECTIONS).then_some(connection)
    }

    /// Answers one request. Who breaks off has no answer.
    fn answer(&self, mut stream: TcpStream) {
        let answer = match read_head(&mut stream) {
            Ok(head) => self.0.answer(&head),
            Err(error) => match error.kind() {
                ErrorKind::FileTooLarge => Answer::text(431, "the request is too long"),
                ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                    Answer::text(408, "the request takes too long")
                }
                _ => return,
            },
        };
        let _ = answer.write(&mut stream);
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.0.connections.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Reads a request up to the end of its headers.
fn read_head(stream: &mut TcpStream) -> io::Result<Vec<u8>> {
    let start = Instant::now();
    let mut head = Vec::new();
    let mut part = [0; 1024];
    while !head.windows(4).rev().take(part.len() + 3).any(|end| end == b"\r\n\r\n") {
        let left = REQUEST_TIME.saturating_sub(start.elapsed()).max(Duration::from_millis(1));
        stream.set_read_timeout(Some(left))?;
        let bytes = match stream.read(&mut part)? {
            0 => return Err(ErrorKind::UnexpectedEof.into()),
            bytes => bytes,
        };
        head.extend_from_slice(&part[..bytes]);
        if head.len() > MOST_BYTES {
            return Err(ErrorKind::FileTooLarge.into());
        }
        if start.elapsed() > REQUEST_TIME {
            return Err(ErrorKind::TimedOut.into());
        }
    }
    Ok(head)
}

impl Shared {
    fn studies(&self) -> MutexGuard<'_, Studies> {
        self.studies.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A page with the bar at its top.
    fn page(&self, page: &str, study: usize, version: u32) -> Arc<[u8]> {
        let bar = BAR
            .replace("{study}", &study.to_string())
            .replace("{version}", &version.to_string())
            .replace("{token}", &self.token);
        let body = page.find("<body").and_then(|at| Some(at + page[at..].find('>')? + 1));
        let (head, rest) = page.split_at(body.unwrap_or(0));
        [head, &bar, rest].concat().into_bytes().into()
    }

    fn answer(&self, head: &[u8]) -> Answer {
        let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        if !request.parse(head).is_ok_and(|status| status.is_complete()) {
            return Answer::text(400, "this is no request that can be understood");
        }
        let (method, path) = (request.method.unwrap_or(""), request.path.unwrap_or(""));
        let header = |name: &str| {
            let mut found = request.headers.iter().filter(|h| h.name.eq_ignore_ascii_case(name));
            let value = found.next().map(|h| String::from_utf8_lossy(h.value).into_owned());
            // Twice is as wrong as another one.
            if found.next().is_some() { Some(String::new()) } else { value }
        };
        // Another site may have a name that leads here, for which browsers let it read all.
        let is_ours = |host: &str| self.hosts.iter().any(|own| own.eq_ignore_ascii_case(host));
        if !header("host").is_some_and(|host| is_ours(&host)) {
            return Answer::text(403, "this server has another name");
        }
        let origin = header("origin");
        let is_from_here = |origin: &String| origin.strip_prefix("http://").is_some_and(is_ours);
        match (method, path) {
            ("GET", _) => self.get(path),
            ("POST", "/stop" | "/close") => {
                let has_token = header("x-token").is_some_and(|token| token == self.token);
                if !has_token || !origin.as_ref().is_none_or(is_from_here) {
                    return Answer::text(403, "only the page itself may ask for this");
                }
                match path {
                    "/stop" => self.is_stopped.store(true, Ordering::Relaxed),
                    _ if self.is_done.load(Ordering::Relaxed) => {
                        self.is_closed.store(true, Ordering::Relaxed);
                    }
                    _ => return Answer::text(409, "the study is under way"),
                }
                Answer::text(200, "it will end")
            }
            ("POST", _) => Answer::text(404, "there is nothing of this name"),
            _ => Answer::text(405, "only GET, and POST for the buttons"),
        }
    }

    fn get(&self, path: &str) -> Answer {
        let studies = self.studies();
        if path == "/status" {
            return self.status(&studies);
        }
        if path == "/" && !studies.all.is_empty() {
            let location = Some(format!("/{}/", studies.all.len()));
            return Answer { location, ..Answer::text(303, "see the study") };
        }
        let (study, name) = path.trim_start_matches('/').split_once('/').unwrap_or_default();
        let index = study.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
        let Some(shown) = index.and_then(|index| studies.all.get(index)) else {
            return Answer::text(404, "there is nothing of this name");
        };
        if name.is_empty() {
            return Answer::new(200, "text/html; charset=utf-8", Arc::clone(&shown.page));
        }
        if !shown.is_saved {
            return Answer::text(404, "the files will be there when the study has ended");
        }
        let file = shown.directory.join(name);
        drop(studies);
        match (kind_of(name), std::fs::read(&file)) {
            (Some(kind), Ok(contents)) => Answer::new(200, kind, contents.into()),
            _ => Answer::text(404, "there is nothing of this name"),
        }
    }

    fn status(&self, studies: &Studies) -> Answer {
        let state = if self.is_done.load(Ordering::Relaxed) {
            "done"
        } else if self.is_stopped.load(Ordering::Relaxed) {
            "ending"
        } else {
            "running"
        };
        let all = studies.all.iter().map(|shown| {
            let file = shown.directory.join("index.html");
            json!({"name": shown.name, "version": shown.version, "file": file.display().to_string()})
        });
        let status = json!({
            "token": self.token,
            "state": state,
            "label": studies.label,
            "fraction": studies.fraction,
            "studies": all.collect::<Vec<_>>(),
        });
        Answer::new(200, "application/json", status.to_string().into_bytes().into())
    }
}

/// The type of a file that a study writes; none of others, such as those in other directories.
fn kind_of(name: &str) -> Option<&'static str> {
    let plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    let (stem, extension) = name.rsplit_once('.')?;
    match extension {
        _ if stem.is_empty() || !name.chars().all(plain) => None,
        "csv" => Some("text/csv; charset=utf-8"),
        "exr" => Some("image/x-exr"),
        "json" => Some("application/json"),
        "md" => Some("text/plain; charset=utf-8"),
        "png" => Some("image/png"),
        "svg" => Some("image/svg+xml"),
        _ => None,
    }
}

/// An answer to a request.
struct Answer {
    status: u16,
    kind: &'static str,
    body: Arc<[u8]>,
    location: Option<String>,
}

impl Answer {
    fn new(status: u16, kind: &'static str, body: Arc<[u8]>) -> Self {
        Self { status, kind, body, location: None }
    }

    fn text(status: u16, text: &str) -> Self {
        Self::new(status, "text/plain; charset=utf-8", format!("{text}\n").into_bytes().into())
    }

    fn write(&self, stream: &mut TcpStream) -> io::Result<()> {
        let Self { status, kind, body, location } = self;
        let mut head = format!(
            "HTTP/1.1 {status} \r\nContent-Type: {kind}\r\nContent-Length: {}\r\n\
             Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
             Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
             Content-Security-Policy: {POLICY}\r\n",
            body.len()
        );
        if let Some(location) = location {
            head += &format!("Location: {location}\r\n");
        }
        head += "\r\n";
        let start = Instant::now();
        for mut part in [head.as_bytes(), body] {
            while !part.is_empty() {
                let left = ANSWER_TIME.saturating_sub(start.elapsed());
                if left.is_zero() {
                    return Err(ErrorKind::TimedOut.into());
                }
                stream.set_write_timeout(Some(left))?;
                let bytes = stream.write(part)?;
                part = &part[bytes..];
            }
        }
        Ok(())
    }
}
