//! Tables and figures of load sharing.

use super::closed_form::Pair;
use super::{Answer, ArmRoller, Contact, Equilibrium};
use crate::analyses::errors_table;
use crate::contact::PinContact;
use crate::fidelity::Fidelity;
use crate::load::{Cycle, HarmonicError, LoadSharing, PinLoad};
use crate::results::{
    DeclaredTable, PLAIN, SummaryOf, Table, TableOf, Value, decimals, digits, quantities as q, quantity,
};
use crate::units::{ARCMIN, DEG, MPA, UM};
use std::f64::consts::TAU;

/// One contact of pin and disc, by either method.
struct Row {
    crank_angle: f64,
    pair: Pair,
}

const CONTACT: TableOf<Row> = TableOf {
    name: "contact",
    what: "One row per pin, disc and crank position",
    columns: || {
        vec![
            q::CRANK_ANGLE.of(|r: &Row| r.crank_angle.into()),
            q::DISC.of(|r| r.pair.disc.into()),
            q::PIN.of(|r| r.pair.pin.into()),
            q::MESHING_ANGLE.of(|r| (r.pair.meshing_angle / DEG).into()),
            q::FORCE.of(|r| r.pair.force.into()),
            q::PRESSURE.of(|r| (r.pair.pressure / MPA).into()),
            quantity("half_width_um", decimals(1), "Half width of the Hertz contact.")
                .of(|r| (r.pair.half_width / UM).into()),
            quantity(
                "gap_um",
                decimals(3),
                "Gap between pin and flank along their normal; negative is penetration. With the closed form the \
                     gap before loading.",
            )
            .of(|r| (r.pair.gap / UM).into()),
        ]
    },
};

const ERROR: TableOf<LoadSharing> = TableOf {
    name: "error",
    what: "One row per crank position: output error and stiffness",
    columns: || {
        vec![
            q::CRANK_ANGLE.of(|s: &LoadSharing| s.crank_angle.degrees().into()),
            q::TE_LOADED.of(|s| s.output_error.arcmin().into()),
            q::TORSIONAL_STIFFNESS.of(|s| s.stiffness.map(|stiffness| stiffness * ARCMIN).into()),
        ]
    },
};

const HARMONICS: TableOf<HarmonicError> = TableOf {
    name: "harmonics",
    what: "One row per harmonic of the loaded error (ideal joints)",
    columns: || {
        vec![
            q::ORDER.of(|h: &HarmonicError| h.order.into()),
            q::AMPLITUDE.of(|h| (h.amplitude / ARCMIN).into()),
        ]
    },
};

const PINS: TableOf<PinLoad> = TableOf {
    name: "pins",
    what: "One row per pin and disc: loads over one full period (machines with manufacturing errors)",
    columns: || {
        vec![
            q::DISC.of(|p: &PinLoad| p.disc.into()),
            q::PIN.of(|p| p.pin.into()),
            q::MAX_FORCE.of(|p| p.max_force.into()),
            quantity("at_meshing_angle_deg", decimals(1), "Meshing angle at which its force is largest.")
                .of(|p| (p.max_force_at / DEG).into()),
            quantity("mean_force_n", decimals(1), "Mean force, the unloaded positions included.")
                .of(|p| p.mean_force.into()),
            quantity("loaded_share", decimals(3), "Share of the positions at which the pin carries force.")
                .of(|p| p.loaded_share.into()),
        ]
    },
};

/// Name of the table of rolling elements.
pub(super) const ROLLERS: &str = "turning_arm_rollers";

const ARM_ROLLERS: TableOf<ArmRoller> = TableOf {
    name: ROLLERS,
    what: "One row per loaded rolling element of a turning-arm bearing and crank position (joints: bearings)",
    columns: || {
        vec![
            q::CRANK_ANGLE.of(|r: &ArmRoller| (r.crank_angle / DEG).into()),
            quantity("crankshaft", digits(3), "Crankshaft, counted from 0.").of(|r| r.crankshaft.into()),
            q::DISC.of(|r| r.disc.into()),
            q::ROLLER.of(|r| r.roller.into()),
            q::ROLLER_DIRECTION.of(|r| (r.direction.rem_euclid(TAU) / DEG).into()),
            q::FORCE.of(|r| r.force.into()),
        ]
    },
};

pub(crate) fn tables() -> Vec<DeclaredTable> {
    vec![
        CONTACT.into(),
        ARM_ROLLERS.into(),
        ERROR.into(),
        HARMONICS.into(),
        PINS.into(),
        errors_table::TABLE.into(),
    ]
}

pub(super) fn fill(contact: &Contact) -> Vec<Table> {
    match &contact.answer {
        Answer::ClosedForm(answer) => {
            let rows: Vec<Row> =
                answer.pairs.iter().map(|pair| Row { crank_angle: 0.0, pair: *pair }).collect();
            vec![CONTACT.fill(&rows)]
        }
        Answer::Equilibrium(answer) => {
            let law = contact.machine.line_contact();
            let pair = |disc: usize, c: &PinContact| {
                let radius = 1.0 / c.relative_curvature;
                Pair {
                    disc,
                    pin: c.pin,
                    meshing_angle: c.meshing_angle,
                    force: c.force,
                    pressure: law.pressure(c.force, radius),
                    half_width: law.half_width(c.force, radius),
                    gap: c.gap,
                }
            };
            let rows: Vec<Row> = answer
                .contacts()
                .map(|(sharing, disc, c)| Row {
                    crank_angle: sharing.crank_angle.degrees(),
                    pair: pair(disc, c),
                })
                .collect();
            let mut tables = vec![CONTACT.fill(&rows), ERROR.fill(&answer.turn)];
            if !answer.turning_arm_rollers.is_empty() {
                tables.push(ARM_ROLLERS.fill(&answer.turning_arm_rollers));
            }
            if !answer.harmonics.is_empty() {
                tables.push(HARMONICS.fill(&answer.harmonics));
            }
            if !answer.pins.is_empty() {
                tables.push(PINS.fill(&answer.pins));
            }
            tables.extend(errors_table::table(&contact.fidelity));
            tables
        }
    }
}

pub(crate) const SUMMARY: SummaryOf<Contact> = SummaryOf {
    entries: || {
        let mut entries = vec![
            q::METHOD.of(|o: &Contact| match o.answer {
                Answer::Equilibrium(_) => "equilibrium".into(),
                Answer::ClosedForm(_) => "closed-form".into(),
            }),
            q::TORQUE.of(|o| o.torque.into()),
            quantity("friction", PLAIN, "Whether friction took part, as in steady running.")
                .of(|o| o.friction.is_some().into()),
            q::HOURS.of(|o| o.worn.hours.into()),
            q::WEAR_UM.of(|o| (o.worn.deepest() / UM).into()),
            q::MAX_FORCE.of(|o| o.max_force().into()),
            q::LOADED_PAIRS
                .of(|o| o.either(|e| e.cycle.loaded_pairs(), |h| h.solution.loaded_pairs() as f64)),
            q::MAX_PRESSURE.of(|o| {
                let law = o.machine.line_contact();
                o.either(|e| e.cycle.max_pressure(&law) / MPA, |h| h.max_pressure() / MPA)
            }),
            q::TE_LOADED.of(|o| o.of_equilibrium(|e| e.cycle.mean_error().arcmin())),
            q::TE_LOADED_PEAK_TO_PEAK.of(|o| o.of_equilibrium(|e| e.cycle.peak_to_peak_error().arcmin())),
            q::PLAY.of(|o| o.either(|e| e.cycle.mean_play().arcmin(), |h| h.play.arcmin())),
            q::FREE_TRAVEL.of(|o| o.of_equilibrium(|e| e.cycle.mean_free_travel().arcmin())),
            q::PRELOAD.of(|o| o.of_equilibrium(|e| e.cycle.max_preload())),
            q::PRELOAD_FRICTION
                .of(|o| o.of_equilibrium(|e| e.cycle.preload_friction_torque(o.machine.flank_friction()))),
            q::TORSIONAL_STIFFNESS.of(|o| o.of_equilibrium(|e| e.stiffness() * ARCMIN)),
            quantity("disc_torque_shares", decimals(4), "Share of every disc in the output torque.").of(
                |o| match &o.answer {
                    Answer::Equilibrium(e) => {
                        Value::list((0..o.machine.disc_count).map(|disc| e.cycle.disc_share(disc)))
                    }
                    Answer::ClosedForm(_) => Value::Absent,
                },
            ),
            quantity("mean_over.crank_positions", PLAIN, "Crank positions that the figures are taken over.")
                .of(|o| o.counted(|e| e.cycle.positions.len())),
            quantity("mean_over.pin_pitches", PLAIN, "Full period in pin pitches of crank angle.")
                .of(|o| o.counted(|e| e.pitches)),
            quantity("largest_torque_residual_n_m", digits(2), "Largest residual torque of the equilibrium.")
                .of(|o| {
                    let largest = |e: &Equilibrium| {
                        e.cycle.positions.iter().map(|p| p.residual.abs()).fold(0.0, f64::max)
                    };
                    o.of_equilibrium(largest)
                }),
            q::MAX_FORCE.named("nominal.max_force_n").of(|o| o.nominal(Cycle::max_force)),
            q::LOADED_PAIRS.named("nominal.loaded_pairs").of(|o| o.nominal(Cycle::loaded_pairs)),
            q::TE_LOADED.named("nominal.te_loaded_arcmin").of(|o| o.nominal(|c| c.mean_error().arcmin())),
            q::PLAY.named("nominal.play_arcmin").of(|o| o.nominal(|c| c.mean_play().arcmin())),
            quantity("closed_form.max_pair_force_n", decimals(2), "Largest force of a pair in closed form.")
                .of(|o| o.of_handbook(|h| h.largest_pair())),
            quantity("closed_form.first_guess_n", decimals(2), "Largest force before the first iteration.")
                .of(|o| o.of_handbook(|h| h.first_guess)),
            quantity("closed_form.max_approach_um", decimals(3), "Approach at the largest force.")
                .of(|o| o.of_handbook(|h| h.solution.max_approach / UM)),
            quantity(
                "closed_form.smallest_initial_gap_um",
                decimals(3),
                "Smallest gap before loading. If negative, the closed form is not valid; use equilibrium.",
            )
            .of(|o| o.of_handbook(|h| h.solution.smallest_gap() / UM)),
        ];
        entries.extend(Fidelity::entries());
        entries
    },
};

impl Contact {
    fn either(
        &self,
        equilibrium: impl Fn(&Equilibrium) -> f64,
        handbook: impl Fn(&super::closed_form::Handbook) -> f64,
    ) -> Value {
        match &self.answer {
            Answer::Equilibrium(answer) => equilibrium(answer).into(),
            Answer::ClosedForm(answer) => handbook(answer).into(),
        }
    }

    fn of_equilibrium(&self, value: impl Fn(&Equilibrium) -> f64) -> Value {
        match &self.answer {
            Answer::Equilibrium(answer) => value(answer).into(),
            Answer::ClosedForm(_) => Value::Absent,
        }
    }

    fn counted(&self, value: impl Fn(&Equilibrium) -> usize) -> Value {
        match &self.answer {
            Answer::Equilibrium(answer) => value(answer).into(),
            Answer::ClosedForm(_) => Value::Absent,
        }
    }

    fn of_handbook(&self, value: impl Fn(&super::closed_form::Handbook) -> f64) -> Value {
        match &self.answer {
            Answer::Equilibrium(_) => Value::Absent,
            Answer::ClosedForm(answer) => value(answer).into(),
        }
    }

    fn nominal(&self, value: impl Fn(&Cycle) -> f64) -> Value {
        match &self.answer {
            Answer::Equilibrium(answer) => Value::from(answer.nominal.as_ref().map(value)),
            Answer::ClosedForm(_) => Value::Absent,
        }
    }
}
