use super::super::{DenseLinearisation, EquilibriumControl, solve_equilibrium};
use super::*;

/// A ball of 1 kg between two walls, with an initial speed of 1 m/s; wall stiffness in N/m, gravity in N, jump
/// of the force at a given time.
#[derive(Clone, Copy)]
struct Ball {
    wall: f64,
    damping: f64,
    pull: f64,
    jump: Option<(f64, f64)>,
}

impl System for Ball {
    fn linearisation(&self) -> DenseLinearisation {
        DenseLinearisation::new(1)
    }

    fn mass(&self) -> &[f64] {
        &[1.0]
    }

    fn scale(&self) -> &[f64] {
        &[1e-3]
    }

    fn evaluate(
        &self,
        time: f64,
        q: &[f64],
        v: &[f64],
        force: &mut [f64],
        lin: &mut DenseLinearisation,
    ) -> Balance {
        lin.clear();
        let depth = (q[0].abs() - 1.0).max(0.0);
        let stiffness = if depth > 0.0 { self.wall } else { 0.0 };
        let step = self.jump.map_or(0.0, |(at, by)| if time >= at { by } else { 0.0 });
        force[0] = self.pull + step - stiffness * depth * q[0].signum() - self.damping * v[0];
        lin.add_stiffness(0, 0, stiffness);
        lin.add_damping(0, 0, self.damping);
        let closing = q[0].signum() * v[0];
        Balance {
            input_power: (self.pull + step) * v[0],
            dissipation: self.damping * v[0] * v[0],
            stored: 0.5 * stiffness * depth * depth,
            onset_rate: if depth == 0.0 && closing > 0.0 { closing / (1.0 - q[0].abs() + 1e-4) } else { 0.0 },
            ..Balance::default()
        }
    }

    fn next_breakpoint(&self, time: f64) -> Option<f64> {
        self.jump.map(|(at, _)| at).filter(|at| *at > time)
    }

    fn crank_angle(&self, _: &[f64]) -> f64 {
        0.0
    }
}

fn run(ball: &Ball, control: StepControl, position: f64, velocity: f64, end: f64) -> IntegratorState {
    let mut integrator = Integrator::new(*ball, control, 0.0, &[position], &[velocity]).unwrap();
    while integrator.time() < end {
        integrator.advance(end).unwrap();
    }
    integrator.into_state()
}

const FREE: Ball = Ball { wall: 1e8, damping: 0.0, pull: 0.0, jump: None };

/// Free flight at 1 m/s over 2 m and half a period π/√k in each wall: closed form of the position after many
/// bounces.
#[test]
fn ball_between_walls_has_the_closed_form_and_constant_energy() {
    let control = StepControl {
        tolerance: 1e-5,
        largest_step: 0.1,
        velocity_time: 1.0,
        spectral_radius: 1.0,
        ..StepControl::default()
    };
    let contact = std::f64::consts::PI / 1e4;
    let bounces = 10.0;
    let end = 1.0 + bounces * contact + (bounces - 1.0) * 2.0 + 1.0;
    let state = run(&FREE, control, 0.0, 1.0, end);
    assert!(state.current.position[0].abs() < 1e-4, "{}", state.current.position[0]);
    assert!((state.current.velocity[0] - 1.0).abs() < 1e-4);
    assert!((state.energy.current / state.energy.initial - 1.0).abs() < 2e-4, "{:?}", state.energy);
    // Free flight needs few steps.
    assert!(state.counts.accepted < 1000 * bounces as usize, "{}", state.counts.accepted);
}

#[test]
fn error_falls_with_the_square_of_a_fixed_step() {
    let oscillator = Ball { wall: 400.0, damping: 0.3, pull: 0.0, jump: None };
    // Within the right wall throughout: 1 + x, x = e^(-dt) (…) in closed form.
    let exact = |t: f64| {
        let (d, w) = (0.15_f64, (400.0_f64 - 0.15 * 0.15).sqrt());
        2.0 + (-d * t).exp() * 0.1 * ((w * t).cos() + d / w * (w * t).sin())
    };
    let lifted = Ball { pull: 400.0, ..oscillator };
    let error = |step: f64| {
        let control = StepControl { fixed_step: Some(step), spectral_radius: 0.9, ..StepControl::default() };
        (run(&lifted, control, 2.1, 0.0, 1.0).current.position[0] - exact(1.0)).abs()
    };
    let order = (error(2e-3) / error(1e-3)).log2();
    assert!((order - 2.0).abs() < 0.05, "{order}");
}

#[test]
fn a_jump_of_force_is_met_exactly() {
    let ball = Ball { jump: Some((0.3, 2.0)), ..FREE };
    let state = run(&ball, StepControl { largest_step: 1.0, ..StepControl::default() }, 0.0, 0.0, 0.8);
    assert!((state.current.position[0] - 0.25).abs() < 1e-9);
    assert!((state.energy.input - 0.5).abs() < 1e-9);
}

#[test]
fn resumed_run_is_bit_identical() {
    let ball = Ball { pull: 0.3, ..FREE };
    let control = StepControl::default();
    let mut whole = Integrator::new(ball, control, 0.0, &[0.0], &[1.0]).unwrap();
    for _ in 0..700 {
        whole.advance(10.0).unwrap();
    }
    let mut first = Integrator::new(ball, control, 0.0, &[0.0], &[1.0]).unwrap();
    for _ in 0..300 {
        first.advance(10.0).unwrap();
    }
    let mut second = Integrator::resume(ball, control, first.into_state()).unwrap();
    for _ in 0..400 {
        second.advance(10.0).unwrap();
    }
    assert_eq!(whole.state(), second.state());
}

/// Independent balls, each with its own walls; their number makes the matrix a large one.
#[derive(Clone)]
struct Balls {
    balls: Vec<Ball>,
    mass: Vec<f64>,
    scale: Vec<f64>,
}

impl Balls {
    fn new(ball: Ball, count: usize) -> Balls {
        let balls = (0..count).map(|i| Ball { wall: ball.wall * (1.0 + 0.01 * i as f64), ..ball });
        Balls { balls: balls.collect(), mass: vec![1.0; count], scale: vec![1e-3; count] }
    }
}

impl System for Balls {
    fn linearisation(&self) -> DenseLinearisation {
        DenseLinearisation::new(self.balls.len())
    }

    fn mass(&self) -> &[f64] {
        &self.mass
    }

    fn scale(&self) -> &[f64] {
        &self.scale
    }

    fn evaluate(
        &self,
        time: f64,
        q: &[f64],
        v: &[f64],
        force: &mut [f64],
        lin: &mut DenseLinearisation,
    ) -> Balance {
        lin.clear();
        let (mut own, mut balance) = (DenseLinearisation::new(1), Balance::default());
        for (i, ball) in self.balls.iter().enumerate() {
            let one = ball.evaluate(time, &q[i..=i], &v[i..=i], &mut force[i..=i], &mut own);
            lin.add_stiffness(i, i, own.stiffness(0, 0));
            lin.add_damping(i, i, own.damping(0, 0));
            balance.input_power += one.input_power;
            balance.dissipation += one.dissipation;
            balance.stored += one.stored;
            balance.onset_rate = balance.onset_rate.max(one.onset_rate);
        }
        balance
    }

    fn crank_angle(&self, _: &[f64]) -> f64 {
        0.0
    }
}

/// A large matrix is reused over several steps. A run from a saved state forms it again and continues
/// identically to the bit, and each ball moves as it does alone.
#[test]
fn a_large_matrix_is_reused_over_several_steps() {
    let ball = Ball { wall: 1e4, damping: 0.3, pull: 20.0, jump: None };
    let balls = Balls::new(ball, 128);
    let start = |control| Integrator::new(balls.clone(), control, 0.0, &[0.0; 128], &[1.0; 128]).unwrap();
    let go_on = |integrator: &mut Integrator<Balls>, steps: usize| {
        while integrator.state().counts.accepted < steps {
            integrator.advance(10.0).unwrap();
        }
    };
    let control = StepControl { largest_step: 1e-2, ..StepControl::default() };
    let (mut whole, mut first) = (start(control), start(control));
    go_on(&mut whole, 400);
    go_on(&mut first, 250);
    let mut second = Integrator::resume(balls.clone(), control, first.into_state()).unwrap();
    go_on(&mut second, 400);
    assert_eq!(whole.state(), second.state());
    let counts = whole.state().counts;
    assert!(2 * counts.tangents < counts.accepted, "{counts:?}");
    assert!(whole.state().energy.residual() < 1e-5, "{:?}", whole.state().energy);
    // Newton's method leaves an error of 1e-3 of the tolerance in every step.
    let fixed = StepControl { fixed_step: Some(1e-3), tolerance: 1e-6, ..control };
    let mut together = start(fixed);
    go_on(&mut together, 2000);
    for i in [0, 127] {
        let own = Ball { wall: ball.wall * (1.0 + 0.01 * i as f64), ..ball };
        let mut alone = Integrator::new(own, fixed, 0.0, &[0.0], &[1.0]).unwrap();
        while alone.state().counts.accepted < 2000 {
            alone.advance(10.0).unwrap();
        }
        let apart = (alone.current().position[0] - together.current().position[i]).abs();
        assert!(apart < 1e-8, "{i}: {apart:e}");
    }
}

#[test]
fn forces_that_are_nan_stop_the_run_and_keep_the_state() {
    let ball = Ball { jump: Some((0.5, f64::NAN)), ..FREE };
    let mut integrator = Integrator::new(ball, StepControl::default(), 0.0, &[0.0], &[1.0]).unwrap();
    let error = loop {
        if let Err(error) = integrator.advance(1.0) {
            break error;
        }
    };
    assert!(matches!(error, DynamicsError::StepFailed { time, .. } if (time - 0.5).abs() < 1e-9), "{error}");
    assert!((integrator.current().position[0] - 0.5).abs() < 1e-9);
    let negative = StepControl { largest_step: -1.0, ..StepControl::default() };
    assert!(Integrator::new(ball, negative, 0.0, &[0.0], &[1.0]).is_err());
}

#[test]
fn equilibrium_is_found_across_the_clearance_at_the_wall() {
    for pull in [5.0, -5.0, 1e5] {
        let ball = Ball { pull, ..FREE };
        let found = solve_equilibrium(&ball, 0.0, &[0.2], EquilibriumControl::default()).unwrap();
        let expected = pull.signum() * (1.0 + pull.abs() / 1e8);
        assert!((found.position[0] - expected).abs() < 1e-12, "{pull}: {found:?}");
    }
    let unloaded = solve_equilibrium(&FREE, 0.0, &[0.2], EquilibriumControl::default()).unwrap();
    assert_eq!(unloaded.position[0], 0.2);
}
