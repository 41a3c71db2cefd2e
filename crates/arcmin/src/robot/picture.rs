//! The arm of a report: in space along its programs, from the side and from above.

use nalgebra::Vector3;

use super::arm::Pose;
use super::run::{Robot, ToolAnswer};
use super::tool::Kind;
use crate::report::{ArmPicture, ArmProgram, ArmState, Axis, Block, Colour, Plot, Series, Style, compact};
use crate::scene::{ArmScene, Frame, Link, Solid};
use crate::units::{DEG, MM, UM};

/// The arm in space, side view, plan view, distance from the path.
pub(super) fn blocks(robot: &Robot, tool: &ToolAnswer, reach: Option<Block>) -> Vec<Block> {
    let ages = vec![robot.planned; robot.joints.len()];
    let off = |place: usize| tool.field.tool(&tool.places, &ages, place)[0];
    let largest = tool.sorted.paths.iter().map(|place| off(*place).norm()).fold(0.0, f64::max);
    let span = |axis: usize| {
        let all =
            tool.sorted.paths.iter().map(|place| tool.places.places[*place].posture.tool.position[axis]);
        let (low, high) = all
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high): (f64, f64), x| (low.min(x), high.max(x)));
        high - low
    };
    let size = (0..3).map(span).fold(0.1, f64::max);
    let power = (0.1 * size / largest.max(1e-9)).log10().floor();
    let magnified = 10.0_f64.powf(power).max(1.0);
    let mut blocks = vec![Block::Arm(picture(robot, tool, magnified))];
    for (title, [x, y], names) in [("From the side", [0, 2], ["x", "z"]), ("From above", [0, 1], ["x", "y"])]
    {
        let mut plot = Plot::new(title, Axis::new(names[0], "mm"), Axis::new(names[1], "mm")).half();
        plot.equal_scales = true;
        let way = |magnified: f64| {
            tool.sorted.paths.iter().map(move |place| {
                let at = tool.places.places[*place].posture.tool.position + magnified * off(*place);
                (at[x] / MM, at[y] / MM)
            })
        };
        for (number, (place, _)) in tool.sorted.visits.iter().take(4).enumerate() {
            let posture = &tool.places.places[*place].posture;
            let chain = std::iter::once(nalgebra::Vector3::zeros())
                .chain(posture.links.iter().map(|link| link.position))
                .chain(std::iter::once(posture.tool.position));
            let links = Series::new(
                format!("arm at test pose {}", number + 1),
                Style::LineMarkers,
                chain.map(|at| (at[x] / MM, at[y] / MM)),
            );
            let links = links.coloured(Colour::Reference);
            plot.series.push(if number == 0 { links } else { links.hidden() });
        }
        plot.series.push(Series::line("commanded path", way(0.0)).coloured(Colour::Palette(0)));
        plot.series.push(
            Series::line(
                format!("path after {:.0} h, error × {}", robot.planned, compact(magnified, 3)),
                way(magnified),
            )
            .coloured(Colour::Palette(1))
            .strong(),
        );
        blocks.push(Block::Plot(
            plot.noted("Commanded path of the tool and its path at the planned hours, error magnified; the arm is drawn at test poses."),
        ));
    }
    let mut plot =
        Plot::new("Distance from the path", Axis::new("time", "s"), Axis::new("distance", "mm").from_zero());
    let new = vec![0.0; robot.joints.len()];
    for (name, hours) in [("new", &new), ("at the planned hours", &ages)] {
        let points = tool.sorted.paths.iter().filter_map(|place| {
            let here = &tool.places.places[*place];
            let Kind::Path { program: 0 } = here.kind else { return None };
            Some((here.time, tool.mapped().off_the_path(hours, *place) / MM))
        });
        plot.series.push(Series::line(name, points));
    }
    blocks.push(Block::Plot(plot.noted(format!(
        "Distance of the tool from the commanded path along the program \"{}\", at right angles to the path. At rest, distance \
         from the commanded position.",
        robot.programs[0].name
    ))));
    blocks.extend(reach);
    blocks
}

/// Number of instants of all programs in the picture.
const MOMENTS: usize = 1200;
/// Smallest number of instants of a program.
const FEWEST: usize = 100;
/// Number of ages in the picture.
const AGES: usize = 7;

/// The arm along its programs, with the tool error at every age.
fn picture(robot: &Robot, tool: &ToolAnswer, magnified: f64) -> ArmPicture {
    let known: Vec<f64> = tool.figures.iter().map(|(hours, _)| *hours).collect();
    let count = known.len().min(AGES);
    // Including new and the planned hours; a robot file requires at least two ages.
    let hours: Vec<f64> =
        (0..count).map(|age| known[(age * (known.len() - 1)).div_ceil((count - 1).max(1))]).collect();
    let mapped = tool.mapped();
    let shares = |hours: f64| -> Vec<f64> {
        let shares = mapped.shares(&vec![hours; robot.joints.len()]);
        shares.iter().map(|causes| rounded(causes.iter().sum::<f64>() / UM, 0.1)).collect()
    };
    let most = (MOMENTS / robot.programs.len()).max(FEWEST);
    ArmPicture {
        title: "The arm along its programs".to_owned(),
        note: format!(
            "Thin line: commanded path of the tool. Thick line: path reached, error magnified. The colour of a joint shows the \
             size of its share in the deviation of the tool; a negative share reduces the deviation. {}",
            match robot.visuals.iter().flatten().next() {
                Some(_) =>
                    "Links have the simple shapes of the URDF, and bars where it gives none or meshes. The size of a joint \
                            grows with the cube root of its rated torque.",
                None =>
                    "Bars stand for links. The size of a joint grows with the cube root of its rated torque.",
            }
        ),
        arm: scene(robot, tool),
        programs: (0..robot.programs.len())
            .map(|program| moments(robot, tool, program, (&hours, most)))
            .collect(),
        shares_um: hours.iter().map(|hours| shares(*hours)).collect(),
        hours,
        magnified,
    }
}

/// Rounded to whole steps.
fn rounded(value: f64, step: f64) -> f64 {
    // A negative zero would be written with its sign.
    let steps = (value / step).round() + 0.0;
    // Division by a whole number gives no digits beyond those of the step.
    steps / (1.0 / step).round()
}

fn moments(robot: &Robot, tool: &ToolAnswer, program: usize, (hours, most): (&[f64], usize)) -> ArmProgram {
    let of_program = |place: &&usize| tool.places.places[**place].kind == Kind::Path { program };
    let paths: Vec<usize> = tool.sorted.paths.iter().filter(of_program).copied().collect();
    let shown: Vec<usize> = paths.iter().copied().step_by(paths.len().div_ceil(most).max(1)).collect();
    let axes = robot.joints.len();
    let state = |hours: &f64| {
        let mut state = ArmState::default();
        for place in &shown {
            let by_axis: Vec<Vector3<f64>> =
                (0..axes).map(|axis| tool.field.by_axis(&tool.places, axis, *hours, *place)[0]).collect();
            let error: Vector3<f64> = by_axis.iter().sum();
            let along = error.try_normalize(0.0).unwrap_or_default();
            state.error_um.extend(error.iter().map(|x| rounded(x / UM, 0.1)));
            state.share_um.extend(by_axis.iter().map(|moved| rounded(moved.dot(&along) / UM, 0.1)));
        }
        state
    };
    let places = || shown.iter().map(|place| &tool.places.places[*place]);
    ArmProgram {
        name: robot.programs[program].name.clone(),
        time_s: places().map(|place| rounded(place.time, 1e-4)).collect(),
        angles_deg: places()
            .flat_map(|place| &place.angles)
            .map(|angle| rounded(angle / DEG, 1e-3))
            .collect(),
        states: hours.iter().map(state).collect(),
    }
}

fn mm(point: Vector3<f64>) -> [f64; 3] {
    [0, 1, 2].map(|axis| rounded(point[axis] / MM, 1e-3))
}

impl From<&Pose> for Frame {
    fn from(pose: &Pose) -> Frame {
        let rotation = std::array::from_fn(|i| pose.rotation[(i / 3, i % 3)]);
        Frame { position_mm: mm(pose.position), rotation }
    }
}

/// Radius and rated torque of an RV-160E by catalogues: m and N·m.
const SIZE: (f64, f64) = (0.115, 1568.0);
/// Largest radius of a joint relative to the distance from the base to the tool.
const WIDEST: f64 = 0.08;
/// Shorter bars are omitted, m.
const SHORTEST: f64 = 1e-3;

fn scene(robot: &Robot, tool: &ToolAnswer) -> ArmScene {
    let axes = &robot.arm.axes;
    let length =
        axes.iter().map(|axis| axis.place.position.norm()).sum::<f64>() + robot.arm.tool.position.norm();
    let radii: Vec<f64> = robot
        .joints
        .iter()
        .map(|joint| (SIZE.0 * (joint.rated / SIZE.1).cbrt()).min(WIDEST * length))
        .collect();
    // In the frame of its link.
    let middle = |axis: usize| tool.joints[axis].bearings * axes[axis].direction.into_inner();
    let bar = |from: Vector3<f64>, to: Vector3<f64>, radius: f64| {
        ((to - from).norm() > SHORTEST).then(|| cylinder(from, to, radius))
    };
    let given = |link: usize| robot.visuals.get(link).filter(|solids| !solids.is_empty()).cloned();
    let behind = |axis: usize| -> Vec<Solid> {
        let bar = match axes.get(axis + 1) {
            Some(next) => {
                let to = next.place.at(&middle(axis + 1));
                bar(middle(axis), to, 0.7 * radii[axis].min(radii[axis + 1]))
            }
            None => bar(middle(axis), robot.arm.tool.position, 0.3 * radii[axis]),
        };
        bar.into_iter().collect()
    };
    let foot = axes[0].place.at(&middle(0));
    ArmScene {
        base: given(0).unwrap_or_else(|| bar(Vector3::zeros(), foot, 0.85 * radii[0]).into_iter().collect()),
        links: axes
            .iter()
            .enumerate()
            .map(|(number, axis)| {
                let half = 0.8 * radii[number] * axis.direction.into_inner();
                Link {
                    name: axis.name.clone(),
                    frame: (&axis.place).into(),
                    axis: axis.direction.into_inner().into(),
                    joint: cylinder(middle(number) - half, middle(number) + half, radii[number]),
                    solids: given(number + 1).unwrap_or_else(|| behind(number)),
                }
            })
            .collect(),
        shells: robot.visuals.iter().any(|solids| !solids.is_empty()),
        tool_mm: mm(robot.arm.tool.position),
    }
}

/// A cylinder, all lengths in m.
fn cylinder(from: Vector3<f64>, to: Vector3<f64>, radius: f64) -> Solid {
    Solid::Cylinder { from_mm: mm(from), to_mm: mm(to), radius_mm: rounded(radius / MM, 1e-3) }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{answered, two_axes, with_readings};
    use super::*;

    /// Bars meet at the joints; at every instant the error is the displacement of the tool by the joint errors,
    /// and the shares add up to its magnitude.
    #[test]
    fn the_picture_is_the_arm_with_its_errors() {
        let robot = answered(&two_axes(""), &with_readings(&[]));
        let tool = robot.tool.as_ref().unwrap();
        let picture = picture(&robot, tool, 10.0);
        assert_eq!((picture.hours.clone(), picture.arm.shells), (vec![0.0, 6000.0], false));
        let ends = |solid: &Solid| match solid {
            Solid::Cylinder { from_mm, to_mm, .. } => (*from_mm, *to_mm),
            other => panic!("{other:?}"),
        };
        let bars: Vec<_> = picture.arm.links.iter().map(|link| ends(&link.solids[0])).collect();
        assert_eq!(bars, [([0.0; 3], [500.0, 0.0, 0.0]), ([0.0; 3], [500.0, 0.0, 0.0])]);
        assert!(picture.arm.base.is_empty(), "the first joint stands in the base");
        let program = &picture.programs[0];
        assert!(program.time_s.len() > 200 && program.time_s.windows(2).all(|pair| pair[0] < pair[1]));
        for (age, state) in program.states.iter().enumerate() {
            for (moment, time) in program.time_s.iter().enumerate() {
                let place = tool
                    .sorted
                    .paths
                    .iter()
                    .copied()
                    .find(|place| (tool.places.places[*place].time - time).abs() < 1e-4)
                    .unwrap();
                let angles = &tool.places.places[place].angles;
                let off =
                    |axis: usize| tool.field.at(axis, picture.hours[age], place).about.iter().sum::<f64>();
                let turned: Vec<f64> =
                    angles.iter().enumerate().map(|(axis, angle)| angle + off(axis)).collect();
                let at = |angles: &[f64]| robot.arm.posture(angles).tool.position;
                let expected = at(&turned) - at(angles);
                let error = Vector3::from_column_slice(&state.error_um[3 * moment..3 * moment + 3]);
                // Rotations of an arc minute at one metre: second-order terms are below a tenth of a
                // micrometre.
                assert!((error - expected / UM).norm() < 0.3, "{time} s: {error} {expected}");
                let shares: f64 = state.share_um[2 * moment..2 * moment + 2].iter().sum();
                assert!((shares - error.norm()).abs() < 0.3, "{time} s: {shares} {error}");
                let shown = program.angles_deg[2 * moment] - angles[0] / DEG;
                assert!(shown.abs() < 6e-4, "{shown}");
            }
            assert!(state.error_um.iter().any(|error| error.abs() > 10.0), "age {age}");
        }
        let worst = tool.mapped().worst_visit(&[6000.0; 2]).1;
        assert!((picture.shares_um[1].iter().sum::<f64>() - worst / UM).abs() < 0.3);
    }

    #[test]
    fn numbers_are_rounded_to_steps() {
        let written = |value: f64, step: f64| serde_json::to_string(&rounded(value, step)).unwrap();
        assert_eq!(
            [written(428.34, 0.1), written(-0.02, 0.1), written(30.0004, 1e-3)],
            ["428.3", "0.0", "30.0"]
        );
        assert_eq!(written(0.123456, 1e-4), "0.1235");
    }
}
