//! Elastic discs: mesh to reduced model, and one load sharing.

use arcmin::fem::{DiscModel, DiscShape, FlexibleDiscs, FlexibleSettings};
use arcmin::geometry::Relief;
use arcmin::machine::CrankAngle;
use criterion::{Criterion, criterion_group, criterion_main};

fn reduction(c: &mut Criterion) {
    let shape = DiscShape::of(&arcmin::templates::tao2024(), 0);
    let mut group = c.benchmark_group("disc");
    group.sample_size(10);
    for (name, settings) in
        [("plane stress", FlexibleSettings::plane_stress(&shape)), ("tet10", FlexibleSettings::solid(&shape))]
    {
        group.bench_function(format!("mesh, assemble, factorise, {name}"), |b| {
            b.iter(|| DiscModel::new(shape.clone(), settings))
        });
        if let Ok(model) = DiscModel::new(shape.clone(), settings) {
            group.bench_function(format!("reduce, {name}"), |b| b.iter(|| model.reduce()));
        }
    }
    group.finish();
}

fn load_sharing(c: &mut Criterion) {
    let machine = arcmin::templates::tao2024();
    let Ok(discs) = FlexibleDiscs::reduce(DiscShape::all(&machine), FlexibleSettings::plane_stress) else {
        return;
    };
    let meshing = machine.flexible_meshing(&Relief::uniform(1e-5), discs);
    let mut crank = 0.0;
    c.bench_function("load sharing on elastic discs, 412 N·m", |b| {
        b.iter(|| {
            crank += 0.01;
            meshing.load_sharing(CrankAngle::from_radians(crank), 412.0)
        });
    });
}

criterion_group!(benches, reduction, load_sharing);
criterion_main!(benches);
