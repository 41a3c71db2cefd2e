//! Drives of two rings as mechanisms.

use super::{Assembly, EccentricJoints, StageParts, Three, housing, plane_body, require_stiffness, three};
use crate::dynamics::DynamicsError;
use crate::dynamics::mechanism::{Arm, Flanges, NominalMotion, Registry, Turn};
use crate::machine::TwoRing;
use crate::units::ARCMIN;

impl TwoRing {
    /// Builds bodies and joints, with the input held and no load. The first stage contains the eccentric
    /// bearings and the ring at rest, the second one the rotating ring.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for values without meaning.
    pub fn joints(&self) -> Result<EccentricJoints, DynamicsError> {
        self.validate()?;
        let ratio = self.ratio();
        let [first, second] = &self.meshes;
        let [lobes, others] = self.lobes_per_turn();
        let mut bodies = Registry::default();
        let place = second.ring_circle_radius * ARCMIN;
        let arm = |phase: f64| Arm { radius: first.profile.eccentricity, phase };
        let discs: Vec<_> = self
            .phases
            .iter()
            .map(|phase| {
                // All discs share the pins of the second ring.
                let turn = Turn { per_input: -1.0 / lobes, offset: -phase / others };
                let nominal = NominalMotion { place: Some((arm(*phase), Turn::of(1.0))), turn: Some(turn) };
                bodies.add(plane_body(self.disc, [place, ARCMIN], true, nominal))
            })
            .collect();
        let shaft = |body: (f64, f64), scale: f64, turns: bool, per_input: f64| {
            plane_body(body, [place, scale], turns, NominalMotion::turning(per_input))
        };
        let output = bodies.add(shaft(self.output_body(), ARCMIN, true, 1.0 / ratio));
        let input = bodies.add(shaft(self.input_body(), ratio.abs() * ARCMIN, false, 1.0));
        // The housing in the frame of the first ring's pins, for each disc.
        let rows: Vec<_> = (0..self.phases.len()).map(|j| bodies.add(housing(self.row(j)))).collect();
        let coordinates = bodies.number();
        let at = |body| three(&coordinates, body);
        let (output, input) = (at(output), at(input));
        let rows: Vec<Three> = rows.into_iter().map(at).collect();
        let rest = rows[0];
        let discs: Vec<Three> = discs.into_iter().map(at).collect();
        let mut assembly = Assembly::default();
        assembly.support(input, rest, self.input_support);
        assembly.support(output, rest, self.output_support);
        let [own, other] = &self.errors;
        for (j, (disc, phase)) in discs.iter().zip(&self.phases).enumerate() {
            assembly.eccentric(input, *disc, Vec::new(), arm(*phase), (&self.eccentric, own, j));
        }
        let of_first = (0..discs.len()).map(|j| {
            let pins = first.pins_as_made(own, j * first.profile.pin_count, self.row(j));
            first.ring(pins, own.flanks.get(j), j, discs[j], rows[j], true)
        });
        let of_second = (0..discs.len()).map(|j| {
            let pins = second.pins_as_made(other, 0, 0.0);
            second.ring(pins, other.flanks.get(j), j, discs[j], output, true)
        });
        assembly.rings = of_first.chain(of_second).collect();
        let [first_turns, second_turns, eccentric_turns] = self.turns();
        let count = discs.len();
        assembly.stages = vec![
            StageParts {
                rings: 0..count,
                eccentrics: 0..count,
                output_pins: 0..0,
                disc_turns: first_turns,
                eccentric_turns,
            },
            StageParts {
                rings: count..2 * count,
                eccentrics: 0..0,
                output_pins: 0..0,
                disc_turns: second_turns,
                eccentric_turns,
            },
        ];
        let flanges = Flanges { input: input[2], output: output[2], phase: discs[0][2], ratio };
        assembly.finish(coordinates, flanges)
    }

    fn validate(&self) -> Result<(), DynamicsError> {
        let check = DynamicsError::require;
        check(!self.phases.is_empty(), "number of stepped discs", 0.0, "", "must be at least 1")?;
        let [first, second] = self.lobes_per_turn();
        check(
            first != second,
            "lobes over tooth difference of the second profile",
            second,
            "",
            "must differ from the first",
        )?;
        let [one, other] = self.meshes.each_ref().map(|mesh| mesh.profile.eccentricity);
        check(one == other, "eccentricity of the second profile", other, "m", "must be that of the first")?;
        require_stiffness([
            ("stiffness of the input's bearings", self.input_support),
            ("stiffness of the output's bearings", self.output_support),
        ])?;
        self.meshes.iter().try_for_each(|mesh| mesh.validate())
    }
}

#[cfg(test)]
mod tests;
