//! The parts of the page as they stand in the repository.

use granum_report::page::COMPONENTS;
use granum_report::viewer::VIEWER;

use crate::answer::Answer;

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const MODULE: &str = "text/javascript; charset=utf-8";

/// Files of the folder `page` under their own names.
macro_rules! files {
    ($($name:literal: $kind:expr),* $(,)?) => {
        [$((concat!("/", $name), $kind, include_str!(concat!("../page/", $name)))),*]
    };
}

/// Address, type and content of every part but those that reports have as well: the viewer of grains, and the style of what results are made of.
const FILES: &[(&str, &str, &str)] = &files![
    "index.html": HTML,
    "style.css": CSS,
    "modules/main.js": MODULE,
    "modules/dom.js": MODULE,
    "modules/router.js": MODULE,
    "modules/server.js": MODULE,
    "modules/figure.js": MODULE,
    "modules/numbers.js": MODULE,
    "modules/parts.js": MODULE,
    "modules/grains.js": MODULE,
    "modules/views/list.js": MODULE,
    "modules/views/run.js": MODULE,
    "modules/views/compare.js": MODULE,
    "modules/views/campaign.js": MODULE,
    "modules/views/families.js": MODULE,
    "modules/views/family.js": MODULE,
    "modules/views/study.js": MODULE,
    "modules/views/surrogate.js": MODULE,
    "modules/views/calibration.js": MODULE,
];

/// The part of an address.
pub fn find(path: &str) -> Option<Answer> {
    let path = if path == "/" { "/index.html" } else { path };
    if path == "/modules/viewer.js" {
        return Some(Answer::Asset(MODULE, VIEWER));
    }
    if path == "/components.css" {
        return Some(Answer::Asset(CSS, COMPONENTS));
    }
    FILES.iter().find(|(name, ..)| *name == path).map(|(_, kind, text)| Answer::Asset(kind, text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// A module that is not listed would be missing in the program alone.
    #[test]
    fn every_module_of_the_folder_is_in_the_program_and_imports_what_is_there() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("page/modules");
        let folders = [folder.clone(), folder.join("views")];
        let entries = folders.iter().flat_map(|folder| std::fs::read_dir(folder).unwrap().flatten());
        for path in
            entries.map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|e| e == "js"))
        {
            let inside = path.strip_prefix(folder.parent().unwrap()).unwrap();
            let address = format!("/{}", inside.to_string_lossy());
            assert!(find(&address).is_some(), "{address}");
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.starts_with("// @ts-check"), "{address}");
            for forbidden in
                ["innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "new Function"]
            {
                assert!(!text.contains(forbidden), "{address}: {forbidden}");
            }
            let is_server = address == "/modules/server.js";
            assert!(is_server || !text.contains("fetch("), "{address} asks the server by itself");
        }
        assert!(find("/modules/viewer.js").is_some() && find("/").is_some() && find("/nothing").is_none());
    }
}
