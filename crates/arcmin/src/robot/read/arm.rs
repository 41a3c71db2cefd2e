//! The arm of a robot file: axes from its table or a URDF, tool and payload.

use nalgebra::{Matrix3, Unit, Vector3};

use super::{Result, RobotFile};
use crate::analyses::{AnalysisError, Host, Origin};
use crate::design::At;
use crate::robot::arm::{Arm, Axis, Body, Pose};
use crate::robot::file::{BodySection, UrdfSection};
use crate::robot::urdf::{self, UrdfError};
use crate::scene::Solid;
use crate::tables::text_of;
use crate::units::{DEG, MM};

impl RobotFile {
    fn three(&self, list: &At<Vec<f64>>, what: &str) -> Result<[f64; 3]> {
        list.value.clone().try_into().map_err(|_| {
            let message = format!("`{what}` has {} numbers", list.value.len());
            self.wrong(message, list.span.clone(), "write three: x, y, z")
        })
    }

    fn inertia(&self, list: &At<Vec<f64>>) -> Result<Matrix3<f64>> {
        let (xx, yy, zz, xy, xz, yz) = match list.value[..] {
            [xx, yy, zz] => (xx, yy, zz, 0.0, 0.0, 0.0),
            [xx, yy, zz, xy, xz, yz] => (xx, yy, zz, xy, xz, yz),
            _ => {
                let message = format!("`inertia_kg_m2` has {} numbers", list.value.len());
                return Err(self.wrong(
                    message,
                    list.span.clone(),
                    "write xx, yy, zz, or xx, yy, zz, xy, xz, yz",
                ));
            }
        };
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        if inertia.symmetric_eigenvalues().min() < -1e-9 * inertia.norm() {
            let message = "the inertia has a negative principal moment, which is impossible";
            return Err(self.wrong(
                message,
                list.span.clone(),
                "check the products of inertia and their signs",
            ));
        }
        Ok(inertia)
    }

    fn body(&self, section: &BodySection) -> Result<Body> {
        Ok(Body {
            mass: *section.mass_kg,
            centre: MM * Vector3::from(self.three(&section.centre_mm, "centre_mm")?),
            inertia: self.inertia(&section.inertia_kg_m2)?,
        })
    }

    /// Axes of the table `[[axis]]`.
    fn axes_of_table(&self) -> Result<Vec<Axis>> {
        let mut axes: Vec<Axis> = Vec::new();
        for section in &*self.axis {
            if axes.iter().any(|axis| axis.name == *section.name.value) {
                let message = format!("two axes are called \"{}\"", *section.name);
                return Err(self.wrong(message, section.name.span.clone(), "rename one of them"));
            }
            let direction = Vector3::from(self.three(&section.direction, "direction")?);
            let direction = Unit::try_new(direction, 1e-9).ok_or_else(|| {
                let message = "the axis has no direction";
                self.wrong(message, section.direction.span.clone(), "write one such as [0, 0, 1]")
            })?;
            if !(*section.lower_deg < *section.upper_deg) {
                let message =
                    format!("the range of the axis is {}° to {}°", *section.lower_deg, *section.upper_deg);
                return Err(self.wrong(message, section.lower_deg.span.clone(), "swap them"));
            }
            axes.push(Axis {
                name: section.name.value.clone(),
                place: Pose::new(
                    self.three(&section.position_mm, "position_mm")?.map(|x| MM * x),
                    self.three(&section.rpy_deg, "rpy_deg")?.map(|x| DEG * x),
                ),
                direction,
                link: Body {
                    mass: *section.mass_kg,
                    centre: MM * Vector3::from(self.three(&section.centre_mm, "centre_mm")?),
                    inertia: self.inertia(&section.inertia_kg_m2)?,
                },
                lower: DEG * *section.lower_deg,
                upper: DEG * *section.upper_deg,
                speed: section.speed_deg_s.map_or(f64::INFINITY, |speed| DEG * speed),
                torque: f64::INFINITY,
            });
        }
        Ok(axes)
    }

    /// Simple shapes of the links of a URDF, beginning with the base; empty for a table of axes.
    ///
    /// # Errors
    /// An error in the shapes, with its line.
    pub(in crate::robot) fn visuals(&self, host: &dyn Host) -> Result<Vec<Vec<Solid>>> {
        let Some(section) = &*self.urdf else { return Ok(Vec::new()) };
        let text = urdf_text(section, host)?;
        urdf::visuals(&text, &section.base, &section.tip).map_err(|error| in_urdf(section, error))
    }

    /// The arm with its tool, and its payload.
    ///
    /// # Errors
    /// An error in axes, URDF or payload, with its place.
    pub fn arm(&self, host: &dyn Host) -> Result<(Arm, Body)> {
        let gravity = self.three(&self.gravity_m_s2, "gravity_m_s2")?;
        let mut arm = match (&*self.urdf, &self.axis[..]) {
            (Some(section), []) => {
                let text = urdf_text(section, host)?;
                urdf::read(&text, &section.base, &section.tip, gravity)
                    .map_err(|error| in_urdf(section, error))?
            }
            (None, []) => {
                let hint = "add [urdf] with file = \"…\", or a table of axes [[axis]]";
                return Err(self.wrong("the robot has no axes", None, hint));
            }
            (Some(_), [first, ..]) => {
                let hint = "keep [urdf] or the table of axes";
                return Err(self.wrong("the arm is given twice", first.span.clone(), hint));
            }
            (None, _) => {
                let axes = self.axes_of_table()?;
                Arm { axes, tool: Pose::identity(), gravity: Vector3::from(gravity) }
            }
        };
        // Tool and payload are given in the frame of the tip, which may be behind the last axis in a URDF.
        let tip = arm.tool;
        arm.tool = tip.then(&Pose::new(
            self.three(&self.tool.position_mm, "position_mm")?.map(|x| MM * x),
            self.three(&self.tool.rpy_deg, "rpy_deg")?.map(|x| DEG * x),
        ));
        let payload = match &*self.payload {
            Some(section) => self.body(section)?.transformed(&tip),
            None => Body::none(),
        };
        for (index, section) in self.joint.iter().enumerate() {
            let Some(axis) = arm.axes.iter_mut().find(|axis| axis.name == *section.axis.value) else {
                let names: Vec<&str> = self.names(&arm);
                let message = format!("no axis is called \"{}\"", *section.axis);
                return Err(self.wrong(
                    message,
                    section.axis.span.clone(),
                    format!("axes are {}", names.join(", ")),
                ));
            };
            if self.joint.iter().take(index).any(|other| *other.axis == *section.axis) {
                let message = format!("the axis \"{}\" has two reducers", *section.axis);
                return Err(self.wrong(message, section.axis.span.clone(), "take one [[joint]] out"));
            }
            axis.speed = section.speed_deg_s.map_or(axis.speed, |speed| DEG * speed);
            axis.torque = section.torque_limit_n_m.unwrap_or(axis.torque);
        }
        Ok((arm, payload))
    }
}

fn urdf_text(section: &UrdfSection, host: &dyn Host) -> Result<String> {
    let bytes = host.read(&section.file, Origin::Design)?;
    let text = text_of(&bytes).map_err(|kind| AnalysisError::Input {
        file: section.file.0.clone(),
        line: None,
        message: kind.to_string(),
        help: "save it as UTF-8".to_owned(),
    })?;
    Ok(text.to_string())
}

fn in_urdf(section: &UrdfSection, error: UrdfError) -> AnalysisError {
    AnalysisError::Input {
        file: section.file.0.clone(),
        line: Some(error.line),
        message: error.message,
        help: error.remedy,
    }
}
