//! `treegen limits`.

use treegen_compiler::{Change, limits};

use crate::exit::Failure;
use crate::output::print;

/// Prints a line for each limit: name, default, code, how to change it, what it is.
///
/// # Errors
/// The system's reason for not taking them.
pub fn list() -> Result<(), Failure> {
    let mut lines = vec![["limit", "default", "code", "changed by", "what"].map(str::to_owned)];
    for row in limits() {
        let change = match row.change {
            Change::Fixed => "-".to_owned(),
            Change::Option(option) => option.to_owned(),
            Change::Allow(most) if most <= row.default => format!("--allow {}=N, down", row.name),
            Change::Allow(_) => format!("--allow {}=N", row.name),
        };
        let code = row.code.unwrap_or("-").to_owned();
        lines.push([row.name.to_owned(), row.default.to_string(), code, change, row.what.to_owned()]);
    }
    let width = |column: usize| lines.iter().map(|it| it[column].len()).max().unwrap_or(0);
    let [name, default, code, change] = [0, 1, 2, 3].map(width);
    let text: String = lines
        .iter()
        .map(|[a, b, c, d, e]| format!("{a:name$}  {b:>default$}  {c:code$}  {d:change$}  {e}\n"))
        .collect();
    print(&text)
}
