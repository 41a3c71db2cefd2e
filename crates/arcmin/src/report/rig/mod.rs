//! The page of the test bench: loop, stiffness split, efficiency map, transmission error with named orders,
//! bearing loads.

mod figures;
mod losses;

pub(crate) use figures::{Loops, hysteresis, loop_figures};

use super::{Block, KeyFigure, Page, Provenance, Section, Tone, Verdict, compact, literature, significant};
use crate::dynamics::Part;
use crate::dynamics::labels::PIN_RING;
use crate::machine::Machine;
use crate::rig::{BearingLoad, MeasuredOnBench, NamedOrder, RigState};
use crate::units::{ARCMIN, HOUR};

/// Results of a bench run, lent for rendering.
#[derive(Debug, Clone)]
pub struct RigPage<'a> {
    /// Machine on the bench.
    pub machine: &'a Machine,
    /// Version, design, command and seeds.
    pub provenance: Provenance,
    /// Results of the new machine.
    pub new: &'a RigState,
    /// Results after some hours of wear; `None` if not requested.
    pub worn: Option<&'a RigState>,
    /// Curves of a real bench beside them.
    pub measured: Option<&'a MeasuredOnBench>,
    /// Sentence about the source of the manufacturing errors; `None` for the nominal machine.
    pub errors: Option<String>,
    /// Whether the design gives no friction and some was assumed.
    pub friction_assumed: bool,
}

impl RigPage<'_> {
    /// The page, ready to be rendered.
    pub fn page(&self) -> Page {
        Page {
            title: self.machine.name.clone(),
            subtitle: "Virtual test bench".into(),
            provenance: self.provenance.clone(),
            verdict: self.verdict(),
            sections: self.sections(),
        }
    }

    fn state(&self) -> &RigState {
        self.worn.unwrap_or(self.new)
    }

    fn verdict(&self) -> Verdict {
        let state = self.state();
        let lost = state.lost_motion();
        let limit = self.machine.limits.lost_motion;
        let shortest = state.bearings.iter().min_by(|a, b| a.life_h().total_cmp(&b.life_h()));
        let planned = self.machine.limits.service_life / HOUR;
        let tired = shortest.filter(|bearing| bearing.life_h() < planned);
        let tone = if lost <= limit && tired.is_none() { Tone::Good } else { Tone::Bad };
        let age = match self.worn {
            Some(worn) => format!("after {} h", compact(worn.hours, 6)),
            None => "when new".to_owned(),
        };
        let mut headline = format!(
            "Lost motion {age}, {} arcmin, {} the limit of {} arcmin.",
            significant(lost / ARCMIN, 3),
            if lost <= limit { "stays within" } else { "exceeds" },
            significant(limit / ARCMIN, 3)
        );
        if let Some(bearing) = tired {
            headline.push_str(&format!(
                " The bearing “{}” lasts {} h (L10) at rated torque and speed; {} h are planned.",
                bearing.name,
                compact(bearing.life_h().round(), 6),
                compact(planned, 6)
            ));
        }
        let mut verdict = Verdict::new(tone, headline);
        let figure = |label: &str, value: f64, unit: &str, note: &str| {
            KeyFigure::new(label, significant(value, 3), unit, note)
        };
        verdict.figures = vec![
            figure(
                "Lost motion",
                lost / ARCMIN,
                "arcmin",
                &format!("{age}, between the mid-points at ± 3 % of rated torque"),
            ),
            figure(
                "Backlash",
                state.backlash() / ARCMIN,
                "arcmin",
                &format!("{age}, width of the loop at zero torque"),
            ),
            figure(
                "Torsional stiffness",
                state.stiffness() * ARCMIN,
                "N·m/arcmin",
                &format!("{age}, slope between 50 and 100 % of rated torque"),
            ),
        ];
        let efficiency = state.efficiency.as_ref().map(|map| 100.0 * map.rated);
        verdict.figures.extend(
            efficiency.map(|e| figure("Efficiency", e, "%", &format!("{age}, at rated torque and speed"))),
        );
        let softest = state.split.parts.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        verdict.answers.extend(softest.map(|(part, c)| {
            (
                "Largest compliance".to_owned(),
                format!(
                    "{}, {} % of the compliance",
                    part.name(),
                    significant(100.0 * c / state.split.whole, 2)
                ),
            )
        }));
        let life = |b: &BearingLoad| {
            format!("{}: L10h {} h at rated torque and speed", b.name, significant(b.life_h(), 3))
        };
        verdict.answers.extend(shortest.map(|b| ("Bearing with the shortest life".to_owned(), life(b))));
        let order = |o: &NamedOrder| {
            format!("order {}, {} arcsec: {}", o.order, significant(60.0 * o.amplitude / ARCMIN, 3), o.cause)
        };
        verdict.answers.extend(
            state
                .orders
                .first()
                .map(|o| ("Strongest order of the transmission error at rated torque".to_owned(), order(o))),
        );
        verdict
    }

    /// The sections, for this page or as part of another: loop, stiffness split, efficiency, transmission
    /// error, bearings.
    pub fn sections(&self) -> Vec<Section> {
        let mut states = vec![("new".to_owned(), self.new)];
        states.extend(self.worn.map(|worn| (format!("{} h", compact(worn.hours, 6)), worn)));
        let state = self.state();
        let of = match self.worn {
            Some(worn) => format!(" after {} h", compact(worn.hours, 6)),
            None => String::new(),
        };
        let loops: Vec<Loops<'_>> = states
            .iter()
            .map(|(name, state)| Loops { name: name.clone(), loops: &state.loops, figures: &state.figures })
            .collect();
        let mut bench = hysteresis(self.machine.rated.torque.abs(), &loops, self.measured);
        bench.push(loop_figures(&loops, self.measured));
        if let Some(measured) = self.measured.filter(|measured| !measured.remarks.is_empty()) {
            bench.push(Block::Note(
                Tone::Neutral,
                format!("Measured curves. {}.", measured.remarks.join(". ")),
            ));
        }
        if let Some(errors) = &self.errors {
            bench.push(Block::Note(Tone::Neutral, errors.clone()));
        }
        if self.friction_assumed {
            bench.push(Block::Note(
                Tone::Caution,
                format!(
                    "The design gives no friction. Width of the loop, efficiency and running torques are computed \
                         with assumed coefficients: {}.",
                    assumed_coefficients(self.machine)
                ),
            ));
        }
        let has = |part: Part| state.split.parts.iter().any(|(p, _)| *p == part);
        let rigid = match (has(PIN_RING), has(Part::DISC)) {
            (true, _) => {
                "The solids of carrier and housing are scaled from the pin circle where the design does not give them. Rings of the main bearings are \
                 rigid and bolts do not slip: a real reducer is more compliant by their share."
            }
            (false, true) => {
                "Bearing rings, carrier plates and housing are rigid; a real reducer is more compliant by their \
                     share (--bodies elastic)."
            }
            (false, false) => {
                "Bearing rings, bodies of the discs, carrier plates and housing are rigid; a real reducer is more \
                     compliant by their share (--discs elastic, --bodies \
                 elastic)."
            }
        };
        let split = vec![
            figures::stiffness_split(state),
            Block::Note(
                Tone::Neutral,
                format!(
                    "Bearings, shafts and supports are assumptions where the design file says so. {rigid} `[carrier] \
                     torsional_stiffness_n_m_per_arcmin` and `[ring] seat_compliance_um_per_kn` take measured values."
                ),
            ),
        ];
        vec![
            Section::new("loop", "Hysteresis loop, input locked", bench),
            Section::new("stiffness", format!("Stiffness by part{of}"), split),
            Section::new(
                "losses",
                format!("Efficiency and running torques{of}"),
                losses::blocks(self.machine, state),
            ),
            Section::new(
                "error",
                format!("Transmission error{of}"),
                figures::transmission(state, self.measured),
            ),
            Section::new("bearings", format!("Bearing loads and life{of}"), figures::bearings(state)),
            literature(&["Harris2006", "ISO281", "Palmgren", "Linke", "GBT35089"]),
        ]
    }
}

/// Coefficients that [`assumed_friction`](crate::rig::assumed_friction) takes.
pub fn assumed_coefficients(machine: &Machine) -> String {
    let f = &machine.friction;
    format!(
        "flank {}, bearings {}, gear mesh {}, seals {} N·m, oil {} N·m·s",
        f.flank,
        f.bearing,
        f.gear_mesh,
        significant(f.seal_drag, 3),
        significant(f.oil_drag, 2)
    )
}
