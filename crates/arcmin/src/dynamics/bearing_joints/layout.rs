use super::Arm;
use crate::machine::{FixedMember, Kinematics, Machine};
use crate::units::ARCMIN;

/// Where each coordinate sits. Free coordinates come first, those that are held or prescribed after them.
///
/// Shaft stations come first of all: elimination then fills little.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    pub cranks: usize,
    pub discs: usize,
    /// Modes of every disc; none where discs are rigid.
    modes: Vec<usize>,
    at_rest: FixedMember,
    /// (x, y, θ) of the carrier where the crankshafts sit.
    carrier: [usize; 3],
    /// Angle of the carrier's flange: its own where the carrier is elastic in torsion.
    flange: usize,
    housing: [usize; 3],
    /// Turn of the sun.
    sun_angle: usize,
    /// Turn of the input: that of the sun where the input shaft is rigid.
    input: usize,
    size: usize,
    whole: usize,
}

/// What turns apart from its neighbour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Degrees {
    /// The carrier's flange from the carrier.
    pub flange: bool,
    /// The sun from the input.
    pub input_shaft: bool,
    /// Whether the input is driven by a torque rather than prescribed.
    pub free_input: bool,
}

impl Layout {
    /// `modes` holds the number of modes of every disc.
    pub fn new(cranks: usize, modes: Vec<usize>, at_rest: FixedMember, degrees: Degrees) -> Layout {
        let discs = modes.len();
        let mut next = cranks * (2 * (discs + 2) + 1) + 3 * discs + modes.iter().sum::<usize>() + 2;
        let mut take = |count: usize| {
            next += count;
            next - count
        };
        let mut layout = Layout {
            cranks,
            discs,
            modes,
            at_rest,
            carrier: [0; 3],
            flange: 0,
            housing: [0; 3],
            sun_angle: 0,
            input: 0,
            size: 0,
            whole: 0,
        };
        match at_rest {
            FixedMember::Housing => {
                let at = take(3);
                layout.carrier = [at, at + 1, at + 2];
                layout.flange = if degrees.flange { take(1) } else { at + 2 };
            }
            FixedMember::Carrier => {
                let at = take(3);
                layout.housing = [at, at + 1, at + 2];
                if degrees.flange {
                    layout.carrier[2] = take(1);
                }
            }
        }
        let sun_is_free = degrees.input_shaft || degrees.free_input;
        if sun_is_free {
            layout.sun_angle = take(1);
        }
        layout.input = if degrees.input_shaft && degrees.free_input { take(1) } else { layout.sun_angle };
        layout.size = take(0);
        match at_rest {
            FixedMember::Housing => {
                let at = take(3);
                layout.housing = [at, at + 1, at + 2];
            }
            FixedMember::Carrier => {
                let at = take(3);
                (layout.carrier[0], layout.carrier[1], layout.flange) = (at, at + 1, at + 2);
                if !degrees.flange {
                    layout.carrier[2] = at + 2;
                }
            }
        }
        if !degrees.free_input {
            layout.input = take(1);
        }
        if !sun_is_free {
            layout.sun_angle = layout.input;
        }
        layout.whole = take(0);
        layout
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
        self.crank(self.cranks) + 3 * j + self.modes[..j].iter().sum::<usize>()
    }

    /// Modes of disc j.
    pub fn modes(&self, j: usize) -> std::ops::Range<usize> {
        let first = self.disc(j) + 3;
        first..first + self.modes[j]
    }

    /// x of every centre that moves in the plane, the housing's apart.
    pub fn centres(&self) -> impl Iterator<Item = usize> {
        let stations = (0..self.cranks)
            .flat_map(move |k| (0..self.discs + 2).map(move |station| self.crank(k) + 2 * station));
        stations
            .chain((0..self.discs).map(|j| self.disc(j)))
            .chain([self.sun(), self.carrier[0]])
            .filter(|x| *x < self.size)
    }

    /// x of the sun.
    pub fn sun(&self) -> usize {
        self.disc(self.discs)
    }

    pub fn carrier(&self) -> [usize; 3] {
        self.carrier
    }

    pub fn housing(&self) -> [usize; 3] {
        self.housing
    }

    pub fn housing_moves(&self) -> bool {
        self.at_rest == FixedMember::Carrier
    }

    /// Angle of the carrier's flange, where it turns apart from the carrier.
    pub fn flange(&self) -> Option<usize> {
        (self.flange != self.carrier[2]).then_some(self.flange)
    }

    /// Angle of the output.
    pub fn output(&self) -> usize {
        match self.at_rest {
            FixedMember::Housing => self.flange,
            FixedMember::Carrier => self.housing[2],
        }
    }

    pub fn sun_angle(&self) -> usize {
        self.sun_angle
    }

    pub fn input(&self) -> usize {
        self.input
    }

    pub fn has_free_input(&self) -> bool {
        self.input < self.size
    }

    /// Number of free coordinates.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Number of all coordinates.
    pub fn whole(&self) -> usize {
        self.whole
    }

    pub fn mass(&self, machine: &Machine) -> Vec<f64> {
        let mut mass = vec![0.0; self.whole];
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
            mass[self.modes(j)].fill(1.0);
        }
        // The sun as a steel cylinder of twice its face width, an assumption that matters for vibrations
        // only.
        let stage = &machine.gear_stage;
        let radius = stage.sun_pitch_radius();
        let sun = machine.crankshafts.material.density
            * std::f64::consts::PI
            * radius
            * radius
            * 2.0
            * stage.face_width;
        let at = self.sun();
        mass[at..at + 2].fill(sun.max(1e-3));
        for axis in 0..2 {
            mass[self.carrier[axis]] = machine.carrier.mass;
            mass[self.housing[axis]] = machine.housing.mass;
        }
        mass[self.housing[2]] = machine.housing.inertia;
        // Half of an elastic carrier's inertia goes with its flange.
        let halves = if self.flange().is_some() { 0.5 } else { 1.0 };
        mass[self.flange] = halves * machine.carrier.inertia;
        mass[self.carrier[2]] = halves * machine.carrier.inertia;
        mass[self.input] += stage.motor_inertia;
        mass[self.sun_angle] += stage.sun_inertia;
        mass.truncate(self.size);
        mass
    }

    /// One minute of arc at the output, as places (at the radius of the crankshafts) and angles, and a modal
    /// coordinate's unit of error.
    pub fn scale(&self, kinematics: &Kinematics, radius: f64, mode: f64) -> Vec<f64> {
        let mut scale = vec![radius * ARCMIN; self.whole];
        for k in 0..self.cranks {
            scale[self.crank_angle(k)] = kinematics.lobe_count * ARCMIN;
        }
        for j in 0..self.discs {
            scale[self.disc(j) + 2] = ARCMIN;
            scale[self.modes(j)].fill(mode);
        }
        for angle in [self.carrier[2], self.flange, self.housing[2]] {
            scale[angle] = ARCMIN;
        }
        for angle in [self.sun_angle, self.input] {
            scale[angle] = kinematics.housing_fixed_ratio().abs() * ARCMIN;
        }
        scale.truncate(self.size);
        scale
    }

    /// Free coordinates of the nominal machine at the sun angle `sun`.
    pub fn nominal(&self, kinematics: &Kinematics, carrier_bores: &[Arm], sun: f64) -> Vec<f64> {
        let mut q = vec![0.0; self.whole];
        let output = sun / kinematics.ratio();
        let (carrier, housing) = match self.at_rest {
            FixedMember::Housing => (output, 0.0),
            FixedMember::Carrier => (0.0, output),
        };
        let crank = housing - kinematics.lobe_count * (carrier - housing);
        for (k, bore) in carrier_bores.iter().enumerate() {
            let axis = bore.at(carrier);
            for station in 0..self.discs + 2 {
                let at = self.crank(k) + 2 * station;
                (q[at], q[at + 1]) = (axis.x, axis.y);
            }
            q[self.crank_angle(k)] = crank;
        }
        for j in 0..self.discs {
            let pose = kinematics.disc_pose(j, crank, carrier);
            let at = self.disc(j);
            (q[at], q[at + 1], q[at + 2]) = (pose.centre.x, pose.centre.y, pose.angle);
        }
        (q[self.carrier[2]], q[self.flange], q[self.housing[2]]) = (carrier, carrier, housing);
        (q[self.sun_angle], q[self.input]) = (sun, sun);
        q.truncate(self.size);
        q
    }
}
