use super::Arm;
use crate::machine::{Kinematics, Machine};
use crate::units::ARCMIN;

/// Where each coordinate sits. Shaft stations come first: elimination then fills little.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    pub cranks: usize,
    pub discs: usize,
    /// Whether the output flange turns apart from the carrier.
    flange: bool,
    free_sun: bool,
}

impl Layout {
    pub fn new(cranks: usize, discs: usize, flange: bool, free_sun: bool) -> Layout {
        Layout { cranks, discs, flange, free_sun }
    }

    fn crank(&self, k: usize) -> usize {
        k * (2 * (self.discs + 2) + 1)
    }

    /// x of the shaft at a support.
    pub fn support(&self, k: usize, end: usize) -> usize {
        self.crank(k) + 2 * end
    }

    /// x of the shaft at disc j.
    pub fn disc_station(&self, k: usize, j: usize) -> usize {
        self.crank(k) + 4 + 2 * j
    }

    pub fn crank_angle(&self, k: usize) -> usize {
        self.crank(k) + 2 * (self.discs + 2)
    }

    /// x of disc j.
    pub fn disc(&self, j: usize) -> usize {
        self.crank(self.cranks) + 3 * j
    }

    /// x of the sun.
    pub fn sun(&self) -> usize {
        self.disc(self.discs)
    }

    /// x of the carrier.
    pub fn carrier(&self) -> usize {
        self.sun() + 2
    }

    /// Angle of the output.
    pub fn output(&self) -> usize {
        self.carrier() + 2 + usize::from(self.flange)
    }

    /// Angle of the sun: the last coordinate, or one beyond them where it is prescribed.
    pub fn sun_angle(&self) -> usize {
        self.output() + 1
    }

    pub fn has_flange(&self) -> bool {
        self.flange
    }

    pub fn has_free_sun(&self) -> bool {
        self.free_sun
    }

    pub fn size(&self) -> usize {
        self.sun_angle() + usize::from(self.free_sun)
    }

    pub fn mass(&self, machine: &Machine) -> Vec<f64> {
        let mut mass = vec![0.0; self.size()];
        let cranks = &machine.crankshafts;
        let stations = self.discs + 2;
        for k in 0..self.cranks {
            let at = self.crank(k);
            mass[at..at + 2 * stations].fill(cranks.mass / stations as f64);
            mass[self.crank_angle(k)] = cranks.inertia;
        }
        for j in 0..self.discs {
            let at = self.disc(j);
            mass[at..at + 2].fill(machine.disc.mass);
            mass[at + 2] = machine.disc.inertia;
        }
        // The sun as a steel cylinder of twice its face width, an assumption that matters for vibrations only.
        let radius = machine.gear_stage.sun_pitch_radius();
        let sun = machine.crankshafts.material.density * std::f64::consts::PI * radius * radius * 2.0 * machine.gear_stage.face_width;
        let at = self.sun();
        mass[at..at + 2].fill(sun.max(1e-3));
        let at = self.carrier();
        mass[at..at + 2].fill(machine.carrier.mass);
        mass[at + 2] = machine.carrier.inertia;
        if self.flange {
            // Half of the carrier's inertia goes with its output flange.
            mass[at + 2] *= 0.5;
            mass[at + 3] = mass[at + 2];
        }
        if self.free_sun {
            mass[self.sun_angle()] = machine.gear_stage.sun_inertia + machine.gear_stage.motor_inertia;
        }
        mass
    }

    /// One minute of arc at the output, as places (at the radius of the crankshafts) and angles.
    pub fn scale(&self, kinematics: &Kinematics, radius: f64) -> Vec<f64> {
        let mut scale = vec![radius * ARCMIN; self.size()];
        for k in 0..self.cranks {
            scale[self.crank_angle(k)] = kinematics.lobe_count * ARCMIN;
        }
        for j in 0..self.discs {
            scale[self.disc(j) + 2] = ARCMIN;
        }
        scale[self.carrier() + 2] = ARCMIN;
        scale[self.output()] = ARCMIN;
        if self.free_sun {
            scale[self.sun_angle()] = kinematics.housing_fixed_ratio().abs() * ARCMIN;
        }
        scale
    }

    /// Nominal coordinates at the sun angle `sun`.
    pub fn nominal(&self, kinematics: &Kinematics, carrier_bores: &[Arm], sun: f64) -> Vec<f64> {
        let mut q = vec![0.0; self.size()];
        let output = sun / kinematics.housing_fixed_ratio();
        let crank = -kinematics.lobe_count * output;
        for (k, bore) in carrier_bores.iter().enumerate() {
            let axis = bore.at(output);
            for station in 0..self.discs + 2 {
                let at = self.crank(k) + 2 * station;
                (q[at], q[at + 1]) = (axis.x, axis.y);
            }
            q[self.crank_angle(k)] = crank;
        }
        for j in 0..self.discs {
            let pose = kinematics.disc_pose(j, crank, output);
            let at = self.disc(j);
            (q[at], q[at + 1], q[at + 2]) = (pose.centre.x, pose.centre.y, pose.angle);
        }
        q[self.carrier() + 2] = output;
        q[self.output()] = output;
        if self.free_sun {
            q[self.sun_angle()] = sun;
        }
        q
    }
}
