//! A study whose page is served: to its reader, and to those who must not read it, stop it or hold
//! it up.

use super::{Options, run, serve};
use crate::common::End;
use clap::Parser;
use serde_json::Value;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// A study that runs in a thread, and its directory, which is removed again.
struct Running {
    study: Option<JoinHandle<Result<End, String>>>,
    interrupted: Arc<AtomicBool>,
    address: SocketAddr,
    out: PathBuf,
}

impl Running {
    fn start(name: &str, options: &[&str]) -> Self {
        let out = std::env::temp_dir().join(format!("pathspace-{name}-{}", std::process::id()));
        let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let (serve, directory) = (address.to_string(), out.to_string_lossy().into_owned());
        let common = ["compare", "--size", "16", "--integrators", "pt,bdpt", "--max-bounces", "2"];
        let own = ["--reference-samples", "16", "--out", &directory, "--serve", &serve];
        let options = Options::parse_from(common.iter().chain(&own).chain(options));
        let interrupted = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&interrupted);
        let study = thread::spawn(move || run(&options, &flag).map_err(|error| error.to_string()));
        Self { study: Some(study), interrupted, address, out }
    }

    /// The head and the body of the answer to a request, or nothing if there was none.
    fn send(&self, request: &str) -> Option<(String, String)> {
        let start = Instant::now();
        let mut stream = loop {
            match TcpStream::connect(self.address) {
                Ok(stream) => break stream,
                Err(error) => assert!(start.elapsed() < Duration::from_secs(5), "{error}"),
            }
            thread::sleep(Duration::from_millis(5));
        };
        stream.write_all(request.as_bytes()).ok()?;
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).ok()?;
        let answer = String::from_utf8_lossy(&answer);
        answer.split_once("\r\n\r\n").map(|(head, body)| (head.to_owned(), body.to_owned()))
    }

    /// The status and the body of the answer to a request with these headers.
    fn ask(&self, line: &str, headers: &str) -> (u16, String) {
        let host =
            if headers.contains("Host:") { "" } else { &format!("Host: {}\r\n", self.address) };
        let request = format!("{line} HTTP/1.1\r\n{host}{headers}\r\n");
        let (head, body) = self.send(&request).expect("an answer");
        (head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect(&head), body)
    }

    fn status(&self) -> Value {
        let (status, body) = self.ask("GET /status", "");
        assert_eq!(status, 200);
        serde_json::from_str(&body).unwrap()
    }

    /// Waits until the status is such.
    fn until(&self, is_such: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let status = self.status();
            if is_such(&status) {
                return status;
            }
            assert!(start.elapsed() < Duration::from_secs(20), "{status}");
            thread::sleep(Duration::from_millis(5));
        }
    }

    fn end(&mut self) -> Result<End, String> {
        self.study.take().unwrap().join().unwrap()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.interrupted.store(true, Ordering::Relaxed);
        let _ = std::fs::remove_dir_all(&self.out);
    }
}

fn read(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap()
}

/// So many runs that only a stop ends them soon.
const LONG: [&str; 4] = ["--samples", "1e6", "--seeds", "1024"];

#[test]
fn a_page_fills_and_its_button_ends_the_study() {
    let mut running = Running::start("served", &LONG);
    let status = running.until(|status| status["studies"][0]["version"].as_u64() > Some(0));
    assert_eq!(
        (&status["state"], &status["studies"][0]["name"]),
        (&"running".into(), &"cornell-box".into())
    );
    let (head, _) =
        running.send(&format!("GET / HTTP/1.1\r\nHost: {}\r\n\r\n", running.address)).unwrap();
    assert!(head.starts_with("HTTP/1.1 303 ") && head.contains("Location: /1/"), "{head}");
    let (_, page) = running.ask("GET /1/", "");
    assert!(page.contains("data-name=\"path-tracing\"") && page.contains("id=\"live\""));
    assert!(page.contains("Incomplete: "));
    // Files of the last study are none of this one.
    assert_eq!(running.ask("GET /1/report.json", "").0, 404);

    let token = format!("X-Token: {}\r\n", status["token"].as_str().unwrap());
    assert!(page.contains(status["token"].as_str().unwrap()));
    let own = format!("{token}Origin: http://{}\r\n", running.address);
    for headers in [
        "",
        "X-Token: 0\r\n",
        &format!("{token}Origin: http://evil.example\r\n"),
        &format!("{token}Origin: null\r\n"),
        &format!("{own}Origin: http://evil.example\r\n"),
        &format!("{token}Host: evil.example\r\n"),
    ] {
        assert_eq!(running.ask("POST /stop", headers).0, 403, "{headers}");
    }
    assert_eq!(running.ask("POST /close", &own).0, 409);
    assert_eq!(running.status()["state"], "running");

    assert_eq!(running.ask("POST /stop", &own).0, 200);
    running.until(|status| status["state"] == "done");
    let (_, page) = running.ask("GET /1/", "");
    let directory = running.out.join("cornell-box");
    let saved = read(&directory.join("index.html"));
    let (head, rest) = saved.split_at(saved.find("<body").unwrap());
    let rest = &rest[rest.find('>').unwrap() + 1..];
    assert!(page.starts_with(head) && page.ends_with(rest) && page.contains("id=\"live\""));
    assert!(saved.contains("Incomplete: ") && !saved.contains("id=\"live\""));
    let report = directory.join("report.json");
    assert_eq!(running.ask("GET /1/report.json", ""), (200, read(&report)));
    for path in ["/1/index.html", "/1/../report.json", "/1/%2e%2e/x.json", "/1/.json", "/2/", "/0/"]
    {
        assert_eq!(running.ask(&format!("GET {path}"), "").0, 404, "{path}");
    }
    assert_eq!(running.ask("POST /close", &own).0, 200);
    assert_eq!(running.end(), Ok(End::Interrupted));
}

#[test]
fn a_finished_study_is_served_until_an_interrupt() {
    let mut running = Running::start("finished", &["--samples", "4", "--seeds", "2"]);
    running.until(|status| status["state"] == "done");
    assert!(!running.ask("GET /1/", "").1.contains("Incomplete: "));
    running.interrupted.store(true, Ordering::Relaxed);
    let end = running.end();
    assert!(matches!(end, Ok(End::Done | End::Wrong)), "{end:?}");
}

/// Names that lead here do not help those who have them, and nonsense holds nothing up.
#[test]
fn others_are_refused_and_nothing_waits_for_them() {
    let mut running = Running::start("hostile", &LONG);
    running.until(|status| status["studies"][0]["version"].as_u64() > Some(0));
    let port = running.address.port();
    for host in ["evil.example", "127.0.0.1", "127.0.0.1:1", "localhost", ""] {
        assert_eq!(running.ask("GET /1/", &format!("Host: {host}\r\n")).0, 403, "{host}");
    }
    assert_eq!(running.ask("GET /1/", &format!("Host: localhost:{port}\r\n")).0, 200);
    let twice = format!("Host: 127.0.0.1:{port}\r\nHost: evil.example\r\n");
    assert_eq!(running.ask("GET /1/", &twice).0, 403);
    assert_eq!(running.send("GET /1/ HTTP/1.1\r\n\r\n").unwrap().0.split(' ').nth(1), Some("403"));
    for (line, status) in
        [("PUT /stop", 405), ("OPTIONS /stop", 405), ("POST /", 404), ("GET x", 404)]
    {
        assert_eq!(running.ask(line, "").0, status, "{line}");
    }
    assert_eq!(running.ask("GET /1/", &"A: b\r\n".repeat(100)).0, 400);
    for nonsense in ["\0\u{1}\u{2}\r\n\r\n", "GET\r\n\r\n", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"] {
        let answer = running.send(nonsense);
        assert!(answer.is_none_or(|(head, _)| head.starts_with("HTTP/1.1 400 ")), "{nonsense:?}");
    }
    let long = format!("GET / HTTP/1.1\r\nA: {}", "a".repeat(1 << 20));
    let answer = running.send(&long);
    assert!(answer.is_none_or(|(head, _)| head.starts_with("HTTP/1.1 431 ")));

    let slow: Vec<TcpStream> = (0..20)
        .map(|i| {
            let mut stream = TcpStream::connect(running.address).unwrap();
            let begun = ["", "GET /1/ HTTP/1.1\r\nHost:", "POST /stop"][i % 3];
            stream.write_all(begun.as_bytes()).unwrap();
            stream
        })
        .collect();
    let before = running.status()["fraction"].as_f64().unwrap();
    running.until(|status| status["fraction"].as_f64().unwrap() > before);
    drop(slow);
    // More than have a place: who comes later has one once they have gone.
    let crowd: Vec<_> = (0..100).filter_map(|_| TcpStream::connect(running.address).ok()).collect();
    drop(crowd);
    running.interrupted.store(true, Ordering::Relaxed);
    assert_eq!(running.end(), Ok(End::Interrupted));
    assert!(running.out.join("cornell-box/index.html").exists());
}

#[test]
fn pages_are_served_on_this_machine_alone() {
    for (text, address) in [
        ("80", "127.0.0.1:80"),
        ("localhost:0", "127.0.0.1:0"),
        ("127.1.2.3:8000", "127.1.2.3:8000"),
        ("[::1]:1", "[::1]:1"),
    ] {
        assert_eq!(serve::parse_loopback(text), Ok(address.parse().unwrap()));
    }
    for text in ["0.0.0.0:80", "192.168.0.1:80", "[::]:80", "[::ffff:10.0.0.1]:80"] {
        assert!(serve::parse_loopback(text).unwrap_err().contains("from other machines"), "{text}");
    }
    for text in ["", "a", "65536", "example.org:80", "127.0.0.1"] {
        assert!(serve::parse_loopback(text).unwrap_err().contains("is not PORT"), "{text}");
    }
    let taken = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let first = serve::Server::start(Some(taken)).unwrap();
    let refusal = serve::Server::start(Some(taken)).unwrap_err();
    assert!(refusal.contains(&taken.to_string()), "{refusal} at {}", first.url());
    let options = |text| Options::try_parse_from(["compare"].into_iter().chain(text));
    assert_eq!(options(vec!["--serve", "--seeds", "2"]).unwrap().serve, Some(None));
    assert!(options(vec!["--serve", "--samples", "4", "--shard", "1/2"]).is_err());
}
