//! Depth, roulette, and sets of techniques.

use crate::compare::{self, Comparison, Named, assert_agree, measure};
use crate::rooms::camera;
use crate::team::{Team, apart, grey, lit_room, metal};
use pathspace::film::Technique;
use pathspace::integrator::{Bidirectional, Depth, LightTracer, PathTracer, UniformArea};
use pathspace::path::{Excluded, Roulette, Survival, TechniqueSet};
use pathspace::render::Render;
use pathspace::scene::World;

/// The images of exactly 0, 1, 2 and 3 bounces sum to that of up to 3, for each integrator.
#[test]
fn bounces_add_up() {
    let world = lit_room();
    let comparison = Comparison { target: 0.004, ..Comparison::default() };
    type Make = fn(Depth) -> Box<dyn Render<World>>;
    let makers: [(&str, Make); 4] = [
        ("path", |depth| Box::new(PathTracer { depth, ..PathTracer::default() })),
        ("light", |depth| Box::new(LightTracer { depth, ..LightTracer::default() })),
        ("bidirectional", |depth| Box::new(Bidirectional { depth, ..Bidirectional::default() })),
        ("uniform area", |depth| Box::new(UniformArea { depth, ..UniformArea::default() })),
    ];
    for (name, make) in makers {
        let limit = if name == "uniform area" { 1 } else { 3 };
        let whole = make(Depth::up_to(limit));
        let whole =
            measure(&world, &camera(), (&format!("{name}, up to {limit}"), &*whole), &comparison);
        let parts: Vec<_> = (0..=limit)
            .map(|k| {
                measure(
                    &world,
                    &camera(),
                    (&format!("{name}, exactly {k}"), &*make(Depth::exactly(k))),
                    &comparison,
                )
            })
            .collect();
        let mut sum = parts[0].images.clone();
        for (i, image) in sum.iter_mut().enumerate() {
            for (j, pixel) in image.pixels_mut().iter_mut().enumerate() {
                *pixel = parts.iter().map(|part| part.images[i].pixels()[j]).sum();
            }
        }
        let sum =
            compare::Measured { name: format!("{name}, sum"), images: sum, samples_per_pixel: 0 };
        compare::assert_measurements_agree(name, &[whole, sum], &comparison);
    }
}

/// Roulette without a limit: the same as a limit so deep that nothing is left.
#[test]
fn roulette_replaces_a_deep_limit() {
    let world = lit_room();
    let deep = Depth::up_to(24);
    let harsh = Roulette { start: 0, survival: Survival::Fixed(0.8), ..Roulette::default() };
    let early = Roulette { start: 0, ..Roulette::default() };
    let team = Team::new(Depth::default())
        .path()
        .light()
        .bidirectional()
        .with("path, early roulette", PathTracer { roulette: early, ..PathTracer::default() })
        .with("light, fixed survival", LightTracer { roulette: harsh, ..LightTracer::default() })
        .with("bidirectional, fixed", Bidirectional { roulette: harsh, ..Bidirectional::default() })
        .with(
            "path, 24 bounces",
            PathTracer { depth: deep, roulette: Roulette::NEVER, ..PathTracer::default() },
        );
    assert_agree(
        "roulette",
        &world,
        &camera(),
        &team.named(),
        &Comparison { target: 0.0025, ..Comparison::default() },
    );
}

/// Every (s, t) alone and unweighted has the mean of path tracing at this path length.
fn techniques_alone(case: &str, world: &World, bounces: u32, comparison: &Comparison) {
    let depth = Depth::exactly(bounces);
    let only = |s: u16| {
        let only = Technique::new(s, bounces as u16 + 2 - s);
        Bidirectional {
            techniques: TechniqueSet::only(only).expect("a short path"),
            depth,
            ..Bidirectional::default()
        }
    };
    let alone: Vec<(String, Bidirectional)> = (0..=bounces as u16 + 1)
        .map(|s| (format!("only ({s}, {})", bounces as u16 + 2 - s), only(s)))
        .collect();
    let path = PathTracer { depth, ..PathTracer::default() };
    let mut team: Vec<Named<'_>> = vec![("path", &path)];
    team.extend(
        alone.iter().map(|(name, integrator)| (name.as_str(), integrator as &dyn Render<World>)),
    );
    assert_agree(&format!("{case}, {bounces} bounces"), world, &camera(), &team, comparison);
}

#[test]
fn each_technique_alone() {
    techniques_alone("Lambert", &apart(grey()), 1, &Comparison::default());
}

#[test]
fn each_technique_alone_on_metal() {
    let world = apart(metal(0.5, 0.5));
    techniques_alone("metal", &world, 1, &Comparison { target: 0.003, ..Comparison::default() });
}

#[test]
#[ignore = "the same with longer paths"]
fn each_technique_alone_on_longer_paths() {
    techniques_alone(
        "Lambert",
        &apart(grey()),
        2,
        &Comparison { target: 0.005, ..Comparison::default() },
    );
    let world = apart(metal(0.5, 0.5));
    techniques_alone("metal", &world, 2, &Comparison { target: 0.006, ..Comparison::default() });
    for material in [grey(), metal(0.5, 0.5)] {
        techniques_alone(
            "three bounces",
            &apart(material),
            3,
            &Comparison { target: 0.006, most: 20_000, ..Comparison::default() },
        );
    }
}

/// Removing any one technique leaves the mean: the weights of the others fill the gap.
fn without_one(bounces: u16) {
    let world = apart(metal(0.5, 0.5));
    let depth = Depth::exactly(u32::from(bounces));
    let without = |s| {
        let without = Technique::new(s, bounces + 2 - s);
        let excluded = Excluded::NONE.with(without).expect("a short path");
        Bidirectional {
            techniques: TechniqueSet { excluded, ..TechniqueSet::BIDIRECTIONAL },
            depth,
            ..Bidirectional::default()
        }
    };
    let sets: Vec<(String, Bidirectional)> =
        (0..=bounces + 1).map(|s| (format!("without s = {s}"), without(s))).collect();
    let path = PathTracer { depth, ..PathTracer::default() };
    let mut team: Vec<Named<'_>> = vec![("path", &path)];
    team.extend(
        sets.iter().map(|(name, integrator)| (name.as_str(), integrator as &dyn Render<World>)),
    );
    assert_agree(
        &format!("without one, {bounces} bounces"),
        &world,
        &camera(),
        &team,
        &Comparison::default(),
    );
}

#[test]
fn without_any_one_technique() {
    without_one(1);
}

#[test]
#[ignore = "the same with longer paths"]
fn without_any_one_technique_on_longer_paths() {
    without_one(2);
}
