//! Wall time of the paper's 0.8 s run, of one evaluation of the equations of motion, and of the contacts of
//! one disc.

use arcmin::contact::{ContactLaw, DiscVelocity};
use arcmin::dynamics::{
    BearingJoints, Drive, ElasticDiscs, FlexibleOptions, IdealJoints, JointSettings, OutputLoad, Run,
    RunPlan, System,
};
use arcmin::fem::{FlexibleDiscs, FlexibleSettings};
use arcmin::geometry::Relief;
use arcmin::progress::Silent;
use arcmin::units::{ARCMIN, RPM, UM};
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;

fn model(law: ContactLaw, load: OutputLoad) -> IdealJoints {
    let machine =
        arcmin::templates::tao2024().with_contact_law(law).unwrap_or_else(|error| panic!("{error}"));
    let drive = Drive::SpeedLaw { speed: 1500.0 * RPM, rise_time: 0.1 };
    IdealJoints::new(&machine, &Relief::uniform(10.0 * UM), drive, load, 0.0)
        .unwrap_or_else(|error| panic!("{error}"))
}

fn runs(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("run_0.8_s");
    group.sample_size(10);
    let sine = OutputLoad::Sine { amplitude: 412.0, period: 0.3 };
    let linear = ContactLaw::Linear { stiffness: 2.85e8 };
    let cases = [
        ("constant_line_hertz", ContactLaw::LineHertz, OutputLoad::Constant { torque: 412.0 }),
        ("sine_line_hertz", ContactLaw::LineHertz, sine.clone()),
        ("sine_linear", linear, sine),
        ("no_load_line_hertz", ContactLaw::LineHertz, OutputLoad::None),
    ];
    for (name, law, load) in cases {
        let model = model(law, load);
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let mut run = Run::new(model.clone(), RunPlan::default(), &Silent)
                    .unwrap_or_else(|error| panic!("{error}"));
                run.finish(&Silent).unwrap_or_else(|error| panic!("{error}"));
                run.result().counts
            });
        });
    }
    group.finish();
}

fn evaluation(criterion: &mut Criterion) {
    let model = model(ContactLaw::LineHertz, OutputLoad::Constant { torque: 412.0 });
    let mut lin = model.linearisation();
    let angle = 1500.0 * RPM * 0.05;
    let position = [-39.0 * angle / 81.0, angle / 81.0 - 0.76 * ARCMIN];
    criterion.bench_function("evaluation_80_pins_loaded", |bencher| {
        bencher.iter(|| {
            let mut force = [0.0; 2];
            model.evaluate(0.1, black_box(&position), &[0.0, 0.0], &mut force, &mut lin);
            force
        });
    });
    let machine = arcmin::templates::tao2024();
    let contacts = machine.pin_contacts(&Relief::uniform(10.0 * UM));
    let pose = machine.kinematics().disc_pose(0, 1.2, -1.2 / 39.0 - 0.79 * ARCMIN);
    criterion.bench_function("contacts_40_pins_loaded", |bencher| {
        bencher.iter(|| contacts.react(black_box(pose), DiscVelocity::REST))
    });
}

/// Elastic discs in bearings.
fn elastic(criterion: &mut Criterion) {
    let machine = arcmin::templates::tao2024();
    let discs = FlexibleDiscs::reduce(arcmin::fem::DiscShape::all(&machine), FlexibleSettings::plane_stress)
        .unwrap_or_else(|error| panic!("{error}"));
    let discs = ElasticDiscs::free(&arcmin::fem::DiscShape::all(&machine), discs, FlexibleOptions::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let settings = JointSettings { discs: Some(discs), ..JointSettings::default() };
    let drive = Drive::SpeedLaw { speed: 1500.0 * RPM, rise_time: 0.1 };
    let load = OutputLoad::Constant { torque: 412.0 };
    let model =
        BearingJoints::new(&machine, &settings, drive, load, 5.0).unwrap_or_else(|error| panic!("{error}"));
    let mut group = criterion.benchmark_group("elastic_discs_in_bearings");
    group.sample_size(10);
    group.bench_function("run_0.8_s", |bencher| {
        bencher.iter(|| {
            let mut run = Run::new(model.clone(), RunPlan::default(), &Silent)
                .unwrap_or_else(|error| panic!("{error}"));
            run.finish(&Silent).unwrap_or_else(|error| panic!("{error}"));
            run.result().counts
        });
    });
    if let Ok(rest) =
        arcmin::dynamics::solve_equilibrium(&*model, 0.0, &model.nominal_position_at(0.0), Default::default())
    {
        let speed = vec![0.0; rest.position.len()];
        let (mut force, mut lin) = (speed.clone(), model.linearisation());
        group.bench_function("evaluation_loaded", |bencher| {
            bencher.iter(|| {
                black_box(model.evaluate(0.0, black_box(&rest.position), &speed, &mut force, &mut lin))
            })
        });
    }
    group.finish();
}

criterion_group!(benches, runs, evaluation, elastic);
criterion_main!(benches);
