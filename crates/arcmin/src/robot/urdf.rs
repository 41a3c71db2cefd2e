//! A serial arm from a URDF file (ROS wiki, urdf/XML). Links connected by fixed joints are combined.
//!
//! The XML is read by `roxmltree`, which provides the line of every element; `urdf-rs` replaces missing
//! inertias by zeros and does not provide lines.

use nalgebra::{Matrix3, Unit, Vector3};
use roxmltree::{Document, Node};

use super::arm::{Arm, Axis, Body, Pose};

mod tree;
mod visuals;

use tree::{Joint, Tree};
pub(super) use visuals::visuals;

/// An error in a file with its line and a remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct UrdfError {
    /// Line, counted from 1.
    pub line: usize,
    /// Fault in one sentence.
    pub message: String,
    /// Advice in one sentence.
    pub remedy: String,
}

type Result<T> = std::result::Result<T, UrdfError>;

fn line(node: Node<'_, '_>) -> usize {
    node.document().text_pos_at(node.range().start).row as usize
}

fn wrong(node: Node<'_, '_>, message: impl Into<String>, remedy: impl Into<String>) -> UrdfError {
    UrdfError { line: line(node), message: message.into(), remedy: remedy.into() }
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|inner| inner.has_tag_name(name))
}

fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str> {
    node.attribute(name).ok_or_else(|| {
        let tag = node.tag_name().name();
        wrong(node, format!("<{tag}> has no {name}"), format!("add {name}=\"…\""))
    })
}

fn number(node: Node<'_, '_>, name: &str) -> Result<f64> {
    let text = attribute(node, name)?;
    text.trim().parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(|| {
        let remedy = match text.contains('$') {
            true => "expand the file with xacro first",
            false => "write a finite number with a decimal point",
        };
        wrong(node, format!("{name}=\"{text}\" is not a number"), remedy)
    })
}

fn three(node: Node<'_, '_>, name: &str, default: [f64; 3]) -> Result<[f64; 3]> {
    let Some(text) = node.attribute(name) else { return Ok(default) };
    let numbers: Option<Vec<f64>> =
        text.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect();
    numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| {
        wrong(
            node,
            format!("{name}=\"{text}\" is not a list of three numbers"),
            "write three with spaces between",
        )
    })
}

fn origin(node: Node<'_, '_>) -> Result<Pose> {
    Ok(match child(node, "origin") {
        Some(origin) => Pose::new(three(origin, "xyz", [0.0; 3])?, three(origin, "rpy", [0.0; 3])?),
        None => Pose::identity(),
    })
}

/// Mass of a link in its own frame; `None` if the file does not contain it.
fn body(link: Node<'_, '_>) -> Result<Option<Body>> {
    let Some(inertial) = child(link, "inertial") else { return Ok(None) };
    let missing =
        |what: &str| wrong(inertial, format!("<inertial> has no <{what}>"), format!("add it: <{what} …/>"));
    let mass_node = child(inertial, "mass").ok_or_else(|| missing("mass"))?;
    let mass = number(mass_node, "value")?;
    if mass < 0.0 {
        return Err(wrong(mass_node, format!("a mass of {mass} kg"), "write a mass that is not negative"));
    }
    let node = child(inertial, "inertia").ok_or_else(|| missing("inertia"))?;
    let [xx, xy, xz, yy, yz, zz] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(|name| number(node, name));
    let (xx, xy, xz, yy, yz, zz) = (xx?, xy?, xz?, yy?, yz?, zz?);
    let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let least = inertia.symmetric_eigenvalues().min();
    if least < -1e-9 * inertia.norm() {
        let message = "the inertia has a negative principal moment, which is impossible";
        return Err(wrong(node, message, "export it again from the CAD model, about the centre of mass"));
    }
    let own = Body { mass, centre: Vector3::zeros(), inertia };
    Ok(Some(own.transformed(&origin(inertial)?)))
}

/// Reads the arm from `base` (empty: the root) to `tip` (empty: the only end), with gravity in m/s² in the
/// frame of the base. The tool is the tip's frame.
///
/// # Errors
/// The first fault, with its line.
pub fn read(text: &str, base: &str, tip: &str, gravity: [f64; 3]) -> Result<Arm> {
    let document = parse(text)?;
    let tree = Tree::of(&document, base, tip)?;
    arm(&tree, gravity)
}

fn parse(text: &str) -> Result<Document<'_>> {
    Document::parse(text).map_err(|error| UrdfError {
        line: error.pos().row as usize,
        message: format!("no XML: {error}"),
        remedy: "write a URDF file; xacro files are expanded first".to_owned(),
    })
}

fn arm(tree: &Tree<'_, '_>, gravity: [f64; 3]) -> Result<Arm> {
    let Tree { links, joints, chain } = tree;
    let mut axes: Vec<Axis> = Vec::new();
    // Pose of the present link in the frame of the last axis.
    let mut place = Pose::identity();
    for (order, index) in chain.iter().enumerate() {
        let joint = &joints[*index];
        place = place.then(&origin(joint.node)?);
        match joint.kind {
            "fixed" => {}
            "revolute" | "continuous" => {
                axes.push(axis(joint, place)?);
                place = Pose::identity();
            }
            kind => {
                let message =
                    format!("joint \"{}\" is {kind}: only revolute joints have a reducer", joint.name);
                let remedy = "make it fixed, or give a base and tip between which all joints are revolute";
                return Err(wrong(joint.node, message, remedy));
            }
        }
        let Some(last) = axes.last_mut() else { continue };
        let link = joint.child;
        let mut mass = body(links[link].node)?;
        let next = chain.get(order + 1).copied();
        for (side, pose) in tree.fixed_to(link, next, beside_the_chain(links[link].name))? {
            if let Some(other) = body(links[side].node)? {
                let other = other.transformed(&pose);
                mass = Some(mass.map_or(other, |mass| mass.with(&other)));
            }
        }
        if mass.is_none() && joint.moves() && next.is_some_and(|next| joints[next].moves()) {
            let message = format!("the link \"{}\" is movable but has no <inertial>", links[link].name);
            let remedy = "add <inertial> with <mass> and <inertia>, which are needed for its weight";
            return Err(wrong(links[link].node, message, remedy));
        }
        if let Some(mass) = mass {
            last.link = last.link.with(&mass.transformed(&place));
        }
    }
    if let Some((massless, joint)) = axes
        .iter()
        .zip(chain.iter().map(|index| &joints[*index]).filter(|joint| joint.moves()))
        .find(|(axis, _)| axis.link.mass == 0.0)
    {
        let link = &links[joint.child];
        let message = format!("the link \"{}\" behind joint \"{}\" has no mass", link.name, massless.name);
        return Err(wrong(link.node, message, "add <inertial> with <mass> and <inertia>"));
    }
    if axes.is_empty() {
        let node = links.first().map(|link| link.node);
        return Err(UrdfError {
            line: node.map_or(1, line),
            message: "the chain has no revolute joint".to_owned(),
            remedy: "give base and tip under [urdf]".to_owned(),
        });
    }
    Ok(Arm { axes, tool: place, gravity: Vector3::from(gravity) })
}

/// The error for a movable joint outside of the chain: branches must be fixed, because they are part of the
/// link.
fn beside_the_chain(link: &str) -> impl Fn(&Joint<'_, '_>) -> Result<()> {
    move |joint| {
        let message = format!("joint \"{}\" moves beside the chain, on the link \"{link}\"", joint.name);
        let remedy =
            "make it fixed in its present position (for example a gripper), so that its mass is included";
        Err(wrong(joint.node, message, remedy))
    }
}

fn axis(joint: &Joint<'_, '_>, place: Pose) -> Result<Axis> {
    if let Some(mimic) = child(joint.node, "mimic") {
        let message = format!("joint \"{}\" follows another one", joint.name);
        return Err(wrong(mimic, message, "coupled joints are not modelled: make it fixed"));
    }
    let direction = match child(joint.node, "axis") {
        Some(node) => three(node, "xyz", [1.0, 0.0, 0.0])?,
        None => [1.0, 0.0, 0.0],
    };
    let direction = Unit::try_new(Vector3::from(direction), 1e-9).ok_or_else(|| {
        let message = format!("the axis of joint \"{}\" has no direction", joint.name);
        wrong(joint.node, message, "write <axis xyz=\"0 0 1\"/>")
    })?;
    let (mut lower, mut upper) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut speed, mut torque) = (f64::INFINITY, f64::INFINITY);
    match child(joint.node, "limit") {
        Some(limit) => {
            let given = |name: &str, value: &mut f64| -> Result<()> {
                if limit.attribute(name).is_some() {
                    *value = number(limit, name)?;
                }
                Ok(())
            };
            if joint.kind == "revolute" {
                (lower, upper) = (0.0, 0.0);
                given("lower", &mut lower)?;
                given("upper", &mut upper)?;
                if !(lower < upper) {
                    let message =
                        format!("joint \"{}\" has an empty range, {lower} to {upper} rad", joint.name);
                    return Err(wrong(limit, message, "write lower and upper in rad, or make it continuous"));
                }
            }
            given("velocity", &mut speed)?;
            given("effort", &mut torque)?;
        }
        None if joint.kind == "revolute" => {
            let message = format!("the revolute joint \"{}\" has no <limit>", joint.name);
            return Err(wrong(
                joint.node,
                message,
                "add <limit lower upper effort velocity>, or make it continuous",
            ));
        }
        None => {}
    }
    // In many files zero means that the value is not known.
    let some = |value: f64| if value > 0.0 { value } else { f64::INFINITY };
    Ok(Axis {
        name: joint.name.to_owned(),
        place,
        direction,
        link: Body::none(),
        lower,
        upper,
        speed: some(speed),
        torque: some(torque),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::newton_euler::holding_loads;

    const TWO: &str = r#"<robot name="two">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.4 0 0"/><mass value="12"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.9" iyz="0" izz="0.9"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0.3 0 0" rpy="0 0 1.5707963267948966"/><mass value="5"/><inertia ixx="0.4" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.4"/></inertial></link>
  <link name="flange"/>
  <link name="weight"><inertial><mass value="2"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 -1 0"/><limit lower="-2" upper="2" effort="500" velocity="3"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/><origin xyz="0.8 0 0"/><axis xyz="0 -1 0"/></joint>
  <joint name="end" type="fixed"><parent link="lower"/><child link="flange"/><origin xyz="0.6 0 0"/></joint>
  <joint name="hung" type="fixed"><parent link="lower"/><child link="weight"/><origin xyz="0.5 0 0"/></joint>
</robot>"#;

    const G: [f64; 3] = [0.0, 0.0, -10.0];

    /// Fixed links are combined with their parents, and the holding torques agree with a computation by hand.
    #[test]
    fn a_tree_with_fixed_links_is_an_arm() {
        let arm = read(TWO, "", "flange", G).unwrap();
        assert_eq!(arm.axes.iter().map(|axis| &axis.name[..]).collect::<Vec<_>>(), ["shoulder", "elbow"]);
        assert_eq!((arm.axes[0].upper, arm.axes[0].torque, arm.axes[1].speed), (2.0, 500.0, f64::INFINITY));
        assert!((arm.posture(&[0.0, 0.0]).tool.position - Vector3::new(1.4, 0.0, 0.0)).norm() < 1e-12);
        let loads = holding_loads(&arm, &[0.0, 0.0]);
        let elbow = 10.0 * (5.0 * 0.3 + 2.0 * 0.5);
        assert!((loads[1].torque - elbow).abs() < 1e-9);
        assert!((loads[0].torque - elbow - 10.0 * (12.0 * 0.4 + 7.0 * 0.8)).abs() < 1e-9);
    }

    #[test]
    fn faults_are_reported_with_line_and_remedy() {
        let error = |text: &str, tip: &str| read(text, "", tip, G).unwrap_err();
        let branched = error(TWO, "");
        assert!(branched.message.contains("branches behind \"lower\""), "{branched:?}");
        assert_eq!(branched.line, 10);
        assert!(branched.remedy.contains("tip"));
        let replaced = |from: &str, to: &str| TWO.replacen(from, to, 1);
        for (text, line, message) in [
            (replaced("<mass value=\"12\"/>", ""), 3, "no <mass>"),
            (replaced("value=\"12\"", "value=\"${m}\""), 3, "is not a number"),
            (replaced("type=\"continuous\"", "type=\"prismatic\""), 8, "only revolute joints"),
            (replaced("<child link=\"flange\"/>", "<child link=\"upper\"/>"), 9, "is the child of two joints"),
            (replaced("<parent link=\"base\"/>", "<parent link=\"bass\"/>"), 7, "is not there"),
            (replaced("<parent link=\"base\"/>", "<parent link=\"lower\"/>"), 7, "elbow, shoulder form a loop"),
            (replaced("<parent link=\"base\"/>", "<parent link=\"upper\"/>"), 7, "joints shoulder form a loop"),
            ("<robot/>".to_owned(), 1, "has no links"),
            (replaced("<limit lower=\"-2\" upper=\"2\" effort=\"500\" velocity=\"3\"/>", ""), 7, "has no <limit>"),
            (replaced("xyz=\"0 -1 0\"/><limit", "xyz=\"0 0 0\"/><limit"), 7, "no direction"),
            (TWO.replacen("<inertial><origin xyz=\"0.4 0 0\"/><mass value=\"12\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.9\" iyz=\"0\" izz=\"0.9\"/></inertial>", "", 1), 3, "has no <inertial>"),
            ("<robot>".to_owned(), 1, "no XML"),
            ("<sdf/>".to_owned(), 1, "is not a robot"),
        ] {
            let found = error(&text, "flange");
            assert!(found.message.contains(message) && found.line == line, "{message}: {found:?}");
            assert!(!found.remedy.is_empty());
        }
    }
}
