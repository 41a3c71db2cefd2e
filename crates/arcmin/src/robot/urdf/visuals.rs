//! The simple shapes in a URDF file: boxes, cylinders and spheres of its links. Meshes, which are in other
//! files, are ignored.

use nalgebra::Vector3;
use roxmltree::Node;

use super::{Joint, Result, Tree, attribute, child, number, origin, parse, three, wrong};
use crate::robot::arm::Pose;
use crate::scene::{Frame, Solid};
use crate::units::MM;

/// Shapes of the base, then of the link behind every axis with all links fixed to it, in its frame.
///
/// # Errors
/// The first fault, with its line.
pub fn visuals(text: &str, base: &str, tip: &str) -> Result<Vec<Vec<Solid>>> {
    let document = parse(text)?;
    let tree = Tree::of(&document, base, tip)?;
    let mut found = vec![Vec::new()];
    let mut place = Pose::identity();
    let first = match tree.chain.first() {
        Some(joint) => tree.joints[*joint].parent,
        None => return Ok(found),
    };
    let ways = std::iter::once((first, tree.chain.first())).chain(
        tree.chain
            .iter()
            .enumerate()
            .map(|(order, joint)| (tree.joints[*joint].child, tree.chain.get(order + 1))),
    );
    let mut to_here: Option<&Joint> = None;
    for (link, next) in ways {
        if let Some(joint) = to_here {
            place = place.then(&origin(joint.node)?);
            if joint.moves() {
                place = Pose::identity();
                found.push(Vec::new());
            }
        }
        to_here = next.map(|joint| &tree.joints[*joint]);
        let Some(solids) = found.last_mut() else { continue };
        let fixed = tree.fixed_to(link, next.copied(), |_| Ok(()))?;
        for (fixed, pose) in [(link, Pose::identity())].into_iter().chain(fixed) {
            for node in tree.links[fixed].node.children().filter(|node| node.has_tag_name("visual")) {
                solids.extend(solid(node, &place.then(&pose))?);
            }
        }
    }
    Ok(found)
}

/// A `<visual>` in a frame relative to which its link has a pose; `None` for a mesh.
fn solid(visual: Node<'_, '_>, link: &Pose) -> Result<Option<Solid>> {
    let pose = link.then(&origin(visual)?);
    let Some(geometry) = child(visual, "geometry") else { return Ok(None) };
    let size = |node: Node<'_, '_>, name: &str| -> Result<f64> {
        let size = number(node, name)?;
        match size > 0.0 {
            true => Ok(size / MM),
            false => Err(wrong(
                node,
                format!("{name}=\"{size}\" is not a valid size"),
                "write a length in m that is not 0",
            )),
        }
    };
    let at = |point: Vector3<f64>| <[f64; 3]>::from(pose.at(&point) / MM);
    if let Some(node) = child(geometry, "cylinder") {
        let (radius_mm, length) = (size(node, "radius")?, size(node, "length")? * MM);
        let end = |side: f64| at(Vector3::new(0.0, 0.0, 0.5 * side * length));
        return Ok(Some(Solid::Cylinder { from_mm: end(-1.0), to_mm: end(1.0), radius_mm }));
    }
    if let Some(node) = child(geometry, "sphere") {
        return Ok(Some(Solid::Ball { at_mm: at(Vector3::zeros()), radius_mm: size(node, "radius")? }));
    }
    let Some(node) = child(geometry, "box") else { return Ok(None) };
    let text = attribute(node, "size")?;
    let size_mm = three(node, "size", [0.0; 3])?.map(|size| size / MM);
    if size_mm.iter().any(|size| *size <= 0.0) {
        return Err(wrong(
            node,
            format!("size=\"{text}\" is not a valid box"),
            "write three lengths in m that are not 0",
        ));
    }
    Ok(Some(Solid::Block { frame: Frame::from(&pose), size_mm }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARM: &str = r#"<robot name="one">
  <link name="world"/>
  <link name="foot"><visual><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.05" length="0.2"/></geometry></visual></link>
  <link name="upper"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><origin xyz="0.3 0 0" rpy="0 1.5707963267948966 0"/><geometry><cylinder radius="0.04" length="0.6"/></geometry></visual>
    <visual><geometry><mesh filename="upper.stl"/></geometry></visual></link>
  <link name="hand"><visual><origin xyz="0 0 0.01" rpy="0 0 1.5707963267948966"/><geometry><box size="0.1 0.2 0.3"/></geometry></visual></link>
  <link name="lamp"><visual><geometry><sphere radius="0.02"/></geometry></visual></link>
  <joint name="stand" type="fixed"><parent link="world"/><child link="foot"/><origin xyz="1 0 0"/></joint>
  <joint name="turn" type="continuous"><parent link="foot"/><child link="upper"/><origin xyz="0 0 0.2"/><axis xyz="0 0 1"/></joint>
  <joint name="hold" type="fixed"><parent link="upper"/><child link="hand"/><origin xyz="0.6 0 0"/></joint>
  <joint name="shine" type="fixed"><parent link="upper"/><child link="lamp"/><origin xyz="0.5 0 0.1" rpy="0 0 1.5707963267948966"/></joint>
</robot>"#;

    fn near(a: [f64; 3], b: [f64; 3]) {
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} {b:?}");
    }

    /// Shapes are at the positions of their links' frames, and meshes are ignored.
    #[test]
    fn simple_shapes_come_with_their_links() {
        let found = visuals(ARM, "", "hand").unwrap();
        assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), [1, 3]);
        let Solid::Cylinder { from_mm, to_mm, radius_mm } = found[0][0] else { panic!("{found:?}") };
        near(from_mm, [1000.0, 0.0, 0.0]);
        near(to_mm, [1000.0, 0.0, 200.0]);
        assert!((radius_mm - 50.0).abs() < 1e-9);
        let Solid::Cylinder { from_mm, to_mm, .. } = found[1][0] else { panic!("{found:?}") };
        near(from_mm, [0.0; 3]);
        near(to_mm, [600.0, 0.0, 0.0]);
        let Solid::Ball { at_mm, .. } = found[1][1] else { panic!("{found:?}") };
        near(at_mm, [500.0, 0.0, 100.0]);
        let Solid::Block { frame, size_mm } = found[1][2] else { panic!("{found:?}") };
        near(frame.position_mm, [600.0, 0.0, 10.0]);
        near(size_mm, [100.0, 200.0, 300.0]);
        near([frame.rotation[0], frame.rotation[3], frame.rotation[6]], [0.0, 1.0, 0.0]);
    }

    #[test]
    fn shapes_without_a_size_are_refused() {
        for (from, to, line, message) in [
            ("radius=\"0.02\"", "radius=\"0\"", 8, "is not a valid size"),
            ("radius=\"0.02\"", "radius=\"wide\"", 8, "is not a number"),
            ("size=\"0.1 0.2 0.3\"", "size=\"0.1 -0.2 0.3\"", 7, "is not a valid box"),
            ("size=\"0.1 0.2 0.3\"", "", 7, "has no size"),
            (" length=\"0.2\"", "", 3, "has no length"),
        ] {
            let error = visuals(&ARM.replacen(from, to, 1), "", "hand").unwrap_err();
            assert!(error.message.contains(message) && error.line == line, "{error:?}");
        }
    }
}
