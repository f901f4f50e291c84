//! Abstract states: what a graph can come to whatever the draws.
//!
//! A concrete state has all its values and a path; a plant that draws at every branch has a state for each of them. An
//! **abstract state** has ranges where values depend on draws, and no path. Equal ones are one, so of a plant whose apex
//! counts down from 20 there are 21. What holds for an abstract state holds for every concrete one that it stands for.
//!
//! - [`range`], [`value`], [`operation`], [`machine`]: expressions on abstract values.
//! - [`flow`], [`needs`], [`measures`]: which slots matter, and which of them decide what is chosen.
//! - [`walk`], [`sketch`], [`step`]: what an abstract state stands for, up to the next ones; [`drawings`]: what is kept of that.
//! - [`linear`]: corners whose places are data.
//! - [`loose`], [`profile`]: bounds that need only be valid.
//! - [`cycles`], [`circle`], [`run`], [`canon`]: what all states below one amount to.
//! - [`skeleton`]: a graph without all that only moves and shapes things.
//! - [`hyper`]: one box for all states of a module.
//! - [`anchored`], [`translated`]: states that are others moved.
//! - [`planted`]: what states with shapes in them amount to.
//! - [`findings`], [`certain`], [`vain`], [`unseen`], [`trouble`]: what is certain of a program before anything of it is drawn.

mod anchored;
mod canon;
mod certain;
mod circle;
mod cycles;
mod drawings;
mod entries;
mod findings;
mod flow;
mod hyper;
mod linear;
mod loose;
mod machine;
mod measures;
mod needs;
mod operation;
mod planted;
mod profile;
mod range;
mod run;
mod skeleton;
mod sketch;
mod slim;
mod step;
mod survey;
mod translated;
mod trouble;
mod unseen;
mod vain;
mod value;
mod walk;

pub(crate) use entries::Circle;
pub use findings::{Findings, IdleRule};
pub(crate) use hyper::HyperBoxes;
pub(crate) use loose::{Gathered, Loose, box_between, primitive_bounds};
pub(crate) use planted::{Next, Plant, extents as extents_of_plants};
pub(crate) use profile::stretch;
pub(crate) use skeleton::skeleton;
pub(crate) use sketch::{Count, Extent, Part, Sketch, What};
pub(crate) use survey::{Scout, Survey};
pub use vain::Vain;

#[cfg(test)]
mod tests;
