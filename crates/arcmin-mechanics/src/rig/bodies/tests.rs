use super::super::StiffnessSplit;
use super::super::stiffness_split;
use super::*;
use crate::dynamics::labels::{CARRIER, PIN_RING};
use crate::dynamics::{
    BearingMeshing, ElasticCarrier, ElasticDiscs, ElasticHousing, EquilibriumControl, FlexibleOptions, Part,
    System, TiltingOutput, solve_equilibrium,
};
use crate::fem::DiscShape;
use crate::fem::{BodyShapes, BoreInterface, DiscModel, FlexibleDiscs, FlexibleSettings};
use crate::machine::{FixedMember, Hold, OutputForces};
use crate::progress::Silent;
use crate::templates::{TEMPLATES, tao2024};
use crate::units::ARCMIN;

mod forces;

fn zero(count: usize) -> Compliance {
    Compliance { count, values: vec![0.0; count * count] }
}

fn none(machine: &Machine) -> ElasticBodies {
    let shapes = BodyShapes::of(machine);
    ElasticBodies {
        carrier: zero(shapes.carrier.main_seat(1) + 2),
        housing: zero(shapes.housing.main_seat(1) + 2),
    }
}

/// A carrier with torsional compliance only, C = J Jᵀ/k with J the displacements of the crank seats per angle,
/// adds 1/k; pins with the compliance c in any direction equal pins on seats of the compliance c in the model
/// itself.
#[test]
fn known_compliances_have_the_exact_effect() {
    let machine = tao2024();
    let shapes = BodyShapes::of(&machine);
    let settings = JointSettings::default();
    let mut twisting = none(&machine);
    let (k, n) = (2.0e6, twisting.carrier.count);
    let mut ways = vec![0.0; n];
    for (crank, place) in shapes.carrier.cranks.iter().enumerate() {
        for end in 0..2 {
            let at = shapes.carrier.seat(crank, end);
            (ways[at], ways[at + 1]) = (-place.y, place.x);
        }
    }
    for i in 0..n {
        for j in 0..n {
            twisting.carrier.values[i * n + j] = ways[i] * ways[j] / k;
        }
    }
    let found = body_compliance(&machine, &settings, &twisting, 0.7).unwrap();
    assert!((found.carrier * k - 1.0).abs() < 1e-5 && found.housing == 0.0, "{}", found.carrier * k);
    assert!(found.crank_seats.abs() < 1e-9 * found.carrier);

    let mut seats = none(&machine);
    let (c, n) = (1e-11, seats.housing.count);
    for i in 0..shapes.housing.main_seat(0) {
        seats.housing.values[i * n + i] = c;
    }
    let found = body_compliance(&machine, &settings, &seats, 0.7).unwrap();
    let mut sprung = machine.clone();
    sprung.ring.seat_compliance = c;
    let split = stiffness_split(&sprung, &settings, 0.7).unwrap();
    let own = split.parts.iter().find(|(part, _)| *part == Part::PIN_SEAT).unwrap().1;
    assert!((found.housing / own - 1.0).abs() < 0.01, "{:e} {own:e}", found.housing);
    let stiff = body_compliance(&machine, &settings, &seats.stiffened(1e4), 0.7).unwrap();
    assert!((stiff.housing / found.housing * 1e4 - 1.0).abs() < 1e-9);
    // Grooves without clearance add nothing.
    let mut fitting = machine.clone();
    fitting.solids.housing.groove_clearance = 0.0;
    assert!(found.pin_grooves > 0.0);
    assert_eq!(body_compliance(&fitting, &settings, &seats, 0.7).unwrap().pin_grooves, 0.0);
}

/// Rollers of the supports transmit the torque: the forces on their seats have its moment on the carrier.
#[test]
fn loads_of_the_carrier_balance_the_torque() {
    let machine = tao2024();
    let shapes = BodyShapes::of(&machine);
    let mut model =
        BearingJoints::held(&machine, &JointSettings { damped: false, ..JointSettings::default() }).unwrap();
    model.hold_sun(0.7, 0.0);
    model.set_load(-machine.rated.torque);
    let q = creep(&model, 1e-3, &model.nominal_position_at(0.7)).unwrap();
    let loads = model.carrier_loads(&q);
    assert_eq!(loads.len(), shapes.carrier.main_seat(1) + 2);
    let mut torque = 0.0;
    for (crank, place) in shapes.carrier.cranks.iter().enumerate() {
        for end in 0..2 {
            let at = shapes.carrier.seat(crank, end);
            torque += place.x * loads[at + 1] - place.y * loads[at];
        }
    }
    assert!((torque.abs() / machine.rated.torque - 1.0).abs() < 1e-6, "{torque}");
    // The moment of the pins on the housing is the torque minus that of the sun, about T/i.
    let rest = vec![0.0; q.len()];
    let (_, sun) = model.evaluate_with_input(0.0, &q, &rest, &mut rest.clone(), None);
    assert!((sun.abs() * machine.kinematics().ratio() / machine.rated.torque - 1.0).abs() < 0.01, "{sun}");
    let loads = model.housing_loads(&q);
    assert_eq!(loads.len(), shapes.housing.main_seat(1) + 2);
    let tangential: f64 = loads[..shapes.housing.main_seat(0)].iter().skip(1).step_by(2).sum();
    let moment = tangential.abs() * machine.ring.pin_circle_radius;
    let expected = machine.rated.torque + sun;
    // The line of a contact passes through the pin's centre, on the pin circle, and so does the force due to
    // rolling with variable curvature.
    assert!((moment / expected - 1.0).abs() < 1e-6, "{moment} {expected}");
}

/// Elastic crank seats in the model itself: the parts add up to the whole, the first-order value is slightly
/// larger, and 10⁴ times stiffer seats have no effect.
#[test]
fn elastic_carrier_softens_the_machine() {
    let machine = tao2024();
    let mut bodies = none(&machine);
    let n = bodies.carrier.count;
    for i in 0..n - 4 {
        bodies.carrier.values[i * n + i] = if i % SEAT_COORDINATES > 1 { 2e-10 } else { 1e-9 };
    }
    let carrier = ElasticCarrier::new(&bodies.carrier, machine.crankshafts.count).unwrap();
    let with = |carrier: Option<ElasticCarrier>| {
        let settings = JointSettings { carrier, ..JointSettings::default() };
        stiffness_split(&machine, &settings, 0.7).unwrap()
    };
    let (rigid, soft) = (with(None), with(Some(carrier.clone())));
    assert!(apart(&soft) < 2e-3, "{soft:?}");
    let first = body_compliance(&machine, &JointSettings::default(), &bodies, 0.7).unwrap();
    let (first, added) = (first.carrier + first.crank_seats, soft.whole - rigid.whole);
    assert!(added > 0.8 * first && added < 1.05 * first, "{added:e} {first:e}");
    let stiff = with(Some(carrier.stiffened(1e4).unwrap()));
    assert!((stiff.whole / rigid.whole - 1.0).abs() < 1e-4, "{} {}", stiff.whole, rigid.whole);
}

/// Relative difference between the sum of the parts and the whole.
fn apart(split: &StiffnessSplit) -> f64 {
    (split.parts.iter().map(|part| part.1).sum::<f64>() / split.whole - 1.0).abs()
}

/// Discs whose bores stay round.
fn round(machine: &Machine) -> Option<ElasticDiscs> {
    let discs = crate::fem::tests::discs(machine);
    Some(ElasticDiscs::free(&DiscShape::all(machine), discs, FlexibleOptions::default()).unwrap())
}

/// All bodies of the shipped design, on a disc (without windows) that is reduced once for
/// all tests.
fn elastic(machine: &Machine, bodies: &ElasticBodies) -> JointSettings {
    let discs = crate::fem::tests::discs_with_rims(machine);
    JointSettings {
        discs: Some(ElasticDiscs::free(&DiscShape::all(machine), discs, FlexibleOptions::default()).unwrap()),
        carrier: Some(ElasticCarrier::new(&bodies.carrier, machine.crankshafts.count).unwrap()),
        housing: Some(ElasticHousing::new(machine, &bodies.housing).unwrap()),
        damped: false,
        ..JointSettings::default()
    }
}

/// Coarse meshes of the shipped design's bodies.
fn coarse(machine: &Machine) -> ElasticBodies {
    let mut shapes = BodyShapes::of(machine);
    shapes.carrier.size *= 1.28;
    shapes.carrier.layers = [1, 2];
    shapes.housing.sizes = shapes.housing.sizes.map(|size| 1.3 * size);
    shapes.housing.layers = [1, 1];
    shapes.reduce(&Silent).unwrap()
}

/// With elastic carrier, housing, grooves and rims: the parts of the compliance add up to the whole within 0.1
/// %, every new part increases the compliance, the first-order value is slightly larger, the causes of lost
/// motion add up with a small rest, and 10⁴ times stiffer bodies with round bores in the discs equal rigid ones
/// within 1e-4'.
#[test]
#[ignore = "long"]
fn everything_elastic_in_one_model() {
    let machine = tao2024();
    let bodies = coarse(&machine);
    let all = elastic(&machine, &bodies);
    let bare = JointSettings { carrier: None, housing: None, discs: round(&machine), ..all.clone() };
    let (with, without) =
        (stiffness_split(&machine, &all, 0.7).unwrap(), stiffness_split(&machine, &bare, 0.7).unwrap());
    let to = |c: f64| c / ARCMIN * 1e4;
    println!(
        "{:.2} of {:.2}, apart {:e} {:e}",
        to(with.whole),
        to(without.whole),
        apart(&with),
        apart(&without)
    );
    with.parts.iter().for_each(|(part, c)| println!("{} {:.3}", part.name(), to(*c)));
    assert!(apart(&with) < 1e-3, "{}", apart(&with));
    let of = |split: &StiffnessSplit, part: Part| {
        split.parts.iter().find(|(p, _)| *p == part).map_or(0.0, |(_, c)| *c)
    };
    for part in [CARRIER, PIN_RING, Part::PIN_SEAT, Part::DISC] {
        assert!(of(&with, part) > of(&without, part), "{part:?}");
    }
    // Under the forces with the same discs: elastic rims change the load sharing of pins and rollers.
    let rigid = JointSettings { carrier: None, housing: None, ..all.clone() };
    let first = body_compliance(&machine, &rigid, &bodies, 0.7).unwrap();
    println!("first order {:.3} {first:?}", to(first.sum()));
    let carried = of(&with, CARRIER) / (first.carrier + first.crank_seats);
    assert!(carried > 0.6 && carried < 1.1, "{carried}");
    let ring = (of(&with, PIN_RING) + of(&with, Part::PIN_SEAT)) / (first.housing + first.pin_grooves);
    assert!(ring > 0.8 && ring < 1.1, "{ring}");

    let causes = BearingMeshing::new(&machine, &all).unwrap().lost_motion_causes(2, &mut Vec::new()).unwrap();
    assert!(causes.residual().abs() < 1e-5 * causes.whole, "{} of {}", causes.residual(), causes.whole);
    let hard = JointSettings {
        carrier: all.carrier.as_ref().map(|body| body.stiffened(1e4).unwrap()),
        housing: all.housing.as_ref().map(|body| body.stiffened(1e4).unwrap()),
        ..bare.clone()
    };
    for torque in [12.0, 412.0] {
        let error = |settings: &JointSettings| {
            let mut model = BearingJoints::held(&machine, settings).unwrap();
            model.hold_sun(0.7, 0.0);
            model.set_load(torque);
            model.output_error(&creep(&model, 1e-3, &model.nominal_position_at(0.7)).unwrap()) / ARCMIN
        };
        let (hard, rigid) = (error(&hard), error(&bare));
        assert!((hard - rigid).abs() < 1e-4, "{torque}: {hard} {rigid}");
    }
}

/// Discs with windows for the carrier's pillars: their thin rims are displaced outwards by more than most gaps,
/// and pins on the opposite side of a disc are loaded. The machine, with tilting output, crankshafts and discs,
/// has an equilibrium at every torque between the rated ones, forces are derivatives of the energy, tangents
/// agree with differences of the forces, and the parts of the stiffness and the causes of lost motion add up.
#[test]
fn discs_with_windows_balance_with_everything_else_elastic() {
    let mut machine = tao2024();
    machine.disc.windows.clone_from(&machine.solids.windows);
    let forces = OutputForces { moment: 200.0, ..OutputForces::default() };
    let tilt = Some(TiltingOutput::of(&machine, forces));
    let settings = JointSettings { tilt, ..elastic(&machine, &coarse(&machine)) };
    let mut meshing = BearingMeshing::new(&machine, &settings).unwrap();
    let rated = machine.rated.torque;
    for torque in [rated, 0.5 * rated, 0.03 * rated, -0.03 * rated, -rated] {
        for crank in [0.0, 0.7, 2.9] {
            let balance = meshing.balance(crate::machine::CrankAngle::from_radians(crank), torque, None);
            assert!(balance.is_ok(), "{torque} {crank}: {balance:?}");
        }
    }
    let (q, _) = meshing.balance(crate::machine::CrankAngle::from_radians(0.7), rated, None).unwrap();
    let model = meshing.model();
    let rest = vec![0.0; q.len()];
    let forces = |q: &[f64]| {
        let mut force = rest.clone();
        let mut tangent = model.linearisation();
        model.evaluate(0.0, q, &rest, &mut force, &mut tangent);
        (force, tangent)
    };
    let (force, tangent) = forces(&q);
    let load = |i: usize| if i == model.output_index() { rated } else { 0.0 };
    for i in 0..q.len() {
        let step = 1e-6 * model.scale()[i];
        let (mut ahead, mut behind) = (q.clone(), q.clone());
        ahead[i] += step;
        behind[i] -= step;
        let stored = |q: &[f64]| model.evaluate_forces(0.0, q, &rest, &mut rest.clone()).stored;
        let work = (stored(&behind) - stored(&ahead)) / (2.0 * step) - load(i);
        assert!(
            ((work - force[i]) * model.scale()[i]).abs() < 1e-4 * rated * ARCMIN,
            "{i}: {work:e} {}",
            force[i]
        );
        let (ahead, behind) = (forces(&ahead).0, forces(&behind).0);
        for j in 0..q.len() {
            let slope = (behind[j] - ahead[j]) / (2.0 * step);
            let size = (tangent.stiffness(i, i) * tangent.stiffness(j, j)).abs().sqrt();
            assert!(
                (slope - tangent.stiffness(j, i)).abs() < 1e-4 * size,
                "{j} {i}: {} {}",
                slope / size,
                tangent.stiffness(j, i) / size
            );
        }
    }
    let split = stiffness_split(&machine, &settings, 0.7).unwrap();
    assert!(apart(&split) < 1e-3, "{}", apart(&split));
    let causes = meshing.lost_motion_causes(2, &mut Vec::new()).unwrap();
    assert!(causes.residual().abs() < 1e-5 * causes.whole, "{} of {}", causes.residual(), causes.whole);
}

/// The smooth modes and the local compliance of the grooves store the same energy as the whole compliance of
/// the housing under the forces of the pins at rated torque.
#[test]
fn modes_of_the_housing_represent_its_compliance() {
    let machine = tao2024();
    let bodies = coarse(&machine);
    let bare = JointSettings { damped: false, ..JointSettings::default() };
    let mut model = BearingJoints::held(&machine, &bare).unwrap();
    model.hold_sun(0.7, 0.0);
    model.set_load(machine.rated.torque);
    let q = creep(&model, 1e-3, &model.nominal_position_at(0.7)).unwrap();
    let mut forces = model.housing_loads(&q);
    let pins = forces.len() - 4;
    forces[pins..].fill(0.0);
    let whole = bodies.housing.energy(&forces);
    let mut fitting = machine.clone();
    fitting.solids.housing.groove_clearance = 0.0;
    let housing = ElasticHousing::new(&fitting, &bodies.housing).unwrap();
    let parts = housing.energy(&forces[..pins]);
    println!("{} modes, own {:e} m/N, {whole:e} J {parts:e} J", housing.count(), housing.seat_compliance());
    assert!((parts / whole - 1.0).abs() < 0.03, "{parts:e} {whole:e}");
}

/// Compliance at the output of the assumed machine with all bodies elastic.
fn predict(
    machine: &Machine,
    discs: &FlexibleDiscs,
    cache: &mut Vec<(BodyShapes, ElasticBodies)>,
) -> (f64, String) {
    let start = std::time::Instant::now();
    let shapes = BodyShapes::of(machine);
    let known = cache.iter().find(|(known, _)| *known == shapes).map(|(_, bodies)| bodies.clone());
    let bodies = known.unwrap_or_else(|| shapes.reduce(&Silent).unwrap());
    cache.push((shapes, bodies.clone()));
    let cold = start.elapsed().as_secs_f64();
    let settings = JointSettings {
        discs: Some(
            ElasticDiscs::free(&DiscShape::all(machine), discs.clone(), FlexibleOptions::default()).unwrap(),
        ),
        carrier: Some(ElasticCarrier::new(&bodies.carrier, machine.crankshafts.count).unwrap()),
        housing: Some(ElasticHousing::new(machine, &bodies.housing).unwrap()),
        ..JointSettings::default()
    };
    let split = stiffness_split(machine, &settings, 0.7).unwrap();
    let to = |c: f64| c / ARCMIN * 1e4;
    let parts: Vec<String> =
        split.parts.iter().map(|(part, c)| format!("{} {:.2}", part.name(), to(*c))).collect();
    (1e4 / to(split.whole), format!("cold {cold:.1} s; {}", parts.join("; ")))
}

/// The table of the book: torsional stiffness over assumed dimensions, one at a time and all together.
#[test]
#[ignore = "minutes: prints the table of the chapter on the real machine"]
fn manual_stiffness_over_assumed_dimensions() {
    for template in TEMPLATES {
        let mut plain = crate::design::Design::parse(template.text, template.name).unwrap().machine();
        let reduce = |machine: &Machine| {
            FlexibleDiscs::with(DiscShape::all(machine), |shape| {
                let plain = FlexibleSettings::plane_stress(shape);
                let settings = FlexibleSettings { interface: BoreInterface::Rims, ..plain };
                DiscModel::new(shape.clone(), settings).and_then(|model| model.reduce()).map(|r| r.0)
            })
            .unwrap()
        };
        let show = |name: &str, (stiffness, text): &(f64, String)| {
            println!("{}; {name}; {stiffness:.1} N·m/arcmin; {text}", template.name);
        };
        let mut cache = Vec::new();
        let solid = reduce(&plain);
        show("disc without windows", &predict(&plain, &solid, &mut cache));
        plain.disc.windows = plain.solids.windows.clone();
        let windowed = reduce(&plain);
        show("assumed", &predict(&plain, &windowed, &mut cache));
        type Change = fn(&mut Machine);
        let soft: [(&str, Change); 8] = [
            ("output face held over the pillars", |m| m.solids.carrier.hold = Hold::Bolts),
            ("8 bolts", |m| m.solids.housing.bolt_count = 8),
            ("ring 1.2 R_p", |m| m.solids.housing.body_radius *= 1.2 / 1.25),
            ("shaft 0.85", |m| m.crankshafts.shaft_diameter *= 0.85),
            ("rollers 0.8 long", |m| {
                m.bearings.turning_arm.roller_length *= 0.8;
                m.bearings.crank_support.roller_length *= 0.8;
            }),
            ("clearance 15 um", |m| m.bearings.turning_arm.clearance = 15e-6),
            ("grooves 5 times as loose", |m| m.solids.housing.groove_clearance *= 5.0),
            ("mesh 0.75", |m| m.gear_stage.mesh_stiffness *= 0.75),
        ];
        let stiff: [(&str, Change); 5] = [
            ("flange held all over", |m| m.solids.housing.hold = Hold::Face),
            ("shaft 1.15", |m| m.crankshafts.shaft_diameter *= 1.15),
            ("rollers 1.2 long", |m| {
                m.bearings.turning_arm.roller_length *= 1.2;
                m.bearings.crank_support.roller_length *= 1.2;
            }),
            ("no clearance", |m| m.bearings.turning_arm.clearance = 0.0),
            ("mesh 1.25", |m| m.gear_stage.mesh_stiffness *= 1.25),
        ];
        for (side, changes) in [("soft", &soft[..]), ("stiff", &stiff[..])] {
            let mut all = plain.clone();
            for (name, change) in changes {
                let mut one = plain.clone();
                change(&mut one);
                change(&mut all);
                show(name, &predict(&one, &windowed, &mut cache));
            }
            show(&format!("all {side}"), &predict(&all, &windowed, &mut cache));
        }
    }
}
