//! Images and error maps side by side.

use pathspace::film::{Image, ImageFile};
use pathspace::math::Rgb;
use pathspace::report::{ERROR_SCALE, Study, error_colour, exposure, signed_error_map};

const GAP: u32 = 6;
const BACKGROUND: Rgb = Rgb([0.02; 3]);

/// A column for the reference and then for each integrator: the image, and below it the signed
/// relative error. Below the reference is the scale of the errors, zero in its middle.
pub fn side_by_side(study: &Study) -> ImageFile {
    let reference = study.reference.image();
    let (width, height) = (reference.width(), reference.height());
    let gain = exposure(reference).exp2();
    let scale = Image::from_fn(width, height / 8, |x, _| {
        error_colour((2.0 * (f64::from(x) + 0.5) / f64::from(width) - 1.0) * ERROR_SCALE)
    });
    let errors = study.images.iter().map(|images| signed_error_map(&images.mean, reference));
    let lower: Vec<Image> = std::iter::once(scale).chain(errors).collect();
    let upper: Vec<&Image> =
        std::iter::once(reference).chain(study.images.iter().map(|images| &images.mean)).collect();
    let size = [upper.len() as u32 * (width + GAP) - GAP, 2 * height + GAP];
    ImageFile::from(Image::from_fn(size[0], size[1], |x, y| {
        let (column, x) = ((x / (width + GAP)) as usize, x % (width + GAP));
        let pixel = match y.checked_sub(height + GAP) {
            None => upper[column].get(x, y).map(|radiance| radiance * gain),
            Some(y) => lower[column].get(x, y),
        };
        pixel.unwrap_or(BACKGROUND)
    }))
}
