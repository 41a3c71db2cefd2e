//! Drawings of drives with the keys of their designs.

use std::path::Path;

use crate::common::*;

/// The picture in the chapter on single stages is what the command draws; ARCMIN_BOOK=rewrite draws it anew.
#[test]
fn the_picture_of_the_book_is_drawn_by_the_command() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    good(d, &["new", "nema17-19", "d.toml"]);
    let said = good(d, &["check", "--drawing", "d.svg", "d.toml"]);
    assert!(said.contains("drawing in d.svg"), "{said}");
    let drawn = read(d, "d.svg");
    let picture =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src/images/single-stage-drawing.svg");
    if std::env::var("ARCMIN_BOOK").is_ok_and(|word| word == "rewrite") {
        std::fs::write(&picture, &drawn).unwrap();
    }
    assert_eq!(
        std::fs::read_to_string(picture).unwrap(),
        drawn,
        "ARCMIN_BOOK=rewrite draws the picture anew"
    );
    // Every family, RV reducers too; with --json as well.
    for template in ["printed-15", "steel-59", "two-ring-225", "two-stage-500", "rv-40e"] {
        good(d, &["new", template, "o.toml", "--force"]);
        good(d, &["check", "--json", "--drawing", "o.svg", "o.toml"]);
        assert!(read(d, "o.svg").contains("data-key=\"disc.width_mm\""), "{template}");
    }
    assert!(refused(d, &["check", "--drawing", "missing/d.svg", "d.toml"]).contains("missing"));
}
