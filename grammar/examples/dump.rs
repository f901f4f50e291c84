fn main() {
    for path in std::env::args().skip(1) {
        let text = if path == "-" { std::io::read_to_string(std::io::stdin()).unwrap() } else { std::fs::read_to_string(&path).unwrap() };
        let t = std::time::Instant::now();
        let parsed = treegen_grammar::parse(treegen_grammar::FileId::MAIN, &text);
        eprintln!("{path}: {} items, {} errors, {:?}", parsed.file.items.len(), parsed.errors.len(), t.elapsed());
        for e in parsed.errors.iter().take(12) {
            let s = e.span.start as usize;
            let line = text[..s].matches('\n').count() + 1;
            let col = s - text[..s].rfind('\n').map_or(0, |i| i + 1) + 1;
            eprintln!("  {line}:{col} `{}` {:?}", text[s..e.span.end as usize].chars().take(40).collect::<String>(), e.kind);
        }
        if std::env::var("TREE").is_ok() { eprintln!("{:#?}", parsed.file); }
    }
}
