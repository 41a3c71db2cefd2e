//! Effects of the uncertain inputs of an RV reducer.

use super::band::{BandResults, Inputs};
use super::bearings::lives_in_friction;
use crate::analyses::rig::with_friction;
use crate::analyses::stage::AnyDesign;
use crate::analyses::{AnalysisError, Host};
use crate::design::{Design, Value as Written};
use crate::fidelity::Fidelity;
use crate::life::{Prediction, WornState};
use crate::load::{Cycle, ShareLoad};
use crate::machine::{Machine, WearCoefficient};
use crate::units::{ARCMIN, MPA};
use crate::wear::{CoupledOptions, CoupledWear};

/// Crank positions for lost motion, loads and bearings: only differences matter.
const LIGHT: usize = 12;
pub(in crate::analyses) const LOADED: usize = 18;

/// Effects of the inputs of an RV reducer. Bodies are rigid: elastic ones take ten times as long. On the RV-40E they give a band of
/// bearing life of 4100 to 7000 h in place of 1100 to 6700 h.
///
/// # Errors
/// As [`Inputs::evaluate`].
pub(super) fn inputs_of(
    design: &Design,
    fidelity: &Fidelity,
    prediction: &Prediction,
    host: &dyn Host,
) -> Result<Inputs, AnalysisError> {
    let states = states_of(prediction);
    let rigid = Fidelity { elastic: None, frame: None, ..fidelity.clone() };
    let evaluation = Evaluation { fidelity: &rigid, states: &states };
    // A separate finding reports ranges that exclude the value of the design.
    let free = design.with("unknowns", Written::LeftOut).unwrap_or_else(|_| design.clone());
    let free = in_friction(&free);
    let present = free.machine();
    let stations = states.iter().map(|state| state.hours).collect();
    let free = AnyDesign::from(free);
    let results_of = |moved: &AnyDesign| {
        let machine = moved.rv("bands of the life")?.machine();
        if rests_alike(&machine, &present) { Ok(None) } else { evaluation.at(&machine).map(Some) }
    };
    Inputs::evaluate(design.unknowns(), (&free, &evaluation.at(&present)?), stations, results_of, host)
}

/// States in which drives are evaluated: new, in the middle and at the end of the service life, and where the search for the
/// limit of lost motion ended.
pub(in crate::analyses) fn states_of(prediction: &Prediction) -> Vec<&WornState> {
    let points = &prediction.points;
    let mut states: Vec<&WornState> = vec![&points[0].state];
    states.extend([points.len() / 2, points.len() - 1].map(|index| &points[index].state));
    states.extend(&prediction.beyond);
    states.dedup_by(|a, b| a.hours == b.hours);
    states
}

/// The design with the friction in its bearing lives: its own, or the assumed one. Otherwise a single coefficient
/// other than zero would replace all assumed ones.
fn in_friction(design: &Design) -> Design {
    let (rough, assumed) = with_friction(&design.machine(), false);
    if !assumed {
        return design.clone();
    }
    let f = &rough.friction;
    let keys = [
        ("friction.flank_coefficient", f.flank),
        ("friction.pin_seat_coefficient", f.pin_seat),
        ("friction.bearing_coefficient", f.bearing),
        ("friction.gear_mesh_coefficient", f.gear_mesh),
        ("friction.seal_drag_n_m", f.seal_drag),
        ("friction.oil_drag_n_m_s_per_rad", f.oil_drag),
    ];
    design.with_all(keys).unwrap_or_else(|_| design.clone())
}

/// Whether two machines are the same in static equilibrium: masses and damping have an effect in motion only.
fn rests_alike(a: &Machine, b: &Machine) -> bool {
    let mut a = a.clone();
    a.disc.mass = b.disc.mass;
    a.disc.inertia = b.disc.inertia;
    (a.crankshafts.mass, a.crankshafts.inertia) = (b.crankshafts.mass, b.crankshafts.inertia);
    (a.carrier.mass, a.carrier.inertia) = (b.carrier.mass, b.carrier.inertia);
    a.housing = b.housing;
    a.gear_stage.mesh_damping = b.gear_stage.mesh_damping;
    a.gear_stage.sun_inertia = b.gear_stage.sun_inertia;
    a.gear_stage.motor_inertia = b.gear_stage.motor_inertia;
    a.contact_damping = b.contact_damping;
    // These analyses with rigid bodies do not use the other keys.
    a.solids.carrier = b.solids.carrier.clone();
    a.solids.housing = b.solids.housing.clone();
    a == *b
}

/// States in which machines are evaluated.
struct Evaluation<'a> {
    fidelity: &'a Fidelity,
    states: &'a [&'a WornState],
}

impl Evaluation<'_> {
    fn at(&self, machine: &Machine) -> Result<BandResults, AnalysisError> {
        let failed = || AnalysisError::compute("compute the effects of the uncertain inputs on the life");
        let mut in_bearings = self.fidelity.in_bearings(machine)?;
        let mut meshing = self.fidelity.meshing(machine)?;
        let contact = machine.line_contact();
        let mut results = BandResults::of_rings(1);
        for state in self.states {
            state.apply_to(&machine.designed_relief(), &mut in_bearings);
            results.lost_motion.push(in_bearings.lost_motion(LIGHT).map_err(failed())? / ARCMIN);
            state.apply_to(&machine.designed_relief(), &mut meshing);
            let cycle: Cycle =
                meshing.loaded_cycle(machine.largest_signed_torque(), LOADED).map_err(failed())?;
            results.pressure[0].push(cycle.max_pressure(&contact) / MPA);
            results.transmission_error.push(cycle.peak_to_peak_error().arcmin());
            if machine.limits.backlash.is_some() {
                let free = meshing.free_cycle(machine.rated.torque, LIGHT).map_err(failed())?;
                results.backlash.push(free.mean_free_travel().arcmin());
            }
        }
        // A calibrated coefficient gives the same wear for any other inputs.
        if let WearCoefficient::Given(coefficient) = machine.wear.coupled {
            let middle = &self.states[self.states.len() / 2].surfaces;
            let joints = self.fidelity.meshing(machine)?;
            let rate = CoupledWear::with(machine, joints, CoupledOptions::default())
                .mean_rate(middle)
                .map_err(AnalysisError::wear("compute the effects of the uncertain inputs on the wear"))?;
            results.wear = coefficient * rate;
        }
        let settings = self.fidelity.joint_settings()?;
        if let Some(worst) = lives_in_friction(machine, &settings, LIGHT)?.worst() {
            results.bearing = worst.life_h;
        }
        Ok(results)
    }
}
