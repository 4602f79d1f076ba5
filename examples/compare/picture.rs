//! Images and error maps side by side.

use super::font;
use super::measure::Measured;
use super::reference::Reference;
use super::report::{Row, error_text};
use pathspace::film::{Image, ImageFile};
use pathspace::math::Rgb;

/// Relative error that gets the full colour.
const SCALE: f64 = 0.5;
const GAP: u32 = 6;
const BACKGROUND: Rgb = Rgb([0.02; 3]);
const INK: Rgb = Rgb([0.75; 3]);

/// Stops of exposure that make an image's brighter parts, but not its lights, nearly white.
pub fn exposure(image: &Image) -> f64 {
    let mut luminances: Vec<f64> = image.pixels().iter().map(|p| p.luminance()).filter(|l| *l > 0.0 && l.is_finite()).collect();
    if luminances.is_empty() {
        return 0.0;
    }
    luminances.sort_by(f64::total_cmp);
    let bright = luminances[luminances.len() * 9 / 10];
    (0.7 / bright).log2().clamp(-60.0, 60.0)
}

/// A column for the reference and for each integrator: the image, and below it the signed relative error.
pub fn side_by_side(measured: &[Measured], reference: &Reference, rows: &[Row]) -> ImageFile {
    let (width, height) = (reference.image.width(), reference.image.height());
    let scale = if width >= 220 { 2 } else { 1 };
    let line = font::height(scale);
    let columns = measured.len() as u32 + 1;
    let mut canvas = Canvas::new(columns * (width + GAP) + GAP, 2 * height + 4 * line + 4 * GAP);
    let top = [GAP, GAP + line + GAP / 2, 2 * GAP + line + height + GAP / 2];
    let gain = exposure(&reference.image).exp2();
    let left = |column: u32| GAP + column * (width + GAP);

    canvas.text("reference", left(0), top[0], scale);
    canvas.image(left(0), top[1], width, height, |x, y| pixel(&reference.image, x, y) * gain);
    legend(&mut canvas, left(0), top[2], width, scale);
    // Where the reference is dark, a relative error has no meaning: it is taken relative to a part of the mean.
    let floor = 0.02 * reference.image.mean().luminance();
    for (column, (run, row)) in (1..).zip(measured.iter().zip(rows)) {
        canvas.text(run.integrator.name(), left(column), top[0], scale);
        canvas.image(left(column), top[1], width, height, |x, y| pixel(&run.image, x, y) * gain);
        canvas.image(left(column), top[2], width, height, |x, y| {
            let (i, r) = (pixel(&run.image, x, y).luminance(), pixel(&reference.image, x, y).luminance());
            error_colour((i - r) / (r + floor))
        });
        let bottom = top[2] + height + GAP;
        canvas.text(&format!("{} samples", run.samples_per_pixel), left(column), bottom, scale);
        canvas.text(&format!("relmse {}", error_text(row.relative_mse)), left(column), bottom + line, scale);
        let note = if run.sees_all { format!("{:.1} s", row.seconds) } else { "blind to some paths".to_owned() };
        canvas.text(&note, left(column), bottom + 2 * line, scale);
    }
    ImageFile::from(canvas.image)
}

fn pixel(image: &Image, x: u32, y: u32) -> Rgb {
    image.get(x, y).unwrap_or(Rgb::BLACK)
}

/// White is exact, red too bright, blue too dark, all at full colour from `SCALE` on; magenta is not a number.
fn error_colour(error: f64) -> Rgb {
    if error.is_nan() {
        return Rgb::new(1.0, 0.0, 1.0);
    }
    let amount = (error.abs() / SCALE).min(1.0).sqrt();
    let colour = if error > 0.0 { Rgb::new(0.7, 0.0, 0.02) } else { Rgb::new(0.0, 0.08, 0.7) };
    Rgb::splat(0.9 * (1.0 - amount)) + colour * amount
}

/// What the colours of the error maps mean.
fn legend(canvas: &mut Canvas, left: u32, top: u32, width: u32, scale: u32) {
    let line = font::height(scale);
    let percent = (SCALE * 100.0) as u32;
    canvas.text("relative error", left, top + GAP, scale);
    let bar = top + GAP + line;
    canvas.image(left, bar, width, 2 * line, |x, _| error_colour((2.0 * (f64::from(x) + 0.5) / f64::from(width) - 1.0) * SCALE));
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

    fn image(&mut self, left: u32, top: u32, width: u32, height: u32, colour: impl Fn(u32, u32) -> Rgb) {
        for y in 0..height {
            (0..width).for_each(|x| self.set(left + x, top + y, colour(x, y)));
        }
    }

    fn text(&mut self, text: &str, left: u32, top: u32, scale: u32) {
        font::draw(text, scale, |x, y| self.set(left + x, top + y, INK));
    }
}
