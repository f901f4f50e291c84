//! Searches inside searches, however deep.

use std::thread;

use super::ask::Ask;
use super::cell::Cell;
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::Origin;

/// Searches inside one another on one stack.
const ON_ONE_STACK: u32 = 64;
/// Bytes of the stack for that many: far more than they take.
const STACK: usize = 4 << 20;

/// Steps that a cell counts as at least that is made for one ray alone, since there is no room to keep it: far more work than to go through
/// one.
const MADE: u64 = 1 << 10;
/// Bytes of such a cell that count as a step: all that are inside one another are there at a time.
const BYTES: u64 = 16;

/// Does something one search further inside, through a cell that is made for that alone. It counts as many steps.
///
/// # Errors
/// As [`further`].
pub(super) fn deeper<R: Send, E: From<Fault> + Send>(
    ask: &mut Ask,
    cell: &Cell,
    go: impl FnOnce(&mut Ask) -> Result<R, E> + Send,
) -> Result<R, E> {
    ask.steps = ask.steps.saturating_add(MADE.max(cell.bytes() as u64 / BYTES));
    further(ask, go)
}

/// Does something one search further inside. So that no stack overflows, whatever its size, every so often it goes on
/// on another.
///
/// # Errors
/// What `go` gives, or the limit of depth if there can be no other stack.
pub(super) fn further<R: Send, E: From<Fault> + Send>(
    ask: &mut Ask,
    go: impl FnOnce(&mut Ask) -> Result<R, E> + Send,
) -> Result<R, E> {
    ask.nested += 1;
    let result = if ask.nested.is_multiple_of(ON_ONE_STACK) { on_another_stack(ask, go) } else { go(ask) };
    ask.nested -= 1;
    result
}

fn on_another_stack<R: Send, E: From<Fault> + Send>(
    ask: &mut Ask,
    go: impl FnOnce(&mut Ask) -> Result<R, E> + Send,
) -> Result<R, E> {
    let most = u64::from(ask.nested);
    thread::scope(|scope| {
        let thread = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, || go(ask));
        let result = thread.ok().and_then(|it| it.join().ok());
        result.unwrap_or_else(|| Err(Fault::new(FaultKind::Limit { limit: Limit::Depth, most }, Origin::NONE).into()))
    })
}
