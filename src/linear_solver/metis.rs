//! Nested dissection by METIS (Karypis & Kumar 1998).
//!
//! METIS draws its random numbers, seeded anew by every call, from one state for the whole process: two
//! calls at a time would disturb each other's order.
//!
//! The safe `metis` crate does not offer METIS_NodeND, so that this one call goes to its `-sys` crate.
#![allow(unsafe_code)]

use crate::assembly::Lists;
use metis_sys::{
    METIS_NOPTIONS, METIS_NodeND, METIS_SetDefaultOptions, idx_t, rstatus_et_METIS_OK,
};
use std::sync::{Mutex, PoisonError};

/// Held by the one call that METIS can serve.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// The order in which to eliminate the nodes of an undirected graph without loops.
///
/// # Errors
/// METIS's status where it has no answer (out of memory, or more entries than its index type holds).
pub fn nested_dissection(graph: &Lists) -> Result<Vec<u32>, i32> {
    let (start, neighbours) = graph.parts();
    if idx_t::try_from(neighbours.len()).is_err() {
        return Err(metis_sys::rstatus_et_METIS_ERROR_INPUT);
    }
    let mut nodes = graph.len() as idx_t;
    let mut xadj: Vec<idx_t> = start.iter().map(|&s| s as idx_t).collect();
    let mut adjncy: Vec<idx_t> = neighbours.iter().map(|&n| n as idx_t).collect();
    let mut order: Vec<idx_t> = vec![0; graph.len()];
    let mut position: Vec<idx_t> = vec![0; graph.len()];
    let mut options = [0; METIS_NOPTIONS as usize];
    // A panic cannot leave METIS halfway: it is C.
    let turn = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    // SAFETY: the arrays have the lengths that METIS_NodeND documents (n + 1, xadj[n], n, n) and
    // outlive the call; METIS keeps no pointer.
    let status = unsafe {
        METIS_SetDefaultOptions(options.as_mut_ptr());
        METIS_NodeND(
            &mut nodes,
            xadj.as_mut_ptr(),
            adjncy.as_mut_ptr(),
            std::ptr::null_mut(),
            options.as_mut_ptr(),
            order.as_mut_ptr(),
            position.as_mut_ptr(),
        )
    };
    drop(turn);
    if status == rstatus_et_METIS_OK {
        Ok(order.into_iter().map(|node| node as u32).collect())
    } else {
        Err(status)
    }
}
