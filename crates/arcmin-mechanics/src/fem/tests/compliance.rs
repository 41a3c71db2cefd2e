//! Static compliance of reduced discs between bores, rims and flank, compared with the full mesh.

use super::*;

/// A disc supported by springs at its bore centres and loaded on the flank. Rigid motions, elastic modes of the
/// free disc and the residual compliance together give the displacements of the full mesh factorised with these
/// springs, for any number of held modes, because the residual compliance contains the omitted ones.
#[test]
fn free_modes_and_residual_give_the_static_compliance_between_bores_and_flank() {
    use nalgebra::{DMatrix, DVector};
    let Fixture { model, reduced, .. } = fixture();
    let spring = 5e8;
    let inner = model.inner_unknowns();
    let mut sprung = model.stiffness.clone();
    for column in inner..model.map.count {
        let diagonal = (sprung.column_start[column]..sprung.column_start[column + 1])
            .find(|k| sprung.rows[*k] == column)
            .unwrap();
        sprung.values[diagonal] += spring;
    }
    let factor = solve::Cholesky::new(&sprung).unwrap();
    let stations = &reduced.stations;
    // On the flank of three lobes: far from the bores, over a bore, between.
    let places: Vec<f64> =
        [0usize, 10, 23].map(|lobe| stations.parameter((lobe * stations.per_lobe()) as f64 + 3.4)).to_vec();
    let bores: Vec<_> = model.shape.bores.iter().map(|bore| bore.centre).collect();
    for held in [0, 3, 9] {
        let free = reduced.free_modes(held).unwrap();
        let residual = reduced.residual_compliance(held);
        let n = 3 + free.flank.count();
        assert_eq!(free.flank.count(), 1 + held);
        // Displacement of a point in a direction by the rigid motions.
        let rigid = |place: crate::geometry::Vec2, along: crate::geometry::Vec2| {
            [along.x, along.y, along.dot(&crate::geometry::quarter_turn(place))]
        };
        let mut stiffness = DMatrix::<f64>::zeros(n, n);
        for (m, square) in free.flank.eigenvalues.iter().enumerate() {
            stiffness[(3 + m, 3 + m)] = *square;
        }
        let bore_row = |k: usize, along: crate::geometry::Vec2| {
            let modes =
                (0..free.flank.count()).map(|m| free.bore(m, k).centre.dot(&along)).collect::<Vec<_>>();
            DVector::from_iterator(n, rigid(bores[k], along).into_iter().chain(modes))
        };
        let axes = [crate::geometry::Vec2::x(), crate::geometry::Vec2::y()];
        for k in 0..bores.len() {
            for along in axes {
                let row = bore_row(k, along);
                stiffness += spring * &row * row.transpose();
            }
        }
        let flank_row = |tau: f64| {
            let at = stations.stencil(tau);
            let modes = (0..free.flank.count()).map(|m| free.flank.at(m, &at)).collect::<Vec<_>>();
            DVector::from_iterator(
                n,
                rigid(model.shape.profile.flank_point(tau), -model.shape.profile.outward_normal(tau))
                    .into_iter()
                    .chain(modes),
            )
        };
        for tau in &places {
            let mut force = vec![0.0; model.map.count];
            model.surface().surface(*tau).add_force(&model.map, &mut force, 1.0);
            let mut solution = faer::Mat::from_fn(force.len(), 1, |i, _| force[i]);
            factor.solve(solution.as_mut());
            let exact = solution.col_as_slice(0);
            let found = stiffness.clone().lu().solve(&flank_row(*tau)).unwrap();
            let at = stations.stencil(*tau);
            let own = model.read_at_depth(exact, *tau, reduced.reading_depth).unwrap();
            let mine = flank_row(*tau).dot(&found) + residual.own(&at);
            // Under distant forces the displacements at the surface and at the reading depth are equal within
            // the Poisson strain between them and the error of the splines between stations.
            assert!((mine / own - 1.0).abs() < 0.01, "{held} own: {mine:e} {own:e}");
            for other in places.iter().filter(|other| *other != tau) {
                let exact = model.read_surface(exact, *other);
                let mine = flank_row(*other).dot(&found) + residual.cross(&at, &stations.stencil(*other));
                assert!((mine - exact).abs() < 3e-3 * own, "{held} cross: {mine:e} {exact:e} of {own:e}");
            }
            for k in 0..bores.len() {
                for (axis, along) in axes.into_iter().enumerate() {
                    let (mine, exact) = (bore_row(k, along).dot(&found), exact[inner + 2 * k + axis]);
                    assert!(
                        (mine - exact).abs() < 2e-3 * own,
                        "{held} bore {k}: {mine:e} {exact:e} of {own:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn modes_with_rims_give_the_static_compliance_between_rims_and_flank() {
    let mut machine = tao2024();
    machine.disc.windows = machine.solids.windows.clone();
    let Fixture { model, reduced, .. } = fixture_of(&machine, BoreInterface::Rims);
    assert_eq!(reduced.interface.per_bore, carrier::SEAT_COORDINATES);
    compare_free_disc_with_mesh(model, reduced);
}

/// The same for a disc of a single stage; the interface of its bore and output holes are the means of their
/// displacement.
#[test]
fn modes_with_means_hold_the_static_compliance_between_holes_and_flank() {
    let stage = crate::dynamics::two_elastic_discs();
    let shape = DiscShape::all_of_stage(&stage).swap_remove(1);
    let settings = FlexibleSettings { interface: BoreInterface::Means, ..coarse(&shape) };
    let model = DiscModel::new(shape, settings).unwrap();
    let (reduced, _) = model.reduce().unwrap();
    assert_eq!((reduced.interface.per_bore, reduced.interface.count), (2, 18));
    compare_free_disc_with_mesh(&model, &reduced);
}

/// A disc with free rims under a force on its flank, pressures of an arc of rollers on all bores and balancing
/// forces: elastic modes of the free disc and the residual compliance give the displacements of flank and rims
/// of the full mesh held at three points.
fn compare_free_disc_with_mesh(model: &DiscModel, reduced: &ReducedDisc) {
    let (nb, per) = (reduced.interface.count, reduced.interface.per_bore);
    let stations = &reduced.stations;
    let places: Vec<f64> = [0, 1, 2]
        .map(|third| third * reduced.lobe_count / 3)
        .map(|lobe| stations.parameter((lobe * stations.per_lobe() + 3) as f64))
        .to_vec();
    let bores: Vec<_> = model.shape.bores.iter().map(|bore| bore.centre).collect();
    // A roller at 30° on each bore loads all orders of its rim.
    let mut on_rims: Vec<f64> = (0..bores.len())
        .flat_map(|_| {
            let wave = |n: f64, f: fn(f64) -> f64| 0.5 * f(n * std::f64::consts::FRAC_PI_6);
            let orders = (2..=carrier::RIM_ORDER)
                .flat_map(move |n| [wave(n as f64, f64::cos), wave(n as f64, f64::sin)]);
            [wave(1.0, f64::cos), wave(1.0, f64::sin), 0.5].into_iter().chain(orders).take(per)
        })
        .collect();
    // Balancing forces at the centres of the first and the last bore: equal forces, and a couple perpendicular
    // to the line through them.
    let tau = places[1];
    let normal = -model.shape.profile.outward_normal(tau);
    let cross = |a: crate::geometry::Vec2, b: crate::geometry::Vec2| a.x * b.y - a.y * b.x;
    let last = bores.len() - 1;
    let (mut whole, mut moment) = (normal, cross(model.shape.profile.flank_point(tau), normal));
    for (bore, forces) in bores.iter().zip(on_rims.chunks_exact(per)) {
        let force = crate::geometry::Vec2::new(forces[0], forces[1]);
        whole += force;
        moment += cross(*bore, force);
    }
    let (apart, middle) = (bores[0] - bores[last], 0.5 * (bores[0] + bores[last]));
    let couple =
        (moment - cross(middle, whole)) / apart.norm_squared() * crate::geometry::quarter_turn(apart);
    for (k, sign) in [(0, 1.0), (last, -1.0)] {
        let balance = -0.5 * whole - sign * couple;
        on_rims[k * per] += balance.x;
        on_rims[k * per + 1] += balance.y;
    }
    let (sprung, loads) = model.held_means().unwrap().parts();
    let mut force = vec![0.0; model.map.count];
    model.surface().surface(tau).add_force(&model.map, &mut force, 1.0);
    for (load, share) in loads.iter().zip(&on_rims) {
        load.iter().for_each(|(dof, f)| force[*dof] += share * f);
    }
    let mut solution = faer::Mat::from_fn(force.len(), 1, |i, _| force[i]);
    sprung.solve(solution.as_mut());
    let exact = solution.col_as_slice(0);
    for held in [0, 3, 9] {
        let free = reduced.free_modes(held).unwrap();
        let residual = reduced.residual_compliance(held);
        let count = free.flank.count();
        assert_eq!(count, nb - 3 + held);
        let at = stations.stencil(tau);
        let bore_motion = |m: usize, b: usize| {
            let way = free.bore(m, b / per);
            [way.centre.x, way.centre.y].into_iter().chain(way.rim).nth(b % per).unwrap()
        };
        let q: Vec<f64> = (0..count)
            .map(|m| {
                let rims: f64 = on_rims.iter().enumerate().map(|(b, f)| f * bore_motion(m, b)).sum();
                (free.flank.at(m, &at) + rims) / free.flank.eigenvalues[m]
            })
            .collect();
        // Displacements of flank and rims in the mean axes, and those of the full mesh after the best rigid
        // motion.
        let mut rows = Vec::new();
        let (axes, quarter) =
            ([crate::geometry::Vec2::x(), crate::geometry::Vec2::y()], crate::geometry::quarter_turn);
        let rigid = |place: crate::geometry::Vec2, along: crate::geometry::Vec2| {
            [along.x, along.y, along.dot(&quarter(place)) / 0.05]
        };
        for place in places.iter().filter(|place| **place != tau) {
            let there = stations.stencil(*place);
            let modal: f64 = (0..count).map(|m| q[m] * free.flank.at(m, &there)).sum();
            let normal = -model.shape.profile.outward_normal(*place);
            rows.push((
                modal + residual.cross(&at, &there),
                model.read_surface(exact, *place),
                rigid(model.shape.profile.flank_point(*place), normal),
            ));
        }
        for b in 0..nb {
            let modal: f64 = (0..count).map(|m| q[m] * bore_motion(m, b)).sum();
            let moves = axes.get(b % per).map_or([0.0; 3], |axis| rigid(bores[b / per], *axis));
            rows.push((modal, reduction::read(&loads[b], exact), moves));
        }
        let moves = nalgebra::DMatrix::from_fn(rows.len(), 3, |i, j| rows[i].2[j]);
        let apart = nalgebra::DVector::from_iterator(rows.len(), rows.iter().map(|row| row.0 - row.1));
        let rigidly = (moves.transpose() * &moves).lu().solve(&(moves.transpose() * &apart)).unwrap();
        let left = apart - moves * rigidly;
        let largest = rows[places.len() - 1..].iter().fold(0.0_f64, |most, row| most.max(row.0.abs()));
        assert!(left.amax() < 3e-4 * largest, "{held}: {left} of {largest:e}");
    }
}

/// Small bores far apart in a large disc ovalise as holes in an infinite sheet: under a pressure p cos 2φ by p
/// r (5 − ν)/(3 E), under a uniform one by p r (1 + ν)/E (Michell, Lamé).
#[test]
fn val_rims_of_small_bores_are_holes_in_a_sheet() {
    let mut shape = DiscShape::of(&tao2024(), 0);
    let radius = 2e-3;
    for bore in &mut shape.bores {
        *bore = RoundHole { centre: 0.5 * bore.centre, radius };
    }
    shape.holes.clear();
    let settings = FlexibleSettings { interface: BoreInterface::Rims, ..coarse(&shape) };
    let model = DiscModel::new(shape, settings).unwrap();
    let (_, stiffness) = model.held_means().unwrap().constraint_modes();
    let n = carrier::SEAT_COORDINATES;
    let steel = &model.shape.material;
    let (e, nu) = (steel.youngs_modulus, steel.poisson_ratio);
    let pressure = 1.0 / (std::f64::consts::PI * radius * model.shape.width);
    let sheet = |order: usize| match order {
        0 => 0.5 * pressure * radius * (1.0 + nu) / e,
        _ => pressure * radius * (5.0 - nu) / (3.0 * e),
    };
    for (at, order) in [(2, 0), (3, 2), (4, 2)] {
        // The coupling of the rims is weak: their compliance is the inverse of their own stiffness.
        for bore in 0..2 {
            let k = bore * n + at;
            let ratio = 1.0 / stiffness[k * 2 * n + k] / sheet(order);
            assert!((ratio - 1.0).abs() < 0.02, "bore {bore}, order {order}: {ratio}");
        }
    }
}
