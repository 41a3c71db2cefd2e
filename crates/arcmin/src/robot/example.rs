//! The robot that `arcmin robot new` writes.

/// A robot file and the designs that it names.
#[derive(Debug, Clone, Copy)]
pub struct Example {
    /// Robot file, TOML.
    pub text: &'static str,
    /// Names and texts of the designs in the same directory.
    pub designs: [(&'static str, &'static str); 3],
}

/// A six-axis arm for 20 kg.
pub fn example() -> Example {
    let rv_80e = crate::templates::find("rv-80e").map_or("", |template| template.text);
    Example {
        text: include_str!("../../robots/arm-20kg.toml"),
        designs: [
            ("rv-160e.toml", include_str!("../../robots/rv-160e.toml")),
            ("rv-80e.toml", rv_80e),
            ("rv-20e.toml", include_str!("../../robots/rv-20e.toml")),
        ],
    }
}
