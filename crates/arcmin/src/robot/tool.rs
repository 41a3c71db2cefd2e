//! Effect of joint errors on the tool: at the test poses as the program reaches them, at the same poses
//! approached from all sides, and along the path.

use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;

use super::arm::{Arm, Posture};
use super::file::Compensation;
use super::joint::{AgedJoint, JointModel, neighbours};
use super::loads::Course;
use super::memory::Standing;
use super::newton_euler::{AxisLoad, inverse_dynamics};
use super::read::Program;

/// Causes of joint errors, in the order of results.
pub const CAUSES: [&str; 4] = ["lost motion", "wind-up", "transmission error", "tilt"];

/// A position at which the tool error is evaluated.
#[derive(Debug, Clone)]
pub struct Place {
    pub kind: Kind,
    pub posture: Posture,
    /// External load of each axis.
    pub(super) loads: Vec<AxisLoad>,
    /// Joint angles in rad.
    pub angles: Vec<f64>,
    /// Direction of the commanded path; zero at rest.
    pub along: Vector3<f64>,
    /// Time in s from the beginning of the program; 0 for approaches.
    pub time: f64,
}

/// Kind of a position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A test pose as the program reaches it.
    Visit { pose: usize },
    /// A test pose approached from a side.
    Approach { pose: usize, side: usize },
    /// A point along the path of a program.
    Path { program: usize },
}

/// Errors of a joint at a position: angles in rad about its axis by lost motion, wind-up, transmission error;
/// and the tilt perpendicular to the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Off {
    pub about: [f64; 3],
    pub tilt: Vector3<f64>,
}

/// Number of approaches of a test pose: along ± x, y, z of the base, and from directions distributed uniformly
/// over the sphere.
pub const APPROACHES: usize = 30;
/// Number of those along the axes of the base, which come first.
pub const ALONG_AXES: usize = 6;
/// Number of positions along the paths of all programs.
const PATH_PLACES: usize = 4000;
/// Number of steps of an approach.
const STEPS: usize = 24;
/// A joint that moves less than this on an approach does not reverse its friction, rad.
const MOVES: f64 = 2e-6;
/// Largest displacement of a joint on an approach, rad: near singular postures it would be large.
const LONGEST: f64 = 0.1;

/// Unit vector to the side from which a pose is approached.
pub fn side(index: usize) -> Vector3<f64> {
    match index {
        0..ALONG_AXES => {
            let mut side = Vector3::zeros();
            side[index / 2] = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
            side
        }
        _ => {
            // A Fibonacci lattice on the sphere.
            let n = (APPROACHES - ALONG_AXES) as f64;
            let z = 1.0 - (2.0 * (index - ALONG_AXES) as f64 + 1.0) / n;
            let turn = (index - ALONG_AXES) as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
            let r = (1.0 - z * z).sqrt();
            Vector3::new(r * turn.cos(), r * turn.sin(), z)
        }
    }
}

/// Torque history of every joint; the state of a joint is evaluated at some of its steps.
#[derive(Debug)]
struct History {
    /// For each axis: external torque without drag (N·m), and the present or last sense of rotation.
    steps: Vec<Vec<(f64, f64)>>,
    /// Step and number of the position.
    evaluated: Vec<(usize, usize)>,
    /// Whether it is periodic: it is then passed twice, so that its beginning agrees with its end.
    repeats: bool,
}

/// All positions with the torque histories that lead to them.
#[derive(Debug)]
pub struct Places {
    pub places: Vec<Place>,
    histories: Vec<History>,
    /// Test poses, each with the number of its first visit.
    pub poses: usize,
}

impl Places {
    /// Test poses of all programs, their approaches of this length (m), and positions along the paths.
    pub fn of(arm: &Arm, programs: &[Program], courses: &[Course], approach: f64) -> Places {
        let mut all = Places { places: Vec::new(), histories: Vec::new(), poses: 0 };
        let mut known: Vec<Vec<f64>> = Vec::new();
        let samples: usize = programs.iter().map(|program| program.motion.len()).sum();
        let stride = samples.div_ceil(PATH_PLACES).max(1);
        for (index, (program, course)) in programs.iter().zip(courses).enumerate() {
            let motion = &program.motion;
            let mut evaluated = Vec::new();
            let mut ask = |all: &mut Places, sample: usize, kind: Kind| {
                let speed: Vec<f64> = motion.speed.iter().map(|axis| axis[sample]).collect();
                let jacobian = course.postures[sample].jacobian();
                let along = jacobian.iter().zip(&speed).fold(Vector3::zeros(), |sum, (j, v)| sum + j[0] * *v);
                evaluated.push((sample, all.places.len()));
                all.places.push(Place {
                    kind,
                    posture: course.postures[sample].clone(),
                    loads: course.loads[sample].clone(),
                    angles: motion.angles_at(sample),
                    along: along.try_normalize(1e-6).unwrap_or_default(),
                    time: motion.time[sample],
                });
            };
            for sample in &program.tests {
                let angles = motion.angles_at(*sample);
                let same = |other: &Vec<f64>| other.iter().zip(&angles).all(|(a, b)| (a - b).abs() < 1e-5);
                let pose = known.iter().position(same).unwrap_or(known.len());
                if pose == known.len() {
                    known.push(angles);
                }
                ask(&mut all, *sample, Kind::Visit { pose });
            }
            for sample in (0..motion.len()).step_by(stride) {
                ask(&mut all, sample, Kind::Path { program: index });
            }
            evaluated.sort_unstable();
            let steps = (0..arm.count())
                .map(|axis| {
                    let rest = motion.rest_speed(axis);
                    let mut sense = 0.0;
                    (0..motion.len())
                        .map(|sample| {
                            let speed = motion.speed[axis][sample];
                            if speed.abs() > rest {
                                sense = speed.signum();
                            }
                            (-course.loads[sample][axis].torque, sense)
                        })
                        .collect()
                })
                .collect();
            all.histories.push(History { steps, evaluated, repeats: true });
        }
        all.poses = known.len();
        all.approach_all(arm, &known, approach);
        all
    }

    /// Approaches of every pose from all sides.
    fn approach_all(&mut self, arm: &Arm, poses: &[Vec<f64>], length: f64) {
        let paths: Vec<(Place, Vec<Vec<(f64, f64)>>)> = (0..poses.len() * APPROACHES)
            .into_par_iter()
            .map(|number| {
                let (pose, index) = (number / APPROACHES, number % APPROACHES);
                approach(arm, pose, &poses[pose], (index, side(index)), length)
            })
            .collect();
        for (place, steps) in paths {
            self.histories.push(History {
                steps,
                evaluated: vec![(2 * STEPS, self.places.len())],
                repeats: false,
            });
            self.places.push(place);
        }
    }

    /// Postures at rest with their approaches, without a program.
    pub fn at_rest(arm: &Arm, postures: &[Vec<f64>], approach: f64) -> Places {
        let mut all = Places { places: Vec::new(), histories: Vec::new(), poses: postures.len() };
        all.approach_all(arm, postures, approach);
        all
    }

    /// Errors of one axis at all positions with this reducer; `new` is the joint for which the controller
    /// compensates.
    pub fn off(
        &self,
        axis: usize,
        joint: &JointModel,
        age: &AgedJoint,
        compensates: Compensation,
    ) -> Vec<Off> {
        let nothing = Off { about: [0.0; 3], tilt: Vector3::zeros() };
        let mut off = vec![nothing; self.places.len()];
        let known = &joint.ages[0];
        for history in &self.histories {
            let steps = &history.steps[axis];
            let drag = |(torque, sense): (f64, f64)| torque - joint.drag * sense;
            let mut standing = Standing::settled(&age.curve);
            if history.repeats {
                for step in steps {
                    standing.load(drag(*step));
                }
            }
            let mut evaluated = history.evaluated.iter().peekable();
            // Before its first motion in a program, an axis has its sense of rotation at the end.
            let last_sense = steps.last().map_or(0.0, |step| step.1);
            for (number, (torque, sense)) in steps.iter().enumerate() {
                let sense = if *sense == 0.0 && history.repeats { last_sense } else { *sense };
                let torque = drag((*torque, sense));
                let wind_up = standing.load(torque);
                while let Some((_, place)) = evaluated.next_if(|(step, _)| *step == number) {
                    let here = &self.places[*place];
                    let elastic = age.curve.elastic(torque);
                    let error = age.transmission_error(joint.offset + here.angles[axis], torque);
                    let mut about = [wind_up - elastic, elastic, error];
                    let z = &here.posture.axes[axis];
                    let moment = -here.loads[axis].tilting(z, joint.bearings);
                    let mut tilt = match moment.norm() {
                        0.0 => Vector3::zeros(),
                        size => moment * (joint.leaning.tilt(size) / size),
                    };
                    match compensates {
                        Compensation::None => {}
                        Compensation::Stiffness => {
                            about[1] -= known.curve.elastic(torque);
                            tilt = Vector3::zeros();
                        }
                        Compensation::Table => {
                            let known_elastic = known.curve.elastic(torque);
                            about[0] -= known.curve.branch(standing.rises(), torque) - known_elastic;
                            about[1] -= known_elastic;
                            about[2] -= known.transmission_error(joint.offset + here.angles[axis], torque);
                            tilt = Vector3::zeros();
                        }
                    }
                    off[*place] = Off { about, tilt };
                }
            }
        }
        off
    }
}

/// From the far end of a straight path through the pose to the side, and back to the pose: the pose, and torque
/// and sense of rotation of every joint on the path.
fn approach(
    arm: &Arm,
    pose: usize,
    angles: &[f64],
    (index, side): (usize, Vector3<f64>),
    length: f64,
) -> (Place, Vec<Vec<(f64, f64)>>) {
    let posture = arm.posture(angles);
    let step = straight(&posture, side * length);
    let still = vec![0.0; arm.count()];
    let mut steps: Vec<Vec<(f64, f64)>> = vec![Vec::new(); arm.count()];
    for turn in 0..=2 * STEPS {
        // From −1 to 1 and back to 0.
        let (share, sense) = match turn {
            turn if turn <= STEPS => (2.0 * turn as f64 / STEPS as f64 - 1.0, 1.0),
            turn => (1.0 - (turn - STEPS) as f64 / STEPS as f64, -1.0),
        };
        let at: Vec<f64> = angles.iter().zip(&step).map(|(a, d)| a + share * d).collect();
        let loads = inverse_dynamics(arm, &arm.posture(&at), &still, &still);
        for (axis, load) in loads.iter().enumerate() {
            let sense = if step[axis].abs() > MOVES { sense * step[axis].signum() } else { 0.0 };
            steps[axis].push((-load.torque, sense));
        }
    }
    let loads = inverse_dynamics(arm, &posture, &still, &still);
    let place = Place {
        kind: Kind::Approach { pose, side: index },
        posture,
        loads,
        angles: angles.to_vec(),
        along: Vector3::zeros(),
        time: 0.0,
    };
    (place, steps)
}

/// Joint angles (rad) for a straight displacement `way` (m) of the tool without rotation, by least squares,
/// which is approximate for an arm with few axes.
fn straight(posture: &Posture, way: Vector3<f64>) -> Vec<f64> {
    let jacobian = posture.jacobian();
    let matrix = DMatrix::from_fn(6, jacobian.len(), |row, axis| jacobian[axis][row / 3][row % 3]);
    let wanted = DVector::from_iterator(6, way.iter().copied().chain([0.0; 3]));
    // For arms with fewer than six axes only the displacement is fitted, not the rotation.
    let matrix = if jacobian.len() < 6 { matrix.rows(0, 3).into_owned() } else { matrix };
    let wanted = wanted.rows(0, matrix.nrows()).into_owned();
    let found =
        matrix.svd(true, true).solve(&wanted, 1e-3).unwrap_or_else(|_| DVector::zeros(jacobian.len()));
    let longest = found.amax();
    let scale = if longest > LONGEST { LONGEST / longest } else { 1.0 };
    found.iter().map(|angle| scale * angle).collect()
}

/// Errors of every joint of an arm at every age and position.
#[derive(Debug)]
pub struct Field {
    /// Indices: axis, age, position.
    off: Vec<Vec<Vec<Off>>>,
    /// Ages of each axis in hours in motion.
    hours: Vec<Vec<f64>>,
    /// Hours in motion for each hour of the robot.
    moving: Vec<f64>,
    bearings: Vec<f64>,
}

impl Field {
    pub fn of(places: &Places, joints: &[JointModel], moving: &[f64], compensates: Compensation) -> Field {
        let jobs: Vec<(usize, usize)> = joints
            .iter()
            .enumerate()
            .flat_map(|(axis, joint)| (0..joint.ages.len()).map(move |age| (axis, age)))
            .collect();
        let mut found: Vec<Vec<Off>> = jobs
            .par_iter()
            .map(|(axis, age)| places.off(*axis, &joints[*axis], &joints[*axis].ages[*age], compensates))
            .collect();
        let mut off: Vec<Vec<Vec<Off>>> = joints.iter().map(|_| Vec::new()).collect();
        for ((axis, _), list) in jobs.iter().zip(found.drain(..)) {
            off[*axis].push(list);
        }
        Field {
            off,
            hours: joints.iter().map(|joint| joint.ages.iter().map(|age| age.hours).collect()).collect(),
            moving: moving.to_vec(),
            bearings: joints.iter().map(|joint| joint.bearings).collect(),
        }
    }

    pub fn axes(&self) -> usize {
        self.off.len()
    }

    /// Errors of an axis at a position, at this age of its reducer in hours of the robot.
    pub fn at(&self, axis: usize, hours: f64, place: usize) -> Off {
        let ([a, b], share) = neighbours(&self.hours[axis], hours * self.moving[axis]);
        let (a, b) = (&self.off[axis][a][place], &self.off[axis][b][place]);
        Off {
            about: [0, 1, 2].map(|cause| a.about[cause] + share * (b.about[cause] - a.about[cause])),
            tilt: a.tilt + share * (b.tilt - a.tilt),
        }
    }

    /// Displacement (m) and rotation (rad) of the tool at a position due to one axis, by cause.
    pub fn caused(&self, places: &Places, axis: usize, hours: f64, place: usize) -> [[Vector3<f64>; 2]; 4] {
        let here = &places.places[place].posture;
        let off = self.at(axis, hours, place);
        let about = |angle: f64| here.moved_by(axis, &(angle * here.axes[axis]), 0.0);
        let [lost, elastic, error] = off.about.map(about);
        [lost, elastic, error, here.moved_by(axis, &off.tilt, self.bearings[axis])]
    }

    /// Displacement (m) and rotation (rad) at a position due to one axis.
    pub fn by_axis(&self, places: &Places, axis: usize, hours: f64, place: usize) -> [Vector3<f64>; 2] {
        let here = &places.places[place].posture;
        let off = self.at(axis, hours, place);
        let about = here.moved_by(axis, &(off.about.iter().sum::<f64>() * here.axes[axis]), 0.0);
        if off.tilt == Vector3::zeros() {
            return about;
        }
        let tilt = here.moved_by(axis, &off.tilt, self.bearings[axis]);
        [about[0] + tilt[0], about[1] + tilt[1]]
    }

    /// Displacement (m) and rotation (rad) of the tool at a position, for these ages of the axes in hours of
    /// the robot.
    pub fn tool(&self, places: &Places, hours: &[f64], place: usize) -> [Vector3<f64>; 2] {
        (0..self.axes()).fold([Vector3::zeros(); 2], |[p, r], axis| {
            let [dp, dr] = self.by_axis(places, axis, hours[axis], place);
            [p + dp, r + dr]
        })
    }
}
