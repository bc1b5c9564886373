//! A study: its surrogates with their scores.

use granum_io::shell::quoted_path;
use granum_learn::study::{self, MemberScores, PartScore};
use serde_json::{Value, json};

use crate::answer::{Answer, Answered};
use crate::commands;
use crate::numbers::number;
use crate::query::Query;
use crate::site::Site;

/// The surrogates of a study with their scores: `path`. A training under way has none yet, and a reproduction has them in a folder of its own.
pub fn study(site: &Site, query: &Query) -> Answered {
    let path = query.needed("path")?;
    let place = site.place(path)?;
    let named = site.folder.as_named(path);
    let next = site.program.next(&place, &named).unwrap_or_default();
    let mut lines = vec![commands::line("How far it is", format!("granum status {}", quoted_path(&named)))];
    commands::add_next(&mut lines, next.command);
    let mut answer = json!({
        "holds": next.name, "next": site.without_root(next.text), "models": [], "scores": [], "commands": lines,
    });
    match study::load(&place, site.program.methods()) {
        Ok(stored) => {
            answer["models"] = stored.study.members().map(|member| json!(member.name)).collect();
            answer["scores"] = stored.scores.fits.iter().flat_map(|fit| &fit.members).map(score).collect();
        }
        Err(error) => answer["note"] = json!(site.without_root(error)),
    }
    Ok(Answer::Json(answer))
}

fn score(member: &MemberScores) -> Value {
    let error = |part: &PartScore| match part.score.states {
        0 => Value::Null,
        _ => number(part.score.relative_rmse),
    };
    json!({
        "name": member.name, "method": member.method, "training": error(&member.training), "held_out": error(&member.held_out),
        "unseen": error(&member.unseen), "coverage": member.unseen.coverage.map(number),
    })
}
