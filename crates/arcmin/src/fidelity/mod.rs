//! Model of a machine: its joints, discs and other bodies, rigid or elastic, and its manufacturing errors.
//!
//! All analyses have the options `joints`, `discs`, `errors` and `seed`. [`Fidelity::resolve`] evaluates them once.
//! [`Fidelity::meshing`] then gives the load sharing, [`Fidelity::joint_settings`] the settings of the multibody model,
//! and [`worn_after`](crate::life::worn_after) the state of wear after some hours. The state after H hours is therefore
//! the same in all analyses.

mod bodies;
mod elastic;
mod meshing;
mod model;
mod options;
mod room;

pub use bodies::ElasticFrame;
pub use elastic::Elastic;
pub(crate) use elastic::stage_discs;
pub use meshing::{MachineMeshing, MeshingStart};
pub use model::Facets;
pub(crate) use options::LARGEST_SEED;
pub use options::{Bores, DiscBodies, Element, ErrorSource, FidelityOptions, FrameBodies, Joints};

use crate::analyses::{AnalysisError, Host, Origin};
use crate::design::{Choice, Design, InputFile};
use crate::dynamics::{BearingMeshing, ElasticDiscs, JointSettings, TiltingOutput};
use crate::geometry::Relief;
use crate::machine::{Batch, Machine, ManufacturingErrors, OutputForces};
use crate::results::{Column, Value, quantities as q};

/// Joints, bodies and manufacturing errors of the model of a machine.
#[derive(Debug, Clone)]
pub struct Fidelity {
    /// Joints between the bodies.
    pub joints: Joints,
    /// Elastic discs; `None` for rigid ones.
    pub elastic: Option<Elastic>,
    /// Elastic carrier, housing and rims; `None` for rigid ones.
    pub frame: Option<ElasticFrame>,
    /// Tilt of the output in its main bearings, with elastic bodies or under external forces.
    pub tilt: Option<TiltingOutput>,
    /// Deviations of the model from the drawing.
    pub errors: ManufacturingErrors,
    /// Origin of these deviations.
    pub source: ErrorSource,
    /// Seed of a drawn machine.
    pub seed: Option<u64>,
    /// Whether the design gives errors that the model with ideal joints does not include.
    pub errors_left_out: bool,
}

/// Whether the solids of carrier, housing and discs are possible: no overlap, and material between all openings.
pub(crate) fn has_room(machine: &Machine) -> bool {
    room::check(&bodies::with_windows(machine)).is_ok()
}

impl Fidelity {
    /// Without bearings, elasticity of the discs and errors.
    pub fn ideal() -> Fidelity {
        Fidelity {
            joints: Joints::Ideal,
            elastic: None,
            frame: None,
            tilt: None,
            errors: ManufacturingErrors::default(),
            source: ErrorSource::None,
            seed: None,
            errors_left_out: false,
        }
    }

    /// From options: reads measured flanks, draws the errors, reduces elastic discs (or takes them from the
    /// host's cache).
    ///
    /// # Errors
    /// Invalid combinations of options, with the reason; files that cannot be read; discs that cannot be reduced.
    pub fn resolve(
        design: &Design,
        options: &FidelityOptions,
        host: &dyn Host,
    ) -> Result<Fidelity, AnalysisError> {
        let mut machine = design.machine();
        let mut fidelity = Fidelity { joints: options.joints.value, ..Fidelity::ideal() };
        fidelity.take_errors(design, &machine, options, host)?;
        let bends = options.bodies.value == FrameBodies::Elastic;
        if bends && options.joints.value == Joints::Ideal {
            return Err(AnalysisError::usage(
                "ideal joints do not support elastic carriers and housings",
                "choose joints = bearings",
            ));
        }
        if bends {
            machine = bodies::with_windows(&machine);
            room::check(&machine)?;
        }
        if bends || options.discs.value == DiscBodies::Elastic {
            // Checked before meshing.
            if options.joints.value == Joints::Bearings && options.bores == Bores::Common {
                return Err(elastic::no_free_bores());
            }
            let (discs, frame) = rayon::join(
                || Elastic::reduce(&machine, options, host),
                || bends.then(|| ElasticFrame::reduce(&machine, host)).transpose(),
            );
            (fidelity.elastic, fidelity.frame) = (Some(discs?), frame?);
        }
        if bends || (machine.duty_tilts() && options.joints.value == Joints::Bearings) {
            fidelity.tilt = Some(TiltingOutput::of(&machine, OutputForces::default()));
        }
        Ok(fidelity)
    }

    /// Applies external forces to the output of a machine.
    ///
    /// # Errors
    /// [`AnalysisError::Usage`] with ideal joints, in which the output cannot tilt.
    pub(crate) fn push_output(
        &mut self,
        machine: &Machine,
        forces: OutputForces,
    ) -> Result<(), AnalysisError> {
        if forces.is_zero() {
            return Ok(());
        }
        if self.joints == Joints::Ideal {
            return Err(AnalysisError::usage(
                "ideal joints do not support forces that tilt the output",
                "choose joints = bearings",
            ));
        }
        self.tilt = Some(TiltingOutput::of(machine, forces));
        Ok(())
    }

    fn take_errors(
        &mut self,
        design: &Design,
        machine: &Machine,
        options: &FidelityOptions,
        host: &dyn Host,
    ) -> Result<(), AnalysisError> {
        let given = design.given_errors();
        if options.joints.value == Joints::Ideal {
            if matches!(options.errors, Some(ErrorSource::Given | ErrorSource::Drawn)) {
                return Err(AnalysisError::usage(
                    "ideal joints do not support manufacturing errors",
                    "choose joints = bearings",
                ));
            }
            self.errors_left_out = options.errors.is_none() && given.is_some();
        } else {
            self.source = options.errors.unwrap_or(match given {
                Some(_) => ErrorSource::Given,
                None => ErrorSource::None,
            });
        }
        if options.seed.is_some() && self.source != ErrorSource::Drawn {
            return Err(AnalysisError::usage(
                "a seed needs drawn errors",
                "add errors = drawn, or remove the seed",
            ));
        }
        match self.source {
            ErrorSource::None => {}
            ErrorSource::Given => {
                self.errors = given.ok_or_else(|| {
                    AnalysisError::usage(
                        "the design gives no manufacturing errors",
                        "add a section [errors]; `arcmin keys errors` lists its keys",
                    )
                })?;
                for flank in design.measured_flanks() {
                    let file = InputFile(flank.file.clone());
                    let bytes = host.read(&file, Origin::Design)?;
                    let measured =
                        crate::analyses::inputs::measured_flank(&file, &bytes, machine.ring.pin_count - 1)?;
                    if self.errors.discs.len() <= flank.disc {
                        self.errors.discs.resize_with(flank.disc + 1, Default::default);
                    }
                    self.errors.discs[flank.disc].flank.measured = measured.measured;
                }
            }
            ErrorSource::Drawn => {
                let tolerances = design.drawing_tolerances().ok_or_else(|| {
                    AnalysisError::usage(
                        "the design gives no tolerances to draw from",
                        "add a section [tolerances]; `arcmin keys tolerances` lists its keys",
                    )
                })?;
                let seed = options.seed.unwrap_or(1) as u64;
                self.seed = Some(seed);
                self.errors = match options.batch_seed {
                    Some(batch) => {
                        let batch = Batch { seed: batch as u64, share: options.batch_share };
                        ManufacturingErrors::draw_from_batch(machine, &tolerances, seed, batch)
                    }
                    None => ManufacturingErrors::draw(machine, &tolerances, seed),
                };
            }
        }
        Ok(())
    }

    /// The same without manufacturing errors.
    pub fn nominal(&self) -> Fidelity {
        Fidelity {
            errors: ManufacturingErrors::default(),
            source: ErrorSource::None,
            seed: None,
            ..self.clone()
        }
    }

    /// Another machine of the same series.
    pub fn with_errors(&self, errors: ManufacturingErrors, seed: u64) -> Fidelity {
        Fidelity { errors, source: ErrorSource::Drawn, seed: Some(seed), ..self.clone() }
    }

    /// Load sharing of the machine with new surfaces.
    ///
    /// # Errors
    /// [`AnalysisError`] if the machine has no such model.
    pub fn meshing(&self, machine: &Machine) -> Result<MachineMeshing, AnalysisError> {
        Ok(match (self.joints, &self.elastic) {
            (Joints::Ideal, None) => MachineMeshing::Ideal(machine.meshing(&Relief::uniform(0.0))),
            (Joints::Ideal, Some(elastic)) => {
                let discs = elastic.reduced().clone();
                MachineMeshing::Elastic(Box::new(machine.flexible_meshing(&Relief::uniform(0.0), discs)))
            }
            (Joints::Bearings, _) => MachineMeshing::Bearings(Box::new(self.in_bearings(machine)?)),
        })
    }

    /// The whole machine in its bearings, also if the option `joints` is ideal.
    ///
    /// # Errors
    /// [`AnalysisError`] if the machine has no such model.
    pub fn in_bearings(&self, machine: &Machine) -> Result<BearingMeshing, AnalysisError> {
        BearingMeshing::new(machine, &self.joint_settings()?)
            .map_err(AnalysisError::compute("set up the machine in its bearings"))
    }

    /// [`Fidelity::meshing`] in steady running at rated speed, with the machine's friction.
    ///
    /// # Errors
    /// [`AnalysisError`] with ideal joints, which have no model of friction, or if the machine has no such model.
    pub fn running_meshing(&self, machine: &Machine) -> Result<MachineMeshing, AnalysisError> {
        if self.joints == Joints::Ideal {
            return Err(AnalysisError::usage(
                "ideal joints do not support friction",
                "choose joints = bearings",
            ));
        }
        let meshing = BearingMeshing::running(machine, &self.joint_settings()?)
            .map_err(AnalysisError::compute("set up the machine in its bearings"))?;
        Ok(MachineMeshing::Bearings(Box::new(meshing)))
    }

    /// Settings of the multibody model in bearings, new surfaces.
    ///
    /// # Errors
    /// [`AnalysisError`] if one rigid spider connects all bores: the bearings then cannot displace each bore.
    pub fn joint_settings(&self) -> Result<JointSettings, AnalysisError> {
        let discs = self.free_discs()?;
        let (errors, tilt) = (self.errors.clone(), self.tilt.clone());
        let settings = JointSettings { errors, discs, tilt, ..JointSettings::default() };
        Ok(match &self.frame {
            Some(frame) => frame.on(settings),
            None => settings,
        })
    }

    /// Elastic discs whose bores move independently. `None` (rigid discs) if one rigid spider connects the bores and the
    /// joints are ideal: bearings cannot displace single bores of such a disc.
    fn free_discs(&self) -> Result<Option<ElasticDiscs>, AnalysisError> {
        match &self.elastic {
            None => Ok(None),
            Some(elastic) if elastic.bores_are_tied() && self.joints == Joints::Ideal => Ok(None),
            Some(elastic) => elastic.free().map(|discs| Some(discs.clone())),
        }
    }

    /// Entries of every summary with the joints, bodies and errors of the model.
    pub(crate) fn entries<O: HasFidelity>() -> Vec<Column<O>> {
        vec![
            q::JOINTS.of(|o: &O| o.fidelity().joints.word().into()),
            q::DISCS.of(|o: &O| o.fidelity().discs_word().into()),
            q::BODIES.of(|o: &O| o.fidelity().bodies_word().into()),
            q::ERRORS_SOURCE.of(|o: &O| o.fidelity().source.word().into()),
            q::ERRORS_SEED.of(|o: &O| Value::from(o.fidelity().seed)),
        ]
    }

    pub(crate) fn discs_word(&self) -> &'static str {
        if self.elastic.is_some() { "elastic" } else { "rigid" }
    }

    pub(crate) fn bodies_word(&self) -> &'static str {
        if self.frame.is_some() { "elastic" } else { "rigid" }
    }

    /// Joints, bodies and errors of the model, in words for terminal and report.
    pub fn sentence(&self) -> String {
        let joints = match self.joints {
            Joints::Ideal => "ideal joints (no bearing clearance, no compliance but that of the teeth)",
            Joints::Bearings => "every body in its bearings",
        };
        let discs = match (&self.frame, &self.elastic) {
            (Some(_), _) => "elastic discs, carrier and housing",
            (None, Some(_)) => "elastic discs",
            (None, None) => "rigid discs",
        };
        let errors = match (self.source, self.seed) {
            (ErrorSource::None, _) if self.errors_left_out => {
                ", the design's [errors] left out: they enter with joints = bearings".to_owned()
            }
            (ErrorSource::None, _) => ", nominal machine".to_owned(),
            (ErrorSource::Given, _) => ", manufacturing errors of the design".to_owned(),
            (ErrorSource::Drawn, seed) => {
                format!(", machine drawn from the tolerances with seed {}", seed.unwrap_or(1))
            }
        };
        let tilts = match &self.tilt {
            Some(tilt) if !tilt.forces.is_zero() => ", leaning under forces from outside",
            _ => "",
        };
        format!("{joints}, {discs}{tilts}{errors}")
    }

    /// Seeds of everything drawn.
    pub fn seeds(&self) -> Vec<u64> {
        self.seed.into_iter().collect()
    }
}

/// Outcomes that contain the fidelity of their model.
pub(crate) trait HasFidelity {
    fn fidelity(&self) -> &Fidelity;
}
