//! The contents of a scene as text.

use super::NamedScene;
use pathspace::endpoint::{AnyLight, Light, LightId};
use pathspace::scene::{Scene, Warning};
use std::fmt::Write;
use std::mem::discriminant;

/// Items of a list that are printed.
const MOST: usize = 20;

/// Cameras, lights, materials, settings and warnings.
pub fn text(scene: &NamedScene) -> String {
    let world = &scene.world;
    let film = scene.camera.0.film();
    let mut text = format!("{}: {}\n", scene.name, scene.description);
    let lights = (0..world.light_count()).map(|index| {
        let id = LightId(index as u32);
        let light = world.light(id);
        let [r, g, b] = light.power().0;
        let name = world.light_name(id).unwrap_or_default();
        format!("{name}: {} of power {r:.4} {g:.4} {b:.4}", kind(light))
    });
    list(&mut text, "cameras", scene.views.iter().cloned());
    list(&mut text, "lights", lights);
    list(&mut text, "materials", world.material_names().iter().cloned());
    list(&mut text, "messages", scene.messages.iter().cloned());
    let depth = scene.max_bounces.map_or_else(|| "any".to_owned(), |max| max.to_string());
    let size = film.window_size();
    let _ = writeln!(text, "image: {} x {} pixels\nmax bounces: {depth}", size.x, size.y);
    text
}

/// Warnings, one line for all of a kind.
pub fn grouped(warnings: &[Warning]) -> Vec<String> {
    let mut kinds: Vec<(&Warning, usize)> = Vec::new();
    for warning in warnings {
        match kinds.iter_mut().find(|(first, _)| discriminant(*first) == discriminant(warning)) {
            Some((_, count)) => *count += 1,
            None => kinds.push((warning, 1)),
        }
    }
    let line = |(warning, count)| match count {
        1 => format!("warning: {warning}"),
        _ => format!("warning: {warning} (× {count} of this kind)"),
    };
    kinds.into_iter().map(line).collect()
}

fn list(text: &mut String, title: &str, items: impl ExactSizeIterator<Item = String>) {
    let count = items.len();
    let _ = writeln!(text, "{title}: {count}");
    for item in items.take(MOST) {
        let _ = writeln!(text, "  {item}");
    }
    if count > MOST {
        let _ = writeln!(text, "  and {} more", count - MOST);
    }
}

fn kind(light: &AnyLight) -> &'static str {
    match light {
        AnyLight::Area(_) => "surface",
        AnyLight::Point(_) => "point light",
        AnyLight::Spot(_) => "spot light",
        AnyLight::Directional(_) => "directional light",
        AnyLight::Constant(_) | AnyLight::Map(_) => "environment",
        AnyLight::Custom(_) => "light",
    }
}
