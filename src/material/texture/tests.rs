//! Lookups, borders, transforms and refusals.

use super::*;
use approx::assert_relative_eq;

fn grey(values: &[f64]) -> Arc<Image> {
    Arc::new(
        Image::new(values.len() as u32, 1, values.iter().map(|v| Rgb::splat(*v)).collect())
            .expect("a row"),
    )
}

#[test]
fn images_continue_beyond_their_border() {
    let image = grey(&[1.0, 2.0, 3.0]);
    let row = |wrap, interpolation, offset: f64| -> Vec<f64> {
        let texture =
            Texture::bitmap(Arc::clone(&image), interpolation, [wrap, Wrap::Clamp]).expect("valid");
        (-4..8).map(|i| texture.at(DVec2::new((f64::from(i) + offset) / 3.0, 7.3)).r()).collect()
    };
    let expected = [
        (Wrap::Repeat, [3.0, 1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0, 2.0]),
        (Wrap::Mirror, [3.0, 3.0, 2.0, 1.0, 1.0, 2.0, 3.0, 3.0, 2.0, 1.0, 1.0, 2.0]),
        (Wrap::Clamp, [1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0]),
    ];
    for (wrap, expected) in expected {
        assert_eq!(row(wrap, Interpolation::Nearest, 0.25), expected);
        let between = row(wrap, Interpolation::Bilinear, 0.75);
        for (i, value) in between.iter().enumerate().take(11) {
            assert_relative_eq!(
                *value,
                0.75 * expected[i] + 0.25 * expected[i + 1],
                max_relative = 1e-12
            );
        }
    }
}

#[test]
fn rows_run_downwards() {
    let image = Image::from_fn(2, 2, |x, y| Rgb::new(f64::from(x), f64::from(y), 0.0));
    let texture = Texture::bitmap(image, Interpolation::Nearest, [Wrap::Clamp; 2]).expect("valid");
    assert_eq!(texture.at(DVec2::new(0.9, 0.1)), Rgb::new(1.0, 0.0, 0.0));
    assert_eq!(texture.at(DVec2::new(0.1, 0.9)), Rgb::new(0.0, 1.0, 0.0));
    let flipped = texture
        .with_transform(DAffine2::from_cols(DVec2::X, DVec2::NEG_Y, DVec2::Y))
        .expect("finite");
    assert_eq!(flipped.at(DVec2::new(0.9, 0.1)), Rgb::new(1.0, 1.0, 0.0));
    assert_eq!(flipped.range(), [Rgb::BLACK, Rgb::new(1.0, 1.0, 0.0)]);
}

#[test]
fn factors_and_cutoffs_come_after_interpolation() {
    let texture = Texture::bitmap(grey(&[0.0, 1.0]), Interpolation::Bilinear, [Wrap::Clamp; 2])
        .expect("valid");
    let scaled = texture.scaled(Rgb::new(0.5, 2.0, 0.5)).expect("finite");
    assert_eq!(scaled.at(DVec2::splat(0.5)), Rgb::new(0.25, 1.0, 0.25));
    assert_eq!(scaled.range(), [Rgb::BLACK, Rgb::new(0.5, 2.0, 0.5)]);
    let grey = scaled.scaled(Rgb::new(1.0, 0.25, 1.0)).expect("finite").cut(0.25);
    assert_eq!([0.45, 0.55].map(|u| grey.at(DVec2::splat(u))), [Rgb::BLACK, Rgb::WHITE]);
    assert_eq!(grey.range(), [Rgb::BLACK, Rgb::WHITE]);
    assert_eq!(grey.scaled(Rgb::WHITE), Err(TextureError::Cut));
    assert_eq!(Texture::from(Rgb::splat(0.2)).cut(0.3).as_constant(), Some(Rgb::BLACK));
    assert_eq!(
        Texture::from(Rgb::splat(0.2)).scaled(Rgb::splat(f64::INFINITY)),
        Err(TextureError::NotFinite)
    );
}

#[test]
fn boards_have_four_squares() {
    let board = Texture::checkerboard(Rgb::WHITE, Rgb::BLACK)
        .with_transform(DAffine2::from_scale(DVec2::splat(0.5)))
        .expect("finite");
    for (u, v, expected) in [
        (0.5, 0.5, 1.0),
        (1.5, 0.5, 0.0),
        (0.5, 1.5, 0.0),
        (1.5, 1.5, 1.0),
        (-0.5, 0.5, 0.0),
        (2.5, 0.5, 1.0),
    ] {
        assert_eq!(board.at(DVec2::new(u, v)), Rgb::splat(expected), "{u} {v}");
    }
}

#[test]
fn bad_values_are_refused_and_bad_coordinates_survive() {
    assert_eq!(
        Texture::bitmap(grey(&[]), Interpolation::Nearest, [Wrap::Clamp; 2]),
        Err(TextureError::Empty)
    );
    assert_eq!(
        Texture::bitmap(grey(&[f64::NAN]), Interpolation::Nearest, [Wrap::Clamp; 2]),
        Err(TextureError::NotFinite)
    );
    let texture = Texture::bitmap(grey(&[1.0, 2.0]), Interpolation::Bilinear, [Wrap::Mirror; 2])
        .expect("valid");
    assert!(texture.clone().with_transform(DAffine2::from_scale(DVec2::NAN)).is_err());
    for x in [1e300, -1e300] {
        assert!(texture.at(DVec2::new(x, -x)).is_finite());
    }
    assert!(
        texture.is_within(1.0, 2.0)
            && !texture.is_within(0.0, 1.5)
            && !Texture::from(Rgb::splat(f64::NAN)).is_within(0.0, 1.0)
    );
}

#[test]
fn textures_of_one_bitmap_share_its_range() {
    let colours = [Rgb::new(0.5, 0.25, -1.0), Rgb::new(0.125, 2.0, 0.0), Rgb::new(1.0, 0.5, -3.0)];
    let image = Image::new(3, 1, colours.to_vec()).expect("3 pixels");
    let bitmap = Bitmap::new(image).expect("valid");
    let range = [Rgb::new(0.125, 0.25, -3.0), Rgb::new(1.0, 2.0, 0.0)];
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        let texture = bitmap.clone().texture(Interpolation::Nearest, [wrap; 2]);
        assert_eq!(texture.range(), range);
        let scaled = texture.scaled(Rgb::new(-2.0, 0.5, 1.0)).expect("finite");
        assert_eq!(scaled.range(), [Rgb::new(-2.0, 0.125, -3.0), Rgb::new(-0.25, 1.0, 0.0)]);
    }
}

#[test]
fn products_clamped_channels_and_cutoffs_have_their_range() {
    let row = |values: &[f64]| {
        Texture::bitmap(grey(values), Interpolation::Nearest, [Wrap::Clamp; 2]).expect("valid")
    };
    let both = |texture: &Texture| [0.25, 0.75].map(|u| texture.at(DVec2::splat(u)).r());
    let product = row(&[0.5, 2.0]).times(row(&[4.0, 0.25]));
    assert_eq!(product.range().map(|bound| bound.r()), [0.125, 8.0]);
    assert_eq!(both(&product.clone().scaled(Rgb::splat(3.0)).expect("finite")), [6.0, 1.5]);
    let constant = Texture::from(Rgb::splat(0.5)).times(Rgb::splat(4.0).into());
    assert_eq!((constant.as_constant(), product.as_constant()), (Some(Rgb::splat(2.0)), None));
    assert_eq!(product.clamped(0.0, 1.0), Err(TextureError::Product));

    let scaled = row(&[0.25, 2.0]).scaled(Rgb::splat(-2.0)).expect("finite");
    let clamped = scaled.clamped(-1.0, 1.0).expect("an image");
    assert_eq!((both(&clamped), clamped.range()), ([-0.5, -1.0], [-1.0, -0.5].map(Rgb::splat)));

    for (cutoff, range) in [(0.25, [1.0; 2]), (0.3, [0.0, 1.0]), (2.0, [0.0, 1.0]), (2.1, [0.0; 2])]
    {
        let cut = row(&[0.25, 2.0]).cut(cutoff);
        assert_eq!(cut.range(), range.map(Rgb::splat), "{cutoff}");
        assert_eq!(both(&cut), range, "{cutoff}");
    }
}
