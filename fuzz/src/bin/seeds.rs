//! Writes the seeds of a target, or of all: `seeds FOLDER [TARGET...]` makes `FOLDER/TARGET/NAME`.

use granum_fuzz::{checks, seeds};

fn main() -> std::io::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let Some(folder) = arguments.next() else {
        eprintln!("usage: seeds FOLDER [TARGET...]");
        std::process::exit(2);
    };
    let wanted: Vec<String> = arguments.collect();
    for (target, _) in checks::ALL {
        if !wanted.is_empty() && !wanted.iter().any(|name| name == target) {
            continue;
        }
        let folder = std::path::Path::new(&folder).join(target);
        std::fs::create_dir_all(&folder)?;
        for (name, bytes) in seeds::for_target(target) {
            std::fs::write(folder.join(name), bytes)?;
        }
    }
    Ok(())
}
