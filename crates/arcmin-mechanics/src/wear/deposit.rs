use std::f64::consts::{PI, TAU};

use crate::geometry::Profile;

/// Arc length along one tooth's flank as a function of the meshing angle, on a grid of cells around the grid
/// angles of a [`Relief`](crate::geometry::Relief).
#[derive(Debug, Clone)]
pub struct FlankArc {
    /// Arc length at the faces of the cells, in m; cell i lies between faces i and i + 1.
    faces: Vec<f64>,
}

impl FlankArc {
    /// `cells` equal steps of φ, cell i centred on φ_i = −π + 2π i/cells. Simpson's rule per half cell.
    pub fn new(profile: &Profile, cells: usize) -> FlankArc {
        let step = TAU / cells as f64;
        let speed = |phi: f64| profile.flank_length_per_meshing_angle(phi.cos());
        let corner = profile.tip().map(|tip| tip.end);
        let mut faces = Vec::with_capacity(cells + 1);
        let mut arc = 0.0;
        faces.push(arc);
        for i in 0..cells {
            let centre = -PI + step * i as f64;
            for half in [-1.0, 1.0] {
                let (a, b) =
                    if half < 0.0 { (centre - 0.5 * step, centre) } else { (centre, centre + 0.5 * step) };
                arc += match corner
                    .filter(|corner| a.abs().min(b.abs()) < *corner && *corner < a.abs().max(b.abs()))
                {
                    // The length has a jump at the corner of a tip; the flank ends at its own side of the
                    // corner.
                    Some(corner) => {
                        let (flank, land) = match a.abs() < b.abs() {
                            true => (a, b),
                            false => (b, a),
                        };
                        (corner - flank.abs()) * speed(flank) + (land.abs() - corner) * speed(land)
                    }
                    None => 0.5 * step / 6.0 * (speed(a) + 4.0 * speed(0.5 * (a + b)) + speed(b)),
                };
            }
            faces.push(arc);
        }
        FlankArc { faces }
    }

    /// Number of cells of the flank of one tooth.
    pub fn cells(&self) -> usize {
        self.faces.len() - 1
    }

    /// Whole length of one tooth's flank, root to root over the tip, in m.
    pub fn length(&self) -> f64 {
        self.faces[self.cells()]
    }

    /// Arc length in m at the left face of a cell on the unrolled flank, where cells repeat for every tooth.
    pub(super) fn face(&self, cell: isize) -> f64 {
        let n = self.cells() as isize;
        self.faces[cell.rem_euclid(n) as usize] + cell.div_euclid(n) as f64 * self.length()
    }

    /// Arc length in m at the grid point of a cell.
    pub(super) fn centre(&self, cell: usize) -> f64 {
        0.5 * (self.faces[cell] + self.faces[cell + 1])
    }

    /// Width of a cell in m.
    pub fn cell_width(&self, cell: usize) -> f64 {
        self.faces[cell + 1] - self.faces[cell]
    }

    /// Adds `amount` (m² of removed section) to `section`, cell by cell, for a contact of half-width
    /// `half_width` (m) that moves from meshing angle `from` to `to` (rad, less than half a turn apart).
    ///
    /// The part of a cell is the exact integral over it of a moving triangle with the mean-square width of the
    /// Hertz pressure. The sum does not depend on the grid, and successive sections of one path join without
    /// ripple.
    ///
    /// The half ellipse of the pressure itself is not used for the following reason. The contact spends more
    /// time on the crests of a wavy flank and wears them. Spreading reduces this effect by the transform of the
    /// kernel, which is positive for the triangle. That of the half ellipse, 2 J_1(kb)/(kb), is negative
    /// between kb = 3.83 and 7.02: waves with a length of about 1.2 half-widths would grow, and after 20 µm of
    /// wear the contact points of the pins on them would not be unique.
    pub(super) fn spread(&self, section: &mut [f64], from: f64, to: f64, half_width: f64, amount: f64) {
        let n = self.cells() as isize;
        let face = |index: isize| self.face(index);
        let half_width = BASE * half_width;
        let place = |angle: f64| {
            let x = (angle + PI) / TAU * n as f64 + 0.5;
            let cell = x.floor() as isize;
            (cell, face(cell) + (x - cell as f64) * (face(cell + 1) - face(cell)))
        };
        let (first, start) = place(from);
        // The shorter way, across tip or root if necessary.
        let (_, end) = place(from + crate::units::wrap_angle(to - from));
        let path = Path { start: start.min(end), end: start.max(end), half_width };
        let mut add = |index: isize, share: f64| section[index.rem_euclid(n) as usize] += amount * share;
        let mut index = first;
        loop {
            add(index, path.share(face(index), face(index + 1)));
            index += 1;
            if face(index) >= path.end + half_width || index - first >= n / 2 {
                break;
            }
        }
        index = first - 1;
        while face(index + 1) > path.start - half_width && first - index < n / 2 {
            add(index, path.share(face(index), face(index + 1)));
            index -= 1;
        }
    }
}

/// A contact moving from `start` to `end` on a line, in m.
struct Path {
    start: f64,
    end: f64,
    half_width: f64,
}

impl Path {
    /// Fraction of the removal between the coordinates `left` and `right`.
    fn share(&self, left: f64, right: f64) -> f64 {
        self.below(right) - self.below(left)
    }

    /// Fraction to the left of a coordinate: the mean over the path of the triangle's fraction.
    fn below(&self, place: f64) -> f64 {
        let (near, far) = ((place - self.start) / self.half_width, (place - self.end) / self.half_width);
        if near - far < 1e-6 {
            triangle_share(0.5 * (near + far))
        } else {
            (triangle_share_integral(near) - triangle_share_integral(far)) / (near - far)
        }
    }
}

/// Half base of the triangle divided by the Hertz half-width, for which both have the mean-square width b²/4.
const BASE: f64 = 1.224_744_871_391_589;

/// Integral of the triangle 1 − |x| from −1 to x, from 0 at −1 to 1 at +1.
fn triangle_share(x: f64) -> f64 {
    let rest = 0.5 * (1.0 - x.abs()).max(0.0).powi(2);
    if x < 0.0 { rest } else { 1.0 - rest }
}

/// ∫ of [`triangle_share`] from −∞ to x.
fn triangle_share_integral(x: f64) -> f64 {
    (1.0 - x.abs()).max(0.0).powi(3) / 6.0 + x.max(0.0)
}

/// The same on a pin: `section` on equal cells of its circumference, centred on ψ_i = −π + 2π i/cells. `reach`
/// is the fraction of each cell within reach of the flank, empty if all are: removal from surfaces out of reach
/// is distributed to the rest of the contact's width.
pub(super) fn spread_on_pin(
    section: &mut [f64],
    reach: &[f64],
    pin_radius: f64,
    from: f64,
    to: f64,
    half_width: f64,
    amount: f64,
) {
    let n = section.len() as isize;
    let half_width = BASE * half_width;
    let cell = TAU * pin_radius / n as f64;
    let place = |angle: f64| ((angle + PI) / TAU * n as f64 + 0.5) * cell;
    let (start, end) = (place(from), place(to));
    let path = Path { start: start.min(end), end: start.max(end), half_width };
    let first = ((path.start - half_width) / cell).floor() as isize;
    let last = ((path.end + half_width) / cell).floor() as isize;
    let share = |index: isize| path.share(index as f64 * cell, (index + 1) as f64 * cell);
    let reached = |index: isize| reach.get(index.rem_euclid(n) as usize).copied().unwrap_or(1.0);
    let mut amount = amount;
    if !reach.is_empty() {
        amount /= (first..=last).map(|index| reached(index) * share(index)).sum::<f64>().max(LEAST_REACH);
    }
    for index in first..=last {
        section[index.rem_euclid(n) as usize] += amount * reached(index) * share(index);
    }
}

/// Smallest fraction of a contact's width within reach.
const LEAST_REACH: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;

    fn profile() -> Profile {
        Profile::new(40, 64e-3, 1.3e-3, 3e-3)
    }

    #[test]
    fn arc_length_of_a_tooth_agrees_with_the_polygon_of_the_flank() {
        // The second grid has no face at the corners.
        let tipped = Profile::new(22, 40e-3, 2.2e-3, 2.5e-3).with_teeth(2, None).unwrap();
        for (p, within) in [(profile(), 1e-7), (tipped, 1e-5)] {
            let n = 200_000;
            let pitch = TAU / p.lobe_count() as f64;
            let polygon: f64 = (0..n)
                .map(|i| {
                    let tau = pitch * i as f64 / n as f64;
                    (p.flank_point(tau + pitch / n as f64) - p.flank_point(tau)).norm()
                })
                .sum();
            assert!((FlankArc::new(&p, 720).length() / polygon - 1.0).abs() < within);
        }
    }

    #[test]
    fn spreading_keeps_the_amount_everywhere_and_for_every_width() {
        let arc = FlankArc::new(&profile(), 720);
        for i in 0..360 {
            let phi = -PI + 0.0171 * i as f64;
            for (width, travel) in [(1e-7, 0.0), (2e-5, 0.01), (2e-4, -0.03), (1e-7, 0.02)] {
                let mut section = vec![0.0; 720];
                arc.spread(&mut section, phi, phi + travel, width, 1.0);
                assert!((section.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{phi} {width}");
                assert!(section.iter().all(|share| *share >= 0.0));
                let mut pin = vec![0.0; 720];
                spread_on_pin(&mut pin, &[], 3e-3, phi, phi + travel, width, 1.0);
                assert!((pin.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                // Beside a groove the whole amount is removed from the rest of the width.
                let mut half = vec![0.0; 720];
                let reach: Vec<f64> = (0..720).map(|i| if i % 3 == 0 { 1.0 } else { 0.3 }).collect();
                spread_on_pin(&mut half, &reach, 3e-3, phi, phi + travel, width, 1.0);
                assert!((half.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            }
        }
    }

    /// ∫ of the kernel times cos(kx) for a contact at rest: positive for all waves, with the mean-square width
    /// of the Hertz pressure.
    #[test]
    fn trap_half_ellipse_digs_waves_deeper() {
        let cell = 5e-3;
        let centres = |i: i32| (f64::from(i) + 0.5) * cell;
        let triangle: Vec<f64> = {
            let path = Path { start: 0.0, end: 0.0, half_width: BASE };
            (-400..400).map(|i| path.share(centres(i) - 0.5 * cell, centres(i) + 0.5 * cell)).collect()
        };
        let ellipse: Vec<f64> =
            (-400..400).map(|i| 2.0 / PI * (1.0 - centres(i).powi(2)).max(0.0).sqrt() * cell).collect();
        let moment = |shares: &[f64], k: f64| {
            shares.iter().zip(-400..).map(|(share, i)| share * (k * centres(i)).cos()).sum::<f64>()
        };
        let least = |shares: &[f64]| {
            (0..150).map(|i| moment(shares, 0.1 * f64::from(i))).fold(f64::INFINITY, f64::min)
        };
        // 2 J_1(5.136)/5.136; cells of 5e-3 half-widths leave 1e-4.
        assert!((least(&ellipse) + 0.1323).abs() < 5e-4, "{}", least(&ellipse));
        assert!(least(&triangle) > -1e-4, "{}", least(&triangle));
        let square: f64 = triangle.iter().zip(-400..).map(|(share, i)| share * centres(i).powi(2)).sum();
        assert!((square - 0.25).abs() < 1e-4, "{square}");
    }

    #[test]
    fn integral_of_the_share_is_its_integral() {
        for i in -12..12 {
            let x = 0.1 * i as f64 + 0.013;
            let h = 1e-5;
            let slope = (triangle_share_integral(x + h) - triangle_share_integral(x - h)) / (2.0 * h);
            assert!((slope - triangle_share(x)).abs() < 1e-8, "{x}");
        }
    }
}
