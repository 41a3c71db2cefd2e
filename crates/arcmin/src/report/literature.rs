//! The literature behind the models.

use super::{Block, Reference, Section};

/// The section of a report with the entries of these keys. Every key that the texts of the report cite must be among them.
pub fn literature(keys: &[&str]) -> Section {
    let cited = all().into_iter().filter(|reference| keys.contains(&reference.key.as_str()));
    Section::new("literature", "Literature", vec![Block::References(cited.collect())])
}

/// Whether a key has an entry.
pub(super) fn has_entry(key: &str) -> bool {
    all().iter().any(|reference| reference.key == key)
}

fn all() -> Vec<Reference> {
    let entry = |key: &str, citation: &str, doi: Option<&str>, used_for: &str| Reference {
        key: key.into(),
        citation: citation.into(),
        doi: doi.map(str::to_owned),
        used_for: used_for.into(),
    };
    vec![
        entry(
            "Tao2024",
            "Tao, Y.; Liu, H.; Wu, M.; Zheng, N.; Pei, J. The Effect of Cycloid Gear Wear on the Transmission Accuracy of the RV Reducer. Machines 2024, 12(8), 511.",
            Some("10.3390/machines12080511"),
            "Closed-form load sharing, wear as a uniform depth, simulated transmission error.",
        ),
        entry(
            "Archard1953",
            "Archard, J. F. Contact and Rubbing of Flat Surfaces. Journal of Applied Physics 1953, 24(8), 981–988.",
            Some("10.1063/1.1721448"),
            "Wear law: depth per pass k·p·s.",
        ),
        entry(
            "Johnson1985",
            "Johnson, K. L. Contact Mechanics. Cambridge University Press, 1985.",
            Some("10.1017/CBO9781139171731"),
            "Line contact: half-width, pressure, approach of two bodies to reference depths.",
        ),
        entry(
            "Harris2006",
            "Harris, T. A.; Kotzalas, M. N. Rolling Bearing Analysis, 5th ed. CRC Press, 2006.",
            None,
            "Roller bearings: load against approach of line contacts, load distribution.",
        ),
        entry(
            "ISO281",
            "ISO 281:2007. Rolling bearings — Dynamic load ratings and rating life.",
            None,
            "Rating life of the bearings.",
        ),
        entry(
            "ISO76",
            "ISO 76:2006. Rolling bearings — Static load ratings.",
            None,
            "Pressure of rollers that leaves a dent of a ten-thousandth of their diameter: 4000 MPa.",
        ),
        entry(
            "Palmgren",
            "Palmgren, A. Grundlagen der Wälzlagertechnik, 3rd ed. Franckh, 1964; factors of Harris2006, table 10.3.",
            None,
            "Drag of the bearings without load, if the design includes it.",
        ),
        entry(
            "Linke",
            "Linke, H. Stirnradverzahnung, 2nd ed. Hanser, 2010; ISO/TR 14179-2:2001. Gears — Thermal capacity.",
            None,
            "Drag of seals over diameter and temperature.",
        ),
        entry(
            "GBT35089",
            "GB/T 35089-2018. Precision gear transmission for robot — Test method (Chinese national standard).",
            None,
            "Transmission error, efficiency, backlash and stiffness on a test bench.",
        ),
        entry(
            "GBT40731",
            "GB/T 40731-2021. Method of test and evaluation for lost motion of precision reducer (Chinese national standard).",
            None,
            "Lost motion from the hysteresis loop.",
        ),
    ]
}
