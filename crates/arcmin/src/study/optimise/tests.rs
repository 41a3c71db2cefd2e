use std::f64::consts::{PI, TAU};

use super::*;

/// Runs a search over f on [−range, range]ⁿ and returns its best goal and the generations it took to reach
/// `aim`.
fn search(
    n: usize,
    range: f64,
    start: f64,
    population: Option<usize>,
    seed: u64,
    (generations, aim): (u64, f64),
    f: impl Fn(&[f64]) -> Outcome,
) -> (Vec<f64>, Outcome, u64) {
    let real = |u: &[f64]| -> Vec<f64> { u.iter().map(|u| range * (2.0 * u - 1.0)).collect() };
    let unit = vec![0.5 * (start / range + 1.0); n];
    let mut cma = CmaEs::new(&unit, 0.2, population, seed).unwrap();
    while cma.generation() < generations
        && !cma.best().is_some_and(|(_, o)| o.is_feasible() && o.goals[0] < aim)
    {
        let outcomes: Vec<Outcome> = cma.ask().iter().map(|u| f(&real(u))).collect();
        cma.tell(&outcomes).unwrap();
    }
    let (place, outcome) = cma.best().unwrap();
    (real(place), outcome.clone(), cma.generation())
}

fn goal(value: f64) -> Outcome {
    Outcome { goals: vec![value], constraints: vec![] }
}

fn rosenbrock(x: &[f64]) -> f64 {
    x.windows(2).map(|w| 100.0 * (w[1] - w[0] * w[0]).powi(2) + (1.0 - w[0]).powi(2)).sum()
}

#[test]
fn cma_reaches_known_optima() {
    for seed in 0..3 {
        let sphere = |x: &[f64]| goal(x.iter().map(|x| x * x).sum());
        let (_, best, generations) = search(10, 5.0, 3.0, None, seed, (400, 1e-10), sphere);
        // pycma takes about 170 generations of ten from there.
        assert!(best.goals[0] < 1e-10 && generations < 260, "sphere {best:?} after {generations}");
        // Axes of lengths 1 … 1000.
        let ellipsoid =
            |x: &[f64]| goal(x.iter().enumerate().map(|(k, x)| 1e6_f64.powf(k as f64 / 9.0) * x * x).sum());
        let (_, best, generations) = search(10, 5.0, 3.0, None, seed, (1500, 1e-10), ellipsoid);
        assert!(best.goals[0] < 1e-10 && generations < 900, "ellipsoid {best:?} after {generations}");
        let (place, best, generations) =
            search(8, 3.0, -1.0, None, seed, (3000, 1e-10), |x| goal(rosenbrock(x)));
        // One run in about six ends in the other minimum, at (−1, 1, …), with 3.99.
        let local = best.goals[0] > 3.9 && best.goals[0] < 4.1;
        assert!(best.goals[0] < 1e-10 || local, "Rosenbrock {best:?} at {place:?} after {generations}");
    }
    // Many minima: a larger population finds the lowest.
    let rastrigin = |x: &[f64]| goal(x.iter().map(|x| 10.0 + x * x - 10.0 * (TAU * x).cos()).sum::<f64>());
    let found = |seed: &u64| search(5, 5.12, 0.5, Some(200), *seed, (250, 1e-8), rastrigin).1.goals[0] < 1e-8;
    assert!((0..4).filter(found).count() >= 3, "Rastrigin");
}

#[test]
fn cma_finds_an_optimum_on_the_bound() {
    // The least of the sphere around (1.2, …) within the cube up to 1 is its corner: 3·0.04.
    let (_, best, _) =
        search(3, 1.0, 0.0, None, 1, (300, 0.12 + 1e-7), |x| goal(x.iter().map(|x| (x - 1.2).powi(2)).sum()));
    assert!((best.goals[0] - 0.12).abs() < 1e-6, "{best:?}");
}

/// Optima on the bound of a constraint, known in closed form.
#[test]
fn cma_keeps_constraints() {
    for seed in 0..3 {
        // TR2 (Kramer & Schwefel 2006): the sphere with Σx ≥ n has its least value n at (1, …, 1).
        let tangent = |x: &[f64]| Outcome {
            goals: vec![x.iter().map(|x| x * x).sum()],
            constraints: vec![x.len() as f64 - x.iter().sum::<f64>()],
        };
        let (_, best, generations) = search(5, 5.0, 4.0, None, seed, (1500, 5.0 + 1e-5), tangent);
        assert!(best.goals[0] < 5.0 + 1e-5, "TR2 {best:?} after {generations}");
        // Rosenbrock within the disc x² + y² ≤ 1.5: (0.907234, 0.822755), 0.0086286 (Lagrange's condition by
        // hand, below).
        let disc = |x: &[f64]| Outcome {
            goals: vec![rosenbrock(x)],
            constraints: vec![x[0] * x[0] + x[1] * x[1] - 1.5],
        };
        let exact = rosenbrock_on_disc(1.5_f64.sqrt());
        let (_, best, _) = search(2, 2.0, -1.0, None, seed, (1500, exact + 1e-7), disc);
        assert!(best.is_feasible() && best.goals[0] < exact + 1e-6, "disc {best:?} {exact}");
    }
}

/// Least of Rosenbrock's function on a circle by golden section of the angle.
fn rosenbrock_on_disc(radius: f64) -> f64 {
    let f = |angle: f64| rosenbrock(&[radius * angle.cos(), radius * angle.sin()]);
    let (mut low, mut high) = (0.5_f64, 1.0_f64);
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..200 {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        if f(a) < f(b) { high = b } else { low = a }
    }
    f(0.5 * (low + high))
}

#[test]
fn a_search_is_resumed_where_it_stopped() {
    let f = |u: &Vec<f64>| goal(rosenbrock(u));
    let mut straight = CmaEs::new(&[0.2; 4], 0.2, None, 5).unwrap();
    let mut resumed = straight.clone();
    for _ in 0..40 {
        let told: Vec<Outcome> = straight.ask().iter().map(f).collect();
        straight.tell(&told).unwrap();
        let text = serde_json::to_string(&resumed).unwrap();
        resumed = serde_json::from_str(&text).unwrap();
        let told: Vec<Outcome> = resumed.ask().iter().map(f).collect();
        resumed.tell(&told).unwrap();
    }
    assert_eq!(straight, resumed);
    assert!(straight.tell(&[]).is_err());
    assert!(CmaEs::new(&[1.5], 0.1, None, 0).is_err() && CmaEs::new(&[], 0.1, None, 0).is_err());
}

#[test]
fn failed_designs_rank_last_and_stop_nothing() {
    // Whatever lies left of 0 fails: a wall that the search must walk along.
    let (place, best, _) = search(3, 2.0, 1.0, None, 2, (300, 1e-9), |x| {
        if x[0] < 0.0 { Outcome::failed() } else { goal(x.iter().map(|x| x * x).sum()) }
    });
    assert!(best.goals[0] < 1e-6 && place[0] >= 0.0, "{best:?}");
    let mut all_fail = CmaEs::new(&[0.5; 2], 0.2, None, 0).unwrap();
    for _ in 0..50 {
        let told = vec![Outcome::failed(); all_fail.population()];
        all_fail.tell(&told).unwrap();
    }
    assert!(all_fail.ask().iter().flatten().all(|u| (0.0..=1.0).contains(u)));
}

/// Zitzler, Deb & Thiele (2000): two goals over 30 variables, the fronts known.
fn zdt(number: usize, x: &[f64]) -> Outcome {
    let g = 1.0 + 9.0 * x[1..].iter().sum::<f64>() / (x.len() - 1) as f64;
    Outcome { goals: vec![x[0], front_height(number, x[0], g)], constraints: vec![] }
}

fn front_height(number: usize, f: f64, g: f64) -> f64 {
    match number {
        1 => g * (1.0 - (f / g).sqrt()),
        2 => g * (1.0 - (f / g).powi(2)),
        _ => g * (1.0 - (f / g).sqrt() - f / g * (10.0 * PI * f).sin()),
    }
}

#[test]
fn nsga2_reaches_known_fronts() {
    for number in 1..=3 {
        let mut search = Nsga2::new(30, 100, 1).unwrap();
        for _ in 0..250 {
            let told: Vec<Outcome> = search.ask().iter().map(|x| zdt(number, x)).collect();
            search.tell(&told).unwrap();
        }
        let front = search.front();
        // Deb et al. report distances of 0.03 to 0.11 (table II, after 250 generations of 100, γ of the
        // mean).
        let above: Vec<f64> =
            front.iter().map(|(_, o)| o.goals[1] - front_height(number, o.goals[0], 1.0)).collect();
        let mean = above.iter().sum::<f64>() / above.len() as f64;
        assert!(mean < 0.03, "ZDT{number}: {mean} above the front");
        let mut firsts: Vec<f64> = front.iter().map(|(_, o)| o.goals[0]).collect();
        firsts.sort_by(f64::total_cmp);
        let end = if number == 3 { 0.80 } else { 0.97 };
        assert!(firsts.len() > 80 && firsts[0] < 0.02 && firsts[firsts.len() - 1] > end, "ZDT{number}");
    }
}

#[test]
fn nsga2_keeps_constraints_and_resumes() {
    // Least of (x, y) under x² + y² ≥ 0.25: a quarter of a circle.
    let f = |u: &Vec<f64>| Outcome { goals: u.clone(), constraints: vec![0.25 - u[0] * u[0] - u[1] * u[1]] };
    let mut search = Nsga2::new(2, 40, 3).unwrap();
    let mut resumed = search.clone();
    for _ in 0..200 {
        let told: Vec<Outcome> = search.ask().iter().map(f).collect();
        search.tell(&told).unwrap();
        resumed = serde_json::from_str(&serde_json::to_string(&resumed).unwrap()).unwrap();
        let told: Vec<Outcome> = resumed.ask().iter().map(f).collect();
        resumed.tell(&told).unwrap();
    }
    assert_eq!(search, resumed);
    let front = search.front();
    assert!(front.len() > 30);
    assert!(front.iter().all(|(_, outcome)| outcome.is_feasible()));
    let outside =
        front.iter().map(|(place, _)| place[0].hypot(place[1]) - 0.5).sum::<f64>() / front.len() as f64;
    assert!(outside < 0.01, "{outside}");
}
