//! Files of images, with what they tell of their rendering.

use super::{Checkpoint, Rendering};
use crate::film::{FilmRegion, Image, ImageFile};
use crate::path::Counters;
use std::time::Duration;

/// The part of a rendering's identity that files tell.
const SHOWN: [&str; 4] = ["integrator", "filter", "sampler", "seed"];

impl Rendering {
    /// The image with its window and metadata (integrator, sampler, seed, filter, samples per
    /// pixel, time, rays), ready to be saved.
    #[must_use]
    pub fn to_file(&self) -> ImageFile {
        let done = (self.samples_per_pixel, &self.counters, self.wall);
        let mut file = image_file(self.image.clone(), self.film.region(), done);
        let (sampler, seed) = self.sampling.unzip();
        let values = [
            Some(self.integrator.to_owned()),
            Some(format!("{:?}", self.filter)),
            sampler.map(|sampler| format!("{sampler:?}")),
            seed.map(|seed| seed.to_string()),
        ];
        let shown = SHOWN.into_iter().zip(values);
        file.metadata.extend(shown.filter_map(|(name, value)| Some((name.to_owned(), value?))));
        file
    }
}

impl Checkpoint {
    /// The image with its window and metadata, as that of a [rendering](Rendering::to_file), and with
    /// the caller's own entries.
    #[must_use]
    pub fn to_file(&self) -> ImageFile {
        let done = (self.state.samples_per_pixel(), &self.counters(), self.state.times.wall);
        let mut file = image_file(self.image(), self.state.film.region(), done);
        let shown = SHOWN.iter().filter_map(|name| self.identity.0.get_key_value(*name));
        let entries = shown.chain(&self.metadata);
        file.metadata.extend(entries.map(|(name, value)| (name.clone(), value.clone())));
        file
    }
}

fn image_file(
    image: Image,
    region: FilmRegion,
    (samples_per_pixel, counters, wall): (u32, &Counters, Duration),
) -> ImageFile {
    let mut file = ImageFile::from(image);
    file.region = Some(region);
    let entries = [
        ("samples_per_pixel", samples_per_pixel.to_string()),
        (ImageFile::CLOCK, format!("{:.3}", wall.as_secs_f64())),
        ("rays", counters.rays().to_string()),
        ("non_finite", counters.non_finite.to_string()),
    ];
    file.metadata.extend(entries.map(|(key, value)| (key.to_owned(), value)));
    file
}
