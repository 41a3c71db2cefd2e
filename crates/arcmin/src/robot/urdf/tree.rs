//! Links and joints of a URDF, and the chain of joints from base to tip.

use roxmltree::{Document, Node};

use super::{Result, attribute, child, origin, wrong};
use crate::robot::arm::Pose;

pub struct Link<'a, 'i> {
    pub name: &'a str,
    pub node: Node<'a, 'i>,
}

pub struct Joint<'a, 'i> {
    pub name: &'a str,
    pub node: Node<'a, 'i>,
    pub kind: &'a str,
    pub parent: usize,
    pub child: usize,
}

impl Joint<'_, '_> {
    /// Whether its type is not `fixed`.
    pub fn moves(&self) -> bool {
        self.kind != "fixed"
    }
}

/// Links and joints of a file, and the numbers of the joints from base to tip.
pub struct Tree<'a, 'i> {
    pub links: Vec<Link<'a, 'i>>,
    pub joints: Vec<Joint<'a, 'i>>,
    pub chain: Vec<usize>,
}

impl<'a, 'i> Tree<'a, 'i> {
    /// The tree with its chain from `base` (empty: the root) to `tip` (empty: the only end).
    ///
    /// # Errors
    /// Missing or duplicate elements, loops, and ambiguous chains.
    pub fn of(document: &'a Document<'i>, base: &str, tip: &str) -> Result<Tree<'a, 'i>> {
        let robot = document.root_element();
        if !robot.has_tag_name("robot") {
            let message = format!("<{}> is not a robot", robot.tag_name().name());
            return Err(wrong(
                robot,
                message,
                "the root element of a URDF file is <robot>; SDF and MJCF are not supported",
            ));
        }
        let links = links(robot)?;
        let joints = joints(robot, &links)?;
        let mut tree = Tree { links, joints, chain: Vec::new() };
        tree.no_loop()?;
        let base = tree.base(robot, base)?;
        let tip = tree.tip(robot, base, tip)?;
        tree.chain = tree.between(base, tip)?;
        Ok(tree)
    }

    /// Number of the joint whose child is this link.
    fn above(&self, link: usize) -> Option<usize> {
        self.joints.iter().position(|joint| joint.child == link)
    }

    /// Number of a link by its name; `key` is the key of the robot file with the name.
    fn named(&self, robot: Node<'_, '_>, name: &str, key: &str) -> Result<usize> {
        self.links.iter().position(|link| link.name == name).ok_or_else(|| {
            let message = format!("no link is called \"{name}\" ({key} of the robot file)");
            wrong(robot, message, format!("links are {}", names(&self.links)))
        })
    }

    /// A link is the child of at most one joint, so that the path to its root is endless only in a loop.
    fn no_loop(&self) -> Result<()> {
        for joint in &self.joints {
            let mut names = vec![joint.name];
            let mut at = joint.parent;
            while at != joint.child && names.len() <= self.joints.len() {
                let Some(next) = self.above(at) else { break };
                names.push(self.joints[next].name);
                at = self.joints[next].parent;
            }
            if at == joint.child {
                names.reverse();
                let message = format!(
                    "the joints {} form a loop: the link \"{}\" is not connected to a base",
                    names.join(", "),
                    self.links[joint.child].name
                );
                let remedy =
                    "closed chains are not modelled: connect one of the links to the base, or remove a joint";
                return Err(wrong(joint.node, message, remedy));
            }
        }
        Ok(())
    }

    /// The base by its name; without a name the only link that is not the child of a joint.
    fn base(&self, robot: Node<'_, '_>, name: &str) -> Result<usize> {
        if !name.is_empty() {
            return self.named(robot, name, "base");
        }
        let roots: Vec<usize> = (0..self.links.len()).filter(|link| self.above(*link).is_none()).collect();
        match roots[..] {
            [root] => Ok(root),
            // Without loops at least one link is not the child of a joint, unless there are no links.
            [] => Err(wrong(robot, "the robot has no links", "a URDF file contains <link> and <joint>")),
            [_, second, ..] => {
                let names: Vec<&str> = roots.iter().map(|link| self.links[*link].name).collect();
                let message = format!("several links are not the child of any joint: {}", names.join(", "));
                let remedy = "connect them, or give the base: [urdf] base = \"…\"";
                Err(wrong(self.links[second].node, message, remedy))
            }
        }
    }

    /// The tip by its name; without a name the last link, ignoring branches without movable joints.
    fn tip(&self, robot: Node<'_, '_>, base: usize, name: &str) -> Result<usize> {
        if !name.is_empty() {
            return self.named(robot, name, "tip");
        }
        let mut at = base;
        loop {
            let next: Vec<&Joint> = self.joints.iter().filter(|joint| joint.parent == at).collect();
            at = match &next[..] {
                [] => return Ok(at),
                [one] => one.child,
                many => {
                    let moving: Vec<&&Joint> = many
                        .iter()
                        .filter(|joint| joint.moves() || self.carries_moving(joint.child))
                        .collect();
                    if let [one] = &moving[..] {
                        one.child
                    } else {
                        let names: Vec<&str> =
                            many.iter().map(|joint| self.links[joint.child].name).collect();
                        let message = format!(
                            "the tree branches behind \"{}\" into {}",
                            self.links[at].name,
                            names.join(" and ")
                        );
                        let remedy = "give the link with the tool: [urdf] tip = \"…\"";
                        return Err(wrong(many[1].node, message, remedy));
                    }
                }
            };
        }
    }

    /// Whether there is a movable joint between a link and an end of the tree.
    fn carries_moving(&self, link: usize) -> bool {
        let mut open = vec![link];
        while let Some(at) = open.pop() {
            for joint in self.joints.iter().filter(|joint| joint.parent == at) {
                if joint.moves() {
                    return true;
                }
                open.push(joint.child);
            }
        }
        false
    }

    /// Numbers of the joints from `base` to `tip`.
    fn between(&self, base: usize, tip: usize) -> Result<Vec<usize>> {
        let mut chain = Vec::new();
        let mut at = tip;
        while at != base {
            let Some(joint) = self.above(at) else {
                let message = format!(
                    "no chain of joints leads from \"{}\" to \"{}\"",
                    self.links[base].name, self.links[tip].name
                );
                return Err(wrong(
                    self.links[tip].node,
                    message,
                    "give base and tip of one chain under [urdf]",
                ));
            };
            chain.push(joint);
            at = self.joints[joint].parent;
        }
        chain.reverse();
        Ok(chain)
    }

    /// Links connected to `link` by fixed joints, except for the joint `next` of the chain, and their poses in
    /// its frame. `moving`: whether a movable joint is an error.
    ///
    /// # Errors
    /// Errors of `moving`, and poses that cannot be read.
    pub fn fixed_to(
        &self,
        link: usize,
        next: Option<usize>,
        moving: impl Fn(&Joint<'_, '_>) -> Result<()>,
    ) -> Result<Vec<(usize, Pose)>> {
        let mut found = Vec::new();
        let mut open = vec![(link, Pose::identity())];
        while let Some((at, pose)) = open.pop() {
            for (index, joint) in self.joints.iter().enumerate().filter(|(_, joint)| joint.parent == at) {
                if Some(index) == next {
                    continue;
                }
                if joint.moves() {
                    moving(joint)?;
                    continue;
                }
                let inner = (joint.child, pose.then(&origin(joint.node)?));
                found.push(inner);
                open.push(inner);
            }
        }
        Ok(found)
    }
}

fn names(links: &[Link<'_, '_>]) -> String {
    links.iter().map(|link| link.name).collect::<Vec<_>>().join(", ")
}

fn links<'a, 'i>(robot: Node<'a, 'i>) -> Result<Vec<Link<'a, 'i>>> {
    let mut links: Vec<Link> = Vec::new();
    for node in robot.children().filter(|node| node.has_tag_name("link")) {
        let name = attribute(node, "name")?;
        if links.iter().any(|link| link.name == name) {
            return Err(wrong(node, format!("two links are called \"{name}\""), "rename one of them"));
        }
        links.push(Link { name, node });
    }
    Ok(links)
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
                let message = format!("joint \"{name}\" names the link \"{link}\", which is not there");
                wrong(inner, message, format!("links are {}", names(links)))
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
                "the link \"{}\" is the child of two joints, \"{}\" and \"{name}\": the tree has a loop or a double parent",
                links[joint.child].name, other.name
            );
            return Err(wrong(node, message, "closed chains are not modelled: remove one of the joints"));
        }
        joints.push(joint);
    }
    Ok(joints)
}
