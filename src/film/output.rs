//! Image files: PNG (tone mapped sRGB), Radiance HDR (Ward 1991) and OpenEXR with metadata.

use super::image::{Image, linear_from_srgb, to_f32};
use super::{Film, FilmRegion, replace_file};
use crate::math::Rgb;
use exr::prelude as openexr;
use glam::{IVec2, UVec2};
use image::{DynamicImage, ImageFormat, RgbImage};
use std::collections::BTreeMap;
use std::error::Error;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// The contents of an image file.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageFile {
    /// Linear radiance.
    pub image: Image,
    /// The film that the image is a window of; `None` if it is all of it. Only OpenEXR files keep
    /// it.
    pub region: Option<FilmRegion>,
    /// Texts such as the seed or the integrator's name, by key. Only OpenEXR files keep them, as
    /// attributes `pathspace.key`.
    pub metadata: BTreeMap<String, String>,
    /// Exposure of PNG files in stops: radiance 2 to the power of `-exposure` becomes white. Not
    /// kept by any format.
    pub exposure: f64,
}

/// The reason for which a file could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The extension is none of `png`, `hdr` and `exr`.
    #[error("image file {} must end in .png, .hdr or .exr", .0.display())]
    Extension(PathBuf),
    /// The image has no pixels, or more rows or columns than the format can hold.
    #[error("image has no pixels or is too large for {}", .0.display())]
    Size(PathBuf),
    /// A key of the metadata is empty, longer than 200 bytes, or a key or text contains a NUL.
    #[error("metadata entry {0:?} is empty, too long or contains a NUL")]
    Metadata(String),
    /// The window is not inside the film, or is not of the image's size.
    #[error("window {0:?} does not fit the image")]
    Region(FilmRegion),
    /// The file could not be written or read.
    #[error("image file {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The error underneath.
        source: Box<dyn Error + Send + Sync>,
    },
}

const PREFIX: &str = "pathspace.";

#[derive(Clone, Copy)]
enum Format {
    Png,
    Hdr,
    Exr,
}

impl Format {
    fn of(path: &Path) -> Result<Self, OutputError> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("hdr") => Ok(Self::Hdr),
            Some("exr") => Ok(Self::Exr),
            _ => Err(OutputError::Extension(path.to_owned())),
        }
    }
}

impl From<Image> for ImageFile {
    fn from(image: Image) -> Self {
        Self { image, region: None, metadata: BTreeMap::new(), exposure: 0.0 }
    }
}

impl ImageFile {
    /// The key of the metadata that a clock decides, and not what was rendered: seconds of
    /// rendering. Without it, the same rendering makes the same file.
    pub const CLOCK: &'static str = "seconds";

    /// Writes the file in the format of its extension: `.png`, `.hdr` or `.exr`. The same contents
    /// make the same bytes. Under the name there is the old file or the new one, whole, at any time
    /// ([`replace_file`]).
    ///
    /// PNG is 8-bit sRGB; HDR keeps positive values to about 1 %; OpenEXR keeps 32-bit floats, the
    /// window and the metadata.
    ///
    /// # Errors
    /// If the extension is unknown, the image empty, the metadata or window invalid, or the file
    /// cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), OutputError> {
        let path = path.as_ref();
        let format = Format::of(path)?;
        // Both limits are those of OpenEXR, whose coordinates are signed 32-bit integers.
        let (width, height) = (self.image.width(), self.image.height());
        if width == 0 || height == 0 || width > 1 << 30 || height > 1 << 30 {
            return Err(OutputError::Size(path.to_owned()));
        }
        let mut file = Vec::new();
        match format {
            Format::Png => {
                let bytes = self.image.to_srgb8(self.exposure);
                let buffer = RgbImage::from_raw(width, height, bytes)
                    .ok_or_else(|| OutputError::Size(path.to_owned()))?;
                buffer
                    .write_to(&mut Cursor::new(&mut file), ImageFormat::Png)
                    .map_err(|e| file_error(path, e))?;
            }
            Format::Hdr => {
                // Radiance's format has no sign.
                let pixels: Vec<_> = self
                    .image
                    .pixels()
                    .iter()
                    .map(|p| image::Rgb(p.0.map(|c| to_f32(c).max(0.0))))
                    .collect();
                let encoder = image::codecs::hdr::HdrEncoder::new(&mut file);
                encoder
                    .encode(&pixels, width as usize, height as usize)
                    .map_err(|e| file_error(path, e))?;
            }
            Format::Exr => file = self.to_exr(path)?,
        }
        replace_file(path, &file).map_err(|e| file_error(path, e))
    }

    /// Reads a `.png` (taken as sRGB), `.hdr` or `.exr` (channels R, G, B) file.
    ///
    /// # Errors
    /// If the extension is unknown, or the file cannot be read or is not of its format.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, OutputError> {
        let path = path.as_ref();
        let format = match Format::of(path)? {
            Format::Png => ImageFormat::Png,
            Format::Hdr => ImageFormat::Hdr,
            Format::Exr => return load_exr(path),
        };
        let mut reader = image::ImageReader::open(path).map_err(|e| file_error(path, e))?;
        reader.set_format(format);
        let decoded: DynamicImage = reader.decode().map_err(|e| file_error(path, e))?;
        let (width, height) = (decoded.width(), decoded.height());
        let buffer = decoded.into_rgb32f();
        let pixels = buffer.pixels().map(|p| Rgb(p.0.map(f64::from)));
        let pixels = match format {
            ImageFormat::Png => pixels.map(|p| p.map(linear_from_srgb)).collect(),
            _ => pixels.collect(),
        };
        Image::new(width, height, pixels)
            .map(Self::from)
            .ok_or_else(|| OutputError::Size(path.to_owned()))
    }

    fn to_exr(&self, path: &Path) -> Result<Vec<u8>, OutputError> {
        let (width, height) = (self.image.width(), self.image.height());
        let region = self.region.unwrap_or(FilmRegion::full(UVec2::new(width, height)));
        let fits =
            Film::contains_window(&region) && region.window_size() == UVec2::new(width, height);
        if !fits || region.resolution.max_element() > 1 << 30 {
            return Err(OutputError::Region(region));
        }
        let mut attributes = openexr::LayerAttributes {
            layer_position: openexr::Vec2(region.window_min.x as i32, region.window_min.y as i32),
            software_name: Some(text(concat!("pathspace ", env!("CARGO_PKG_VERSION")))),
            ..openexr::LayerAttributes::default()
        };
        for (key, value) in &self.metadata {
            if key.is_empty() || key.len() > 200 || key.contains('\0') || value.contains('\0') {
                return Err(OutputError::Metadata(key.clone()));
            }
            attributes.other.insert(
                text(&format!("{PREFIX}{key}")),
                openexr::AttributeValue::Text(text(value)),
            );
        }
        let pixel = |at: openexr::Vec2<usize>| {
            let [r, g, b] = self.image.pixels()[at.y() * width as usize + at.x()].0.map(to_f32);
            (r, g, b)
        };
        let channels = openexr::SpecificChannels::rgb(pixel);
        let layer = openexr::Layer::new(
            (width as usize, height as usize),
            attributes,
            openexr::Encoding::SMALL_LOSSLESS,
            channels,
        );
        let mut file = openexr::Image::from_layer(layer);
        let resolution = (region.resolution.x as usize, region.resolution.y as usize);
        file.attributes.display_window = openexr::IntegerBounds::from_dimensions(resolution);
        let mut bytes = Vec::new();
        openexr::WritableImage::write(&file)
            .to_buffered(Cursor::new(&mut bytes))
            .map_err(|e| file_error(path, e))?;
        sort_attributes(&mut bytes);
        Ok(bytes)
    }
}

/// Sorts the attributes in the header of an OpenEXR file by their names. The library has them in
/// the order of a hash table, which is another one each time.
fn sort_attributes(file: &mut [u8]) {
    // Behind a magic number and the version: names and types, each with a zero at its end, sizes
    // and values.
    const START: usize = 8;
    let mut attributes = Vec::new();
    let mut end = START;
    while file[end] != 0 {
        let start = end;
        for _ in 0..2 {
            end += file[end..].iter().take_while(|byte| **byte != 0).count() + 1;
        }
        let size = std::array::from_fn(|k| file[end + k]);
        end += 4 + u32::from_le_bytes(size) as usize;
        attributes.push(file[start..end].to_vec());
    }
    attributes.sort();
    file[START..end].copy_from_slice(&attributes.concat());
}

fn load_exr(path: &Path) -> Result<ImageFile, OutputError> {
    use openexr::{ReadChannels, ReadLayers, ReadSpecificChannel};
    let file = openexr::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("R")
        .required("G")
        .required("B")
        .collect_pixels(
            |size: openexr::Vec2<usize>, _: &_| (size.width(), vec![Rgb::BLACK; size.area()]),
            |(width, pixels): &mut (usize, Vec<Rgb>), at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = Rgb::new(r.into(), g.into(), b.into());
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .map_err(|e| file_error(path, e))?;
    let layer = file.layer_data;
    let size = (u32::try_from(layer.size.width()), u32::try_from(layer.size.height()));
    let (Ok(width), Ok(height)) = size else { return Err(OutputError::Size(path.to_owned())) };
    let pixels = layer.channel_data.pixels.1;
    let mut loaded = ImageFile::from(
        Image::new(width, height, pixels).ok_or_else(|| OutputError::Size(path.to_owned()))?,
    );

    // The window in a film that starts at (0, 0). Other programs may write data outside the display
    // window: then there is none.
    let display = file.attributes.display_window;
    let position = layer.attributes.layer_position;
    let min = IVec2::new(
        position.x().wrapping_sub(display.position.x()),
        position.y().wrapping_sub(display.position.y()),
    );
    let resolution = (u32::try_from(display.size.width()), u32::try_from(display.size.height()));
    if let (Ok(x), Ok(y), true) = (resolution.0, resolution.1, min.cmpge(IVec2::ZERO).all()) {
        let window_min = min.as_uvec2();
        let window_max =
            UVec2::new(window_min.x.saturating_add(width), window_min.y.saturating_add(height));
        let region = FilmRegion { resolution: UVec2::new(x, y), window_min, window_max };
        let whole = region == FilmRegion::full(region.resolution);
        loaded.region = (Film::contains_window(&region) && !whole).then_some(region);
    }
    for (key, value) in &layer.attributes.other {
        if let openexr::AttributeValue::Text(value) = value {
            let key = String::from_utf8_lossy(key.as_slice()).into_owned();
            let key = key.strip_prefix(PREFIX).map(str::to_owned).unwrap_or(key);
            loaded.metadata.insert(key, String::from_utf8_lossy(value.as_slice()).into_owned());
        }
    }
    Ok(loaded)
}

/// OpenEXR texts are bytes; ours are UTF-8.
fn text(s: &str) -> openexr::Text {
    openexr::Text::from_slice_unchecked(s.as_bytes())
}

fn file_error(path: &Path, source: impl Into<Box<dyn Error + Send + Sync>>) -> OutputError {
    OutputError::File { path: path.to_owned(), source: source.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file that is removed again.
    struct Temporary(PathBuf);

    impl Temporary {
        fn new(name: &str) -> Self {
            Self(std::env::temp_dir().join(format!("pathspace-{}-{name}", std::process::id())))
        }
    }

    impl Drop for Temporary {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(&self.0);
        }
    }

    fn gradient() -> Image {
        Image::from_fn(5, 4, |x, y| Rgb::new(f64::from(x) * 0.3, f64::from(y) * 10.0, 0.25))
    }

    #[test]
    fn exr_keeps_floats_window_and_metadata() {
        let path = Temporary::new("crop.exr");
        let mut file = ImageFile::from(gradient());
        file.image.pixels_mut()[0] = Rgb::new(-1.5, 1e300, 1e-30);
        file.region = Some(FilmRegion {
            resolution: UVec2::new(20, 10),
            window_min: UVec2::new(3, 2),
            window_max: UVec2::new(8, 6),
        });
        for (key, value) in [
            ("seed", "18446744073709551615"),
            ("integrator", "path-tracing"),
            ("note", "Größe ½"),
            ("compression", ""),
        ] {
            file.metadata.insert(key.into(), value.into());
        }
        file.save(&path.0).unwrap();
        let loaded = ImageFile::load(&path.0).unwrap();
        assert_eq!((loaded.region, &loaded.metadata), (file.region, &file.metadata));
        for (a, b) in loaded.image.pixels().iter().zip(file.image.pixels()) {
            assert_eq!(*a, b.map(|c| f64::from(to_f32(c))));
        }
        assert_eq!(loaded.image.get(0, 0).unwrap().g(), f64::from(f32::MAX));
    }

    #[test]
    fn hdr_and_png_keep_what_they_can() {
        let (hdr, png) = (Temporary::new("a.HDR"), Temporary::new("a.png"));
        let file = ImageFile::from(gradient());
        file.save(&hdr.0).unwrap();
        let loaded = ImageFile::load(&hdr.0).unwrap().image;
        for (a, b) in loaded.pixels().iter().zip(file.image.pixels()) {
            assert!((0..3).all(|c| (a[c] - b[c]).abs() <= 0.01 * b.max_component()), "{a:?} {b:?}");
        }
        file.save(&png.0).unwrap();
        let loaded = ImageFile::load(&png.0).unwrap().image;
        for (a, b) in loaded.pixels().iter().zip(file.image.pixels()) {
            assert!((0..3).all(|c| (a[c] - b[c].min(1.0)).abs() < 0.005), "{a:?} {b:?}");
        }
    }

    /// The attributes are in a hash table, whose order is another one each time.
    #[test]
    fn the_same_contents_make_the_same_bytes() {
        let path = Temporary::new("same.exr");
        let mut file = ImageFile::from(gradient());
        for key in ["a", "b", "c", "d", "e", "f", "g", "h"] {
            file.metadata.insert(key.into(), format!("value of {key}"));
        }
        let bytes = || {
            file.save(&path.0).unwrap();
            std::fs::read(&path.0).unwrap()
        };
        let first = bytes();
        assert!((0..8).all(|_| bytes() == first));
        assert_eq!(ImageFile::load(&path.0).unwrap().metadata, file.metadata);
    }

    #[test]
    fn errors_name_the_reason() {
        let file = ImageFile::from(gradient());
        assert!(matches!(file.save("a.jpg"), Err(OutputError::Extension(_))));
        assert!(matches!(
            ImageFile::from(Image::from_fn(0, 3, |_, _| Rgb::BLACK)).save("a.exr"),
            Err(OutputError::Size(_))
        ));
        for name in ["x.png", "x.hdr", "x.exr"] {
            let missing = std::env::temp_dir().join("pathspace-no-such-directory").join(name);
            assert!(matches!(file.save(&missing), Err(OutputError::File { .. })));
            assert!(ImageFile::load(&missing).unwrap_err().to_string().contains(name));
            let garbage = Temporary::new(name);
            std::fs::write(&garbage.0, b"not an image").unwrap();
            assert!(matches!(ImageFile::load(&garbage.0), Err(OutputError::File { .. })));
        }
        let path = Temporary::new("bad.exr");
        let region = FilmRegion::full(UVec2::new(4, 4));
        assert!(matches!(
            ImageFile { region: Some(region), ..file.clone() }.save(&path.0),
            Err(OutputError::Region(_))
        ));
        let metadata = [("a\0".to_owned(), String::new())].into();
        assert!(matches!(
            ImageFile { metadata, ..file }.save(&path.0),
            Err(OutputError::Metadata(_))
        ));
    }
}
