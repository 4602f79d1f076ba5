//! Images and error maps side by side.

use super::font;
use pathspace::film::{Image, ImageFile};
use pathspace::math::Rgb;
use pathspace::report::{ERROR_SCALE, Study, error_colour, exposure, signed_error_map};

const GAP: u32 = 6;
const BACKGROUND: Rgb = Rgb([0.02; 3]);
const INK: Rgb = Rgb([0.75; 3]);

/// A column for the reference and for each integrator: the image, and below it the signed relative
/// error.
pub fn side_by_side(study: &Study) -> ImageFile {
    let reference = study.reference.image();
    let (width, height) = (reference.width(), reference.height());
    let scale = if width >= 220 { 2 } else { 1 };
    let line = font::height(scale);
    let columns = study.images.len() as u32 + 1;
    let mut canvas = Canvas::new(columns * (width + GAP) + GAP, 2 * height + 4 * line + 4 * GAP);
    let top = [GAP, GAP + line + GAP / 2, 2 * GAP + line + height + GAP / 2];
    let gain = exposure(reference).exp2();
    let left = |column: u32| GAP + column * (width + GAP);

    canvas.text("reference", left(0), top[0], scale);
    canvas.image(left(0), top[1], width, height, |x, y| pixel(reference, x, y) * gain);
    legend(&mut canvas, left(0), top[2], width, scale);
    for (column, (method, images)) in (1..).zip(study.report.methods.iter().zip(&study.images)) {
        let map = signed_error_map(&images.mean, reference);
        canvas.text(&method.name, left(column), top[0], scale);
        canvas.image(left(column), top[1], width, height, |x, y| pixel(&images.mean, x, y) * gain);
        canvas.image(left(column), top[2], width, height, |x, y| pixel(&map, x, y));
        let bottom = top[2] + height + GAP;
        canvas.text(
            &format!("{} samples", method.runs * method.samples_per_pixel),
            left(column),
            bottom,
            scale,
        );
        canvas.text(
            &format!("relmse {:.2e}", method.mean_image.relative_mse),
            left(column),
            bottom + line,
            scale,
        );
        let note = if method.complete {
            format!("{:.1} s", method.total.wall)
        } else {
            "blind to some paths".to_owned()
        };
        canvas.text(&note, left(column), bottom + 2 * line, scale);
    }
    ImageFile::from(canvas.image)
}

fn pixel(image: &Image, x: u32, y: u32) -> Rgb {
    image.get(x, y).unwrap_or(Rgb::BLACK)
}

/// What the colours of the error maps mean.
fn legend(canvas: &mut Canvas, left: u32, top: u32, width: u32, scale: u32) {
    let line = font::height(scale);
    let percent = (ERROR_SCALE * 100.0) as u32;
    canvas.text("relative error", left, top + GAP, scale);
    let bar = top + GAP + line;
    canvas.image(left, bar, width, 2 * line, |x, _| {
        error_colour((2.0 * (f64::from(x) + 0.5) / f64::from(width) - 1.0) * ERROR_SCALE)
    });
    let below = bar + 2 * line + GAP;
    let high = format!("+{percent}%");
    canvas.text(&format!("-{percent}%"), left, below, scale);
    canvas.text("0", left + width / 2 - 2 * scale, below, scale);
    canvas.text(&high, left + width.saturating_sub(font::width(&high, scale)), below, scale);
}

struct Canvas {
    image: Image,
}

impl Canvas {
    fn new(width: u32, height: u32) -> Self {
        Self { image: Image::from_fn(width, height, |_, _| BACKGROUND) }
    }

    /// Ignores what is outside.
    fn set(&mut self, x: u32, y: u32, colour: Rgb) {
        let width = self.image.width();
        if x < width && y < self.image.height() {
            self.image.pixels_mut()[y as usize * width as usize + x as usize] = colour;
        }
    }

    fn image(
        &mut self,
        left: u32,
        top: u32,
        width: u32,
        height: u32,
        colour: impl Fn(u32, u32) -> Rgb,
    ) {
        for y in 0..height {
            (0..width).for_each(|x| self.set(left + x, top + y, colour(x, y)));
        }
    }

    fn text(&mut self, text: &str, left: u32, top: u32, scale: u32) {
        font::draw(text, scale, |x, y| self.set(left + x, top + y, INK));
    }
}
