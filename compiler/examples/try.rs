//! Temporary.
#![allow(clippy::all, clippy::print_stdout, clippy::unwrap_used)]
use treegen_compiler::*;
struct Disk;
impl Loader for Disk {
    fn load(&self, importer: &str, path: &str) -> Result<Loaded, LoadError> {
        let p = std::path::Path::new(importer).parent().unwrap().join(path);
        let text = std::fs::read_to_string(&p).map_err(|_| LoadError::NotFound)?;
        Ok(Loaded { name: p.display().to_string(), text })
    }
}
fn main() {
    let mut dump = false;
    let mut options = Options::default();
    for a in std::env::args().skip(1) {
        if a == "--dump" { dump = true; continue; }
        if let Some((n, v)) = a.split_once('=') { options.settings.push(Setting { name: n.into(), value: v.into() }); continue; }
        println!("=== {a}");
        let text = std::fs::read_to_string(&a).unwrap();
        let t = std::time::Instant::now();
        let c = compile(Loaded { name: a.clone(), text }, &Disk, &options);
        print!("{}", show(&c.problems, &c.sources, false));
        println!("scene: {} {:?}", c.scene.is_some(), t.elapsed());
        if dump { if let Some(s) = &c.scene { println!("{s:#?}"); } }
    }
}
