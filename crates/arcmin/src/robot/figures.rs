//! Figures of the tool by ISO 9283:1998: pose accuracy (7.2.1), repeatability (7.2.2), multi-directional variation
//! (7.2.3), distance accuracy (7.3.2), path accuracy (8.2).

use nalgebra::Vector3;

use super::tool::{ALONG_AXES, Field, Kind, Places};

/// Results for the tool. Lengths in m, angles in rad.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Figures {
    /// AP_P: largest distance between the reached and the commanded position of a test pose in the program.
    pub position: f64,
    /// Largest rotation of the tool there.
    pub orientation: f64,
    /// RP_l = l̄ + 3 S_l of a test pose approached from all sides, the largest over the poses.
    pub repeatability: f64,
    /// vAP_P: largest distance between the positions reached from ± x, ± y and ± z.
    pub directions: f64,
    /// AD_P: largest error of the distance between consecutive test poses.
    pub distance: f64,
    /// AT_P: largest distance of the tool from the commanded path.
    pub path: f64,
}

impl Figures {
    /// Values in m and rad, as stored.
    pub(super) fn numbers(&self) -> [f64; 6] {
        [self.position, self.orientation, self.repeatability, self.directions, self.distance, self.path]
    }

    pub(super) fn of_numbers(numbers: &[f64]) -> Option<Figures> {
        let [position, orientation, repeatability, directions, distance, path] = *numbers else {
            return None;
        };
        Some(Figures { position, orientation, repeatability, directions, distance, path })
    }
}

/// Figures with a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Figure {
    /// Pose accuracy, position: AP_P, m.
    Position,
    /// Pose accuracy, orientation: rad.
    Orientation,
    /// Pose repeatability: RP, m.
    Repeatability,
    /// Path accuracy: AT_P, m.
    Path,
}

impl Figure {
    /// All of them, in the order of tables.
    pub const ALL: [Figure; 4] = [Figure::Position, Figure::Orientation, Figure::Repeatability, Figure::Path];

    /// Word for keys and tables.
    pub fn word(self) -> &'static str {
        match self {
            Figure::Position => "position",
            Figure::Orientation => "orientation",
            Figure::Repeatability => "repeatability",
            Figure::Path => "path",
        }
    }
}

/// Numbers of the positions of each kind.
#[derive(Debug)]
pub struct Sorted {
    /// Visits in the order of the programs, each with its pose.
    pub visits: Vec<(usize, usize)>,
    /// Approaches for each pose, in the order of the sides.
    pub approaches: Vec<Vec<usize>>,
    pub paths: Vec<usize>,
}

impl Sorted {
    pub fn of(places: &Places) -> Sorted {
        let mut sorted =
            Sorted { visits: Vec::new(), approaches: vec![Vec::new(); places.poses], paths: Vec::new() };
        for (number, place) in places.places.iter().enumerate() {
            match place.kind {
                Kind::Visit { pose } => sorted.visits.push((number, pose)),
                Kind::Approach { pose, .. } => sorted.approaches[pose].push(number),
                Kind::Path { .. } => sorted.paths.push(number),
            }
        }
        sorted
    }
}

/// The tool of one robot.
#[derive(Debug, Clone, Copy)]
pub struct Tool<'a> {
    pub places: &'a Places,
    pub sorted: &'a Sorted,
    pub field: &'a Field,
}

/// RP_l = l̄ + 3 S_l about the barycentre of the points.
pub fn repeatability(points: &[Vector3<f64>]) -> f64 {
    let n = points.len() as f64;
    let centre = points.iter().fold(Vector3::zeros(), |sum, p| sum + p) / n;
    let distances: Vec<f64> = points.iter().map(|p| (p - centre).norm()).collect();
    let mean = distances.iter().sum::<f64>() / n;
    let squares: f64 = distances.iter().map(|l| (l - mean).powi(2)).sum();
    mean + 3.0 * (squares / (n - 1.0).max(1.0)).sqrt()
}

impl Tool<'_> {
    fn moved(&self, hours: &[f64], place: usize) -> [Vector3<f64>; 2] {
        self.field.tool(self.places, hours, place)
    }

    /// The visit of a test pose with the largest error: number of the position, and the distance in m.
    pub fn worst_visit(&self, hours: &[f64]) -> (usize, f64) {
        self.worst(&self.sorted.visits, |place| self.moved(hours, place)[0].norm())
    }

    pub fn worst_turn(&self, hours: &[f64]) -> (usize, f64) {
        self.worst(&self.sorted.visits, |place| self.moved(hours, place)[1].norm())
    }

    fn worst(&self, visits: &[(usize, usize)], of: impl Fn(usize) -> f64) -> (usize, f64) {
        let each = visits.iter().map(|(place, _)| (*place, of(*place)));
        each.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
    }

    /// The pose with the largest repeatability, and its value in m.
    pub fn worst_pose(&self, hours: &[f64]) -> (usize, f64) {
        let of = |pose: usize| (pose, self.repeatability_of(pose, |place| self.moved(hours, place)[0]));
        (0..self.places.poses).map(of).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
    }

    pub fn repeatability_of(&self, pose: usize, moved: impl Fn(usize) -> Vector3<f64>) -> f64 {
        let points: Vec<Vector3<f64>> = self.sorted.approaches[pose].iter().map(|p| moved(*p)).collect();
        repeatability(&points)
    }

    /// The position along the programs that is farthest from the path, and its distance in m.
    pub fn worst_path_point(&self, hours: &[f64]) -> (usize, f64) {
        let each = self.sorted.paths.iter().map(|place| (*place, self.off_the_path(hours, *place)));
        each.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
    }

    /// Distance of the tool from the commanded path at a place, in m.
    pub fn off_the_path(&self, hours: &[f64], place: usize) -> f64 {
        self.across_the_path(hours, place).norm()
    }

    fn across_the_path(&self, hours: &[f64], place: usize) -> Vector3<f64> {
        let (moved, along) = (self.moved(hours, place)[0], self.places.places[place].along);
        moved - moved.dot(&along) * along
    }

    /// One figure, for these ages of the axes in hours of the robot.
    pub fn figure(&self, figure: Figure, hours: &[f64]) -> f64 {
        match figure {
            Figure::Position => self.worst_visit(hours).1,
            Figure::Orientation => self.worst_turn(hours).1,
            Figure::Repeatability => self.worst_pose(hours).1,
            Figure::Path => self.worst_path_point(hours).1,
        }
    }

    pub fn figures(&self, hours: &[f64]) -> Figures {
        Figures {
            position: self.worst_visit(hours).1,
            orientation: self.worst_turn(hours).1,
            repeatability: self.worst_pose(hours).1,
            directions: self.directions(hours),
            distance: self.distance(hours),
            path: self.worst_path_point(hours).1,
        }
    }

    fn directions(&self, hours: &[f64]) -> f64 {
        let mut largest = 0.0_f64;
        for sides in &self.sorted.approaches {
            let reached: Vec<Vector3<f64>> =
                sides.iter().take(ALONG_AXES).map(|place| self.moved(hours, *place)[0]).collect();
            for (i, a) in reached.iter().enumerate() {
                largest = reached[..i].iter().fold(largest, |most, b| most.max((a - b).norm()));
            }
        }
        largest
    }

    fn distance(&self, hours: &[f64]) -> f64 {
        let reached: Vec<[Vector3<f64>; 2]> = self
            .sorted
            .visits
            .iter()
            .map(|(place, _)| {
                let commanded = self.places.places[*place].posture.tool.position;
                [commanded, commanded + self.moved(hours, *place)[0]]
            })
            .collect();
        reached.windows(2).fold(0.0, |most, pair| {
            let length = |which: usize| (pair[1][which] - pair[0][which]).norm();
            most.max((length(1) - length(0)).abs())
        })
    }

    /// Contribution of each axis to a figure at the position of its largest value, by cause: components along
    /// the deviation, which add up to it, in m.
    pub fn shares(&self, hours: &[f64]) -> Vec<[f64; 4]> {
        let (place, size) = self.worst_visit(hours);
        let along = match size {
            0.0 => Vector3::zeros(),
            size => self.moved(hours, place)[0] / size,
        };
        (0..self.field.axes())
            .map(|axis| {
                self.field.caused(self.places, axis, hours[axis], place).map(|caused| caused[0].dot(&along))
            })
            .collect()
    }

    /// Repeatability at the worst pose in m if only one axis had errors.
    pub fn repeatability_by_axis(&self, hours: &[f64]) -> Vec<f64> {
        let (pose, _) = self.worst_pose(hours);
        (0..self.field.axes())
            .map(|axis| {
                self.repeatability_of(pose, |place| {
                    self.field.by_axis(self.places, axis, hours[axis], place)[0]
                })
            })
            .collect()
    }

    /// The axis with the largest contribution to a figure, and the largest cause of that axis.
    pub fn culprit(&self, figure: Figure, hours: &[f64]) -> (usize, usize) {
        let at = |place: usize, which: usize, whole: Vector3<f64>| -> (usize, usize) {
            let caused: Vec<[f64; 4]> = (0..self.field.axes())
                .map(|axis| {
                    self.field.caused(self.places, axis, hours[axis], place).map(|c| c[which].dot(&whole))
                })
                .collect();
            let axis = largest(caused.iter().map(|causes| causes.iter().sum::<f64>()));
            (axis, largest(caused.get(axis).into_iter().flatten().copied()))
        };
        match figure {
            Figure::Position => {
                let (visit, _) = self.worst_visit(hours);
                at(visit, 0, self.moved(hours, visit)[0])
            }
            Figure::Orientation => {
                let (visit, _) = self.worst_turn(hours);
                at(visit, 1, self.moved(hours, visit)[1])
            }
            // The component of deviations along the path does not contribute to the distance from it.
            Figure::Path => {
                let (way, _) = self.worst_path_point(hours);
                at(way, 0, self.across_the_path(hours, way))
            }
            Figure::Repeatability => {
                let axis = largest(self.repeatability_by_axis(hours).into_iter());
                let (pose, _) = self.worst_pose(hours);
                let cause = largest((0..4).map(|cause| {
                    self.repeatability_of(pose, |place| {
                        self.field.caused(self.places, axis, hours[axis], place)[cause][0]
                    })
                }));
                (axis, cause)
            }
        }
    }
}

fn largest(values: impl Iterator<Item = f64>) -> usize {
    values.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ISO 9283, 7.2.2 by hand: four points on a cross have l = 1, S = 0; with one of them at 3 the sums are
    /// those of the standard.
    #[test]
    fn repeatability_is_the_standards() {
        let points = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]].map(|[x, y]| Vector3::new(x, y, 0.0));
        assert!((repeatability(&points) - 1.0).abs() < 1e-12);
        let two = [Vector3::new(0.0, 0.0, 0.0), Vector3::new(0.0, 0.0, 2.0)];
        assert!((repeatability(&two) - 1.0).abs() < 1e-12);
        let three = [0.0, 0.0, 3.0].map(|z| Vector3::new(0.0, 0.0, z));
        // Distances 1, 1, 2: mean 4/3, S² = (2/9 · 1 + 4/9)/2 = 1/3.
        assert!((repeatability(&three) - (4.0 / 3.0 + 3.0 / 3.0_f64.sqrt())).abs() < 1e-12);
    }
}
