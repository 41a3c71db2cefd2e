//! Transmission error of the running machine in time.

/// A closed set of words, each with its meaning.
macro_rules! choice {
    ($(#[doc = $doc:literal])* $Name:ident { $($(#[doc = $meaning:literal])* $Value:ident = $word:literal,)* }) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $Name { $($(#[doc = $meaning])* $Value,)* }

        impl Choice for $Name {
            const WORDS: &'static [(&'static str, &'static str)] =
                &[$(($word, concat!($($meaning),*).trim_ascii()),)*];
            const VALUES: &'static [$Name] = &[$($Name::$Value,)*];
        }
    };
}

mod declared;
mod inputs;
pub(crate) mod motion;
mod page;

pub(crate) use declared::{SUMMARY, tables};
pub(crate) use declared::{error_entries, fill, orders_value, solver_entries};
pub(crate) use inputs::Inputs;
pub(crate) use motion::dynamics;
pub use motion::{Motion, MotionOptions};
pub(crate) use page::{page_of, text_blocks_of};

use std::ops::Deref;

use super::{AnalysisError, Attachment, Host, elastic_disc, outcome};
use crate::contact::MeshContact;
use crate::design::{Choice, Design, default, default_word, optional, options};
use crate::fidelity::{Facets, Fidelity, FidelityOptions};
use crate::life::{WornState, worn_after};
use crate::machine::{Machine, OutputForces};
use crate::units::{MM, UM};

pub(crate) const ABOUT: &str = "Integrate the equations of motion: transmission error in time";
pub(crate) const GUIDE: &str = "Integrates the equations of motion of the reducer in time and reports its transmission error θ_out − \
    θ_in/i, with statistics from the start of the window on. Without load and drag the machine rattles \
    in its clearance and the mean depends on the start; the run then reports the spread over perturbed \
    starts.\n\nA long run writes checkpoints to its result directory. After Ctrl-C, --resume continues \
    from the last one if design, options and input files are the same.";
pub(crate) const EXAMPLES: &[&str] = &[
    "arcmin simulate my-reducer.toml --wear-um 10",
    "arcmin simulate my-reducer.toml --hours 2000 --load sine --torque-nm 412 --period-s 0.3",
    "arcmin simulate my-reducer.toml --joints bearings --load constant --end-s 3.5 --drag-nm 5",
];

options! {
    /// Options of `simulate`.
    pub struct Options {
        [fidelity: FidelityOptions]
        [motion: MotionOptions]
        /// Geometry of the flank in contact: smooth, or as a mesh of linear elements represents it.
        flank: Flank => default_word("smooth"),
        /// Edge length of the mesh of a faceted flank.
        facet_mm: f64 => default(1.0, 0.02, 5.0),
        /// Uniform wear depth of the whole flank.
        wear_um: Option<f64> => optional(0.0, 1000.0),
        /// Age of the machine in hours of its duty: flanks, pins, bearings and gears are worn accordingly, with the same
        /// model of the machine.
        hours: Option<f64> => optional(0.0, 1e7),
        /// External tilting moment on the output; needs joints in bearings.
        moment_nm: f64 => default(0.0, 0.0, 1e7),
        /// External axial force on the output, positive out of the machine.
        axial_n: f64 => default(0.0, -1e8, 1e8),
        /// External radial force on the output, in the middle of the main bearings and in the plane of the moment.
        radial_n: f64 => default(0.0, -1e8, 1e8),
        /// Contact law of flank and pins. Left out: the design's.
        contact: Option<inputs::Law> => optional(0.0, 0.0),
        /// Stiffness of the linear law in N/m (left out: 2.85e8), or of the impact law in N/m^e.
        contact_stiffness: Option<f64> => optional(1.0, 1e20),
        /// Exponent e of the impact law.
        contact_exponent: f64 => default(1.1, 1.0, 3.0),
    }
}

choice! {
    /// The surface that the pins touch.
    Flank {
        /// the worn flank as computed
        Smooth = "smooth",
        /// straight edges between nodes
        Faceted = "faceted",
        /// contact at the nodes only
        Nodes = "nodes",
    }
}

/// A run with its settings.
#[derive(Debug, Clone)]
pub struct Simulate {
    /// Run with plan and result.
    pub motion: Motion,
    /// Machine that was run.
    pub machine: Machine,
    /// Joints, bodies and errors.
    pub fidelity: Fidelity,
    /// Its wear of surfaces and parts.
    pub worn: WornState,
    /// Edge length in m of a faceted flank.
    pub facet: Option<f64>,
}

impl Deref for Simulate {
    type Target = Motion;

    fn deref(&self) -> &Motion {
        &self.motion
    }
}

impl motion::HasMotion for Simulate {
    fn motion(&self) -> &Motion {
        &self.motion
    }
}

/// Integrates the motion.
///
/// # Errors
/// [`AnalysisError`]; [`AnalysisError::Interrupted`] when the host stops it, after a checkpoint was kept. A run
/// whose integration fails on the way is an outcome with [`Motion::broke_off`].
pub fn run(design: &Design, options: &Options, host: &dyn Host) -> Result<Simulate, AnalysisError> {
    let mut machine = design.machine();
    if let Some(law) = inputs::contact_law(options)? {
        machine.contact_law = law;
    }
    if options.wear_um.is_some() && options.hours.is_some() {
        return Err(AnalysisError::usage(
            "uniform wear (wear_um) and wear by the duty (hours) exclude each other",
            "leave one of them out",
        ));
    }
    let given = Inputs::read(&options.motion, machine.rated, host)?;
    let mut fidelity = Fidelity::resolve(design, &options.fidelity, host)?;
    let worn = match options.hours {
        Some(hours) => worn_after(&machine, &fidelity, hours, host)?,
        None => WornState::uniform(options.wear_um.unwrap_or(0.0) * UM),
    };
    let forces = OutputForces { moment: options.moment_nm, axial: options.axial_n, radial: options.radial_n };
    fidelity.push_output(&machine, forces)?;
    let size = options.facet_mm * MM;
    let facets = match options.flank {
        Flank::Smooth => None,
        Flank::Faceted => Some(Facets { contact: MeshContact::Edges, size }),
        Flank::Nodes => Some(Facets { contact: MeshContact::Nodes, size }),
    };
    let Inputs { drive, load, notes } = given;
    let model = fidelity.model(&machine, &worn, drive, load, options.motion.drag_nm, facets)?;
    let motion = motion::run(model, &options.motion, machine.friction.seal_drag, notes, host)?;
    Ok(Simulate { motion, facet: facets.map(|facets| facets.size), machine, fidelity, worn })
}

outcome!(Simulate {
    fn failure(&self) -> Option<String> {
        self.broke_off.clone()
    }

    fn attachments(&self) -> Result<Vec<Attachment>, AnalysisError> {
        elastic_disc::attachments(&self.machine, &self.fidelity)
    }
});
