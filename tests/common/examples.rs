//! The examples on the pages of `treegen explain`.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use treegen_compiler::Page;

/// One example: its files and the command line that shows what it shows.
pub(crate) struct Example {
    pub(crate) files: Vec<(String, String)>,
    pub(crate) arguments: Vec<String>,
}

/// The examples of a page: what is indented, in order.
pub(crate) fn examples(page: &Page) -> Vec<Example> {
    let mut blocks: Vec<Vec<&str>> = Vec::new();
    let mut is_inside = false;
    for line in page.text.lines() {
        match (line.strip_prefix("    "), line.is_empty()) {
            (Some(code), _) if is_inside => blocks.last_mut().unwrap().push(code),
            (Some(code), _) => blocks.push(vec![code]),
            (None, true) if is_inside => blocks.last_mut().unwrap().push(""),
            (None, _) => {}
        }
        is_inside = line.starts_with("    ") || is_inside && line.is_empty();
    }
    blocks.iter().map(|it| example(it)).collect()
}

fn example(lines: &[&str]) -> Example {
    let mut arguments: Vec<String> = ["check", "main.tg"].map(str::to_owned).to_vec();
    let mut files = vec![("main.tg".to_owned(), String::new())];
    for line in lines {
        let file = line.strip_prefix("// ").filter(|it| !it.contains(' '));
        let file = file.filter(|it| it.ends_with(".tg") || it.ends_with(".obj"));
        if let Some(command) = line.strip_prefix("$ treegen ") {
            arguments = command.split(' ').map(str::to_owned).collect();
        } else if let Some(file) = file {
            files.push((file.to_owned(), String::new()));
        } else {
            let text = &mut files.last_mut().unwrap().1;
            text.push_str(line);
            text.push('\n');
        }
    }
    Example { files: files.into_iter().filter(|it| !it.1.trim().is_empty()).collect(), arguments }
}
