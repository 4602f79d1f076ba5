//! Renderings that are seen while they go on: by a viewer that takes its packets apart, by one that
//! is not there, goes away or does not listen; and the files.

use super::{Arguments, Stopped, common, run};
use clap::Parser;
use pathspace::film::ImageFile;
use std::io::{self, Read};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// A directory that is removed again.
struct Directory(PathBuf);

impl Directory {
    fn new(name: &str) -> Self {
        let name = format!("pathspace-live-{name}-{}", std::process::id());
        Self(std::env::temp_dir().join(name))
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Renders with these options until it is interrupted; the image file.
fn render(directory: &Directory, options: &[&str], interrupted: &AtomicBool) -> PathBuf {
    let out = directory.0.join("box.exr");
    let all = ["render", "--no-clocks", "--max-bounces", "2", "--out"];
    let all = all.into_iter().chain([out.to_str().unwrap()]).chain(options.iter().copied());
    let arguments = Arguments::parse_from(all);
    let scene =
        common::scene_or_file("cornell-box", arguments.size, &arguments.file).expect("a scene");
    let Stopped(stopped) = run(&arguments, &scene, arguments.max_bounces, interrupted).unwrap();
    assert_eq!(stopped, interrupted.load(Ordering::Relaxed));
    out
}

/// Renders with these options to the end; the image file.
fn render_all(directory: &Directory, options: &[&str]) -> PathBuf {
    render(directory, options, &AtomicBool::new(false))
}

/// A packet of tev's protocol: its length with these four bytes, its type, whether the window is to
/// come to the front, and the name of the image; then what the type has.
struct Packet(Vec<u8>);

impl Packet {
    fn read(stream: &mut TcpStream) -> io::Result<Self> {
        let mut length = [0; 4];
        stream.read_exact(&mut length)?;
        let mut rest = vec![0; u32::from_le_bytes(length) as usize - 4];
        stream.read_exact(&mut rest)?;
        rest.reverse();
        Ok(Self(rest))
    }

    fn take<const N: usize>(&mut self) -> [u8; N] {
        std::array::from_fn(|_| self.0.pop().expect("a byte"))
    }

    fn text(&mut self) -> String {
        let bytes = std::iter::from_fn(|| self.0.pop().filter(|byte| *byte != 0));
        String::from_utf8(bytes.collect()).unwrap()
    }

    fn int(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn long(&mut self) -> usize {
        u64::from_le_bytes(self.take()) as usize
    }
}

/// The images of a viewer: the name and the size of its image, how often it changed, and its
/// pixels in the end.
struct Shown {
    name: String,
    size: [usize; 2],
    updates: usize,
    pixels: Vec<[f32; 3]>,
}

/// The next connection, which must come soon.
fn accept(listener: &TcpListener) -> TcpStream {
    listener.set_nonblocking(true).unwrap();
    let start = Instant::now();
    loop {
        match listener.accept() {
            Ok((stream, _)) => {
                stream.set_nonblocking(false).unwrap();
                return stream;
            }
            Err(error) => assert!(start.elapsed() < Duration::from_secs(20), "{error}"),
        }
        thread::sleep(Duration::from_millis(1));
    }
}

/// Shows what one client sends.
fn view(mut stream: TcpStream) -> Shown {
    let mut create = Packet::read(&mut stream).unwrap();
    assert_eq!((create.take(), create.take()), ([4], [1]), "a new image, in front");
    let name = create.text();
    let size = [create.int() as usize, create.int() as usize];
    let channels: Vec<String> = (0..create.int()).map(|_| create.text()).collect();
    assert!(channels == ["R", "G", "B"] && create.0.is_empty());
    let mut shown = Shown { name, size, updates: 0, pixels: vec![[0.0; 3]; size[0] * size[1]] };
    while let Ok(mut update) = Packet::read(&mut stream) {
        assert_eq!((update.take(), update.take()), ([6], [0]), "an update that disturbs nobody");
        assert_eq!(update.text(), shown.name);
        let channels: Vec<String> = (0..update.int()).map(|_| update.text()).collect();
        let [x, y, width, height] = std::array::from_fn(|_| update.int() as usize);
        let [offsets, strides] =
            [(); 2].map(|()| channels.iter().map(|_| update.long()).collect::<Vec<_>>());
        let data: Vec<f32> = std::iter::from_fn(|| {
            (!update.0.is_empty()).then(|| f32::from_le_bytes(update.take()))
        })
        .collect();
        for (c, channel) in channels.iter().enumerate() {
            let channel = ["R", "G", "B"].iter().position(|name| name == channel).unwrap();
            for i in 0..width * height {
                let (column, row) = (x + i % width, y + i / width);
                shown.pixels[row * size[0] + column][channel] = data[offsets[c] + i * strides[c]];
            }
        }
        shown.updates += 1;
    }
    shown
}

fn loopback() -> (TcpListener, SocketAddr) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    (listener, address)
}

fn pixels(file: &Path) -> Vec<[f32; 3]> {
    let image = ImageFile::load(file).unwrap().image;
    image.pixels().iter().map(|pixel| pixel.0.map(|c| c as f32)).collect()
}

#[test]
fn a_viewer_shows_what_the_file_has() {
    let (alone, seen) = (Directory::new("alone"), Directory::new("seen"));
    let options = ["--samples", "40", "--size", "48x32", "--exposure", "1"];
    let whole = render_all(&alone, &options);
    let (listener, address) = loopback();
    let viewer = thread::spawn(move || view(accept(&listener)));
    let address = address.to_string();
    let live = [&options[..], &["--live", &address, "--preview-every", "1ms"]].concat();
    let out = render_all(&seen, &live);
    let shown = viewer.join().unwrap();
    assert_eq!(std::fs::read(&whole).unwrap(), std::fs::read(&out).unwrap());
    assert!(shown.name.starts_with(out.to_str().unwrap()) && shown.updates > 1, "{}", shown.name);
    assert_eq!(shown.size, [48, 32]);
    assert_eq!(shown.pixels, pixels(&out));
    let mut png = ImageFile::load(&out).unwrap();
    png.exposure = 1.0;
    png.save(seen.0.join("expected.png")).unwrap();
    let [expected, preview] = ["expected.png", "box-preview.png"].map(|n| pixels(&seen.0.join(n)));
    let differ = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).any(|c| (a[c] - b[c]).abs() > 0.01);
    assert!(expected.len() == preview.len() && !expected.iter().zip(&preview).any(differ));
    assert!(!alone.0.join("box-preview.png").exists());
}

#[test]
fn a_rendering_needs_no_viewer() {
    let directory = Directory::new("none");
    let (listener, address) = loopback();
    drop(listener);
    let out = render_all(&directory, &["--size", "16", "--live", &address.to_string()]);
    assert!(out.exists() && directory.0.join("box-preview.png").exists());
}

#[test]
fn a_viewer_may_go_away_and_come_back() {
    let directory = Directory::new("away");
    let (listener, address) = loopback();
    let interrupted = AtomicBool::new(false);
    thread::scope(|scope| {
        let viewer = scope.spawn(|| {
            for _ in 0..2 {
                let mut stream = accept(&listener);
                Packet::read(&mut stream).unwrap();
                Packet::read(&mut stream).unwrap();
            }
            let last = accept(&listener);
            interrupted.store(true, Ordering::Relaxed);
            view(last)
        });
        let address = address.to_string();
        let live = ["--time", "20s", "--size", "16", "--live", &address, "--preview-every", "1ms"];
        let out = render(&directory, &live, &interrupted);
        assert_eq!(viewer.join().unwrap().pixels, pixels(&out));
    });
}

#[test]
fn a_viewer_that_does_not_listen_stops_nothing() {
    let directory = Directory::new("deaf");
    let (_listener, address) = loopback();
    let address = address.to_string();
    let live = ["--time", "500ms", "--size", "640", "--live", &address, "--preview-every", "1ms"];
    let start = Instant::now();
    let out = render_all(&directory, &live);
    assert!(out.exists() && start.elapsed() < Duration::from_secs(15), "{:?}", start.elapsed());
}

#[test]
fn an_interrupt_leaves_image_and_preview() {
    let directory = Directory::new("interrupt");
    let options = ["--samples", "1e6", "--size", "16", "--preview-every", "1h"];
    let out = render(&directory, &options, &AtomicBool::new(true));
    let preview = ImageFile::load(directory.0.join("box-preview.png")).unwrap().image;
    assert!(preview.pixels().len() == 256 && out.exists());
}

#[test]
fn addresses_of_viewers() {
    let parse = |text| Arguments::try_parse_from(["render", "--live", text]).map(|a| a.live);
    for text in ["127.0.0.1:14158", "[::1]:1", "a.local:80"] {
        assert_eq!(parse(text).unwrap().as_deref(), Some(text));
    }
    for text in ["14158", ":1", "a:0", "a:65536", "a"] {
        assert!(parse(text).unwrap_err().to_string().contains("is not HOST:PORT"), "{text}");
    }
    let default = Arguments::try_parse_from(["render", "--live", "--samples", "4"]).unwrap();
    assert_eq!(default.live.as_deref(), Some("127.0.0.1:14158"));
}
