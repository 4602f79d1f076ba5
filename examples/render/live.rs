//! A look at a rendering while it goes on: in the viewer tev, and in a file that is written again
//! and again.
//!
//! A thread of its own sends and writes, so that a viewer that is slow, stuck or gone stops nothing.

use indicatif::ProgressBar;
use pathspace::film::{Image, ImageFile};
use pathspace::glam::UVec2;
use pathspace::render::Progress;
use std::io::{self, ErrorKind};
use std::net::{TcpStream, ToSocketAddrs};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

/// The address at which tev listens unless it is told another one.
pub const TEV: &str = "127.0.0.1:14158";

/// The shortest time from one image in the viewer to the next.
const UPDATE: Duration = Duration::from_secs(1);
/// Images may take one part in so many of the time.
const PART: u32 = 50;
/// Time that the viewer has to answer, and to take a part of what it is sent.
const PATIENCE: Duration = Duration::from_secs(2);
/// Time that the last image has to be written and shown.
const FAREWELL: Duration = Duration::from_secs(10);

/// The host and the port of a viewer.
pub fn parse_viewer(text: &str) -> Result<String, String> {
    let port = text.rsplit_once(':').filter(|(host, _)| !host.is_empty());
    match port.and_then(|(_, port)| port.parse::<u16>().ok()) {
        Some(1..) => Ok(text.to_owned()),
        _ => Err(format!("{text:?} is not HOST:PORT, such as {TEV}")),
    }
}

/// The places in which a rendering is to be seen.
#[derive(Clone, Debug)]
pub struct Views {
    /// The viewer's address.
    pub viewer: Option<String>,
    /// The name of the image in the viewer.
    pub title: String,
    /// Its width and height.
    pub size: UVec2,
    /// The file.
    pub file: PathBuf,
    /// Stops by which it is made brighter.
    pub exposure: f64,
    /// Time from one file to the next.
    pub every: Duration,
}

/// A rendering that is seen while it goes on.
#[derive(Debug)]
pub struct Live {
    /// Images, and whether they are the last.
    images: Sender<(Image, bool)>,
    thread: JoinHandle<()>,
    /// Nanoseconds that the thread spent on the last image, or [`AT_WORK`].
    spent: Arc<AtomicU64>,
    pace: Duration,
    due: Instant,
}

const AT_WORK: u64 = u64::MAX;

impl Live {
    /// Looks for the viewer, and says where the rendering is to be seen.
    pub fn start(views: Views, bar: &ProgressBar) -> io::Result<Self> {
        say!("preview     {}, every {:?}", views.file.display(), views.every);
        let viewer = views.viewer.as_ref().map(|address| {
            let (address, title, size) = (address.clone(), views.title.clone(), views.size);
            let (client, has_gone, is_stuck) = (None, false, false);
            let mut viewer = Viewer { address, title, size, client, has_gone, is_stuck };
            match viewer.open() {
                Ok(()) => say!("viewer      tev at {}: {}", viewer.address, viewer.title),
                Err(error) => eprintln!(
                    "no viewer at {}: {error}; tev will show the image once it is there",
                    viewer.address
                ),
            }
            viewer
        });
        let pace = if viewer.is_some() { UPDATE.min(views.every) } else { views.every };
        let (images, received) = channel();
        let spent = Arc::new(AtomicU64::new(0));
        let (own, bar) = (Arc::clone(&spent), bar.clone());
        let thread = thread::Builder::new()
            .name("live".to_owned())
            .spawn(move || show_all(&received, viewer, &views, &bar, &own))?;
        Ok(Self { images, thread, spent, pace, due: Instant::now() })
    }

    /// Shows the image so far, if it is time for one and the one before has been shown.
    pub fn look(&mut self, progress: &Progress<'_>) {
        let start = Instant::now();
        let spent = self.spent.load(Ordering::Acquire);
        if start < self.due || spent == AT_WORK {
            return;
        }
        self.send(progress.image(), false);
        let cost = start.elapsed() + Duration::from_nanos(spent);
        self.due = start + self.pace.max(cost * PART);
    }

    /// Shows the last image, for which it waits a while.
    pub fn finish(self, image: Image) {
        self.send(image, true);
        let start = Instant::now();
        while !self.thread.is_finished() && start.elapsed() < FAREWELL {
            thread::sleep(Duration::from_millis(5));
        }
        if !self.thread.is_finished() {
            eprintln!("the last image is not shown: the viewer is too slow");
        }
    }

    fn send(&self, image: Image, is_last: bool) {
        self.spent.store(AT_WORK, Ordering::Release);
        // A thread that has ended shows nothing more, which is no fault of the rendering.
        let _ = self.images.send((image, is_last));
    }
}

/// Writes and shows what it receives, until the last image.
fn show_all(
    images: &Receiver<(Image, bool)>,
    mut viewer: Option<Viewer>,
    views: &Views,
    bar: &ProgressBar,
    spent: &AtomicU64,
) {
    let warn = |warning: String| bar.suspend(|| eprintln!("{warning}"));
    let (mut due, mut has_failed) = (Instant::now(), false);
    for (image, is_last) in images {
        let start = Instant::now();
        if start >= due || is_last {
            due = start + views.every;
            let mut file = ImageFile::from(image.clone());
            file.exposure = views.exposure;
            if let Err(error) = file.save(&views.file)
                && !std::mem::replace(&mut has_failed, true)
            {
                warn(format!("no preview: {error}"));
            }
        }
        if let Some(viewer) = &mut viewer
            && let Err(error) = viewer.show(&image)
        {
            warn(format!("the viewer has gone, the rendering goes on: {error}"));
        }
        if is_last {
            return;
        }
        spent.store(start.elapsed().as_nanos() as u64, Ordering::Release);
    }
}

/// The viewer tev, which may come and go.
struct Viewer {
    address: String,
    title: String,
    size: UVec2,
    client: Option<TevClient>,
    /// True if it was said that it has gone, which is said once.
    has_gone: bool,
    /// True if it does not take what it is sent.
    is_stuck: bool,
}

impl Viewer {
    /// Connects to the viewer, with a new image in it that is black.
    fn open(&mut self) -> io::Result<()> {
        let mut client = TevClient::wrap(connect(&self.address)?);
        client.send(PacketCreateImage {
            image_name: &self.title,
            grab_focus: true,
            width: self.size.x,
            height: self.size.y,
            channel_names: &CHANNELS,
        })?;
        self.client = Some(client);
        Ok(())
    }

    /// Shows an image; the reason if the viewer has gone, once. One that was not there may be by now.
    fn show(&mut self, image: &Image) -> Result<(), io::Error> {
        if self.client.is_none() && (self.is_stuck || self.open().is_err()) {
            return Ok(());
        }
        let Some(client) = &mut self.client else { return Ok(()) };
        let sent = client.send(PacketUpdateImage {
            image_name: &self.title,
            grab_focus: false,
            channel_names: &CHANNELS,
            channel_offsets: &[0, 1, 2],
            channel_strides: &[3; 3],
            x: 0,
            y: 0,
            width: image.width(),
            height: image.height(),
            data: &image.to_f32(),
        });
        sent.or_else(|error| {
            self.client = None;
            self.is_stuck = matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut);
            if std::mem::replace(&mut self.has_gone, true) { Ok(()) } else { Err(error) }
        })
    }
}

const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// A connection on which nothing waits for long.
fn connect(address: &str) -> io::Result<TcpStream> {
    let mut failure = io::Error::new(ErrorKind::NotFound, "the name has no address");
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, PATIENCE) {
            Ok(stream) => {
                stream.set_write_timeout(Some(PATIENCE))?;
                return Ok(stream);
            }
            Err(error) => failure = error,
        }
    }
    Err(failure)
}
