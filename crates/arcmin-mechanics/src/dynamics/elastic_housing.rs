use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::{DMatrix, DVectorView, SymmetricEigen};

use super::DynamicsError;
use crate::contact::ConformalSeat;
use crate::fem::Compliance;
use crate::geometry::{Vec2, quarter_turn, unit};
use crate::machine::Machine;

/// The ring of pins as part of an elastic housing.
///
/// The compliance C of all grooves, from [`HousingShape::compliance`](crate::fem::HousingShape::compliance), is
/// divided into two parts: the local compliance c of a groove, in series with every contact, and the
/// interaction of pins, which is smooth along the ring. The smooth part is C − c I on the Fourier orders up to
/// `RING_ORDER` of radial and tangential displacements, disc by disc; its eigenvectors are coordinates η with
/// the energy Σ ½ η²/λ that displace the pins by φ η. c is the mean compliance of all higher orders, so that
/// the total displacement under forces that vary smoothly from pin to pin is that of C.
///
/// Grooves are slightly larger than the pins: the additional compliance of the clearance by [`ConformalSeat`],
/// at the mean pin force at rated torque, is added to c.
#[derive(Debug, Clone, PartialEq)]
pub struct ElasticHousing {
    discs: usize,
    pins: usize,
    /// λ of every mode in m/N.
    compliance: Arc<Vec<f64>>,
    /// φ, disc after disc, pin after pin, mode after mode, in the frame of the housing.
    shapes: Arc<Vec<Vec2>>,
    /// c in m/N, and the additional compliance of the clearance.
    own: f64,
    groove: f64,
    /// Fourier components of every mode, in the order of [`basis`].
    orders: Arc<DMatrix<f64>>,
}

/// Highest order of the ring's smooth deformation.
pub const RING_ORDER: usize = 4;
/// Modes with at least this fraction of the largest compliance are kept.
const LEAST: f64 = 2e-3;

impl ElasticHousing {
    /// From the compliance between the housing's interface coordinates.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] if it is not that of this machine's pins.
    pub fn new(machine: &Machine, compliance: &Compliance) -> Result<ElasticHousing, DynamicsError> {
        let (discs, pins) = (machine.disc_count, machine.ring.pin_count);
        let size = 2 * discs * pins;
        DynamicsError::require(
            compliance.count >= size,
            "coordinates of the elastic housing",
            compliance.count as f64,
            "",
            "must be two per disc and pin at least",
        )?;
        let basis = basis(discs, pins);
        let full = DMatrix::from_fn(size, size, |i, j| compliance.at(i, j));
        let low = basis.transpose() * &full * &basis;
        let own = if basis.ncols() < size {
            ((full.trace() - low.trace()) / (size - basis.ncols()) as f64).max(0.0)
        } else {
            0.0
        };
        let smooth = low - DMatrix::identity(basis.ncols(), basis.ncols()) * own;
        let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(smooth);
        let softest = eigenvalues.iter().fold(0.0_f64, |most, value| most.max(*value));
        let soft: Vec<usize> =
            (0..eigenvalues.len()).filter(|mode| eigenvalues[*mode] > LEAST * softest).collect();
        let kept: Vec<f64> = soft.iter().map(|mode| eigenvalues[*mode]).collect();
        let orders = eigenvectors.select_columns(&soft);
        let displacements = &basis * &orders;
        let shapes: Vec<Vec2> = (0..discs * pins)
            .flat_map(|place| (0..soft.len()).map(move |mode| (place, mode)))
            .map(|(place, mode)| {
                let out = unit(TAU * (place % pins) as f64 / pins as f64);
                displacements[(2 * place, mode)] * out
                    + displacements[(2 * place + 1, mode)] * quarter_turn(out)
            })
            .collect();
        Ok(ElasticHousing {
            discs,
            pins,
            compliance: Arc::new(kept),
            shapes: Arc::new(shapes),
            own,
            groove: groove_compliance(machine),
            orders: Arc::new(orders),
        })
    }

    /// Number of coordinates.
    pub fn count(&self) -> usize {
        self.compliance.len()
    }

    /// Numbers of discs and pins.
    pub(super) fn ring(&self) -> (usize, usize) {
        (self.discs, self.pins)
    }

    /// Compliance of a groove under the force of its own pin, in m/N of one disc's force.
    pub fn seat_compliance(&self) -> f64 {
        self.own + self.groove
    }

    /// Diagonal of the stiffness 1/λ in N/m.
    pub(super) fn stiffness(&self) -> impl Iterator<Item = f64> + '_ {
        self.compliance.iter().map(|compliance| 1.0 / compliance)
    }

    /// φ of a pin on one disc, mode after mode.
    #[inline]
    pub(super) fn shapes(&self, disc: usize, pin: usize) -> &[Vec2] {
        let count = self.count();
        &self.shapes[(disc * self.pins + pin) * count..][..count]
    }

    /// Displacements of all pins on one disc in m.
    pub(super) fn pin_displacements(&self, disc: usize, modes: &[f64]) -> Vec<Vec2> {
        let displacement =
            |pin: usize| modes.iter().zip(self.shapes(disc, pin)).map(|(value, shape)| *value * shape).sum();
        (0..self.pins).map(displacement).collect()
    }

    /// The modes for the same deformation of the ring rotated by an angle (rad); if not all modes of an order
    /// are kept, the best approximation by the others.
    pub(super) fn turn(&self, modes: &mut [f64], angle: f64) {
        let mut waves = &*self.orders * DVectorView::from_slice(modes, modes.len());
        let per_disc = waves.len() / self.discs;
        for of_disc in waves.as_mut_slice().chunks_exact_mut(per_disc) {
            // Radial and tangential mean, then radial and tangential cosine, radial and tangential sine of
            // every order.
            for (of_order, order) in of_disc[2..].chunks_exact_mut(4).zip(1..) {
                let (sin, cos) = (f64::from(order) * angle).sin_cos();
                let [radial, tangential, radial_sine, tangential_sine] =
                    [of_order[0], of_order[1], of_order[2], of_order[3]];
                of_order[0] = cos * radial - sin * radial_sine;
                of_order[1] = cos * tangential - sin * tangential_sine;
                of_order[2] = sin * radial + cos * radial_sine;
                of_order[3] = sin * tangential + cos * tangential_sine;
            }
        }
        modes.copy_from_slice(self.orders.tr_mul(&waves).as_slice());
    }

    /// Elastic energy in J under radial and tangential forces on the pins, disc by disc: Σ ½ λ (φ·F)² and ½ c
    /// F².
    pub fn energy(&self, forces: &[f64]) -> f64 {
        let push = |mode: usize| -> f64 {
            (0..self.discs * self.pins)
                .map(|place| {
                    let out = unit(TAU * (place % self.pins) as f64 / self.pins as f64);
                    let force = forces[2 * place] * out + forces[2 * place + 1] * quarter_turn(out);
                    self.shapes(place / self.pins, place % self.pins)[mode].dot(&force)
                })
                .sum()
        };
        let smooth: f64 =
            self.compliance.iter().enumerate().map(|(mode, c)| 0.5 * c * push(mode).powi(2)).sum();
        smooth + 0.5 * self.seat_compliance() * forces.iter().map(|force| force * force).sum::<f64>()
    }

    /// The same for a material `factor` times stiffer, with the effect of the clearance of the grooves reduced
    /// in proportion.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for a factor that is not positive.
    pub fn stiffened(&self, factor: f64) -> Result<ElasticHousing, DynamicsError> {
        DynamicsError::require(factor > 0.0 && factor.is_finite(), "factor", factor, "", "must be positive")?;
        Ok(ElasticHousing {
            compliance: Arc::new(self.compliance.iter().map(|c| c / factor).collect()),
            own: self.own / factor,
            groove: self.groove / factor,
            ..self.clone()
        })
    }
}

/// Orthonormal columns over (disc, pin, radial or tangential): orders 0 to [`RING_ORDER`], cosine and sine,
/// both components, disc by disc; at most the orders that the number of pins resolves.
fn basis(discs: usize, pins: usize) -> DMatrix<f64> {
    let z = pins as f64;
    let orders = RING_ORDER.min((pins - 1) / 2);
    let angle = |pin: usize, order: usize| TAU * (pin * order) as f64 / z;
    let mut waves: Vec<Vec<f64>> = vec![vec![1.0 / z.sqrt(); pins]];
    for order in 1..=orders {
        let scale = (2.0 / z).sqrt();
        waves.push((0..pins).map(|pin| scale * angle(pin, order).cos()).collect());
        waves.push((0..pins).map(|pin| scale * angle(pin, order).sin()).collect());
    }
    let per_disc = 2 * waves.len();
    DMatrix::from_fn(2 * discs * pins, discs * per_disc, |row, column| {
        let (disc, rest) = (row / (2 * pins), row % (2 * pins));
        let (pin, component) = (rest / 2, rest % 2);
        let (of_disc, wave) = (column / per_disc, column % per_disc);
        if disc == of_disc && wave % 2 == component { waves[wave / 2][pin] } else { 0.0 }
    })
}

/// Additional secant compliance in m/N of one disc's force by the clearance of a groove, at the mean force of
/// the loaded pins under rated torque: half a sine of [`Machine::rated`]'s largest force, 2.2 T/(K1 z_c R_p) by
/// the closed form for two discs.
fn groove_compliance(machine: &Machine) -> f64 {
    let solid = &machine.solids.housing;
    let kinematics = machine.kinematics();
    let arm = kinematics.eccentricity * kinematics.lobe_count;
    // Σ F l = T/discs over half of the pins, with F = F₁ l/l₁ and l = l₁ sin on average: F₁ = 4 T/(discs l₁
    // z_p).
    let largest =
        4.0 * machine.rated.torque.abs() / (machine.disc_count as f64 * arm * machine.ring.pin_count as f64);
    let mean = largest * std::f64::consts::FRAC_2_PI;
    let length = machine.solids.carrier.gap / machine.disc_count as f64;
    let seat = ConformalSeat::new(0.5 * solid.groove_clearance, &machine.ring.material, &solid.material);
    let load = mean / length;
    if load > 0.0 { seat.beyond_full_contact(load) / mean } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::turned;
    use crate::templates::tao2024;

    /// A compliance composed of a local and a smooth part is recovered: displacements by the modes plus the
    /// local one are C F for smoothly varying forces, and the number of modes is that of the smooth part.
    #[test]
    fn smooth_and_local_compliance_are_separated() {
        let machine = tao2024();
        let (discs, pins) = (machine.disc_count, machine.ring.pin_count);
        let size = 2 * discs * pins;
        let (own, soft) = (3e-10, 8e-9);
        // Equal ovalisation of both discs' parts, radial cos 2β, tangential −½ sin 2β: without extension.
        let wave: Vec<f64> = (0..size)
            .map(|i| {
                let two = 2.0 * TAU * (i / 2 % pins) as f64 / pins as f64;
                if i.is_multiple_of(2) { two.cos() } else { -0.5 * two.sin() }
            })
            .collect();
        let values = (0..size * size)
            .map(|k| {
                let (i, j) = (k / size, k % size);
                soft * wave[i] * wave[j] + if i == j { own } else { 0.0 }
            })
            .collect();
        let compliance = Compliance { count: size, values };
        let housing = ElasticHousing::new(&machine, &compliance).unwrap();
        assert_eq!(housing.count(), 1);
        assert!((housing.own / own - 1.0).abs() < 1e-9, "{:e}", housing.own);
        let forces: Vec<f64> =
            (0..size).map(|i| if i.is_multiple_of(2) { 100.0 * wave[i] } else { 0.0 }).collect();
        let whole = compliance.displacements(&forces);
        let place = |i: usize| (i / 2 / pins, i / 2 % pins);
        let along = |i: usize| {
            let out = unit(TAU * place(i).1 as f64 / pins as f64);
            if i.is_multiple_of(2) { out } else { quarter_turn(out) }
        };
        let push: f64 =
            (0..size).map(|i| forces[i] * housing.shapes(place(i).0, place(i).1)[0].dot(&along(i))).sum();
        let eta = push * housing.compliance[0];
        for i in 0..size {
            let (disc, pin) = place(i);
            let way = housing.pin_displacements(disc, &[eta])[pin].dot(&along(i)) + own * forces[i];
            assert!((way - whole[i]).abs() < 1e-9 * whole[0].abs(), "{i}: {way:e} {:e}", whole[i]);
        }
        // After a rotation by one pin pitch every pin has the displacement of the previous one; the other mode
        // of this order is not kept.
        let even: Vec<f64> = (0..size * size)
            .map(|k| {
                let (i, j) = (k / size, k % size);
                let apart = (i / 2 % pins) as f64 - (j / 2 % pins) as f64;
                let alike = (i % 2 == j % 2) as u8 as f64;
                soft * alike
                    * ((2.0 * TAU * apart / pins as f64).cos() + 0.5 * (TAU * apart / pins as f64).cos())
                    + if i == j { own } else { 0.0 }
            })
            .collect();
        let even = ElasticHousing::new(&machine, &Compliance { count: size, values: even }).unwrap();
        let modes: Vec<f64> = (0..even.count()).map(|m| (0.7 * m as f64).sin()).collect();
        let mut turned_on = modes.clone();
        even.turn(&mut turned_on, TAU / pins as f64);
        let (before, after) = (even.pin_displacements(1, &modes), even.pin_displacements(1, &turned_on));
        for pin in 0..pins {
            let expected = turned(before[(pin + pins - 1) % pins], unit(TAU / pins as f64));
            assert!((after[pin] - expected).norm() < 1e-12, "{pin}: {} {expected}", after[pin]);
        }
        let stiff = housing.stiffened(10.0).unwrap();
        assert!((stiff.seat_compliance() * 10.0 / housing.seat_compliance() - 1.0).abs() < 1e-12);
        assert!(housing.stiffened(0.0).is_err());
    }
}
