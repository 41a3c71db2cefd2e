//! Contact search, load sharing and wear: `cargo bench --bench quasi_static`.

use std::hint::black_box;

use arcmin::contact::DiscVelocity;
use arcmin::geometry::Relief;
use arcmin::life::{LifeOptions, predict};
use arcmin::machine::CrankAngle;
use arcmin::progress::Silent;
use arcmin::templates::tao2024;
use arcmin::units::{HOUR, UM};
use arcmin::wear::{CoupledOptions, CoupledWear};
use criterion::{Criterion, criterion_group, criterion_main};

fn gaps(c: &mut Criterion) {
    let machine = tao2024();
    let kinematics = machine.kinematics();
    let pose = kinematics.disc_pose(0, 0.321, kinematics.nominal_output_angle(0.321) - 2e-5);
    let uneven =
        Relief::from_samples(Relief::grid(720).map(|phi| 5.0 * UM * (1.0 - (2.0 * phi).cos())).collect());
    for (name, relief) in [
        ("unworn", Relief::uniform(0.0)),
        ("uniform 60 µm", Relief::uniform(60.0 * UM)),
        ("unevenly worn", uneven),
    ] {
        let contacts = machine.pin_contacts(&relief);
        // All 40 pins of one disc, touching or not; a fortieth of it is one gap.
        c.bench_function(&format!("40 gaps, {name}"), |b| {
            b.iter(|| {
                let mut sum = 0.0;
                contacts.visit(black_box(pose), DiscVelocity::REST, true, |contact| {
                    sum += contact.gap + contact.force
                });
                sum
            });
        });
    }
    let profile = machine.profile();
    let p = profile.trace(0.5) + arcmin::geometry::Vec2::new(3e-6, -2e-6);
    c.bench_function("one foot point", |b| b.iter(|| profile.foot(black_box(p), black_box(0.5003)).distance));
}

fn load_sharing(c: &mut Criterion) {
    let machine = tao2024();
    let meshing = machine.meshing(&Relief::uniform(10.0 * UM));
    let crank = CrankAngle::from_degrees(30.0);
    c.bench_function("load sharing, 2 discs x 40 pins", |b| {
        b.iter(|| meshing.load_sharing(black_box(crank), black_box(412.0)))
    });
    let neighbour = meshing
        .load_sharing(CrankAngle::from_degrees(29.4), 412.0)
        .map(|sharing| sharing.output_error)
        .unwrap_or_default();
    c.bench_function("load sharing from the neighbouring crank angle", |b| {
        b.iter(|| meshing.load_sharing_near(black_box(crank), black_box(412.0), neighbour));
    });
}

fn life(c: &mut Criterion) {
    let machine = tao2024();
    let mut group = c.benchmark_group("life");
    group.sample_size(10);
    group.bench_function("coupled wear over 7500 h", |b| {
        b.iter(|| {
            let options = CoupledOptions::default();
            let exposure = machine.coupled_exposure(options)?;
            let mut wear = CoupledWear::new(&machine, options);
            wear.advance_to(exposure.at(7500.0 * HOUR))?;
            Ok::<usize, arcmin::wear::WearError>(wear.updates())
        });
    });
    group.bench_function("prediction with accuracy at 31 times", |b| {
        b.iter(|| {
            let fidelity = arcmin::fidelity::Fidelity::ideal();
            predict(&machine, &fidelity, LifeOptions::default(), &Silent, |_| ())
        })
    });
    group.finish();
}

criterion_group!(benches, gaps, load_sharing, life);
criterion_main!(benches);
