//! Integrators: what they are and how far they go, as hints.

use super::super::Error;
use super::Loader;
use super::document::Element;
use super::values::Object;

/// Types that estimate what the camera sees, along paths of up to `max_depth` edges.
const OF_PATHS: [&str; 18] = [
    "path",
    "volpath",
    "volpathmip",
    "volpath_simple",
    "prb",
    "prb_basic",
    "prb_projective",
    "prbvolpath",
    "ptracer",
    "bdpt",
    "mlt",
    "pssmlt",
    "erpt",
    "ppm",
    "sppm",
    "photonmapper",
    "vpl",
    "adaptive",
];
/// Types that estimate light after no more than one scattering event.
const DIRECT: [&str; 2] = ["direct", "direct_projective"];

impl<'a> Loader<'a> {
    /// Takes the hints of an integrator, or of the one in it.
    pub(super) fn integrator(&mut self, element: &'a Element, depth: u32) -> Result<(), Error> {
        if depth >= self.limits.depth {
            return Err(element.error("integrators are nested too deeply, or contain each other"));
        }
        let object = Object::new(element);
        let mut inside = Vec::new();
        for child in object.objects() {
            let child = self.resolved(child)?;
            if child.tag == "integrator" {
                inside.push(child);
            }
        }
        let kind = element.kind();
        if let Some((first, others)) = inside.split_first() {
            self.warn(
                element,
                match others {
                    [] => format!("of the integrator {kind} only the one in it is taken"),
                    _ => format!("of the integrator {kind} only the first one in it is taken"),
                },
            )?;
            return self.integrator(first, depth + 1);
        }
        self.hints.integrator = Some(kind.to_owned());
        self.hints.max_bounces = match object.integer("max_depth")? {
            _ if DIRECT.contains(&kind) => Some(1),
            Some(0) => {
                self.sees = false;
                self.warn(element, "a max_depth of 0 sees nothing: no emitter is read")?;
                Some(0)
            }
            Some(edges @ 1..) => Some(u32::try_from(edges - 1).unwrap_or(u32::MAX)),
            // For all.
            None | Some(-1) => None,
            Some(edges) => {
                self.warn(
                    element,
                    format!("a max_depth of {edges} is not known, and taken for no limit"),
                )?;
                None
            }
        };
        let is_known = DIRECT.contains(&kind) || OF_PATHS.contains(&kind);
        if !is_known && object.get("max_depth").is_none() {
            self.warn(
                element,
                format!("the integrator {kind} is not known; light is taken without a limit"),
            )?;
        }
        if object.boolean("hide_emitters")? == Some(true) {
            self.warn(element, "hide_emitters is not supported: emitters are visible")?;
        }
        Ok(())
    }
}
