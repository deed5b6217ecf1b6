//! Many runs from one file: [`sweep`] lists them, [`table`] gathers their results, [`engines`] writes a Makefile or a Snakefile.

pub mod engines;
pub mod sweep;
pub mod table;
