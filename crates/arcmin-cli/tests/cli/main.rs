//! The command line: names, texts, exit status, files.

mod answers;
mod atomic;
mod book;
mod common;
mod drawing;
mod errors;
mod exchange;
mod explore;
mod kills;
mod logs;
mod messages;
mod robot;
mod runs;
mod studies;
mod surface;
mod tables;
mod words;
