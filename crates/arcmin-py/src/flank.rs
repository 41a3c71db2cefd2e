//! Geometry of the flank at any parameter.

use arcmin::analyses::profile::FlankPoint;
use arcmin::analyses::stage::AnyDesign;
use arcmin::geometry::{Profile, Relief};
use arcmin::units::{DEG, MM, UM};
use numpy::ndarray::{Array2, ArrayView1};
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Geometry of the flank of a cycloid disc, at any parameters around it.
///
/// Positions are the parameter tau in degrees, once around the disc from 0 to 360; a lobe spans 360 /
/// lobe_count. Every method takes a number or an array of shape (n,) and returns arrays. Design.flank() creates
/// one.
#[pyclass(module = "arcmin", frozen)]
pub struct Flank {
    profile: Profile,
    worn: Relief,
}

type Places<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;

impl Flank {
    pub fn of(py: Python<'_>, design: &AnyDesign, wear_um: f64) -> PyResult<Flank> {
        if !(0.0..=1000.0).contains(&wear_um) {
            let message = format!("`wear_um` is a depth from 0 to 1000 µm, not {wear_um}");
            return Err(crate::errors::value(py, "wear_um", &message, true));
        }
        let (profile, relief) = design.flank();
        Ok(Flank { profile, worn: relief.plus(&Relief::uniform(wear_um * UM)) })
    }

    fn points(&self, tau_deg: &Places<'_>) -> PyResult<Vec<FlankPoint>> {
        let places = checked(tau_deg)?;
        Ok(places
            .iter()
            .map(|tau| FlankPoint::at(&self.profile, &self.worn, &self.worn, tau * DEG))
            .collect())
    }
}

fn checked(places: &Places<'_>) -> PyResult<Vec<f64>> {
    let view: ArrayView1<'_, f64> = places.as_array();
    if view.iter().any(|place| !(place.abs() <= 1e9)) {
        return Err(PyValueError::new_err("parameters must be finite numbers in degrees"));
    }
    Ok(view.to_vec())
}

fn pairs<'py>(
    py: Python<'py>,
    points: &[FlankPoint],
    of: fn(&FlankPoint) -> [f64; 2],
) -> Bound<'py, PyArray2<f64>> {
    let rows: Vec<f64> = points.iter().flat_map(of).collect();
    let shape = (points.len(), 2);
    let array = Array2::from_shape_vec(shape, rows).unwrap_or_else(|_| Array2::zeros(shape));
    PyArray2::from_owned_array(py, array)
}

#[pymethods]
impl Flank {
    /// Number of lobes of the disc.
    #[getter]
    fn lobe_count(&self) -> usize {
        self.profile.lobe_count()
    }

    /// K1 = a z_p / R_p of the generating circle; below 1 the trochoid has no cusps.
    #[getter]
    fn short_width_coefficient(&self) -> f64 {
        self.profile.short_width_coefficient()
    }

    /// Meshing angle in degrees at which the flank changes from concave to convex, or None.
    #[getter]
    fn inflection_deg(&self) -> Option<f64> {
        self.profile.inflection().map(|angle| angle / DEG)
    }

    /// Points of the flank in mm, shape (n, 2): x and y in the frame of the disc.
    fn points_mm<'py>(&self, py: Python<'py>, tau_deg: Places<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        Ok(pairs(py, &self.points(&tau_deg)?, |p| [p.worn.x / MM, p.worn.y / MM]))
    }

    /// Unit normals into the metal, shape (n, 2).
    fn normals<'py>(&self, py: Python<'py>, tau_deg: Places<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        Ok(pairs(py, &self.points(&tau_deg)?, |p| [p.normal.x, p.normal.y]))
    }

    /// Curvature in 1/mm, shape (n,): positive where the flank is concave.
    fn curvature_per_mm<'py>(
        &self,
        py: Python<'py>,
        tau_deg: Places<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let curvatures = self.points(&tau_deg)?.iter().map(|p| MM / p.curvature_radius).collect();
        Ok(PyArray1::from_vec(py, curvatures))
    }

    /// Meshing angle in degrees, in (-180, 180], shape (n,): angle of the pin in contact there, from the
    /// direction of the eccentric.
    fn meshing_angle_deg<'py>(
        &self,
        py: Python<'py>,
        tau_deg: Places<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let angles = self.points(&tau_deg)?.iter().map(|p| p.meshing_angle / DEG).collect();
        Ok(PyArray1::from_vec(py, angles))
    }

    /// Specific sliding of the flank and the pins, shape (n,): sliding speed divided by the speed of the
    /// contact along the flank.
    fn specific_sliding<'py>(
        &self,
        py: Python<'py>,
        tau_deg: Places<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let sliding = self.points(&tau_deg)?;
        let sliding = sliding.iter().map(|p| self.profile.specific_sliding(p.meshing_angle.cos())).collect();
        Ok(PyArray1::from_vec(py, sliding))
    }

    fn __repr__(&self) -> String {
        format!("<Flank of {} lobes, K1 = {:.4}>", self.lobe_count(), self.short_width_coefficient())
    }
}
