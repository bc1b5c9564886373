//! What a user may have meant by a name that is not known.

use granum_core::names::nearest;
use granum_dem::loading::preset::Paths;

use super::case_stage::CaseStage;
use super::case_stage::{PREPARATION_STAGE, STAGE};
use super::definition::Case;
use super::field::any_of;
use super::fields::{Fields, SECTIONS};

/// "did you mean X?" or the list of existing names.
pub(super) fn meant<'a>(wrong: &str, names: impl Iterator<Item = &'a str> + Clone) -> String {
    match nearest(wrong, names.clone()) {
        Some(name) => format!("did you mean {name}?"),
        None => format!("known here: {}", names.collect::<Vec<_>>().join(", ")),
    }
}

/// What a user may have meant by a path such as `grains.diametre` in a case file, where each key is below the heading of its section.
pub(super) fn in_file(fields: &Fields, paths: &Paths, path: &str, section: &str) -> String {
    let key = last(path);
    let known_section = fields.iter().any(|field| field.section == section);
    let beside = beside(fields, section, known_section);
    if let Some(places) = exact(fields, key) {
        return format!("did you mean {}?", any_of(&places));
    }
    if let Some(paths) = paths_with(paths, key) {
        return format!("{key} belongs to a [[stage]] with path = {paths}");
    }
    if let Some(name) = nearest(if known_section { key } else { path }, beside.iter().copied()) {
        return format!("did you mean {name}?");
    }
    match nearest(key, fields.iter().map(|field| field.key)).and_then(|key| exact(fields, key)) {
        Some(places) => format!("did you mean {}?", any_of(&places)),
        None => format!("known here: {}", beside.join(", ")),
    }
}

/// What a user may have meant by a key that is set in a case from outside, with its whole path.
pub(super) fn of_set(case: &Case, path: &str) -> String {
    let (fields, paths) = (&case.fields(), case.vocabulary.paths());
    let key = last(path);
    let section = path.rsplit_once('.').map_or("", |(section, _)| section);
    let did_you_mean = |places: &[String]| format!("did you mean {}?", any_of(places));
    let in_stages = stage_keys(case);
    let of_stages = |key: &str| -> Vec<String> {
        in_stages
            .iter()
            .filter(|(_, known)| *known == key)
            .map(|(place, known)| format!("{place}.{known}"))
            .collect()
    };
    let mut places = exact(fields, key).unwrap_or_default();
    places.extend(of_stages(key));
    if !places.is_empty() {
        return did_you_mean(&places);
    }
    if let Some(paths) = paths_with(paths, key) {
        return format!(
            "it is a parameter of the path {paths}, which is not among the stages of this case; with `granum run` it can be given as \
             --path NAME --with {key}=VALUE"
        );
    }
    let known_section = fields.iter().any(|field| field.section == section);
    let near = match known_section {
        true => nearest(key, beside(fields, section, true)).map(|near| vec![format!("{section}.{near}")]),
        false => None,
    };
    let near = near.or_else(|| {
        let keys = fields.iter().map(|field| field.key).chain(in_stages.iter().map(|(_, key)| *key));
        nearest(key, keys).map(|near| [exact(fields, near).unwrap_or_default(), of_stages(near)].concat())
    });
    near.map_or_else(
        || format!("known here: {}", beside(fields, section, known_section).join(", ")),
        |near| did_you_mean(&near),
    )
}

fn last(path: &str) -> &str {
    path.rsplit('.').next().unwrap_or(path)
}

/// The keys of a section, or the sections.
fn beside(fields: &Fields, section: &str, known_section: bool) -> Vec<&'static str> {
    if known_section {
        return fields.iter().filter(|field| field.section == section).map(|field| field.key).collect();
    }
    SECTIONS.iter().map(|[name, _]| *name).chain(["material", "pair", "stage"]).collect()
}

/// The fields of that key with their sections.
fn exact(fields: &Fields, key: &str) -> Option<Vec<String>> {
    let places: Vec<String> =
        fields.iter().filter(|field| field.key == key).map(|field| field.path()).collect();
    (!places.is_empty()).then_some(places)
}

/// The named paths that have a parameter, as "a, b or c".
pub(super) fn paths_with(paths: &Paths, key: &str) -> Option<String> {
    let names = paths.all().iter().filter(|preset| preset.parameter(key).is_some());
    let names: Vec<String> = names.map(|preset| format!("{:?}", preset.name)).collect();
    (!names.is_empty()).then(|| any_of(&names))
}

/// The parameters of the named paths among the stages of a case, with the places of these.
fn stage_keys(case: &Case) -> Vec<(String, &'static str)> {
    let mut keys = Vec::new();
    let preparation = (case.preparation_stages.as_slice(), PREPARATION_STAGE);
    for (stages, heading) in [preparation, (case.test.tables(), STAGE)] {
        add_stage_keys(stages, heading, &mut keys);
    }
    keys
}

fn add_stage_keys(stages: &[CaseStage], place: &str, keys: &mut Vec<(String, &'static str)>) {
    for (k, stage) in stages.iter().enumerate() {
        let place = format!("{place}.{}", k + 1);
        match stage {
            CaseStage::Path { path, .. } => {
                keys.extend(path.parameters().map(|parameter| (place.clone(), parameter.key)));
            }
            CaseStage::Repeat { stages, .. } => add_stage_keys(stages, &place, keys),
            CaseStage::Control(_) => {}
        }
    }
}
