//! Flanks of drives with more than one.

use super::Facts;
use super::drive::EccentricDrive;
use crate::analyses::profile::{self, FlankProfile, Options};
use crate::analyses::{AnalysisError, Host, Outcome, TextBlock};
use crate::report::{Page, Provenance};
use crate::results::{Column, DeclaredTable, Summary, SummaryOf, Table, TableOf};

/// Flanks stage by stage from the input.
#[derive(Debug, Clone)]
pub struct Flanks {
    /// Flank of each stage.
    pub flanks: Vec<FlankProfile>,
    facts: Facts,
    declared: SummaryOf<Flanks>,
}

/// As those of one flank, with the keys of each stage; ratio, wear and points of the table are given once.
fn entries<D: EccentricDrive>() -> Vec<Column<Flanks>> {
    let of_one = (profile::SUMMARY.entries)();
    let count = of_one.len();
    let mut entries: Vec<Column<Flanks>> = Vec::new();
    for (k, stage) in D::STAGES.iter().enumerate() {
        for (number, column) in of_one.iter().enumerate() {
            let own = stage.flank.iter().find(|key| key.ends_with(column.quantity.key));
            let Some(key) = own.or((k == 0).then_some(&column.quantity.key)) else { continue };
            let number = count * k + number;
            entries.push(Column::numbered(column.quantity.named(key), number, |o, number| {
                let of_one = (profile::SUMMARY.entries)();
                of_one[number % of_one.len()].value(&o.flanks[number / of_one.len()])
            }));
        }
    }
    entries
}

pub(crate) fn summary<D: EccentricDrive>() -> SummaryOf<Flanks> {
    SummaryOf { entries: entries::<D> }
}

pub(crate) fn tables<D: EccentricDrive>() -> Vec<DeclaredTable> {
    D::STAGES.iter().map(|stage| TableOf { name: stage.profile, ..profile::PROFILE }.into()).collect()
}

/// Computes the flanks.
///
/// # Errors
/// None today; the type is that of every analysis.
pub fn run<D: EccentricDrive>(design: &D, options: &Options, _: &dyn Host) -> Result<Flanks, AnalysisError> {
    let flank = |(mesh, stage): (crate::machine::RingMesh, &super::StageKeys)| {
        let name = format!("{}, {}", design.name(), stage.name);
        profile::flank(mesh.profile, &mesh.relief, design.ratio(), name, options)
    };
    Ok(Flanks {
        flanks: design.meshes().into_iter().zip(D::STAGES).map(flank).collect(),
        facts: Facts::of(design),
        declared: summary::<D>(),
    })
}

impl Outcome for Flanks {
    fn summary(&self) -> Summary {
        self.declared.fill(self)
    }

    fn tables(&self) -> Vec<Table> {
        let stages = self.facts.stages.iter().zip(&self.flanks);
        stages
            .map(|(stage, flank)| TableOf { name: stage.profile, ..profile::PROFILE }.fill(&flank.points))
            .collect()
    }

    fn text_blocks(&self) -> Vec<TextBlock> {
        let stages = self.facts.stages.iter().zip(&self.flanks);
        stages
            .map(|(stage, flank)| TextBlock::line(format!("{}: {}", stage.name, flank.sentence())))
            .collect()
    }

    /// Those of the single flanks, one after the other, under the verdict on the sharpest.
    fn page(&self) -> Page {
        let mut pages: Vec<Page> = self.flanks.iter().map(Outcome::page).collect();
        let sharpest =
            (0..pages.len()).min_by(|a, b| self.flanks[*a].sharpest().total_cmp(&self.flanks[*b].sharpest()));
        let verdict = pages[sharpest.unwrap_or(0)].verdict.clone();
        let mut sections = Vec::new();
        for (stage, page) in self.facts.stages.iter().zip(&mut pages) {
            for mut section in page.sections.drain(..) {
                section.title = format!("{}: {}", section.title, stage.name);
                section.id = stage.profile.to_owned();
                sections.push(section);
            }
        }
        Page {
            title: self.facts.name.clone(),
            subtitle: "Flanks of the cycloid discs".to_owned(),
            provenance: Provenance::default(),
            verdict,
            sections,
        }
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
