//! Types of values of options that design files do not have.

use super::DesignError;
use super::field::{FieldValue, Table};
use super::schema::{Key, Kind};
use super::tree::{Item, Node};

type Result<T> = std::result::Result<T, Box<DesignError>>;

/// Name of a file that an analysis reads through its host.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct InputFile(pub String);

impl FieldValue for InputFile {
    fn kind() -> Kind {
        Kind::File
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<InputFile> {
        match &item.node {
            Node::Text(name) if !name.trim().is_empty() => Ok(InputFile(name.to_string())),
            _ => Err(table.wrong_type(key, "the name of a file", item)),
        }
    }

    fn absent(key: &Key, table: &Table<'_>) -> Result<InputFile> {
        Err(table.missing(key))
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        out.push(format!("{path} = {:?}", self.0));
    }

    fn files(&self, out: &mut Vec<InputFile>) {
        out.push(self.clone());
    }
}

impl FieldValue for Vec<InputFile> {
    fn kind() -> Kind {
        Kind::Files
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<Vec<InputFile>> {
        match &item.node {
            Node::List(names) => names.iter().map(|name| InputFile::read(key, name, table)).collect(),
            _ => InputFile::read(key, item, table).map(|one| vec![one]),
        }
    }

    fn absent(_: &Key, _: &Table<'_>) -> Result<Vec<InputFile>> {
        Ok(Vec::new())
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        let names: Vec<&str> = self.iter().map(|file| file.0.as_str()).collect();
        out.push(format!("{path} = {names:?}"));
    }

    fn files(&self, out: &mut Vec<InputFile>) {
        out.extend_from_slice(self);
    }
}
