use super::*;

fn units(count: usize) -> Vec<Distribution> {
    vec![Distribution::Uniform { low: 0.0, high: 1.0 }; count]
}

fn all(layout: Layout, dimensions: usize, samples: u64) -> Vec<Vec<f64>> {
    let sampling = Sampling::new(layout, units(dimensions), samples, 7).unwrap();
    (0..sampling.rows()).map(|row| sampling.point(row).unit).collect()
}

#[test]
fn a_row_depends_on_seed_and_number_alone() {
    for layout in [
        Layout::Random,
        Layout::LatinHypercube,
        Layout::Sobol,
        Layout::Morris { levels: 4 },
        Layout::Saltelli { second_order: true },
        Layout::Tighten { share: 0.2 },
    ] {
        let sampling = Sampling::new(layout.clone(), units(3), 16, 7).unwrap();
        let again = Sampling::new(layout.clone(), units(3), 16, 7).unwrap();
        let forward: Vec<Point> = (0..sampling.rows()).map(|row| sampling.point(row)).collect();
        let mut backward: Vec<Point> = (0..again.rows()).rev().map(|row| again.point(row)).collect();
        backward.reverse();
        assert_eq!(forward, backward);
        let other = Sampling::new(layout.clone(), units(3), 16, 8).unwrap();
        assert_ne!(forward, (0..other.rows()).map(|row| other.point(row)).collect::<Vec<_>>(), "{layout:?}");
        assert!(forward.iter().flat_map(|p| &p.unit).all(|u| (0.0..=1.0).contains(u)));
    }
}

/// Pins what is drawn: a study resumed with a later version must go on with the same samples.
#[test]
fn regress_points_are_pinned() {
    let layouts = [Layout::Random, Layout::LatinHypercube, Layout::Sobol, Layout::Morris { levels: 4 }];
    let points = layouts.map(|layout| Sampling::new(layout, units(2), 100, 7).unwrap().point(42).unit);
    assert_eq!(points, PINNED);
}
const PINNED: [[f64; 2]; 4] = [
    [0.5530644596446225, 0.5640191292446607],
    [0.7055306445964462, 0.10564019129244662],
    [0.5473328895168379, 0.18973804137203842],
    [0.3333333333333333, 1.0],
];

#[test]
fn a_longer_study_begins_with_the_shorter_one() {
    for layout in [Layout::Random, Layout::Sobol, Layout::Morris { levels: 4 }] {
        let (short, long) = (all(layout.clone(), 3, 20), all(layout.clone(), 3, 50));
        assert_eq!(short[..], long[..short.len()], "{layout:?}");
    }
}

#[test]
fn a_grid_has_every_combination_once_with_both_ends() {
    let factors = vec![
        Distribution::Uniform { low: 1.0, high: 3.0 },
        Distribution::List { count: 2 },
        Distribution::LogUniform { low: 1.0, high: 100.0 },
    ];
    let grid = Sampling::new(Layout::Grid { levels: vec![3, 2, 3] }, factors, 0, 0).unwrap();
    assert_eq!(grid.rows(), 18);
    let rows: Vec<Vec<Value>> = (0..18).map(|row| grid.values(&grid.point(row))).collect();
    assert_eq!(rows[0], [Value::Number(1.0), Value::Entry(0), Value::Number(1.0)]);
    assert_eq!(rows[17], [Value::Number(3.0), Value::Entry(1), Value::Number(100.0)]);
    assert_eq!(rows[7][..2], [Value::Number(2.0), Value::Entry(0)]);
    let Value::Number(middle) = rows[7][2] else { panic!() };
    assert!((middle - 10.0).abs() < 1e-13);
    for (k, row) in rows.iter().enumerate() {
        assert!(!rows[k + 1..].contains(row));
    }
}

#[test]
fn a_latin_hypercube_has_one_sample_in_each_stratum() {
    let points = all(Layout::LatinHypercube, 5, 37);
    for dimension in 0..5 {
        let mut strata: Vec<usize> = points.iter().map(|p| (p[dimension] * 37.0) as usize).collect();
        strata.sort_unstable();
        assert_eq!(strata, (0..37).collect::<Vec<_>>());
    }
}

/// Every elementary interval of volume 2⁻⁸ in two dimensions holds exactly one of 256 points: the first two
/// dimensions are a (0, 8, 2)-net in base 2, scrambled or not.
#[test]
fn the_scrambled_sequence_is_a_net() {
    let points = all(Layout::Sobol, 2, 256);
    for bits in 0..=8_u32 {
        let (across, along) = (2_usize.pow(bits), 2_usize.pow(8 - bits));
        let mut seen = vec![0; 256];
        for p in &points {
            seen[(p[0] * across as f64) as usize * along + (p[1] * along as f64) as usize] += 1;
        }
        assert!(seen.iter().all(|count| *count == 1), "{across} × {along}");
    }
}

/// The mean of a smooth function of eight variables is found far better than by chance.
#[test]
fn the_sequence_integrates_better_than_chance() {
    // ∏ (1 + (u − ½)/2) has mean 1; standard deviation √((1 + 1/48)⁸ − 1) = 0.42.
    let f = |p: &Vec<f64>| p.iter().map(|u| 1.0 + 0.5 * (u - 0.5)).product::<f64>();
    let error = |layout| {
        let points = all(layout, 8, 4096);
        (points.iter().map(f).sum::<f64>() / 4096.0 - 1.0).abs()
    };
    let by_chance = 0.42 / 64.0;
    assert!(error(Layout::Random) < 4.0 * by_chance);
    assert!(error(Layout::Sobol) < 0.02 * by_chance, "{}", error(Layout::Sobol));
    assert!(error(Layout::LatinHypercube) < 0.5 * by_chance, "{}", error(Layout::LatinHypercube));
}

#[test]
fn a_trajectory_moves_every_dimension_once_by_delta() {
    let (dimensions, levels) = (6, 4);
    let points = all(Layout::Morris { levels }, dimensions, 50);
    let delta = levels as f64 / (2.0 * (levels as f64 - 1.0));
    let (mut ups, mut firsts) = (0, vec![0; dimensions]);
    for trajectory in points.chunks(dimensions + 1) {
        let mut moved = vec![false; dimensions];
        for step in trajectory.windows(2) {
            let changes: Vec<usize> = (0..dimensions).filter(|d| step[0][*d] != step[1][*d]).collect();
            let [changed] = changes[..] else { panic!("{changes:?}") };
            assert!(((step[1][changed] - step[0][changed]).abs() - delta).abs() < 1e-15);
            ups += usize::from(step[1][changed] > step[0][changed]);
            firsts[changed] += usize::from(!moved.contains(&true));
            moved[changed] = true;
        }
        assert!(moved.iter().all(|moved| *moved));
    }
    // 300 fair coins: 150 ± 5·8.7; each dimension first in 50/6 of 50 trajectories.
    assert!((ups as i32 - 150).abs() < 44, "{ups}");
    assert!(firsts.iter().all(|n| *n > 0 && *n < 25), "{firsts:?}");
}

#[test]
fn saltelli_rows_exchange_one_column() {
    let n = 3;
    for second_order in [false, true] {
        let sampling = Sampling::new(Layout::Saltelli { second_order }, units(n), 4, 1).unwrap();
        let step = sampling.rows_per_sample();
        for base in 0..4 {
            let row = |within: u64| sampling.point(base * step + within).unit;
            let (a, b) = (row(0), row(step - 1));
            assert!(a.iter().zip(&b).all(|(a, b)| a != b));
            for d in 0..n {
                let mut expected = a.clone();
                expected[d] = b[d];
                assert_eq!(row(1 + d as u64), expected);
                if second_order {
                    let mut expected = b.clone();
                    expected[d] = a[d];
                    assert_eq!(row(1 + (n + d) as u64), expected);
                }
            }
        }
    }
}

#[test]
fn tightened_rows_are_the_same_machine_with_one_spread_less() {
    let factors = vec![Distribution::Uniform { low: 0.0, high: 2.0 }, Distribution::Drawn];
    let sampling = Sampling::new(Layout::Tighten { share: 0.25 }, factors, 5, 3).unwrap();
    let (base, first, second) = (sampling.point(6), sampling.point(7), sampling.point(8));
    assert_eq!((base.tightened, &base.unit), (None, &first.unit));
    assert_eq!(second.tightened, Some((1, 0.25)));
    let (drawn, less) = (sampling.values(&base), sampling.values(&first));
    let (Value::Number(x), Value::Number(y)) = (drawn[0], less[0]) else { panic!() };
    assert!((y - (1.0 + 0.75 * (x - 1.0))).abs() < 1e-15 && drawn[1] == less[1]);
}

#[test]
fn invalid_layouts_are_refused_with_a_reason() {
    let reason =
        |layout, factors, samples| Sampling::new(layout, factors, samples, 0).unwrap_err().to_string();
    assert!(reason(Layout::Random, vec![], 5).contains("nothing varies"));
    assert!(reason(Layout::Random, units(1), 0).contains("is 0"));
    assert!(reason(Layout::Sobol, units(1), 65_537).contains("65536 points"));
    assert!(reason(Layout::Saltelli { second_order: false }, units(129), 8).contains("in 258"));
    assert!(reason(Layout::Morris { levels: 5 }, units(1), 8).contains("even"));
    assert!(reason(Layout::Grid { levels: vec![2] }, units(2), 0).contains("levels"));
    assert!(reason(Layout::Grid { levels: vec![usize::MAX; 2] }, units(2), 0).contains("too many points"));
    assert!(reason(Layout::Tighten { share: 0.0 }, units(2), 4).contains("share"));
}
