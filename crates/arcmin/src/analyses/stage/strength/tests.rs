use super::*;
use crate::analyses::Outcome;
use crate::analyses::propose::{Demand, Process, propose};
use crate::design::{StageDesign, TwoRingDesign, TwoStageDesign, Value};
use crate::templates::{NEMA17_19, TWO_RING_225, TWO_STAGE_500};

fn stage(changes: &[(&str, &str)]) -> StageDesign {
    let text = changes.iter().fold(NEMA17_19.text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    StageDesign::parse(&text, "test.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn printed() -> StageDesign {
    let demand = Demand {
        ratio: 15.0,
        tooth_difference: 1,
        torque: 8.0,
        outer_diameter_mm: 80.0,
        process: Process::PrintedFdm,
        speed_rpm: 600.0,
    };
    StageDesign::parse(&propose(demand, &NoHost).unwrap().text, "printed.toml").unwrap()
}

fn with(design: &StageDesign, path: &str, value: impl Into<Value>) -> StageDesign {
    design.with_all([(path, value)]).unwrap_or_else(|error| panic!("{error}"))
}

fn of(strength: &Strength, bearing: Bearing) -> &Borne {
    strength.borne().iter().find(|one| one.bearing == bearing).unwrap_or_else(|| panic!("{bearing:?}"))
}

/// Stresses against the largest forces that `contact` finds: an output pin that one disc presses is a cantilever, its bending
/// F a 4/(π r³). The largest force of a ring pin, at any point of a lobe, gives at least the stress of the lobes and little more.
#[test]
fn stresses_follow_from_the_forces_of_contact() {
    let design =
        stage(&[("support = \"both-ends\"", "support = \"one-end\""), ("count = 2\n", "count = 1\n")]);
    let strength = Strength::at_largest_torque(&design);
    let contact = contact::run(&design, &contact::Options::of_positions(POSITIONS), &NoHost).unwrap();
    let summary = contact.summary();
    let force = summary.number("max_output_pin_force_n").unwrap();
    let bending = force * 2.5e-3 * 4.0 / (PI * 1.5e-3_f64.powi(3));
    let pins = of(&strength, Bearing::PinBending).stress;
    assert!((pins / bending - 1.0).abs() < 1e-9, "{pins:e} {bending:e}");
    let shear = of(&strength, Bearing::PinShear).stress;
    assert!((shear / (4.0 * force / (3.0 * PI * 1.5e-3_f64.powi(2))) - 1.0).abs() < 1e-9, "{shear:e}");
    let pressure = summary.number("max_pressure_mpa").unwrap() * MPA;
    assert!((of(&strength, Bearing::RingContact).stress / pressure - 1.0).abs() < 1e-9);
    // With one disc all forces of its pins are forces on one beam, and the force on the walls is at most the largest of them.
    let walls = of(&strength, Bearing::WebShear).stress;
    let least = [1.98e-3, 1.49e-3].into_iter().fold(f64::INFINITY, f64::min);
    let eccentric = summary.number("eccentric_bearing_force_n").unwrap();
    assert!(walls < 0.75 * 1.1 * eccentric.max(force) / (least * 5e-3), "{walls:e}");
    let hardest = contact.stages[0].ring.iter().max_by(|a, b| a.force.total_cmp(&b.force)).unwrap();
    let at = |angle: f64| lobe(&design.drive().profile, angle, hardest.force, 5e-3);
    let most = (0..180)
        .map(|degrees| at(f64::from(degrees).to_radians()))
        .fold(SectionStress::default(), SectionStress::or);
    let there = at(hardest.meshing_angle);
    for (bearing, most, there) in
        [(Bearing::LobeBending, most.bending, there.bending), (Bearing::LobeShear, most.shear, there.shear)]
    {
        let lobes = of(&strength, bearing).stress;
        assert!(lobes < 1.001 * most && lobes > 0.999 * there, "{bearing:?} {lobes:e} {most:e} {there:e}");
    }
}

/// At the torque of a limit static equilibria have the stress of the limit; the order is that of the torques.
#[test]
#[ignore = "long"]
fn parts_reach_their_limits_at_their_torques() {
    let strength = Strength::of(&printed());
    let order = strength.order();
    assert!(order.iter().filter(|failure| failure.torque.is_some()).count() >= 4, "{order:?}");
    let torques: Vec<f64> = order.iter().filter_map(|failure| failure.torque).collect();
    assert!(torques.is_sorted(), "{torques:?}");
    for failure in order.iter().filter(|failure| failure.torque.is_some()) {
        let there = loads(&printed(), failure.torque.unwrap()).unwrap().borne;
        let same = there.iter().find(|one| one.bearing == failure.borne.bearing).unwrap();
        assert!((same.share() - 1.0).abs() < 0.03, "{:?} {}", failure.borne, same.share());
    }
}

/// Discs of twice the width have half the stress in bending and shear under the same forces; a stronger material yields at a
/// larger torque; a stress above the strength is an error.
#[test]
#[ignore = "long"]
fn strength_follows_from_width_and_material() {
    let design = printed();
    let strength = Strength::at_largest_torque(&design);
    let weak = with(&design, "disc.material.yield_strength_mpa", 20.0);
    let weakened = Strength::at_largest_torque(&weak);
    for bearing in [Bearing::RingContact, Bearing::LobeShear, Bearing::WebBending] {
        let [one, other] = [&strength, &weakened].map(|strength| of(strength, bearing).clone());
        assert!((one.limit / other.limit - 3.0).abs() < 1e-9, "{bearing:?}");
        assert!((one.stress / other.stress - 1.0).abs() < 1e-12, "{bearing:?}");
    }
    let severity = |design: &StageDesign, code: &str| {
        design.findings().into_iter().find(|finding| finding.code == code).unwrap().severity
    };
    assert_eq!(severity(&design, "wall-strength"), Severity::Info);
    assert_eq!(severity(&weak, "wall-strength"), Severity::Error);
    assert_eq!(severity(&weak, "contact-yield"), Severity::Warning);
    // Without yield strength the discs are not checked, and a finding states this.
    let elastic = Material { yield_strength: None, ..design.disc.material.value.clone() };
    let silent = with(&design, "disc.material", elastic);
    let unknown = Strength::at_largest_torque(&silent);
    assert!(
        unknown
            .borne()
            .iter()
            .all(|one| one.bearing == Bearing::PinBending || one.bearing == Bearing::PinShear)
    );
    assert!(silent.findings().iter().any(|finding| finding.code == "strength-unknown"));
}

/// Losses are those of the efficiency of the bench; at twice the speed they are twice as large, and a motor adds its heat.
#[test]
#[ignore = "long"]
fn losses_leave_the_surface() {
    let design = printed();
    let heat = Strength::at_largest_torque(&design).heat.unwrap();
    let rig = crate::analyses::stage::rig::run(
        &design,
        &crate::analyses::stage::rig::Options::parse("discs = \"rigid\"", "test").unwrap(),
        &NoHost,
    )
    .unwrap();
    let output = 8.0 * 600.0 * PI / 30.0 / 15.0;
    let lost = output * (1.0 / rig.efficiency.forward - 1.0);
    assert!((heat.loss / lost - 1.0).abs() < 0.01, "{} {lost}", heat.loss);
    assert!((heat.temperature - 20.0 - heat.loss / (15.0 * heat.surface)).abs() < 1e-9);
    let changes =
        [("load.input_speed_rpm", 1200.0), ("thermal.motor_heat_w", 8.0), ("thermal.ambient_c", 30.0)];
    let hot = design.with_all(changes).unwrap();
    let hot = Strength::at_largest_torque(&hot);
    let found = hot.heat.as_ref().unwrap();
    assert!((found.loss / heat.loss - 2.0).abs() < 1e-9);
    let rise = (found.loss + 8.0) / (15.0 * heat.surface);
    assert!((found.temperature - 30.0 - rise).abs() < 1e-9);
    let softening = hot.findings().into_iter().find(|finding| finding.code == "softening").unwrap();
    assert!(found.temperature > 55.0 && softening.severity == Severity::Warning, "{softening:?}");
    // Discs of PLA in aluminium: the ring gets tighter, R (α_h − α_d) ΔT.
    let housed = Strength::at_largest_torque(&with(&design, "thermal.housing_expansion_um_per_m_k", 23.6));
    let heat = housed.heat.unwrap();
    let growth = design.drive().ring_circle_radius * (23.6e-6 - 41e-6) * (heat.temperature - 20.0);
    assert!((heat.gap_growth.unwrap() / growth - 1.0).abs() < 1e-12);
}

/// With the output at rest the stresses are the same under z_p/z_c of the torque at the ring.
#[test]
fn a_driven_housing_bears_what_its_pins_bear() {
    let [at_rest, driven] = [
        stage(&[]),
        stage(&[
            ("fixed_member = \"ring\" ", "fixed_member = \"output\" "),
            ("rated_torque_n_m = 3\n", "rated_torque_n_m = 3.1578947368421053\n"),
        ]),
    ];
    let [one, other] = [&at_rest, &driven].map(Strength::at_largest_torque);
    for (a, b) in one.borne().iter().zip(other.borne()) {
        assert!((a.stress / b.stress - 1.0).abs() < 1e-3, "{a:?} {b:?}");
    }
    // Powers: 20/19 of the torque at 19/20 of the speed lose 19/20 as much at the same speed of the input.
    let [one, other] = [one, other].map(|strength| strength.heat.unwrap().loss);
    assert!((other / one - 19.0 / 20.0).abs() < 2e-3, "{other} {one}");
}

/// Every family has an order in which parts fail, with the parts of every stage.
#[test]
fn every_family_has_an_order() {
    let two_ring = TwoRingDesign::parse(TWO_RING_225.text, "two-ring.toml").unwrap();
    let two_stage = TwoStageDesign::parse(TWO_STAGE_500.text, "two-stage.toml").unwrap();
    let all = [
        (Strength::of(&stage(&[])), 8, 1),
        (Strength::of(&two_ring), 10, 2),
        (Strength::of(&two_stage), 16, 2),
    ];
    for (strength, parts, stages) in all {
        let order = strength.order();
        assert_eq!(order.len(), parts);
        assert!((0..stages).all(|k| order.iter().any(|failure| failure.borne.stage == k)));
        let finding =
            strength.findings().into_iter().find(|finding| finding.code == "failure-order").unwrap();
        assert_eq!(Some(finding.value), order[0].torque);
        assert!(finding.value > strength.torque, "{finding:?}");
    }
}
