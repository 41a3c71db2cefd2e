//! The design's name as a name in other languages.

/// Names that cannot be one's own: keywords and built-in names of Modelica (specification 3.6, sections 2.3.3, 3.7
/// and 4.8), of MATLAB (`iskeyword`), Python and C, and what URDF, SDFormat and MuJoCo keep for themselves.
const RESERVED: &[&str] = &[
    // Modelica
    "algorithm", "and", "annotation", "assert", "block", "break", "class", "connect", "connector", "constant",
    "constrainedby", "der", "discrete", "each", "else", "elseif", "elsewhen", "encapsulated", "end",
    "enumeration", "equation", "expandable", "extends", "external", "false", "final", "flow", "for", "function",
    "if", "import", "impure", "in", "initial", "inner", "input", "loop", "model", "not", "operator", "or",
    "outer", "output", "package", "parameter", "partial", "protected", "public", "pure", "record",
    "redeclare", "replaceable", "return", "stream", "then", "true", "type", "when", "while", "within", "abs",
    "acos", "actualstream", "array", "asin", "atan", "atan2", "backsample", "cardinality", "cat", "ceil", "change",
    "cos", "cosh", "cross", "delay", "diagonal", "div", "edge", "exp", "fill", "floor", "getinstancename", "hold",
    "homotopy", "identity", "instream", "integer", "linspace", "log", "log10", "matrix", "max", "min", "mod",
    "modelica", "ndims", "noclock", "noevent", "ones", "outerproduct", "pre", "previous", "product", "promote",
    "reinit", "rem", "rooted", "sample", "scalar", "semilinear", "shiftsample", "sign", "sin", "sinh", "size",
    "skew", "smooth", "spatialdistribution", "sqrt", "string", "subsample", "sum", "supersample", "symmetric",
    "tan", "tanh", "terminal", "terminate", "time", "transpose", "vector", "zeros", "real", "boolean", "clock",
    // MATLAB, Python and C, where they differ from those above
    "case", "catch", "classdef", "continue", "global", "otherwise", "parfor", "persistent", "spmd", "switch",
    "try", "def", "del",
    // models of robots
    "world", "base", "none", "default", "parent",
];

/// A name that every format takes: letters of ASCII, digits and underscores, a letter first, none of the
/// languages' own words. Lower case, because Modelica's own classes begin with capitals.
pub(super) fn identifier(name: &str) -> String {
    let name: String = name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' })
        .collect();
    let own = name.starts_with(|c: char| c.is_ascii_alphabetic()) && !RESERVED.contains(&name.as_str());
    if own { name } else { format!("joint_{name}") }
}

/// `h2000`: an age in hours as part of a name, different for different ages.
pub(super) fn label(hours: f64) -> String {
    format!("h{}", format!("{hours}").replace('.', "_"))
}
