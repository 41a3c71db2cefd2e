//! Figures of the virtual test bench and of the machine behind the teeth: hysteresis loop, stiffness split, efficiency, orders, bearings.
//!
//! Every function takes plain results in trade units and gives blocks, for a page of its own or as a section of the life page.

use crate::machine::Machine;

use super::{
    Annotation, Axis, Block, Colour, Column, HeatMap, MeshField, MeshPicture, Plot, Series, Shares, Style, Table, Tone, Width, compact, significant,
};

/// One hysteresis loop, rising and falling branch as (torque in N·m, output angle in arcmin).
#[derive(Debug, Clone, PartialEq)]
pub struct HysteresisLoop {
    /// State or crank position, such as "new" or "7500 h".
    pub label: String,
    pub rising: Vec<(f64, f64)>,
    pub falling: Vec<(f64, f64)>,
    /// A measured loop is drawn as markers.
    pub measured: bool,
}

/// Loops with the torque windows of the definitions.
///
/// `lost_motion_torque_n_m` is 3 % of the rated torque; the stiffness is read between the two torques of `stiffness_window_n_m`.
pub fn hysteresis(loops: &[HysteresisLoop], lost_motion_torque_n_m: f64, stiffness_window_n_m: (f64, f64)) -> Vec<Block> {
    let build = |title: &str, note: String| {
        let mut plot =
            Plot::new(title, Axis::new("Output torque, input locked", "N·m"), Axis::new("Angle of the output", "arcmin")).half().noted(note);
        for (index, one) in loops.iter().enumerate() {
            // Both branches in one series: the loop is read as it was run.
            let points = one.rising.iter().chain(&one.falling).copied();
            let style = if one.measured { Style::Markers } else { Style::Line };
            let colour = if one.measured { Colour::Reference } else { Colour::Palette((index % 7) as u8) };
            plot.series.push(Series::new(one.label.clone(), style, points).coloured(colour));
        }
        plot
    };
    let whole = build(
        "Hysteresis loop",
        format!("Torsional stiffness is the slope between {} and {} N·m.", compact(stiffness_window_n_m.0, 4), compact(stiffness_window_n_m.1, 4)),
    );
    let mut close = build(
        "Hysteresis loop near zero torque",
        "Lost motion: at +3 % and at −3 % of the rated torque take the mid-point between the two branches; it is the angle between these two \
         mid-points. Backlash is the width of the loop at zero torque [GBT40731]."
            .into(),
    );
    let window = 3.0 * lost_motion_torque_n_m;
    for series in &mut close.series {
        for (x, y) in series.points.x.iter().zip(&mut series.points.y) {
            if x.abs() > window {
                *y = None;
            }
        }
    }
    close.x = close.x.between(-window, window);
    for (at, label) in [(-lost_motion_torque_n_m, "−3 %"), (lost_motion_torque_n_m, "+3 %")] {
        close.annotations.push(Annotation::Vertical { at, label: label.into(), tone: Tone::Neutral });
    }
    vec![Block::Plot(whole), Block::Plot(close)]
}

/// Compliance per part, as (part, arcmin per N·m, remark); `whole_nm_per_arcmin` is the stiffness read from the loop.
pub fn stiffness_split(parts: &[(String, f64, String)], whole_nm_per_arcmin: f64) -> Block {
    let sum: f64 = parts.iter().map(|part| part.1).sum();
    let note = format!(
        "Compliance at the output per part. Together they give {} N·m/arcmin; the loop gives {} N·m/arcmin.",
        significant(1.0 / sum, 3),
        significant(whole_nm_per_arcmin, 3)
    );
    let rows = parts.iter().map(|(part, compliance, remark)| (part.clone(), compliance * 100.0, remark.clone())).collect();
    Block::Shares(Shares { title: "Which part gives how much".into(), unit: "arcmin per 100 N·m".into(), rows, note })
}

/// Lost motion per cause over hours: (cause, points of (h, arcmin)).
pub fn lost_motion_causes(causes: &[(String, Vec<(f64, f64)>)]) -> Block {
    let mut plot = Plot::new("Lost motion by cause", Axis::new("Running time", "h"), Axis::new("Lost motion", "arcmin").from_zero()).half();
    // Stacked: every band stands on the one before.
    let mut below: Vec<(f64, f64)> = Vec::new();
    for (index, (cause, points)) in causes.iter().enumerate() {
        let band: Vec<(f64, f64, f64)> = points
            .iter()
            .enumerate()
            .map(|(at, (hours, value))| {
                let low = below.get(at).map_or(0.0, |base| base.1);
                (*hours, low, low + value)
            })
            .collect();
        below = band.iter().map(|(hours, _, high)| (*hours, *high)).collect();
        plot.series.push(Series::band(cause.clone(), band).coloured(Colour::Palette((index % 7) as u8)));
    }
    plot.series.push(Series::line("sum", below).coloured(Colour::Reference).strong());
    plot.note = "Bands stand on each other; their sum is the lost motion of the whole machine.".into();
    Block::Plot(plot)
}

/// Likely causes of an order of the output turn, for orders that theory assigns; `None` for others.
///
/// One order may have several: 80 is the sun's turn against the carrier of an RV-40E-81 and twice its pin count.
pub fn order_cause(machine: &Machine, order: f64) -> Option<String> {
    let is = |of: f64| of > 0.0 && (order - of).abs() < 0.01 * of.max(1.0);
    let kinematics = machine.kinematics();
    let (lobes, pins) = (kinematics.lobe_count, kinematics.pin_count);
    let cranks = machine.crankshafts.count as f64;
    // The planet's own turn relative to the carrier: 1 + z_c per turn of the output, which is z_p.
    let named = [
        (1.0, "carrier and output: eccentricity, bores"),
        (cranks, "position of crankshafts and bores"),
        (lobes, "disc: profile, centre, eccentricity"),
        (pins, "pins: pitch, radius, circle; planet run-out (turn against the carrier)"),
        (kinematics.housing_fixed_ratio(), "sun gear: run-out"),
        (kinematics.housing_fixed_ratio() - 1.0, "sun gear: run-out (turn against the carrier)"),
        (lobes * pins, "pairs entering and leaving the mesh"),
    ];
    let mut causes: Vec<String> = named.iter().filter(|(of, _)| is(*of)).map(|(_, cause)| (*cause).to_owned()).collect();
    for (of, part) in [(lobes, "disc"), (pins, "pins")] {
        causes.extend((2..=4).filter(|factor| is(f64::from(*factor) * of)).map(|factor| format!("{part}, {factor} × {of:.0}")));
    }
    (!causes.is_empty()).then(|| causes.join("; or "))
}

/// Spectrum of the transmission error in orders of the output turn, with the largest named: (label, lines of (order, arcmin)).
pub fn order_spectrum(machine: &Machine, spectra: &[(String, Vec<(f64, f64)>)]) -> Vec<Block> {
    const NAMED: usize = 8;
    /// Beyond this part of the largest line there is nothing to name.
    const WORTH_NAMING: f64 = 0.01;
    let mut plot =
        Plot::new("Orders of the transmission error", Axis::new("Order per turn of the output", ""), Axis::new("Amplitude", "arcmin").from_zero());
    for (index, (label, lines)) in spectra.iter().enumerate() {
        plot.series.push(Series::new(label.clone(), Style::Bars, lines.iter().copied()).coloured(Colour::Palette((index % 7) as u8)));
    }
    let mut blocks = Vec::new();
    if let Some((label, lines)) = spectra.first() {
        let mut largest: Vec<(f64, f64)> = lines.iter().copied().filter(|line| line.0 > 0.0 && line.1.is_finite()).collect();
        largest.sort_by(|a, b| b.1.total_cmp(&a.1));
        let top = largest.first().map_or(0.0, |line| line.1);
        largest.retain(|line| line.1 >= WORTH_NAMING * top);
        largest.truncate(NAMED);
        for (order, amplitude) in largest.iter().take(4) {
            plot.annotations.push(Annotation::Point { x: *order, y: *amplitude, label: compact(*order, 4) });
        }
        let rows = largest
            .iter()
            .map(|(order, amplitude)| {
                vec![compact(*order, 4), significant(*amplitude, 3), order_cause(machine, *order).unwrap_or_else(|| "no single cause known".into())]
            })
            .collect();
        blocks.push(Block::Table(Table {
            title: format!("Largest orders, {label}"),
            columns: vec![Column::number("Order", ""), Column::number("Amplitude", "arcmin"), Column::text("Likely cause")],
            rows,
            note: String::new(),
        }));
    }
    blocks.insert(0, Block::Plot(plot));
    blocks
}

/// Transmission error over one output turn: (label, points of (output angle in °, arcmin)).
pub fn error_over_a_turn(curves: &[(String, Vec<(f64, f64)>)]) -> Block {
    let mut plot = Plot::new("Transmission error over one output turn", Axis::new("Output angle", "°"), Axis::new("Transmission error", "arcmin"));
    for (label, points) in curves {
        plot.series.push(Series::line(label.clone(), points.iter().copied()));
    }
    Block::Plot(plot)
}

/// Efficiency over torque and speed; `cells[speed][torque]`, `None` where the machine does not turn.
pub fn efficiency_map(torques_n_m: &[f64], speeds_rpm: &[f64], cells: &[Vec<Option<f64>>]) -> Block {
    Block::HeatMap(HeatMap {
        title: "Efficiency".into(),
        x: Axis::new("Output torque", "N·m"),
        y: Axis::new("Input speed", "rpm"),
        value: Axis::new("Efficiency", "%"),
        x_values: torques_n_m.to_vec(),
        y_values: speeds_rpm.to_vec(),
        cells: cells.iter().flatten().map(|cell| cell.filter(|value| value.is_finite()).map(|value| 100.0 * value)).collect(),
        note: String::new(),
        width: Width::Half,
    })
}

/// Load of one bearing over the crank turn and its rating life.
#[derive(Debug, Clone, PartialEq)]
pub struct BearingLoad {
    pub name: String,
    /// (crank angle in °, radial load in N).
    pub load: Vec<(f64, f64)>,
    pub equivalent_load_n: f64,
    /// ISO 281; `None` without a dynamic load rating in the design.
    pub l10h_hours: Option<f64>,
}

/// Bearing loads over the crank turn, and their rating lives.
pub fn bearing_loads(bearings: &[BearingLoad]) -> Vec<Block> {
    let mut plot = Plot::new("Bearing loads over the crank turn", Axis::new("Crank angle", "°"), Axis::new("Radial load", "N").from_zero()).half();
    for bearing in bearings {
        plot.series.push(Series::line(bearing.name.clone(), bearing.load.iter().copied()));
    }
    let rows = bearings
        .iter()
        .map(|bearing| {
            let largest = bearing.load.iter().map(|point| point.1).fold(0.0, f64::max);
            vec![
                bearing.name.clone(),
                significant(largest, 3),
                significant(bearing.equivalent_load_n, 3),
                bearing.l10h_hours.map_or_else(|| "no load rating given".to_owned(), |hours| significant(hours, 3)),
            ]
        })
        .collect();
    let table = Table {
        title: "Rating life of the bearings".into(),
        columns: vec![
            Column::text("Bearing"),
            Column::number("Largest load", "N"),
            Column::number("Equivalent load", "N"),
            Column::number("L10h", "h"),
        ],
        rows,
        note: "Rating life by [ISO281]; the equivalent load is that of the load cycle shown.".into(),
    };
    vec![Block::Plot(plot), Block::Table(table)]
}

/// Picture of a plane mesh of linear or quadratic triangles (m), with displacements (m) of every node where there are any.
///
/// Quadratic triangles list their corners first; only those are drawn. The colour is the size of the displacement.
pub fn mesh_picture<const N: usize>(
    title: &str,
    note: &str,
    nodes: impl IntoIterator<Item = [f64; 2]>,
    triangles: &[[usize; N]],
    displacement: &[[f64; 2]],
) -> MeshPicture {
    // Only corners are drawn, so that midside nodes need not be in the page.
    let nodes: Vec<[f64; 2]> = nodes.into_iter().collect();
    let mut place = vec![u32::MAX; nodes.len()];
    let mut used = Vec::new();
    let corners = triangles
        .iter()
        .map(|triangle| {
            let mut corner = [0_u32; 3];
            for (slot, node) in corner.iter_mut().zip(triangle) {
                if place[*node] == u32::MAX {
                    place[*node] = used.len() as u32;
                    used.push(*node);
                }
                *slot = place[*node];
            }
            corner
        })
        .collect();
    let moved = displacement.len() == nodes.len();
    let displacement_um: Vec<[f64; 2]> =
        if moved { used.iter().map(|node| displacement[*node].map(|part| part * 1e6)).collect() } else { Vec::new() };
    let field = moved.then(|| MeshField {
        label: "displacement".into(),
        unit: "µm".into(),
        values: displacement_um.iter().map(|[x, y]| x.hypot(*y)).collect(),
    });
    MeshPicture {
        title: title.into(),
        note: note.into(),
        nodes_mm: used.iter().map(|node| nodes[*node].map(|part| part * 1e3)).collect(),
        triangles: corners,
        displacement_um,
        field,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_get_the_causes_of_theory() {
        let machine = crate::templates::rv_40e_81();
        for (order, word) in [
            (1.0, "carrier"),
            (2.0, "crankshafts"),
            (39.0, "disc"),
            (40.0, "pins"),
            (78.0, "disc, 2 × 39"),
            (80.0, "turn against the carrier); or pins, 2 × 40"),
            (81.0, "sun"),
            (1560.0, "pairs"),
        ] {
            let cause = order_cause(&machine, order).unwrap_or_default();
            assert!(cause.contains(word), "{order}: {cause}");
        }
        assert_eq!(order_cause(&machine, 17.0), None);
    }

    #[test]
    fn bands_of_lost_motion_add_up() {
        let causes = vec![("teeth".to_owned(), vec![(0.0, 0.1), (10.0, 0.4)]), ("bearings".to_owned(), vec![(0.0, 0.3), (10.0, 0.3)])];
        let Block::Plot(plot) = lost_motion_causes(&causes) else { panic!("a plot") };
        assert_eq!(plot.series[1].points.low, vec![Some(0.1), Some(0.4)]);
        assert!((plot.series[2].points.y[1].unwrap_or(0.0) - 0.7).abs() < 1e-12);
    }

    #[test]
    fn mesh_picture_keeps_corners_only() {
        let nodes = vec![[0.0, 0.0], [1e-3, 0.0], [0.0, 1e-3], [0.5e-3, 0.0], [0.5e-3, 0.5e-3], [0.0, 0.5e-3]];
        let displacement: Vec<[f64; 2]> = (0..6).map(|i| [f64::from(i) * 1e-6, 0.0]).collect();
        let picture = mesh_picture("m", "", nodes, &[[0, 1, 2, 3, 4, 5]], &displacement);
        assert_eq!(picture.nodes_mm, vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        assert_eq!(picture.triangles, vec![[0, 1, 2]]);
        assert_eq!(picture.field.map(|field| field.values.len()), Some(3));
    }

    #[test]
    fn loops_near_zero_leave_out_the_rest() {
        let loops = vec![HysteresisLoop {
            label: "new".into(),
            rising: vec![(-412.0, -4.0), (0.0, 0.1), (412.0, 4.0)],
            falling: vec![(412.0, 4.0), (0.0, -0.1), (-412.0, -4.0)],
            measured: false,
        }];
        let blocks = hysteresis(&loops, 12.36, (206.0, 412.0));
        let Block::Plot(close) = &blocks[1] else { panic!("a plot") };
        assert_eq!(close.series[0].points.y, vec![None, Some(0.1), None, None, Some(-0.1), None]);
    }
}
