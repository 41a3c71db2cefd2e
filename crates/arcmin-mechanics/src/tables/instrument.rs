//! Names of columns by the conventions of other programs.

use super::column::Name;

/// Meaning of names by the convention of the program that wrote them; `labelled`: the lines of the head begin
/// with a label, as in traces of TwinCAT.
///
/// * `%time` of `rostopic echo -p`, `__time` of PlotJuggler, `X_Value` of LabVIEW, `Name` of TwinCAT are
///   times.
/// * `field.position0`, `/joint_states/joint_3/effort`, `velocity_0` beside `header.…` are those of a
///   `sensor_msgs/JointState` of ROS, which are in rad, rad/s and N·m. Only if the file has one joint;
///   of several joints the user has to choose one.
pub(super) fn meant(names: &[String], labelled: bool) -> Vec<Option<String>> {
    let ros = names.iter().any(|name| name.contains("header.") || name.starts_with("field."));
    let joints: Vec<Option<(&'static str, String)>> =
        names.iter().map(|name| joint_state(name, ros)).collect();
    let mut of_joint = joints.iter().flatten().map(|joint| &joint.1);
    let first = of_joint.next();
    let single = of_joint.all(|joint| Some(joint) == first);
    let meaning = |(index, name): (usize, &String)| match name.as_str() {
        "%time" => Some("time_ns".to_owned()),
        "__time" | "X_Value" => Some("time_s".to_owned()),
        "Name" if labelled && index == 0 => Some("timestamp".to_owned()),
        _ => joints[index].as_ref().filter(|_| single).map(|joint| joint.0.to_owned()),
    };
    names.iter().enumerate().map(meaning).collect()
}

/// Our name of a part of a joint's state, and the joint.
pub(super) fn joint_state(name: &str, ros: bool) -> Option<(&'static str, String)> {
    if !ros && !name.contains('/') {
        return None;
    }
    let (path, part) = name.rsplit_once(['/', '.']).unwrap_or(("", name));
    let word = part.trim_end_matches(|c: char| c.is_ascii_digit() || "[]_".contains(c));
    let ours = match word {
        "position" => "joint_angle_rad",
        "velocity" => "joint_speed_rad_s",
        "effort" => "joint_torque_n_m",
        _ => return None,
    };
    Some((ours, format!("{path}.{}", &part[word.len()..])))
}

/// Whether rows may do without this last column: LabVIEW names it, but fills it only where there is a
/// comment.
pub(super) fn may_lack_last(names: &[String]) -> bool {
    names.last().is_some_and(|name| Name::new(name).is_like(&Name::new("comment")))
}
