//! Elastic discs of a fidelity: reduced once, then stored in the cache of the host.

use super::{Bores, Element, FidelityOptions, FrameBodies};
use crate::analyses::{AnalysisError, Host};
use crate::dynamics::{ElasticDiscs, FlexibleOptions};
use crate::fem::{
    BoreInterface, CacheKey, DiscElement, DiscModel, DiscShape, FlexibleDiscs, FlexibleSettings, ReducedDisc,
};
use crate::geometry::{Relief, Sector};
use crate::load::LoadSharing;
use crate::machine::{CrankAngle, Machine};

/// Reduced discs with the options of the reduction.
#[derive(Debug, Clone)]
pub struct Elastic {
    reduced: FlexibleDiscs,
    /// With bores that move independently; `None` if one rigid spider connects them.
    free: Option<ElasticDiscs>,
    options: FidelityOptions,
    windows: Vec<Sector>,
}

impl Elastic {
    /// Reduces the discs of a machine.
    pub(super) fn reduce(
        machine: &Machine,
        options: &FidelityOptions,
        host: &dyn Host,
    ) -> Result<Elastic, AnalysisError> {
        let reduced = reduced(DiscShape::all(machine), |shape| settings(options, shape), host)?;
        let free = match options.bores {
            Bores::Common => None,
            Bores::PerBore => Some(
                ElasticDiscs::free(&DiscShape::all(machine), reduced.clone(), options.dynamics())
                    .map_err(AnalysisError::compute("free the bores of the elastic disc"))?,
            ),
        };
        Ok(Elastic { reduced, free, options: options.clone(), windows: machine.disc.windows.clone() })
    }

    /// The reduced discs with fixed bores.
    pub fn reduced(&self) -> &FlexibleDiscs {
        &self.reduced
    }

    /// The discs with bores that move independently.
    ///
    /// # Errors
    /// [`AnalysisError::Usage`] if one rigid spider connects all bores.
    pub fn free(&self) -> Result<&ElasticDiscs, AnalysisError> {
        self.free.as_ref().ok_or_else(no_free_bores)
    }

    pub(super) fn bores_are_tied(&self) -> bool {
        self.free.is_none()
    }

    /// Whether the options request a file for ParaView.
    pub(crate) fn needs_vtu(&self) -> bool {
        self.options.vtu
    }

    /// Modes and damping.
    pub fn dynamics(&self) -> FlexibleOptions {
        self.options.dynamics()
    }

    /// The full model of the first disc, and the load sharing of the unworn machine at rated torque.
    ///
    /// # Errors
    /// [`AnalysisError`] where meshing the disc or sharing the load fails.
    pub fn under_rated_torque(&self, machine: &Machine) -> Result<(DiscModel, LoadSharing), AnalysisError> {
        let mut machine = machine.clone();
        machine.disc.windows.clone_from(&self.windows);
        let shape = DiscShape::of(&machine, 0);
        let model = DiscModel::new(shape.clone(), settings(&self.options, &shape))
            .map_err(AnalysisError::compute("mesh the elastic disc"))?;
        let meshing = machine.flexible_meshing(&Relief::uniform(0.0), self.reduced.clone());
        let sharing = meshing
            .load_sharing(CrankAngle::from_radians(0.0), machine.rated.torque)
            .map_err(AnalysisError::compute("load the elastic disc"))?;
        Ok((model, sharing))
    }
}

/// Width in m at which discs in plane stress are reduced.
const PLANE_WIDTH: f64 = 10e-3;

/// Reduces discs, or reads them from the cache of the host. An invalid cache entry is replaced.
///
/// # Errors
/// [`AnalysisError`] where a disc cannot be reduced, or the host stops it.
fn reduced(
    shapes: Vec<DiscShape>,
    settings: impl Fn(&DiscShape) -> FlexibleSettings + Sync,
    host: &dyn Host,
) -> Result<FlexibleDiscs, AnalysisError> {
    host.report("reducing the discs", 0.0);
    FlexibleDiscs::with(shapes, |disc| {
        let settings = settings(disc);
        // Discs in plane stress that differ in their widths alone share one reduction.
        let width = match settings.element {
            DiscElement::PlaneStress => PLANE_WIDTH,
            DiscElement::Solid { .. } => disc.width,
        };
        let (shape, factor) = (&DiscShape { width, ..disc.clone() }, disc.width / width);
        let key = CacheKey::of(shape, &settings);
        let name = format!("disc-{}.reduced", &key.hex()[..16]);
        let cached =
            host.cached(&name).and_then(|bytes| ReducedDisc::from_bytes(&bytes, shape, &settings).ok());
        if let Some(reduced) = cached {
            return Ok(reduced.widened(factor));
        }
        if host.is_cancelled() {
            return Err(AnalysisError::Stopped);
        }
        let (reduced, _) = DiscModel::new(shape.clone(), settings)
            .and_then(|model| model.reduce())
            .map_err(AnalysisError::compute("reduce the elastic disc"))?;
        host.cache(&name, &reduced.to_bytes(&key));
        Ok(reduced.widened(factor))
    })
}

/// The elastic discs of one stage of a drive of eccentrics. The eccentric displaces the bore, the output pins the holes.
///
/// # Errors
/// [`AnalysisError`] where a disc cannot be reduced, or the host stops it.
pub(crate) fn stage_discs(shapes: Vec<DiscShape>, host: &dyn Host) -> Result<ElasticDiscs, AnalysisError> {
    let settings = |shape: &DiscShape| FlexibleSettings {
        interface: BoreInterface::Means,
        ..FlexibleSettings::plane_stress(shape)
    };
    let reduced = reduced(shapes.clone(), settings, host)?;
    ElasticDiscs::free(&shapes, reduced, FlexibleOptions::default())
        .map_err(AnalysisError::compute("free the bores of the elastic discs"))
}

fn settings(options: &FidelityOptions, shape: &DiscShape) -> FlexibleSettings {
    let settings = match options.element {
        Element::PlaneStress => FlexibleSettings::plane_stress(shape),
        Element::Solid => FlexibleSettings::solid(shape),
    };
    let interface = match options.bores {
        // Elastic bodies include the ovalisation of the rims of the bores.
        Bores::PerBore if options.bodies.value == FrameBodies::Elastic => BoreInterface::Rims,
        Bores::PerBore => BoreInterface::PerBore,
        Bores::Common => BoreInterface::Common,
    };
    FlexibleSettings {
        interface,
        mode_frequency: settings.mode_frequency.max(options.mode_frequency_hz),
        ..settings
    }
}

pub(super) fn no_free_bores() -> AnalysisError {
    AnalysisError::usage(
        "one rigid spider for all bores does not allow each bore its own bearing",
        "leave bores = common out, or choose joints = ideal",
    )
}
