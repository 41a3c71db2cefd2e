//! A serial arm from a URDF file (ROS wiki, urdf/XML). Fixed joints are part of the link that they hang on.
//!
//! The XML is read by `roxmltree`, which knows the line of every element; `urdf-rs` fills in missing inertias with
//! zeros and knows no lines.

use nalgebra::{Matrix3, Unit, Vector3};
use roxmltree::{Document, Node};

use super::arm::{Arm, Axis, Body, Pose};

mod visuals;

pub(super) use visuals::visuals;

/// An error of a file with its place (line, counted from 1) and remedy.
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

struct Link<'a, 'i> {
    name: &'a str,
    node: Node<'a, 'i>,
}

struct Joint<'a, 'i> {
    name: &'a str,
    node: Node<'a, 'i>,
    kind: &'a str,
    parent: usize,
    child: usize,
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
        wrong(node, format!("{name}=\"{text}\" is no number"), remedy)
    })
}

fn three(node: Node<'_, '_>, name: &str, default: [f64; 3]) -> Result<[f64; 3]> {
    let Some(text) = node.attribute(name) else { return Ok(default) };
    let numbers: Option<Vec<f64>> =
        text.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect();
    numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| {
        wrong(
            node,
            format!("{name}=\"{text}\" is no list of three numbers"),
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

/// Mass of a link in its own frame; `None` if the file gives none.
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
        let message = "the inertia has a negative principal moment: no body has it";
        return Err(wrong(node, message, "export it anew from the CAD model, about the centre of mass"));
    }
    let own = Body { mass, centre: Vector3::zeros(), inertia };
    Ok(Some(own.seen_from(&origin(inertial)?)))
}

/// Reads the arm from `base` (empty: the root) to `tip` (empty: the only end), gravity in m/s² in the frame of the
/// base. The tool is the tip's frame.
///
/// # Errors
/// The first thing that is wrong, with its line.
pub fn read(text: &str, base: &str, tip: &str, gravity: [f64; 3]) -> Result<Arm> {
    let document = parse(text)?;
    let tree = Tree::of(&document, base, tip)?;
    arm(&tree.links, &tree.joints, &tree.chain, gravity)
}

fn parse(text: &str) -> Result<Document<'_>> {
    Document::parse(text).map_err(|error| UrdfError {
        line: error.pos().row as usize,
        message: format!("no XML: {error}"),
        remedy: "write a URDF file; xacro files are expanded first".to_owned(),
    })
}

/// Links and joints of a file, and the numbers of the joints from base to tip.
struct Tree<'a, 'i> {
    links: Vec<Link<'a, 'i>>,
    joints: Vec<Joint<'a, 'i>>,
    chain: Vec<usize>,
}

impl<'a, 'i> Tree<'a, 'i> {
    fn of(document: &'a Document<'i>, base: &str, tip: &str) -> Result<Tree<'a, 'i>> {
        let robot = document.root_element();
        if !robot.has_tag_name("robot") {
            let message = format!("<{}> is no robot", robot.tag_name().name());
            return Err(wrong(robot, message, "a URDF file holds <robot>; SDF and MJCF are not read"));
        }
        let mut links = Vec::new();
        for node in robot.children().filter(|node| node.has_tag_name("link")) {
            let name = attribute(node, "name")?;
            if links.iter().any(|link: &Link| link.name == name) {
                return Err(wrong(node, format!("two links are called \"{name}\""), "rename one of them"));
            }
            links.push(Link { name, node });
        }
        let joints = joints(robot, &links)?;
        no_loop(&links, &joints)?;
        let chain = chain(robot, &links, &joints, base, tip)?;
        Ok(Tree { links, joints, chain })
    }
}

fn joints<'a, 'i>(robot: Node<'a, 'i>, links: &[Link<'a, 'i>]) -> Result<Vec<Joint<'a, 'i>>> {
    let mut joints: Vec<Joint> = Vec::new();
    for node in robot.children().filter(|node| node.has_tag_name("joint")) {
        let name = attribute(node, "name")?;
        let end = |tag: &str| -> Result<usize> {
            let inner = child(node, tag).ok_or_else(|| {
                wrong(node, format!("joint \"{name}\" has no <{tag}>"), format!("add <{tag} link=\"…\"/>"))
            })?;
            let link = attribute(inner, "link")?;
            links.iter().position(|known| known.name == link).ok_or_else(|| {
                let known: Vec<&str> = links.iter().map(|link| link.name).collect();
                let message = format!("joint \"{name}\" names the link \"{link}\", which is not there");
                wrong(inner, message, format!("links are {}", known.join(", ")))
            })
        };
        let joint = Joint {
            name,
            node,
            kind: attribute(node, "type")?,
            parent: end("parent")?,
            child: end("child")?,
        };
        if let Some(other) = joints.iter().find(|other| other.child == joint.child) {
            let message = format!(
                "the link \"{}\" hangs on two joints, \"{}\" and \"{name}\": the tree has a loop or a double parent",
                links[joint.child].name, other.name
            );
            return Err(wrong(node, message, "closed chains are not modelled: take one of the joints out"));
        }
        joints.push(joint);
    }
    Ok(joints)
}

/// Every link hangs on one joint at most, so that a way upwards that does not end goes round a loop.
fn no_loop(links: &[Link<'_, '_>], joints: &[Joint<'_, '_>]) -> Result<()> {
    let above = |link: usize| joints.iter().find(|joint| joint.child == link);
    for joint in joints {
        let mut names = vec![joint.name];
        let mut at = joint.parent;
        while at != joint.child && names.len() <= joints.len() {
            let Some(next) = above(at) else { break };
            names.push(next.name);
            at = next.parent;
        }
        if at == joint.child {
            names.reverse();
            let message = format!(
                "the joints {} form a loop: no base carries the link \"{}\"",
                names.join(", "),
                links[joint.child].name
            );
            let remedy =
                "closed chains are not modelled: hang one of the links on the base, or take a joint out";
            return Err(wrong(joint.node, message, remedy));
        }
    }
    Ok(())
}

/// Numbers of the joints from base to tip.
fn chain(
    robot: Node<'_, '_>,
    links: &[Link<'_, '_>],
    joints: &[Joint<'_, '_>],
    base: &str,
    tip: &str,
) -> Result<Vec<usize>> {
    let parent = |link: usize| joints.iter().position(|joint| joint.child == link);
    let named = |word: &str, what: &str| {
        links.iter().position(|link| link.name == word).ok_or_else(|| {
            let known: Vec<&str> = links.iter().map(|link| link.name).collect();
            let message = format!("no link is called \"{word}\" ({what} of the robot file)");
            wrong(robot, message, format!("links are {}", known.join(", ")))
        })
    };
    let roots: Vec<usize> = (0..links.len()).filter(|link| parent(*link).is_none()).collect();
    let base = match (base, &roots[..]) {
        ("", [root]) => *root,
        // Without loops one link at least hangs on nothing, unless there is none.
        ("", []) => {
            let message = "the robot has no links";
            return Err(wrong(robot, message, "a URDF file holds <link> and <joint>"));
        }
        ("", many) => {
            let names: Vec<&str> = many.iter().map(|link| links[*link].name).collect();
            let message = format!("several links hang on nothing: {}", names.join(", "));
            return Err(wrong(
                links[many[1]].node,
                message,
                "join them, or name the base: [urdf] base = \"…\"",
            ));
        }
        (word, _) => named(word, "base")?,
    };
    let moves = |joint: &Joint| joint.kind != "fixed";
    let tip = match tip {
        "" => {
            // Behind the last joint that moves there may be any number of fixed links; then the deepest of a
            // single line, else the user says which.
            let mut at = base;
            loop {
                let next: Vec<&Joint> = joints.iter().filter(|joint| joint.parent == at).collect();
                match &next[..] {
                    [] => break at,
                    [one] => at = one.child,
                    many => {
                        let turning: Vec<&&Joint> = many
                            .iter()
                            .filter(|joint| reaches(joints, joint.child, &moves) || moves(joint))
                            .collect();
                        if let [one] = &turning[..] {
                            at = one.child;
                            continue;
                        }
                        let names: Vec<&str> = many.iter().map(|joint| links[joint.child].name).collect();
                        let message = format!(
                            "the tree branches behind \"{}\" into {}",
                            links[at].name,
                            names.join(" and ")
                        );
                        let remedy = "name the link that carries the tool: [urdf] tip = \"…\"";
                        return Err(wrong(many[1].node, message, remedy));
                    }
                }
            }
        }
        word => named(word, "tip")?,
    };
    let mut way = Vec::new();
    let mut at = tip;
    while at != base {
        let Some(joint) = parent(at).filter(|_| way.len() <= joints.len()) else {
            let message =
                format!("no chain of joints leads from \"{}\" to \"{}\"", links[base].name, links[tip].name);
            return Err(wrong(links[tip].node, message, "name base and tip of one chain under [urdf]"));
        };
        way.push(joint);
        at = joints[joint].parent;
    }
    way.reverse();
    Ok(way)
}

/// Whether a joint that moves hangs on a link.
fn reaches(joints: &[Joint<'_, '_>], link: usize, moves: &dyn Fn(&Joint<'_, '_>) -> bool) -> bool {
    // Every link hangs on one joint, so that a walk longer than that goes round a loop.
    let (mut open, mut steps) = (vec![link], 0);
    while let Some(at) = open.pop().filter(|_| steps <= joints.len()) {
        steps += 1;
        for joint in joints.iter().filter(|joint| joint.parent == at) {
            if moves(joint) {
                return true;
            }
            open.push(joint.child);
        }
    }
    false
}

fn arm(links: &[Link<'_, '_>], joints: &[Joint<'_, '_>], chain: &[usize], gravity: [f64; 3]) -> Result<Arm> {
    let mut axes: Vec<Axis> = Vec::new();
    // From the frame of the last axis to the link at hand.
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
                    format!("joint \"{}\" is {kind}: only turning joints have a reducer", joint.name);
                let remedy = "make it fixed, or name a base and tip between which all joints turn";
                return Err(wrong(joint.node, message, remedy));
            }
        }
        let Some(last) = axes.last_mut() else { continue };
        let link = joint.child;
        let mut mass = body(links[link].node)?;
        // A branch beside the chain must be fixed: it is part of the link.
        let next = chain.get(order + 1).copied();
        for (side, pose) in beside(links, joints, link, next)? {
            if let Some(other) = body(links[side].node)? {
                let other = other.seen_from(&pose);
                mass = Some(mass.map_or(other, |mass| mass.with(&other)));
            }
        }
        if mass.is_none() && joint.kind != "fixed" && next.is_some_and(|next| joints[next].kind != "fixed") {
            let message = format!("the link \"{}\" moves but has no <inertial>", links[link].name);
            let remedy =
                "add <inertial> with <mass> and <inertia>: without them its weight would be left out";
            return Err(wrong(links[link].node, message, remedy));
        }
        if let Some(mass) = mass {
            last.link = last.link.with(&mass.seen_from(&place));
        }
    }
    if let Some((massless, joint)) = axes
        .iter()
        .zip(chain.iter().map(|index| &joints[*index]).filter(|joint| joint.kind != "fixed"))
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
            message: "no joint of the chain turns".to_owned(),
            remedy: "name base and tip under [urdf]".to_owned(),
        });
    }
    Ok(Arm { axes, tool: place, gravity: Vector3::from(gravity) })
}

/// Links that hang on one beside the chain, with their poses in its frame.
fn beside(
    links: &[Link<'_, '_>],
    joints: &[Joint<'_, '_>],
    link: usize,
    next: Option<usize>,
) -> Result<Vec<(usize, Pose)>> {
    let mut found: Vec<(usize, Pose)> = Vec::new();
    let mut open = vec![(link, Pose::identity())];
    while let Some((at, pose)) = open.pop() {
        for (index, joint) in joints.iter().enumerate().filter(|(_, joint)| joint.parent == at) {
            if Some(index) == next || found.len() > links.len() {
                continue;
            }
            if joint.kind != "fixed" {
                let message = format!(
                    "joint \"{}\" moves beside the chain, on the link \"{}\"",
                    joint.name, links[link].name
                );
                let remedy =
                    "make it fixed in the posture that it has (a gripper, say), so that its mass counts";
                return Err(wrong(joint.node, message, remedy));
            }
            let inner = pose.then(&origin(joint.node)?);
            found.push((joint.child, inner));
            open.push((joint.child, inner));
        }
    }
    Ok(found)
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
                    let message = format!("joint \"{}\" may turn from {lower} to {upper} rad", joint.name);
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
    // Zero stands for "not known" in many files.
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

    /// Fixed links belong to what they hang on, and the weights hold each other as by hand.
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
    fn what_is_wrong_is_said_with_line_and_remedy() {
        let error = |text: &str, tip: &str| read(text, "", tip, G).unwrap_err();
        let branched = error(TWO, "");
        assert!(branched.message.contains("branches behind \"lower\""), "{branched:?}");
        assert_eq!(branched.line, 10);
        assert!(branched.remedy.contains("tip"));
        let replaced = |from: &str, to: &str| TWO.replacen(from, to, 1);
        for (text, line, message) in [
            (replaced("<mass value=\"12\"/>", ""), 3, "no <mass>"),
            (replaced("value=\"12\"", "value=\"${m}\""), 3, "is no number"),
            (replaced("type=\"continuous\"", "type=\"prismatic\""), 8, "only turning joints"),
            (replaced("<child link=\"flange\"/>", "<child link=\"upper\"/>"), 9, "hangs on two joints"),
            (replaced("<parent link=\"base\"/>", "<parent link=\"bass\"/>"), 7, "is not there"),
            (replaced("<parent link=\"base\"/>", "<parent link=\"lower\"/>"), 7, "elbow, shoulder form a loop"),
            (replaced("<parent link=\"base\"/>", "<parent link=\"upper\"/>"), 7, "joints shoulder form a loop"),
            ("<robot/>".to_owned(), 1, "has no links"),
            (replaced("<limit lower=\"-2\" upper=\"2\" effort=\"500\" velocity=\"3\"/>", ""), 7, "has no <limit>"),
            (replaced("xyz=\"0 -1 0\"/><limit", "xyz=\"0 0 0\"/><limit"), 7, "no direction"),
            (TWO.replacen("<inertial><origin xyz=\"0.4 0 0\"/><mass value=\"12\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.9\" iyz=\"0\" izz=\"0.9\"/></inertial>", "", 1), 3, "has no <inertial>"),
            ("<robot>".to_owned(), 1, "no XML"),
            ("<sdf/>".to_owned(), 1, "is no robot"),
        ] {
            let found = error(&text, "flange");
            assert!(found.message.contains(message) && found.line == line, "{message}: {found:?}");
            assert!(!found.remedy.is_empty());
        }
    }
}
