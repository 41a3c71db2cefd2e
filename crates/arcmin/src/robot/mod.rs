//! From the joint to the tool: what the tool point of a robot does over the life of its reducers.

mod arm;
mod file;
mod joint;
mod life;
mod loads;
mod memory;
mod motion;
mod newton_euler;
mod read;
mod tool;
mod urdf;
