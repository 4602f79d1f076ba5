//! Finished images: linear radiance per pixel.

use crate::math::Rgb;

/// An image of linear radiance, row-major from the upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<Rgb>,
}

impl Image {
    /// An image from its pixels, row-major; `None` if their number is not `width * height`.
    #[must_use]
    pub fn new(width: u32, height: u32, pixels: Vec<Rgb>) -> Option<Self> {
        (u64::from(width) * u64::from(height) == pixels.len() as u64).then_some(Self {
            width,
            height,
            pixels,
        })
    }

    /// An image from a function of column and row.
    #[must_use]
    pub fn from_fn(width: u32, height: u32, mut f: impl FnMut(u32, u32) -> Rgb) -> Self {
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            pixels.extend((0..width).map(|x| f(x, y)));
        }
        Self { width, height, pixels }
    }

    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels, row-major.
    #[must_use]
    pub fn pixels(&self) -> &[Rgb] {
        &self.pixels
    }

    /// All pixels, row-major, to be changed.
    #[must_use]
    pub fn pixels_mut(&mut self) -> &mut [Rgb] {
        &mut self.pixels
    }

    /// The pixel in column `x` and row `y`; `None` outside.
    #[must_use]
    pub fn get(&self, x: u32, y: u32) -> Option<Rgb> {
        (x < self.width && y < self.height)
            .then(|| self.pixels[y as usize * self.width as usize + x as usize])
    }

    /// Mean over all pixels; black for an empty image.
    #[must_use]
    pub fn mean(&self) -> Rgb {
        self.average(self.pixels.iter().copied())
    }

    /// The part from column `min[0]`, row `min[1]` up to but without column `max[0]`, row `max[1]`;
    /// `None` if it is not inside.
    #[must_use]
    pub fn crop(&self, min: [u32; 2], max: [u32; 2]) -> Option<Self> {
        let inside =
            min[0] <= max[0] && min[1] <= max[1] && max[0] <= self.width && max[1] <= self.height;
        let width = self.width as usize;
        inside.then(|| {
            Self::from_fn(max[0] - min[0], max[1] - min[1], |x, y| {
                self.pixels[(min[1] + y) as usize * width + (min[0] + x) as usize]
            })
        })
    }

    /// Mean squared difference per channel; `None` if the sizes differ.
    #[must_use]
    pub fn mse(&self, reference: &Self) -> Option<Rgb> {
        self.compare(reference, |a, b| (a - b).powi(2))
    }

    /// Relative mean squared error per channel, `(a - b)² / (b² + 0.01)` (Rousselle, Knaus and
    /// Zwicker 2011); `None` if the sizes differ.
    #[must_use]
    pub fn relative_mse(&self, reference: &Self) -> Option<Rgb> {
        self.compare(reference, |a, b| (a - b).powi(2) / (b * b + 0.01))
    }

    /// 8-bit sRGB (IEC 61966-2-1), three bytes per pixel, after multiplication by 2 to the power of
    /// `exposure` (in stops). Values above 1 are clipped; what is not a number becomes 0.
    #[must_use]
    pub fn to_srgb8(&self, exposure: f64) -> Vec<u8> {
        let gain = libm::exp2(exposure);
        self.pixels
            .iter()
            .flat_map(|p| p.0.map(|c| (srgb_from_linear(c * gain) * 255.0).round() as u8))
            .collect()
    }

    /// 32-bit floats, three per pixel: those of an OpenEXR file. What is finite stays finite.
    #[must_use]
    pub fn to_f32(&self) -> Vec<f32> {
        self.pixels.iter().flat_map(|p| p.0.map(to_f32)).collect()
    }

    fn compare(&self, reference: &Self, error: impl Fn(f64, f64) -> f64 + Copy) -> Option<Rgb> {
        let same = (self.width, self.height) == (reference.width, reference.height);
        let pairs = self.pixels.iter().zip(&reference.pixels);
        same.then(|| {
            self.average(
                pairs.map(|(a, b)| Rgb([error(a[0], b[0]), error(a[1], b[1]), error(a[2], b[2])])),
            )
        })
    }

    fn average(&self, values: impl Iterator<Item = Rgb>) -> Rgb {
        values.sum::<Rgb>() / (self.pixels.len().max(1) as f64)
    }
}

/// Rounds, and keeps finite values finite.
pub(super) fn to_f32(value: f64) -> f32 {
    let limit = f64::from(f32::MAX);
    if value.is_finite() { value.clamp(-limit, limit) as f32 } else { value as f32 }
}

/// The sRGB transfer function from linear light to `[0, 1]`, clipped.
#[must_use]
pub fn srgb_from_linear(linear: f64) -> f64 {
    // What is not a number becomes 0; `clamp` would keep it.
    let linear = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    }
}

/// The inverse of the sRGB transfer function on `[0, 1]`.
#[must_use]
pub fn linear_from_srgb(encoded: f64) -> f64 {
    let encoded = if encoded > 0.0 { encoded.min(1.0) } else { 0.0 };
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient() -> Image {
        Image::from_fn(4, 3, |x, y| Rgb::new(f64::from(x), f64::from(y), 1.0))
    }

    #[test]
    fn pixels_means_and_crops() {
        let image = gradient();
        assert_eq!(image.mean(), Rgb::new(1.5, 1.0, 1.0));
        assert_eq!((image.get(3, 2), image.get(4, 0)), (Some(Rgb::new(3.0, 2.0, 1.0)), None));
        let crop = image.crop([1, 1], [3, 3]).unwrap();
        assert_eq!((crop.width(), crop.height(), crop.get(0, 0)), (2, 2, image.get(1, 1)));
        assert!(image.crop([0, 0], [5, 1]).is_none() && image.crop([2, 0], [1, 1]).is_none());
        assert!(Image::new(2, 2, vec![Rgb::BLACK; 3]).is_none());
        assert_eq!(Image::from_fn(0, 5, |_, _| Rgb::WHITE).mean(), Rgb::BLACK);
    }

    #[test]
    fn errors_between_images() {
        let (a, b) =
            (Image::from_fn(2, 2, |_, _| Rgb::splat(1.5)), Image::from_fn(2, 2, |_, _| Rgb::WHITE));
        assert_eq!(a.mse(&b), Some(Rgb::splat(0.25)));
        assert!((a.relative_mse(&b).unwrap().r() - 0.25 / 1.01).abs() < 1e-15);
        assert_eq!(a.mse(&gradient()), None);
    }

    #[test]
    fn srgb_is_invertible_and_clips() {
        for code in 0..=255u8 {
            let linear = linear_from_srgb(f64::from(code) / 255.0);
            assert_eq!(Image::from_fn(1, 1, |_, _| Rgb::splat(linear)).to_srgb8(0.0), [code; 3]);
        }
        let extreme = Image::from_fn(1, 1, |_, _| Rgb::new(f64::NAN, f64::INFINITY, -1.0));
        assert_eq!(extreme.to_srgb8(0.0), [0, 255, 0]);
        assert_eq!(Image::from_fn(1, 1, |_, _| Rgb::splat(0.25)).to_srgb8(2.0), [255; 3]);
    }

    #[test]
    fn floats_are_row_by_row_and_stay_finite() {
        let floats = gradient().to_f32();
        assert_eq!((floats.len(), &floats[9..15]), (36, &[3.0, 0.0, 1.0, 0.0, 1.0, 1.0][..]));
        let extreme = Image::from_fn(1, 1, |_, _| Rgb::new(1e300, f64::NEG_INFINITY, -1e300));
        assert_eq!(extreme.to_f32(), [f32::MAX, f32::NEG_INFINITY, f32::MIN]);
    }
}
