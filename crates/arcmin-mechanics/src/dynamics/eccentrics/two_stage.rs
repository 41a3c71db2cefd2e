//! Two stages in series as one mechanism.

use super::{Assembly, DiscAt, EccentricJoints, housing, plane_body, three};
use crate::dynamics::mechanism::{Flanges, NominalMotion, Registry};
use crate::dynamics::{DynamicsError, ElasticDiscs};
use crate::machine::TwoStage;
use crate::units::ARCMIN;

impl TwoStage {
    /// Builds bodies and joints, with the input held and no load. Output pins of the first and eccentrics of
    /// the second stage are on the intermediate shaft, which has the bearings of both stages.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for values without meaning.
    pub fn joints(&self) -> Result<EccentricJoints, DynamicsError> {
        self.joints_with(None)
    }

    /// The same with elastic discs, those of the first stage first ([`DiscShape::all_of_stage`](crate::fem::DiscShape::all_of_stage)).
    ///
    /// # Errors
    /// As there.
    pub fn joints_with(&self, elastic: Option<&ElasticDiscs>) -> Result<EccentricJoints, DynamicsError> {
        let TwoStage { first, second } = self;
        first.validate()?;
        second.validate()?;
        let bores = [first.loaded_bores(), second.loaded_bores()].concat();
        elastic.map_or(Ok(()), |discs| discs.require(&bores))?;
        let (between, ratio) = (1.0 / first.ratio(), self.ratio());
        // An arcminute at the output is |i| as much before a stage.
        let [middle, fast] = [second.ratio(), ratio].map(|ratio| ratio.abs() * ARCMIN);
        let places = [first.place_scale(), second.place_scale()];
        let mut bodies = Registry::default();
        let of_first = first.add_discs(&mut bodies, [1.0, between], middle, (elastic, 0));
        let of_second = second.add_discs(
            &mut bodies,
            [between, between / second.ratio()],
            ARCMIN,
            (elastic, first.phases.len()),
        );
        let turning = NominalMotion::turning;
        let shaft = bodies.add(plane_body(first.output, [places[1], middle], true, turning(between)));
        let output = bodies.add(plane_body(second.output, [places[1], ARCMIN], true, turning(1.0 / ratio)));
        let input = bodies.add(plane_body(first.input, [places[0], fast], false, turning(1.0)));
        let rest = bodies.add(housing(0.0));
        let coordinates = bodies.number();
        let at = |body| three(&coordinates, body);
        let [shaft, output, input, rest] = [shaft, output, input, rest].map(at);
        let [of_first, of_second] = [of_first, of_second]
            .map(|discs| discs.into_iter().map(|disc| DiscAt::of(&coordinates, disc)).collect::<Vec<_>>());
        let mut assembly = Assembly::new(elastic);
        for (body, stiffness) in [
            (input, first.input_support),
            (shaft, first.output_support),
            (shaft, second.input_support),
            (output, second.output_support),
        ] {
            assembly.support(body, rest, stiffness);
        }
        first.connect(&mut assembly, &of_first, [input, shaft, rest], 1.0, false);
        second.connect(&mut assembly, &of_second, [shaft, output, rest], between, false);
        let flanges = Flanges { input: input[2], output: output[2], phase: of_second[0].place[2], ratio };
        assembly.finish(coordinates, flanges)
    }
}

#[cfg(test)]
mod tests;
