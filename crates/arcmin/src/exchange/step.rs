//! STEP AP214 (AUTOMOTIVE_DESIGN) with a PRODUCT for every part, without which some readers display nothing.

use std::f64::consts::PI;

use super::profile::{Parts, ProfileExport};
use super::solid::SolidFigures;
use super::{ExchangeError, crankshaft};
use crate::geometry::{Segment, unit};
use crate::machine::Kinematics;

/// Entities written so far, numbered from 1.
pub(super) struct Step {
    text: String,
    count: usize,
}

impl Step {
    pub(super) fn add(&mut self, entity: &str) -> usize {
        self.count += 1;
        self.text.push_str(&format!("#{}={entity};\n", self.count));
        self.count
    }
}

/// A part with the entities needed to place it.
struct Product {
    definition: usize,
    representation: usize,
    axis: usize,
}

/// Entities that every product refers to.
struct Frame {
    product_context: usize,
    definition_context: usize,
    representation_context: usize,
}

/// Text of a STEP string: quotes doubled, other characters as UTF-16 in hexadecimal.
fn words(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars().filter(|c| !c.is_control()) {
        match c {
            '\'' => out.push_str("''"),
            '\\' => out.push_str("\\\\"),
            c if c.is_ascii() => out.push(c),
            c => {
                let mut units = [0; 2];
                let hex: String =
                    c.encode_utf16(&mut units).iter().map(|unit| format!("{unit:04X}")).collect();
                out.push_str(&format!("\\X2\\{hex}\\X0\\"));
            }
        }
    }
    out
}

impl Frame {
    fn begin(step: &mut Step) -> Frame {
        let application =
            step.add("APPLICATION_CONTEXT('core data for automotive mechanical design processes')");
        step.add(&format!(
            "APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#{application})"
        ));
        let product_context = step.add(&format!("PRODUCT_CONTEXT('',#{application},'mechanical')"));
        let definition_context =
            step.add(&format!("PRODUCT_DEFINITION_CONTEXT('part definition',#{application},'design')"));
        let length = step.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
        let angle = step.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
        let solid_angle = step.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
        let accuracy = step.add(&format!(
            "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-06),#{length},'distance_accuracy_value','')"
        ));
        let representation_context = step.add(&format!(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{accuracy}))\
             GLOBAL_UNIT_ASSIGNED_CONTEXT((#{length},#{angle},#{solid_angle}))REPRESENTATION_CONTEXT('',''))"
        ));
        Frame { product_context, definition_context, representation_context }
    }

    /// Records of a product; `solid` is `None` for an assembly.
    fn product(&self, step: &mut Step, name: &str, solid: Option<usize>) -> Product {
        let name = words(name);
        let product = step.add(&format!("PRODUCT('{name}','{name}','',(#{}))", self.product_context));
        step.add(&format!("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#{product}))"));
        let formation = step.add(&format!("PRODUCT_DEFINITION_FORMATION('','',#{product})"));
        let definition =
            step.add(&format!("PRODUCT_DEFINITION('design','',#{formation},#{})", self.definition_context));
        let shape = step.add(&format!("PRODUCT_DEFINITION_SHAPE('','',#{definition})"));
        let axis = step.placement([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        let context = self.representation_context;
        let representation = step.add(&match solid {
            Some(solid) => {
                format!("ADVANCED_BREP_SHAPE_REPRESENTATION('{name}',(#{axis},#{solid}),#{context})")
            }
            None => format!("SHAPE_REPRESENTATION('{name}',(#{axis}),#{context})"),
        });
        step.add(&format!("SHAPE_DEFINITION_REPRESENTATION(#{shape},#{representation})"));
        Product { definition, representation, axis }
    }

    /// A part in its assembly: rotated by `angle`, then translated.
    fn place(
        &self,
        step: &mut Step,
        whole: &Product,
        part: &Product,
        name: &str,
        angle: f64,
        place: [f64; 3],
    ) {
        let name = words(name);
        let x = unit(angle);
        let target = step.placement(place, [0.0, 0.0, 1.0], [x.x, x.y, 0.0]);
        let usage = step.add(&format!(
            "NEXT_ASSEMBLY_USAGE_OCCURRENCE('{name}','{name}','',#{},#{},$)",
            whole.definition, part.definition
        ));
        let shape = step.add(&format!("PRODUCT_DEFINITION_SHAPE('Placement','',#{usage})"));
        let transformation =
            step.add(&format!("ITEM_DEFINED_TRANSFORMATION('','',#{},#{target})", part.axis));
        let relation = step.add(&format!(
            "(REPRESENTATION_RELATIONSHIP('','',#{},#{})REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{transformation})\
             SHAPE_REPRESENTATION_RELATIONSHIP())",
            part.representation, whole.representation
        ));
        step.add(&format!("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relation},#{shape})"));
    }
}

impl ProfileExport {
    /// STEP file (AP214) of parts or of the assembly, in millimetres.
    ///
    /// A disc has spline faces of a few sections each along its flank with vertices at roots and crests, two
    /// half cylinders for each bore and hole, and a face for every side and arc of a window. Pins have the
    /// length of the stack of discs. Crankshafts are drawn without the teeth of the planets: eccentrics with
    /// the diameter of the inner raceway, the shaft between and beside them.
    ///
    /// # Errors
    /// [`ExchangeError::NoPart`] for crankshafts and assemblies of single stages.
    pub fn step(&self, parts: Parts) -> Result<String, ExchangeError> {
        let mut step = Step { text: String::new(), count: 0 };
        let frame = Frame::begin(&mut step);
        let disc_name = |disc: usize| format!("cycloid disc {}", disc + 1);
        match parts {
            Parts::Discs => {
                for disc in self.discs() {
                    let solid = self.disc(&mut step, disc, &disc_name(disc));
                    frame.product(&mut step, &disc_name(disc), Some(solid));
                }
            }
            Parts::Pin => {
                self.separate_pin()?;
                let solid = self.pin(&mut step);
                frame.product(&mut step, "pin", Some(solid));
            }
            Parts::Ring => {
                let solid = self.ring_solid(&mut step)?;
                frame.product(&mut step, "ring", Some(solid));
            }
            Parts::Crankshaft => {
                let solid = crankshaft::solid(&mut step, "crankshaft", &crankshaft::slices(self.reducer()?));
                frame.product(&mut step, "crankshaft", Some(solid));
            }
            Parts::Assembly { crank_angle } => {
                let whole = frame.product(&mut step, &format!("{} assembly", self.stamp.design_name), None);
                let (machine, floors) = (self.reducer()?, self.floors());
                let kinematics = machine.kinematics();
                let output = kinematics.nominal_output_angle(crank_angle);
                for (disc, floor) in floors.iter().enumerate() {
                    let solid = self.disc(&mut step, disc, &disc_name(disc));
                    let part = frame.product(&mut step, &disc_name(disc), Some(solid));
                    let pose = kinematics.disc_pose(disc, crank_angle, output);
                    let place = [pose.centre.x, pose.centre.y, *floor];
                    frame.place(&mut step, &whole, &part, &disc_name(disc), pose.angle, place);
                }
                let solid = self.pin(&mut step);
                let part = frame.product(&mut step, "pin", Some(solid));
                for (index, (centre, _)) in self.pins().iter().enumerate() {
                    let place = [centre.x, centre.y, floors[0]];
                    frame.place(&mut step, &whole, &part, &format!("pin {}", index + 1), 0.0, place);
                }
                let solid = crankshaft::solid(&mut step, "crankshaft", &crankshaft::slices(machine));
                let part = frame.product(&mut step, "crankshaft", Some(solid));
                let cranks = &machine.crankshafts;
                for k in 0..cranks.count {
                    let angle = Kinematics::crankshaft_angle(cranks.first_angle, k, cranks.count) + output;
                    let centre = machine.gear_stage.centre_distance() * unit(angle);
                    let name = format!("crankshaft {}", k + 1);
                    frame.place(&mut step, &whole, &part, &name, crank_angle, [centre.x, centre.y, 0.0]);
                }
            }
        }
        let stamps: Vec<String> = self.stamps().iter().map(|line| format!("'{}'", words(line))).collect();
        let version = &self.stamp.version;
        Ok(format!(
            "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(({}),'2;1');\n\
             FILE_NAME('{}','1970-01-01T00:00:00',(''),(''),'arcmin {version}','arcmin {version}','');\n\
             FILE_SCHEMA(('AUTOMOTIVE_DESIGN {{ 1 0 10303 214 1 1 1 1 }}'));\nENDSEC;\nDATA;\n{}ENDSEC;\n\
             END-ISO-10303-21;\n",
            stamps.join(","),
            words(&self.stamp.design_name),
            step.text
        ))
    }

    /// Volume and surface of every part of a STEP file, each once, for comparison with a reader.
    pub fn solid_figures(&self) -> Vec<SolidFigures> {
        let width = self.width();
        let (area, length) = self.disc_area_and_length();
        let mut all: Vec<SolidFigures> = self
            .discs()
            .map(|disc| SolidFigures {
                name: format!("cycloid disc {}", disc + 1),
                volume: area * width,
                surface: 2.0 * area + length * width,
            })
            .collect();
        let (radius, height) = (self.ring_radii().1, self.pin_length());
        all.push(match self.contour() {
            Ok(ring) => {
                let area = PI * ring.outer_radius * ring.outer_radius - ring.opening.area();
                let inner: f64 = ring.opening.segments.iter().map(Segment::length).sum();
                SolidFigures {
                    name: "ring".to_owned(),
                    volume: area * height,
                    surface: 2.0 * area + (inner + 2.0 * PI * ring.outer_radius) * height,
                }
            }
            Err(_) => SolidFigures {
                name: "pin".to_owned(),
                volume: PI * radius * radius * height,
                surface: 2.0 * PI * radius * (radius + height),
            },
        });
        let crankshafts = self.reducer().ok().map(crankshaft::slices);
        all.extend(crankshafts.map(|slices| crankshaft::figures("crankshaft", &slices)));
        all
    }

    pub(super) fn pin_length(&self) -> f64 {
        let floors = self.floors();
        floors[floors.len() - 1] + self.width() - floors[0]
    }

    fn pin(&self, step: &mut Step) -> usize {
        let slice = crankshaft::Slice {
            centre: crate::geometry::Vec2::zeros(),
            radius: self.ring_radii().1,
            from: 0.0,
            to: self.pin_length(),
        };
        crankshaft::solid(step, "pin", &[slice])
    }
}
