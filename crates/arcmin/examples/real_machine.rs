//! Torsional stiffness of the shipped designs with all bodies elastic, part by part, and the range that the
//! assumed dimensions leave: each alone at its limits, all of them there, and as independent spreads.
//!
//! `cargo run --release -p arcmin --example real_machine -- [template] [crank positions]`
//!
//! Nothing is fitted: every dimension stands between limits that are written beside it. Tables in Markdown.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use arcmin::analyses::Host;
use arcmin::design::{Design, Value};
use arcmin::dynamics::labels::CAUSES;
use arcmin::dynamics::{BearingMeshing, Part};
use arcmin::fidelity::{Fidelity, FidelityOptions};
use arcmin::progress::Progress;
use arcmin::rig::stiffness_split;
use arcmin::templates::{TEMPLATES, design};
use arcmin::units::ARCMIN;

type Answer<T> = Result<T, Box<dyn std::error::Error>>;
type Keys = Vec<(String, Value)>;

/// Keeps reductions in memory: a body is reduced once for all designs that share it.
#[derive(Default)]
struct InMemory(Mutex<HashMap<String, Vec<u8>>>);

impl Progress for InMemory {
    fn report(&self, _stage: &str, _share: f64) {}

    fn is_cancelled(&self) -> bool {
        false
    }
}

impl Host for InMemory {
    fn cached(&self, name: &str) -> Option<Vec<u8>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(name).cloned()
    }

    fn cache(&self, name: &str, bytes: &[u8]) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(name.to_owned(), bytes.to_vec());
    }
}

/// A dimension that no catalogue gives, with its soft and its stiff limit.
struct Assumption {
    name: &'static str,
    limits: [(&'static str, Keys); 2],
}

/// The numbers of a design that limits are shares of.
struct Nominal<'a>(&'a Design);

impl Nominal<'_> {
    fn of(&self, key: &str) -> f64 {
        self.0.get(key).ok().and_then(|value| value.as_number()).unwrap_or(f64::NAN)
    }

    /// Keys multiplied by a factor.
    fn scaled(&self, factor: f64, keys: &[&str]) -> Keys {
        keys.iter().map(|key| ((*key).to_owned(), (factor * self.of(key)).into())).collect()
    }

    /// Windows by the rule for those that a design leaves out, with another web (in R_p) to centre hole,
    /// bores and root circle; the pillars keep away from them by eccentricity and 0.02 R_p, as by rule.
    fn windows(&self, web: f64) -> Keys {
        let r = self.of("ring.pin_circle_radius_mm");
        let (web, eccentricity) = (web * r, self.of("crankshafts.eccentricity_mm"));
        let inner = 0.5 * self.of("disc.centre_hole_diameter_mm") + web;
        let outer = r - self.of("ring.pin_radius_mm") - eccentricity - web;
        let reach = 0.5 * self.of("disc.crank_bore_diameter_mm") + web;
        let circle = self.of("crankshafts.circle_radius_mm");
        let count = self.of("crankshafts.count");
        let half = 180.0 / count - (reach / circle).asin().to_degrees();
        let draw_in = eccentricity + 0.02 * r;
        let pillar_inner = inner + draw_in;
        let support = self.of("bearings.crank_support.pitch_diameter_mm")
            + self.of("bearings.crank_support.roller_diameter_mm");
        let beside = 180.0 / count - ((0.5 * support + 0.08 * r) / circle).asin().to_degrees();
        let pillar = (half - (draw_in / pillar_inner).asin().to_degrees()).min(beside);
        let numbers = [
            ("disc.windows[0].inner_radius_mm", inner),
            ("disc.windows[0].outer_radius_mm", outer),
            ("disc.windows[0].angle_deg", self.of("crankshafts.first_angle_deg") + 180.0 / count),
            ("disc.windows[0].width_deg", 2.0 * half),
            ("disc.windows[0].corner_radius_mm", 0.08 * r),
            ("disc.windows[0].count", count),
            ("carrier.solid.pillar_inner_radius_mm", pillar_inner),
            ("carrier.solid.pillar_outer_radius_mm", outer - draw_in),
            ("carrier.solid.pillar_width_deg", 2.0 * pillar),
            ("carrier.solid.pillar_corner_radius_mm", (0.08 * r - draw_in).max(0.02 * r)),
        ];
        numbers.into_iter().map(|(key, value)| (key.to_owned(), value.into())).collect()
    }

    /// Another span of the crank supports; each sits in the middle of its plate.
    fn span(&self, factor: f64) -> Keys {
        let span = factor * self.of("bearings.crank_support_span_mm");
        let gap = (1.1 * (self.of("disc.count") - 1.0) + 1.2) * self.of("disc.width_mm");
        vec![
            ("bearings.crank_support_span_mm".to_owned(), span.into()),
            ("carrier.solid.plate_thickness_mm".to_owned(), (span - gap).into()),
        ]
    }

    fn assumptions(&self) -> Vec<Assumption> {
        const SECTIONS: [&str; 6] = [
            "crankshafts.shaft_diameter_mm",
            "disc.crank_bore_diameter_mm",
            "bearings.turning_arm.pitch_diameter_mm",
            "bearings.turning_arm.roller_diameter_mm",
            "bearings.crank_support.pitch_diameter_mm",
            "bearings.crank_support.roller_diameter_mm",
        ];
        const SHAFT: [&str; 1] = ["crankshafts.shaft_diameter_mm"];
        const ROLLERS: [&str; 2] =
            ["bearings.turning_arm.roller_length_mm", "bearings.crank_support.roller_length_mm"];
        const PLATE: [&str; 1] = ["carrier.solid.plate_thickness_mm"];
        let (r, pin) = (self.of("ring.pin_circle_radius_mm"), 2.0 * self.of("ring.pin_radius_mm"));
        let one = |key: &str, value: Value| vec![(key.to_owned(), value)];
        let groove = |share: f64| one("housing.solid.groove_clearance_um", (1e3 * share * pin).into());
        let clearance = |um: f64| one("bearings.turning_arm.clearance_um", um.into());
        let ring = |share: f64| one("housing.solid.body_diameter_mm", (2.0 * share * r).into());
        let mesh = |factor: f64| self.scaled(factor, &["gear_stage.mesh_stiffness_n_per_um"]);
        let mut over_pillars = self.scaled(0.8, &PLATE);
        over_pillars.extend(one("carrier.solid.hold", "bolts".into()));
        let of = |name, soft, stiff| Assumption { name, limits: [soft, stiff] };
        vec![
            of(
                "web around the windows of the discs, 0.08 R_p",
                ("0.07", self.windows(0.07)),
                ("0.11", self.windows(0.11)),
            ),
            of(
                "diameters of crankshafts and their bearings",
                ("0.93", self.scaled(0.93, &SECTIONS)),
                ("1.07", self.scaled(1.07, &SECTIONS)),
            ),
            of(
                "shaft beside the eccentrics",
                ("0.9", self.scaled(0.9, &SHAFT)),
                ("1.1", self.scaled(1.1, &SHAFT)),
            ),
            of(
                "effective length of rollers",
                ("0.9", self.scaled(0.9, &ROLLERS)),
                ("1.08", self.scaled(1.08, &ROLLERS)),
            ),
            of("span of the crank supports", ("1.1", self.span(1.1)), ("0.92", self.span(0.92))),
            of("clearance of the turning-arm bearings", ("12 µm", clearance(12.0)), ("2 µm", clearance(2.0))),
            of(
                "clearance of pins in their grooves, share of their diameter",
                ("0.5 %", groove(0.005)),
                ("0.03 %", groove(0.0003)),
            ),
            of("outer radius of the ring around the pins", ("1.2 R_p", ring(1.2)), ("1.28 R_p", ring(1.28))),
            of(
                "what holds the housing (16 bolts)",
                ("8 bolts", one("housing.solid.bolt_count", 8_usize.into())),
                ("the whole flange", one("housing.solid.hold", "face".into())),
            ),
            of(
                "plates of the carrier",
                ("0.8 thick, held over the pillars", over_pillars),
                ("1.1", self.scaled(1.1, &PLATE)),
            ),
            of("stiffness of the gear mesh", ("1/1.5", mesh(1.0 / 1.5)), ("1.5", mesh(1.5))),
        ]
    }
}

/// Compliance in arcmin/(N·m), the mean over crank positions: the whole, and every part.
struct Compliance {
    whole: f64,
    parts: Vec<(Part, f64)>,
}

fn fidelity(design: &Design, bodies: &str, host: &InMemory) -> Answer<Fidelity> {
    let options =
        FidelityOptions::parse(&format!("joints = \"bearings\"\nbodies = \"{bodies}\"\n"), "options")?;
    Ok(Fidelity::resolve(design, &options, host)?)
}

fn compliance(design: &Design, fidelity: &Fidelity, positions: usize) -> Answer<Compliance> {
    let (machine, settings) = (design.machine(), fidelity.joint_settings()?);
    let kinematics = machine.kinematics();
    let per_crank = kinematics.ratio() / kinematics.lobe_count;
    let mut mean = Compliance { whole: 0.0, parts: Vec::new() };
    for index in 0..positions {
        // Two crankshafts repeat what they do after half a turn.
        let crank = std::f64::consts::PI * (index as f64 + 0.3) / positions as f64;
        let split = stiffness_split(&machine, &settings, crank * per_crank)?;
        mean.whole += split.whole / ARCMIN / positions as f64;
        if mean.parts.is_empty() {
            mean.parts = split.parts.iter().map(|(part, _)| (*part, 0.0)).collect();
        }
        for ((_, sum), (_, part)) in mean.parts.iter_mut().zip(&split.parts) {
            *sum += part / ARCMIN / positions as f64;
        }
    }
    Ok(mean)
}

fn study(name: &str, positions: usize) -> Answer<()> {
    let plain = design(name).ok_or("no such template")?;
    let host = InMemory::default();
    let found = |design: &Design| compliance(design, &fidelity(design, "elastic", &host)?, positions);
    let rigid = compliance(&plain, &fidelity(&plain, "rigid", &host)?, positions)?;
    let nominal = found(&plain)?;
    println!(
        "## {name}: {:.1} N·m/arcmin; with rigid bodies {:.1}\n",
        1.0 / nominal.whole,
        1.0 / rigid.whole
    );
    println!("| part | 1e-4 arcmin/(N·m) |\n|---|---|");
    for (part, value) in nominal.parts.iter().filter(|(_, value)| *value > 0.0) {
        println!("| {} | {:.2} |", part.name(), 1e4 * value);
    }
    let sum: f64 = nominal.parts.iter().map(|(_, value)| value).sum();
    println!("| sum; from two balances | {:.2}; {:.2} |\n", 1e4 * sum, 1e4 * nominal.whole);
    let mut meshing =
        BearingMeshing::new(&plain.machine(), &fidelity(&plain, "elastic", &host)?.joint_settings()?)?;
    let causes = meshing.lost_motion_causes(positions, &mut Vec::new())?;
    println!("| lost motion by cause | arcmin |\n|---|---|");
    for cause in CAUSES.into_iter().filter(|cause| causes.of(*cause) != 0.0) {
        println!("| {} | {:.4} |", cause.name(), causes.of(cause) / ARCMIN);
    }
    println!("| not explained; whole | {:.5}; {:.4} |\n", causes.residual() / ARCMIN, causes.whole / ARCMIN);
    println!("| assumption | soft | N·m/arcmin | stiff | N·m/arcmin |\n|---|---|---|---|---|");
    let (mut ends, mut squares) = ([plain.clone(), plain.clone()], [0.0; 2]);
    for Assumption { name, limits } in Nominal(&plain).assumptions() {
        let mut cells = String::new();
        for (side, (words, keys)) in limits.into_iter().enumerate() {
            let one = found(&plain.with_all(keys.clone())?)?.whole;
            squares[side] += (one - nominal.whole).powi(2);
            ends[side] = ends[side].with_all(keys)?;
            cells += &format!(" {words} | {:.1} |", 1.0 / one);
        }
        println!("| {name} |{cells}");
    }
    let [low, high] = squares.map(f64::sqrt);
    println!(
        "| as independent spreads (root of squares) | | {:.1} | | {:.1} |",
        1.0 / (nominal.whole + low),
        1.0 / (nominal.whole - high)
    );
    let all = [found(&ends[0])?.whole, found(&ends[1])?.whole];
    println!("| all at their limits at once | | {:.1} | | {:.1} |\n", 1.0 / all[0], 1.0 / all[1]);
    Ok(())
}

fn main() -> Answer<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let positions = arguments.iter().find_map(|word| word.parse().ok()).unwrap_or(4_usize).max(1);
    for template in TEMPLATES {
        if arguments.iter().all(|word| word.parse::<usize>().is_ok() || word == template.name) {
            study(template.name, positions)?;
        }
    }
    Ok(())
}
