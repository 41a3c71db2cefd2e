//! The elastic disc: its mesh and how it deforms under rated torque.

use super::{Block, Column, Section, Table, compact, mesh_picture, significant};
use crate::fem::DiscModel;
use crate::load::LoadSharing;
use crate::machine::Machine;

/// Frequencies listed.
const LISTED: usize = 8;

/// Mesh, deformed shape under the tooth forces of `sharing` on its first disc, and natural frequencies (Hz)
/// with the bores held.
pub fn section(machine: &Machine, model: &DiscModel, frequencies: &[f64], sharing: &LoadSharing) -> Section {
    let loads = sharing.tooth_loads(0);
    let unknowns = model.deflect(&loads);
    let plane = &model.mesh.plane;
    let displacement: Vec<[f64; 2]> =
        model.nodal_displacement(&unknowns)[..plane.nodes.len()].iter().map(|u| [u[0], u[1]]).collect();
    let largest = displacement.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max) * 1e6;
    let stress = model.von_mises(&unknowns)[..plane.nodes.len()].iter().copied().fold(0.0, f64::max) * 1e-6;
    let quality = model.quality();
    let note = format!(
        "Under the {} tooth forces of one disc at {} N·m, bores held. Largest displacement {} µm, largest von Mises stress {} MPa; tooth forces are \
         spread over a millimetre of the flank, so that contact pressures are not among these stresses.",
        loads.len(),
        compact(machine.rated.torque, 4),
        significant(largest, 3),
        significant(stress, 3)
    );
    let picture = mesh_picture(
        "Mesh and deformed shape of the cycloid disc",
        &note,
        plane.nodes.iter().map(|p| [p.x, p.y]),
        &plane.triangles,
        &displacement,
    );
    let rows = frequencies
        .iter()
        .take(LISTED)
        .enumerate()
        .map(|(k, f)| vec![format!("{}", k + 1), significant(f * 1e-3, 4)])
        .collect();
    let table = Table {
        title: "Natural frequencies of the disc, held at its bores".into(),
        columns: vec![Column::number("Mode", ""), Column::number("Frequency", "kHz")],
        rows,
        note: format!(
            "{} elements, {} unknowns, smallest angle {}°.",
            model.mesh.element_count(),
            model.inner_unknowns(),
            significant(quality.smallest_angle_deg, 3)
        ),
    };
    Section::new("elastic-disc", "Elastic disc", vec![Block::Mesh(picture), Block::Table(table)])
}
