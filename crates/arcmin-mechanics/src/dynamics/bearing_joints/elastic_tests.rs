use super::labels::TURNING_ARM;
use super::tests::{machine, of, settle};
use super::{BearingJoints, JointSettings};
use crate::contact::ContactLaw;
use crate::dynamics::mechanism::{Element, Part, Sink};
use crate::dynamics::{
    Drive, ElasticDiscs, EquilibriumControl, FlexibleJoints, FlexibleOptions, OutputLoad, Reducer, Run,
    RunPlan, RunResult, StepControl, System, TimeTable, solve_equilibrium,
};
use crate::fem::tests::{discs, reduced};
use crate::fem::{FemError, FlexibleDiscs};
use crate::geometry::{Relief, Vec2};
use crate::machine::Machine;
use crate::progress::Silent;
use crate::units::ARCMIN;

fn elastic(machine: &Machine) -> Option<ElasticDiscs> {
    Some(
        ElasticDiscs::free(&crate::fem::DiscShape::all(machine), discs(machine), FlexibleOptions::default())
            .unwrap(),
    )
}

/// Discs of a material ten thousand times stiffer.
fn stiff(machine: &Machine) -> Option<ElasticDiscs> {
    let reduced = reduced().stiffened(1e4);
    let discs =
        FlexibleDiscs::with(crate::fem::DiscShape::all(machine), |_| Ok::<_, FemError>(reduced.clone()))
            .unwrap();
    // As many modes as of the real disc: their frequencies are a hundred times higher.
    let options = FlexibleOptions { mode_frequency: 2e6, ..FlexibleOptions::default() };
    Some(ElasticDiscs::free(&crate::fem::DiscShape::all(machine), discs, options).unwrap())
}

fn still(discs: Option<ElasticDiscs>) -> JointSettings {
    JointSettings { discs, damped: false, ..JointSettings::default() }
}

/// Output error in arcmin in static equilibrium.
fn error(machine: &Machine, settings: &JointSettings, sun: f64, torque: f64) -> f64 {
    let mut model = BearingJoints::held(machine, settings).unwrap();
    model.hold_sun(sun, 0.0);
    model.set_load(torque);
    model.output_error(&settle(&model, sun)) / ARCMIN
}

fn run(machine: &Machine, discs: Option<ElasticDiscs>) -> RunResult {
    let settings =
        JointSettings { discs, flank_wear: vec![Relief::uniform(5e-6)], ..JointSettings::default() };
    let drive = Drive::SpeedLaw { speed: machine.rated.input_speed, rise_time: 0.02 };
    let model =
        BearingJoints::new(machine, &settings, drive, OutputLoad::Constant { torque: 412.0 }, 5.0).unwrap();
    // The integration error must be below the difference between the models.
    let control = StepControl { tolerance: 0.1 * StepControl::default().tolerance, ..StepControl::default() };
    let mut run =
        Run::new(model, RunPlan { end: 0.04, window_start: 0.02, control, ..RunPlan::default() }, &Silent)
            .unwrap();
    run.finish(&Silent).unwrap();
    run.result()
}

#[test]
fn discs_ten_thousand_times_stiffer_rest_and_run_like_rigid_ones() {
    let machine = machine();
    for (sun, torque) in [(0.0, 412.0), (1.3, -206.0), (7.7, 12.0)] {
        let (a, b) = (
            error(&machine, &still(stiff(&machine)), sun, torque),
            error(&machine, &still(None), sun, torque),
        );
        assert!((a - b).abs() < 1e-4, "{sun} {torque}: {a}' {b}'");
    }
    let (a, b) = (run(&machine, stiff(&machine)), run(&machine, None));
    for (a, b) in a.series.iter().zip(&b.series) {
        let difference = (a.transmission_error - b.transmission_error) / ARCMIN;
        assert!(difference.abs() < 1e-4, "{} s: {difference}'", a.time);
    }
}

#[test]
fn energy_balances() {
    for contact_law in [ContactLaw::Linear { stiffness: 2.85e8 }, ContactLaw::LineHertz] {
        let machine = Machine { contact_law, ..machine() };
        let residual = run(&machine, elastic(&machine)).energy.residual();
        assert!(residual < 1e-6, "{contact_law:?}: {residual:e}");
    }
}

/// More held modes as coordinates change a run only by their inertia.
#[test]
fn the_result_does_not_depend_on_the_number_of_modes() {
    let machine = machine();
    let mean = |mode_frequency: f64| {
        let options = FlexibleOptions { mode_frequency, ..FlexibleOptions::default() };
        let discs =
            ElasticDiscs::free(&crate::fem::DiscShape::all(&machine), discs(&machine), options).unwrap();
        run(&machine, Some(discs)).statistics.unwrap().mean / ARCMIN
    };
    let (none, some, more) = (mean(0.0), mean(20e3), mean(40e3));
    assert!((none / more - 1.0).abs() < 1e-3 && (some / more - 1.0).abs() < 1e-3, "{none} {some} {more}");
}

/// Bearings, shafts and supports a million times stiffer, without clearance, constrain the bores as ideal
/// joints do: the same elastic disc by its free modes and by its held ones. In both models the bores' rims can
/// rotate about their centres.
#[test]
fn val_stiff_bearings_are_ideal_joints_with_elastic_discs() {
    let mut machine = machine();
    machine.bearings.turning_arm.clearance = 0.0;
    let settings = JointSettings { stiffness_scale: 1e6, ..still(elastic(&machine)) };
    let rigid = JointSettings { discs: None, ..settings.clone() };
    for (sun, torque) in [(0.0, 412.0), (1.3, -206.0), (7.7, 412.0)] {
        let bearings = error(&machine, &settings, sun, torque);
        let drive = Drive::SpeedTable(TimeTable::new("speed", &[(0.0, 2.0 * sun), (1.0, 0.0)]).unwrap());
        let (load, options) = (OutputLoad::Constant { torque }, FlexibleOptions::default());
        let ideal =
            FlexibleJoints::new(&machine, discs(&machine), &Relief::uniform(0.0), drive, load, 0.0, options)
                .unwrap();
        let output = sun / 81.0;
        let mut start = vec![-39.0 * output, output];
        for _ in 0..2 {
            // p = q + c θ.
            start.extend((0..ideal.mode_count() / 2).map(|m| reduced().momentum[2][m] * output));
        }
        let rest = solve_equilibrium(&ideal, 1.0, &start, EquilibriumControl::default()).unwrap().position;
        let expected = ideal.transmission_error(1.0, &rest, &vec![0.0; rest.len()]) / ARCMIN;
        assert!((bearings - expected).abs() < 1e-4, "{sun} {torque}: {bearings}' {expected}'");
        // The elasticity of the discs has a noticeable effect there.
        assert!((bearings - error(&machine, &rigid, sun, torque)).abs() > 0.01);
    }
}

#[test]
fn split_adds_up_with_a_part_for_the_discs() {
    let mut machine = crate::templates::tao2024();
    machine.ring.seat_compliance = 1e-9;
    for discs in [elastic(&machine), None] {
        let mut model = BearingJoints::held(&machine, &still(discs)).unwrap();
        model.set_load(412.0);
        let q = settle(&model, 0.0);
        let n = q.len();
        let (mut force, mut lin) = (vec![0.0; n], model.linearisation());
        model.evaluate(0.0, &q, &vec![0.0; n], &mut force, &mut lin);
        let mut motion = vec![0.0; n];
        motion[model.output_index()] = 1.0;
        let weights = crate::dynamics::Weights { mass: 0.0, damping: 0.0, stiffness: 1.0 };
        lin.solve(&vec![0.0; n], weights, &mut motion).unwrap();
        let whole = motion[model.output_index()];
        let parts = model.split(&q, &motion);
        let share = |part: Part| of(&parts, part) / whole;
        assert!(
            (parts.iter().map(|part| part.1).sum::<f64>() / whole - 1.0).abs() < 1e-9,
            "{parts:?} {whole}"
        );
        match &model.rings[0].elastic {
            Some(_) => assert!(share(Part::DISC) > 0.01 && share(Part::PIN_SEAT) > 1e-3, "{parts:?} {whole}"),
            None => assert_eq!(share(Part::DISC), 0.0),
        }
    }
}

/// Sums the forces of one kind of spring.
struct Forces {
    part: Part,
    force: Vec<f64>,
}

impl Sink for Forces {
    fn element(&mut self, element: &Element<'_>) {
        if element.part == self.part {
            element.index.iter().zip(element.gradient).for_each(|(i, slope)| self.force[*i] -= slope);
        }
    }

    fn damper(&mut self, _: &[usize], _: &[f64], _: &[f64], _: f64) {}
}

/// Turning-arm bearings act on shaft and deformed disc with equal and opposite forces: their sum and their
/// moment about the centre of the machine are zero. The modes, on which they also act, have no momentum.
#[test]
fn forces_of_turning_arm_bearings_are_in_equilibrium() {
    let machine = machine();
    let mut model = BearingJoints::held(&machine, &still(elastic(&machine))).unwrap();
    model.hold_sun(2.0, 0.0);
    model.set_load(412.0);
    let mut q = settle(&model, 2.0);
    let layout = model.layout.clone();
    for j in 0..2 {
        // Bores displaced by some micrometres.
        layout.modes(j).enumerate().for_each(|(m, at)| q[at] += 2e-6 * (1.0 + m as f64));
    }
    let (q, rest) = model.full(0.0, &q, &vec![0.0; q.len()]);
    let mut forces = Forces { part: TURNING_ARM.part, force: vec![0.0; q.len()] };
    model.visit(&q, &rest, &mut forces);
    let f = &forces.force;
    let (mut sum, mut moment, mut size) = (Vec2::zeros(), 0.0, 0.0);
    let mut add = |at: usize, angle: Option<usize>| {
        let (force, place) = (Vec2::new(f[at], f[at + 1]), Vec2::new(q[at], q[at + 1]));
        sum += force;
        moment += crate::geometry::cross(place, force) + angle.map_or(0.0, |angle| f[angle]);
        size += force.norm();
    };
    for k in 0..layout.cranks {
        for j in 0..layout.discs {
            add(layout.disc_station(k, j), (j == 0).then(|| layout.crank_angle(k)));
        }
    }
    for j in 0..layout.discs {
        add(layout.disc(j), Some(layout.disc(j) + 2));
    }
    assert!(size > 1e4, "{size}");
    // Rounding of sums of about 10 kN at 40 mm.
    assert!(sum.norm() < 1e-9 * size && moment.abs() < 1e-10 * size, "{sum:?} {moment:e} of {size}");
    assert!(layout.modes(0).map(|at| f[at].abs()).sum::<f64>() > 1.0);
}

/// At ±3 % of rated torque and worn: the sum of the causes of lost motion is within 1 %, as with rigid discs.
#[test]
fn causes_add_up_with_elastic_discs() {
    use crate::dynamics::{BearingMeshing, Cause};
    let machine = crate::templates::tao2024();
    let settings = JointSettings { flank_wear: vec![Relief::uniform(10e-6)], ..still(elastic(&machine)) };
    let split =
        BearingMeshing::new(&machine, &settings).unwrap().lost_motion_causes(4, &mut Vec::new()).unwrap();
    let rigid = BearingMeshing::new(&machine, &JointSettings { discs: None, ..settings })
        .unwrap()
        .lost_motion_causes(4, &mut Vec::new())
        .unwrap();
    assert!(split.residual().abs() < 1e-5 * split.whole, "{} of {}", split.residual(), split.whole);
    assert!(split.of(Cause::ELASTIC) > rigid.of(Cause::ELASTIC), "{split:?} {rigid:?}");
    assert!(
        (split.of(Cause::FLANK_WEAR) / rigid.of(Cause::FLANK_WEAR) - 1.0).abs() < 0.05,
        "{split:?} {rigid:?}"
    );
}

/// Half a turn of the machine moves the first disc onto the second, lobes onto lobes and each bore onto that of
/// the other crankshaft, so that both deform equally in every position; only the shaft, and the planets at one
/// of its ends, differ. The second disc uses the modes from the reduction of the first one, rotated, with
/// exchanged bores.
#[test]
fn equal_discs_deform_equally() {
    let machine = machine();
    let mut model = BearingJoints::held(&machine, &still(elastic(&machine))).unwrap();
    for sun in [0.0, 2.0, 6.5] {
        model.hold_sun(sun, 0.0);
        model.set_load(412.0);
        let q = settle(&model, sun);
        let discs = &model.rings[0].elastic.as_ref().unwrap().body;
        let modes = [0, 1].map(|disc| &q[model.layout.modes(disc)]);
        let [first, second] = [0, 1].map(|disc| discs.modal_work(disc, modes[disc]));
        assert!((first / second - 1.0).abs() < 0.02, "{sun}: {first:e} {second:e}");
        for (a, b) in modes[0].iter().zip(modes[1]) {
            assert!(
                (a - b).abs() < 0.02 * modes[0].iter().fold(0.0, |m: f64, q| m.max(q.abs())),
                "{sun}: {modes:?}"
            );
        }
    }
}

/// Pins skipped before the modes are known would not touch: evaluation of all pins gives the same forces, at
/// rated torque and at three times that; also for a disc with windows, whose thin rim deforms by far more than
/// a pin's gap.
#[test]
fn skipped_pins_have_no_contact() {
    let machine = machine();
    let mut windowed = machine.clone();
    windowed.disc.windows.clone_from(&machine.solids.windows);
    for (machine, sun, torque) in [
        (&machine, 0.0, 412.0),
        (&machine, 2.0, 1236.0),
        (&machine, 6.5, -1236.0),
        (&windowed, 0.7, 412.0),
        (&windowed, 6.5, -1236.0),
    ] {
        let mut model = BearingJoints::held(machine, &still(elastic(machine))).unwrap();
        model.hold_sun(sun, 0.0);
        model.set_load(torque);
        let q = settle(&model, sun);
        let rest = vec![0.0; q.len()];
        let forces = |model: &BearingJoints| {
            let mut force = rest.clone();
            model.evaluate(0.0, &q, &rest, &mut force, &mut model.linearisation());
            (force, model.forces(0.0, &q, &rest).loaded_pins)
        };
        let mut all = model.clone();
        for ring in &mut all.rings {
            let law = *ring.contacts.contact();
            ring.contacts.set_elastic(law, 1.0);
        }
        let ((few, touching), (every, touching_of_all)) = (forces(&model), forces(&all));
        assert_eq!(touching, touching_of_all);
        for (i, (a, b)) in few.iter().zip(&every).enumerate() {
            assert!((a - b).abs() < 1e-6 * torque.abs(), "{sun} {torque} {i}: {a} {b}");
        }
    }
}
