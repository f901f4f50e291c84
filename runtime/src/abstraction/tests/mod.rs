//! Tests of the analysis: against concrete evaluation, and against points of what is really there.

mod anchored;
mod measures;
mod operations;
mod steps;
