//! Wall time of the model with bearings: one evaluation, the 0.8 s run, one hysteresis loop, one output turn, and
//! what a study asks of a drawn machine: its new state and its life.

use arcmin::analyses::{self, NoHost};
use arcmin::dynamics::{BearingJoints, Drive, JointSettings, OutputLoad, Run, RunPlan, System};
use arcmin::progress::Silent;
use arcmin::rig::{TransmissionSettings, hysteresis_loop, transmission_error_curves};
use arcmin::templates;
use arcmin::units::RPM;
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;

fn bearings(criterion: &mut Criterion) {
    let machine = arcmin::templates::tao2024();
    let settings = JointSettings::default();
    let drive = Drive::SpeedLaw { speed: 1500.0 * RPM, rise_time: 0.1 };
    let load = OutputLoad::Constant { torque: 412.0 };
    let model =
        BearingJoints::new(&machine, &settings, drive, load, 5.0).unwrap_or_else(|error| panic!("{error}"));
    let mut group = criterion.benchmark_group("bearings");
    group.sample_size(10);
    let position = model.nominal_position_at(0.0);
    let rest = vec![0.0; position.len()];
    let mut force = rest.clone();
    let mut linearisation = model.linearisation();
    group.bench_function("evaluate", |bencher| {
        bencher.iter(|| {
            black_box(model.evaluate(0.0, black_box(&position), &rest, &mut force, &mut linearisation))
        })
    });
    group.bench_function("run_0.8_s", |bencher| {
        bencher.iter(|| {
            let mut run = Run::new(model.clone(), RunPlan::default(), &Silent)
                .unwrap_or_else(|error| panic!("{error}"));
            run.finish(&Silent).unwrap_or_else(|error| panic!("{error}"));
            black_box(run.result().counts)
        })
    });
    group.bench_function("hysteresis_loop", |bencher| {
        bencher.iter(|| black_box(hysteresis_loop(&machine, &settings, 1.0).is_ok()))
    });
    let test = TransmissionSettings::new(&machine);
    group.bench_function("output_turn_4_curves", |bencher| {
        bencher.iter(|| black_box(transmission_error_curves(&machine, &settings, test).is_ok()))
    });
    group.finish();
}

/// One sample each of the studies `yield` and `unknowns`, on one thread.
fn samples(criterion: &mut Criterion) {
    let design = templates::design("tao2024").unwrap_or_else(|| panic!("the design is shipped"));
    let threads =
        rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap_or_else(|error| panic!("{error}"));
    let mut group = criterion.benchmark_group("sample");
    group.sample_size(10);
    let drawn = "joints = \"bearings\"\nerrors = \"drawn\"\nseed = 1";
    for (name, analysis, options) in [
        ("new_state", "rig", "positions = 1\nte_positions = 512\nfrictionless = true"),
        ("life", "life", "quasi_static = true\npoints = 12"),
    ] {
        let options = format!("{drawn}\n{options}");
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                threads.install(|| {
                    let analysis = analyses::by_name(analysis)?;
                    analysis.run(&design, &options, "bench", &NoHost).ok().map(|outcome| outcome.summary())
                })
            })
        });
    }
    group.finish();
}

criterion_group!(benches, bearings, samples);
criterion_main!(benches);
