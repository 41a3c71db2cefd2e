use super::super::stiffness_split;
use super::*;
use crate::dynamics::{ElasticCarrier, ElasticDiscs, FlexibleOptions, Part};
use crate::fem::{BodyShapes, DiscModel, FlexibleDiscs, FlexibleSettings};
use crate::machine::Hold;
use crate::templates::{TEMPLATES, rv_40e_81};
use crate::units::ARCMIN;

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

/// A carrier that only twists, C = J Jᵀ/k with J the ways of the crank seats per angle, adds 1/k; pins that
/// give way by c in any direction are pins on seats of the compliance c, a part of the model itself.
#[test]
fn known_compliances_add_what_they_must() {
    let machine = rv_40e_81();
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
    let own = split.parts.iter().find(|(part, _)| *part == Part::PinSeat).unwrap().1;
    assert!((found.housing / own - 1.0).abs() < 0.01, "{:e} {own:e}", found.housing);
    let stiff = body_compliance(&machine, &settings, &seats.stiffened(1e4), 0.7).unwrap();
    assert!((stiff.housing / found.housing * 1e4 - 1.0).abs() < 1e-9);
    // Grooves that fit add nothing.
    let mut fitting = machine.clone();
    fitting.solids.housing.groove_clearance = 0.0;
    assert!(found.pin_grooves > 0.0);
    assert_eq!(body_compliance(&fitting, &settings, &seats, 0.7).unwrap().pin_grooves, 0.0);
}

/// Rollers of the supports carry what the torque asks: their seats' forces turn the carrier by the torque.
#[test]
fn loads_of_the_carrier_balance_the_torque() {
    let machine = rv_40e_81();
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
    // Pins turn the housing by the torque less what the sun takes: T (1 − 1/i).
    let loads = model.housing_loads(&q);
    assert_eq!(loads.len(), shapes.housing.main_seat(1) + 2);
    let tangential: f64 = loads[..shapes.housing.main_seat(0)].iter().skip(1).step_by(2).sum();
    let moment = tangential.abs() * machine.ring.pin_circle_radius;
    let expected = machine.rated.torque * (1.0 - 1.0 / machine.kinematics().ratio());
    // The line of a contact passes through the pin's centre, on the pin circle; the flanks' rolling to other
    // curvatures takes the rest, about 1e-3 of the contact forces.
    assert!((moment / expected - 1.0).abs() < 2e-3, "{moment} {expected}");
}

/// Crank seats that give way in the model itself: parts add up to the whole, first order is near it and
/// above, and 10⁴ times stiffer ones are none.
#[test]
fn elastic_carrier_softens_the_machine() {
    let machine = rv_40e_81();
    let mut bodies = none(&machine);
    let n = bodies.carrier.count;
    for i in 0..n {
        bodies.carrier.values[i * n + i] = 1e-9;
    }
    let carrier = ElasticCarrier::new(&bodies.carrier, machine.crankshafts.count).unwrap();
    let with = |carrier: Option<ElasticCarrier>| {
        let settings = JointSettings { carrier, ..JointSettings::default() };
        stiffness_split(&machine, &settings, 0.7).unwrap()
    };
    let (rigid, soft) = (with(None), with(Some(carrier.clone())));
    let own = soft.parts.iter().find(|(part, _)| *part == Part::Carrier).unwrap().1;
    let sum: f64 = soft.parts.iter().map(|part| part.1).sum();
    assert!((sum / soft.whole - 1.0).abs() < 0.02 && own > 0.0, "{soft:?}");
    let mut seats = bodies.clone();
    for i in (0..n).filter(|i| i % SEAT_COORDINATES > 1 || *i >= n - 4) {
        seats.carrier.values[i * n + i] = 0.0;
    }
    let first = body_compliance(&machine, &JointSettings::default(), &seats, 0.7).unwrap().carrier;
    let added = soft.whole - rigid.whole;
    assert!(added > 0.8 * first && added < 1.05 * first, "{added:e} {first:e} {own:e}");
    let stiff = with(Some(carrier.stiffened(1e4).unwrap()));
    assert!((stiff.whole / rigid.whole - 1.0).abs() < 1e-4, "{} {}", stiff.whole, rigid.whole);
}

struct Prediction {
    stiffness: f64,
    text: String,
}

/// Stiffness in N·m/arcmin with elastic windowed discs, carrier and housing; at one place of the sun.
fn predict(
    machine: &Machine,
    discs: &FlexibleDiscs,
    cache: &mut Vec<(BodyShapes, ElasticBodies)>,
) -> Prediction {
    let elastic = ElasticDiscs::free(machine, discs.clone(), FlexibleOptions::default()).unwrap();
    let start = std::time::Instant::now();
    let shapes = BodyShapes::of(machine);
    let known = cache.iter().find(|(known, _)| *known == shapes).map(|(_, bodies)| bodies.clone());
    let bodies = known.unwrap_or_else(|| shapes.reduce().unwrap());
    cache.push((shapes, bodies.clone()));
    let cold = start.elapsed().as_secs_f64();
    let carrier = ElasticCarrier::new(&bodies.carrier, machine.crankshafts.count).unwrap();
    let settings = JointSettings { discs: Some(elastic), carrier: Some(carrier), ..JointSettings::default() };
    let (mut whole, mut added, mut parts) = (0.0, [0.0; 4], vec![0.0; Part::ALL.len()]);
    for sun in [0.7] {
        let split = stiffness_split(machine, &settings, sun).unwrap();
        let body = body_compliance(machine, &settings, &bodies, sun).unwrap();
        whole += split.whole;
        split.parts.iter().for_each(|(part, c)| parts[*part as usize] += c);
        for (sum, value) in
            added.iter_mut().zip([body.carrier, body.crank_seats, body.housing, body.pin_grooves])
        {
            *sum += value;
        }
    }
    let to = |c: f64| c / ARCMIN * 1e4;
    let mut text = format!("model {:.1}; cold {cold:.1} s;", 1e4 / to(whole));
    for part in Part::ALL {
        text += &format!(" {} {:.2};", part.name(), to(parts[part as usize]));
    }
    text += &format!(" carrier {:.2}; crank seats {:.2};", to(added[0]), to(added[1]));
    text += &format!(" housing {:.2}; pin grooves {:.2}", to(added[2]), to(added[3]));
    Prediction { stiffness: 1e4 / to(whole + added.iter().sum::<f64>()), text }
}

/// The table of the book: torsional stiffness over assumed dimensions, one at a time and all together.
#[test]
#[ignore = "minutes: prints the table of the chapter on the real machine"]
fn stiffness_over_assumed_dimensions() {
    for template in TEMPLATES {
        let mut plain = crate::design::Design::parse(template.text, template.name).unwrap().machine();
        let reduce = |machine: &Machine| {
            FlexibleDiscs::with(machine, |shape| {
                let settings = FlexibleSettings::plane_stress(shape);
                DiscModel::new(shape.clone(), settings).and_then(|model| model.reduce()).map(|r| r.0)
            })
            .unwrap()
        };
        let show = |name: &str, found: &Prediction| {
            println!("{}; {name}; {:.1} N·m/arcmin; {}", template.name, found.stiffness, found.text);
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
