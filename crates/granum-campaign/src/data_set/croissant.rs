//! The description of a data set for programs: Croissant 1.0 (MLCommons), JSON-LD that Hugging Face, Kaggle, OpenML and others read.

use granum_io::ColumnKind;
use serde_json::{Value, json};

use super::layout::{RUN, RUNS_FILE, STATES_FILE};
use super::meaning;
use super::written::Written;

/// Number of digits of the digest in the name of the data set.
const DIGITS: usize = 12;

/// The text of the file.
pub(super) fn text(written: &Written) -> String {
    let digest = &written.digest[..DIGITS.min(written.digest.len())];
    let (runs, version) = (written.contents.taken.len(), written.campaign.version());
    let description = format!(
        "{runs} element tests of granular materials with {} recorded states, simulated with the discrete element method (granum \
         {version}). Compression is positive, units are SI. README.md has the details. SHA-256 over the content: {}",
        written.rows, written.digest
    );
    let file = |name: &str| {
        json!({
            "@type": "cr:FileObject",
            "@id": name,
            "name": name,
            "contentUrl": name,
            "encodingFormat": "application/x-parquet",
            "sha256": written.sums.get(name),
        })
    };
    let run_fields = written.runs.columns().iter().map(|column| {
        let meaning = meaning::of_column(&column.name, written.campaign.base(), written.campaign.sensors());
        field(RUNS_FILE, "runs", &column.name, &column.unit, data_type(column.kind), &meaning)
    });
    let state_fields = written.states.table.columns().iter().map(|column| {
        let meaning = meaning::of_column(&column.name, written.campaign.base(), written.campaign.sensors());
        let mut field =
            field(STATES_FILE, "states", &column.name, &column.unit, data_type(column.kind), &meaning);
        if column.name == RUN {
            field["references"] = json!({ "field": { "@id": format!("runs/{RUN}") } });
        }
        field
    });
    let list_fields = written.states.lists.iter().map(|list| {
        let meaning = meaning::of_list(&list.name);
        let mut field = field(STATES_FILE, "states", &list.name, &list.unit, "sc:Float", &meaning);
        field["repeated"] = json!(true);
        field
    });
    let described = json!({
        "@context": context(),
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": format!("granum-{digest}"),
        "description": description,
        "version": "1.0.0",
        "keywords": ["discrete element method", "granular materials", "element test"],
        "distribution": [file(RUNS_FILE), file(STATES_FILE)],
        "recordSet": [
            {
                "@type": "cr:RecordSet",
                "@id": "runs",
                "name": "runs",
                "description": "A row for each run.",
                "key": { "@id": format!("runs/{RUN}") },
                "field": run_fields.collect::<Vec<_>>(),
            },
            {
                "@type": "cr:RecordSet",
                "@id": "states",
                "name": "states",
                "description": "A row for each recorded state of a run.",
                "field": state_fields.chain(list_fields).collect::<Vec<_>>(),
            },
        ],
    });
    // Texts and names can always be written.
    serde_json::to_string_pretty(&described).unwrap_or_default() + "\n"
}

fn data_type(kind: ColumnKind) -> &'static str {
    match kind {
        ColumnKind::Real => "sc:Float",
        ColumnKind::Integer => "sc:Integer",
        ColumnKind::Boolean => "sc:Boolean",
        ColumnKind::Word => "sc:Text",
    }
}

/// A column as a field of a record set.
fn field(file: &str, set: &str, name: &str, unit: &str, data_type: &str, meaning: &str) -> Value {
    let meaning = if meaning.is_empty() { name.replace(['_', '.'], " ") } else { meaning.to_string() };
    let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
    json!({
        "@type": "cr:Field",
        "@id": format!("{set}/{name}"),
        "name": format!("{set}/{name}"),
        "description": format!("{meaning}{unit}"),
        "dataType": data_type,
        "source": { "fileObject": { "@id": file }, "extract": { "column": name } },
    })
}

/// The context of Croissant 1.0, as its specification gives it.
fn context() -> Value {
    json!({
        "@language": "en",
        "@vocab": "https://schema.org/",
        "citeAs": "cr:citeAs",
        "column": "cr:column",
        "conformsTo": "dct:conformsTo",
        "cr": "http://mlcommons.org/croissant/",
        "rai": "http://mlcommons.org/croissant/RAI/",
        "data": { "@id": "cr:data", "@type": "@json" },
        "dataType": { "@id": "cr:dataType", "@type": "@vocab" },
        "dct": "http://purl.org/dc/terms/",
        "equivalentProperty": "cr:equivalentProperty",
        "examples": { "@id": "cr:examples", "@type": "@json" },
        "extract": "cr:extract",
        "field": "cr:field",
        "fileProperty": "cr:fileProperty",
        "fileObject": "cr:fileObject",
        "fileSet": "cr:fileSet",
        "format": "cr:format",
        "includes": "cr:includes",
        "isLiveDataset": "cr:isLiveDataset",
        "jsonPath": "cr:jsonPath",
        "key": "cr:key",
        "md5": "cr:md5",
        "parentField": "cr:parentField",
        "path": "cr:path",
        "recordSet": "cr:recordSet",
        "references": "cr:references",
        "regex": "cr:regex",
        "repeated": "cr:repeated",
        "replace": "cr:replace",
        "samplingRate": "cr:samplingRate",
        "sc": "https://schema.org/",
        "separator": "cr:separator",
        "source": "cr:source",
        "subField": "cr:subField",
        "transform": "cr:transform",
    })
}
