//! Output torque from the torque of the motor.

use super::clock::median;

/// Quantities of the motor's shaft at each reading.
pub(super) struct Shaft<'a> {
    /// Times, s.
    pub time: &'a [f64],
    /// Torque of the motor in N·m.
    pub torque: Vec<f64>,
    /// Output speed in rad/s.
    pub speed: &'a [f64],
    pub connected: &'a [bool],
    pub moves: &'a [bool],
    pub ratio: f64,
    pub efficiency: f64,
    /// Moment of inertia of the rotor, kg·m².
    pub rotor_inertia: f64,
}

/// Torque in N·m at the output.
///
/// The input torque of the reducer is the motor's torque τ less J dω/dt of its rotor. If it has the direction
/// of the motion, the motor drives and i η of it is transmitted. Against the motion the load drives, and τ is
/// the part η of its torque: T = τ i/η. At rest the direction of friction is unknown: T = τ i.
pub(super) fn output_torque(shaft: &Shaft) -> Vec<f64> {
    let half = shaft.half_width();
    let at = |i: usize| {
        let left = shaft.torque[i] - shaft.rotor_inertia * shaft.ratio * shaft.acceleration(i, half);
        let through = match shaft.moves[i] {
            false => 1.0,
            true if left * shaft.speed[i] >= 0.0 => shaft.efficiency,
            true => 1.0 / shaft.efficiency,
        };
        left * shaft.ratio * through
    };
    (0..shaft.torque.len()).map(at).collect()
}

impl Shaft<'_> {
    /// Number of readings on either side for the differences of speeds: as many as keep their noise below a
    /// fiftieth of the largest torque, within a twentieth of a second.
    fn half_width(&self) -> usize {
        if self.rotor_inertia == 0.0 || self.time.len() < 3 {
            return 1;
        }
        let steps: Vec<f64> = self.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let step = median(&steps);
        let bends: Vec<f64> = self.speed.windows(3).map(|v| (v[2] - 2.0 * v[1] + v[0]).abs()).collect();
        let noise = median(&bends) / (0.6745 * 6_f64.sqrt());
        let most = self.torque.iter().fold(0.0_f64, |most, torque| most.max(torque.abs()));
        let within = ((0.05 / step) as usize).clamp(1, 100);
        let left = |h: usize| {
            self.rotor_inertia * self.ratio.abs() * noise / (2_f64.sqrt() * h as f64 * step) <= 0.02 * most
        };
        (1..=within).find(|h| left(*h)).unwrap_or(within)
    }

    /// rad/s² at the output, between neighbouring readings without a gap.
    fn acceleration(&self, i: usize, half: usize) -> f64 {
        let (mut a, mut b) = (i, i);
        while a > 0 && i - a < half && self.connected[a] {
            a -= 1;
        }
        while b + 1 < self.time.len() && b - i < half && self.connected[b + 1] {
            b += 1;
        }
        if a == b { 0.0 } else { (self.speed[b] - self.speed[a]) / (self.time[b] - self.time[a]) }
    }
}
