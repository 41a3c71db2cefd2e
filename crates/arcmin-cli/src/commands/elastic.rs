use std::path::{Path, PathBuf};

use arcmin::dynamics::{ElasticDiscs, FlexibleOptions};
use arcmin::fem::{
    BoreInterface, CacheKey, DiscModel, DiscShape, FlexibleDiscs, FlexibleSettings, ReducedDisc,
};
use arcmin::geometry::Relief;
use arcmin::load::{FlexibleMeshing, LoadSharing};
use arcmin::machine::{CrankAngle, Machine};
use arcmin::report::Section;

use crate::failure::Failure;
use crate::run::{Run, write_file};

/// Options of everything that lets the discs deform.
#[derive(Debug, Clone, PartialEq, clap::Args)]
pub struct Options {
    /// Finite elements of the elastic disc.
    #[arg(long, value_enum, default_value = "plane-stress")]
    pub element: Element,
    /// What the bores are tied to; in bearings each bore goes its own way.
    #[arg(long, value_enum, default_value = "per-bore")]
    pub bores: Bores,
    /// Elastic discs: modes up to this frequency vibrate, the compliance of the others acts without inertia.
    #[arg(long, value_name = "F", default_value_t = FlexibleOptions::default().mode_frequency)]
    pub mode_frequency_hz: f64,
    /// Elastic discs: damping ratio of every mode.
    #[arg(long, value_name = "Z", default_value_t = FlexibleOptions::default().damping_ratio)]
    pub damping_ratio: f64,
    /// Directory for reduced discs, so that the next run need not reduce them again [default: the output
    /// directory].
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Elastic discs: write disc.vtu (ParaView) with the mesh, displacement and stress under rated torque,
    /// and the lowest modes.
    #[arg(long)]
    pub vtu: bool,
}

/// Modes in the file for ParaView.
const VTU_MODES: usize = 8;

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Element {
    /// Six-node triangles in plane stress.
    PlaneStress,
    /// Ten-node tetrahedra through the width.
    Solid,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Bores {
    /// Each bore carries its own bearing.
    PerBore,
    /// One rigid spider for all bores.
    Common,
}

impl Options {
    pub fn dynamics(&self) -> FlexibleOptions {
        FlexibleOptions { mode_frequency: self.mode_frequency_hz, damping_ratio: self.damping_ratio }
    }

    /// Bearings move every bore by itself.
    fn bores_move(&self) -> Result<(), Failure> {
        match self.bores {
            Bores::PerBore => Ok(()),
            Bores::Common => Err(Failure::Usage {
                message: "bearings move every bore by itself: one spider for all bores leaves none to them"
                    .to_owned(),
                help: "leave --bores common out, or choose --joints ideal".to_owned(),
            }),
        }
    }

    pub fn settings(&self, shape: &DiscShape) -> FlexibleSettings {
        let settings = match self.element {
            Element::PlaneStress => FlexibleSettings::plane_stress(shape),
            Element::Solid => FlexibleSettings::solid(shape),
        };
        let interface = match self.bores {
            Bores::PerBore => BoreInterface::PerBore,
            Bores::Common => BoreInterface::Common,
        };
        FlexibleSettings {
            interface,
            mode_frequency: settings.mode_frequency.max(self.mode_frequency_hz),
            ..settings
        }
    }
}

/// The reduced discs of a machine, from the cache where it holds them. A damaged or foreign cache file is
/// replaced.
pub fn discs(machine: &Machine, options: &Options, directory: &Path) -> Result<FlexibleDiscs, Failure> {
    let (output, directory) = (directory, options.cache.as_deref().unwrap_or(directory));
    let discs = FlexibleDiscs::with(machine, |shape| {
        let settings = options.settings(shape);
        let key = CacheKey::of(shape, &settings);
        let path = directory.join(format!("disc-{}.reduced", &key.hex()[..16]));
        let cached = std::fs::read(&path)
            .ok()
            .and_then(|bytes| ReducedDisc::from_bytes(&bytes, shape, &settings).ok());
        if let Some(reduced) = cached {
            return Ok(reduced);
        }
        let (reduced, _) = DiscModel::new(shape.clone(), settings)
            .and_then(|model| model.reduce())
            .map_err(Failure::compute("reduce the elastic disc"))?;
        // Should this fail, writing the file says so with its path.
        let _ = std::fs::create_dir_all(directory);
        write_file(&path, &reduced.to_bytes(&key))?;
        Ok(reduced)
    })?;
    if options.vtu {
        let (model, sharing) = under_rated_torque(machine, options, discs.clone())?;
        let text = model
            .vtu(&sharing.tooth_loads(0), VTU_MODES)
            .map_err(Failure::compute("find the modes of the disc"))?;
        write_file(&output.join("disc.vtu"), text.as_bytes())?;
    }
    Ok(discs)
}

/// Elastic discs whose bores are moved by bearings.
pub fn in_bearings(run: &Run, machine: &Machine, options: &Options) -> Result<ElasticDiscs, Failure> {
    run.progress().report("reducing the discs", 0.0);
    options.bores_move()?;
    free(machine, discs(machine, options, &run.path("."))?, options)
}

/// As [`in_bearings`], the reductions at hand.
pub fn free(machine: &Machine, discs: FlexibleDiscs, options: &Options) -> Result<ElasticDiscs, Failure> {
    options.bores_move()?;
    ElasticDiscs::free(machine, discs, options.dynamics())
        .map_err(Failure::compute("free the bores of the elastic disc"))
}

/// Load sharing on elastic discs, new surfaces.
pub fn meshing(run: &Run, machine: &Machine, options: &Options) -> Result<FlexibleMeshing, Failure> {
    run.progress().report("reducing the discs", 0.0);
    Ok(machine.flexible_meshing(&Relief::uniform(0.0), discs(machine, options, &run.path("."))?))
}

/// The full model of the first disc, and the load sharing of the unworn machine at rated torque.
fn under_rated_torque(
    machine: &Machine,
    options: &Options,
    discs: FlexibleDiscs,
) -> Result<(DiscModel, LoadSharing), Failure> {
    let shape = DiscShape::of(machine, 0);
    let model = DiscModel::new(shape.clone(), options.settings(&shape))
        .map_err(Failure::compute("mesh the elastic disc"))?;
    let meshing = machine.flexible_meshing(&Relief::uniform(0.0), discs);
    let sharing = meshing
        .load_sharing(CrankAngle::from_radians(0.0), machine.rated.torque)
        .map_err(Failure::compute("load the elastic disc"))?;
    Ok((model, sharing))
}

/// The section of a report about the disc: mesh and shape under rated torque.
pub fn section(machine: &Machine, options: &Options, discs: FlexibleDiscs) -> Result<Section, Failure> {
    let frequencies = discs.reduced(0).frequencies();
    let (model, sharing) = under_rated_torque(machine, options, discs)?;
    Ok(arcmin::report::elastic::section(machine, &model, &frequencies, &sharing))
}
