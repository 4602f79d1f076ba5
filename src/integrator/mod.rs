//! Integrators: each is a set of techniques for drawing paths.
//!
//! | integrator | techniques |
//! |---|---|
//! | [`UniformArea`] | every vertex behind the first surface uniform on the scene's area |
//! | [`PathTracer`] | s = 0 (BSDF sampling) and s = 1 (next event estimation), or either alone |
//! | [`LightTracer`] | t = 1 (connect to the lens) |
//! | [`Bidirectional`] | all (s, t), or any set of them |
//! | [`PhotonMapping`] | merges at the first finite lobe seen from the camera, s = 0 without one |
//! | [`InstantRadiosity`] | connections to light walks that all pixels share, rest by s = 0 and 1 |
//! | [`VertexConnectionMerging`] | all (s, t) and all merges |
//! | [`Multiplexed`] | one of all (s, t) in each sample |
//! | [`Metropolis`] | those of another integrator, whose numbers Markov chains move |
//! | [`Regularization`] | those of an integrator, in a scene without Dirac lobes |
//! | [`Guiding`] | those of an integrator, with camera walks that go where light was found before |
//! | [`Adaptive`] | the most efficient set, from path tracing to all (s, t), as a pilot finds it |
//!
//! All of them estimate the same image, with the same normalisation and the same meaning of depth:
//! those that merge up to a bias that vanishes as passes are added ([`Estimator`]).
//!
//! An [`Integrator`] is plain settings. Started on a [`Stage`] it becomes a [`Run`], which owns
//! what lives for one rendering and draws samples. What a walk does is written for one path
//! ([`Steps`](crate::path::Steps)); many advance together. An [`Audit`] finds one path that an
//! integrator draws, and all that makes up its contribution.

mod adaptive;
mod any_run;
mod arrivals;
mod audit;
mod bidirectional;
mod crew;
mod guiding;
mod instant_radiosity;
mod light_tracer;
mod metropolis;
mod multiplexed;
mod path_tracer;
mod photon_mapping;
mod regularization;
mod run;
mod shared;
mod uniform_area;
mod vertex_connection_merging;
mod viewed;
mod with_needs;

pub use crate::path::{Depth, Stage};
pub use adaptive::{Adaptive, Candidate, Decision};
pub use any_run::{AnyIntegrator, AnyRun, BoxedRun, StartOnWorld};
pub use arrivals::Arrivals;
pub use audit::{Audit, AuditError, AuditedPath, AuditedTechnique};
pub use bidirectional::Bidirectional;
pub use crew::{Caller, Crew};
pub use guiding::{Guidable, Guidance, GuidedRun, Guiding};
pub use instant_radiosity::{InstantRadiosity, VirtualLightPasses};
pub use light_tracer::LightTracer;
pub use metropolis::{Chains, ChunkChains, Metropolis, Normalization};
pub use multiplexed::{Choices, Multiplexed};
pub use path_tracer::{PathTracer, PathTracing};
pub use photon_mapping::{PhotonMapping, PhotonPasses};
pub use regularization::{Regularization, RegularizedPasses};
pub use run::{Estimator, Integrator, IntegratorError, Notes, Run, SingleWalk, Started};
pub use shared::{LightWalks, Merging, PhotonMaps, SharedWalks};
pub use uniform_area::UniformArea;
pub use vertex_connection_merging::{MergingPairs, VertexConnectionMerging};
pub use with_needs::WithNeeds;
