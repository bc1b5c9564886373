//! The addresses of the server, one file for each group of them. A new one is a function and a line here.

mod calibration;
mod campaign;
mod compare;
mod family;
mod figures;
mod folder;
mod grains;
mod run;
mod study;
mod surrogate;

use std::sync::Arc;

use axum::Router;
use axum::body::Body;
use axum::extract::{RawQuery, Request, State};
use axum::http::{Response, Uri};
use axum::middleware::{self, Next};
use axum::response::Response as AxumResponse;
use axum::routing::{MethodRouter, get};

use crate::answer::{Answer, Answered};
use crate::assets;
use crate::guard::Guard;
use crate::query::Query;
use crate::refused::Refused;
use crate::site::Site;

/// All addresses behind the guard.
pub fn router(guard: Guard, site: Arc<Site>) -> Router {
    Router::new()
        .route("/api/folder", ask(folder::list))
        .route("/api/run", ask(run::run))
        .route("/api/progress", ask(run::progress))
        .route("/api/figures", ask(figures::list))
        .route("/api/figure", ask(figures::figure))
        .route("/api/compare", ask(compare::compare))
        .route("/api/grains", ask(grains::grains))
        .route("/api/campaign", ask(campaign::campaign))
        .route("/api/quantities", ask(campaign::map_quantities))
        .route("/api/map", ask(campaign::map))
        .route("/api/families", ask(family::list))
        .route("/api/family", ask(family::family))
        .route("/api/predict-family", ask(family::predict))
        .route("/api/study", ask(study::study))
        .route("/api/surrogate", ask(surrogate::surrogate))
        .route("/api/predict", ask(surrogate::predict))
        .route("/api/calibration", ask(calibration::calibration))
        .route("/api/calibration-figure", ask(calibration::figure))
        .fallback(asset)
        .with_state(site)
        .layer(middleware::from_fn_with_state(guard, guarded))
}

/// A question that is answered beside the connections, by one of a few threads.
fn ask(answer: fn(&Site, &Query) -> Answered) -> MethodRouter<Arc<Site>> {
    get(move |State(site): State<Arc<Site>>, RawQuery(query): RawQuery| async move {
        let Ok(place) = site.places.clone().acquire_owned().await else { return lost().response() };
        let work = move || {
            let _place = place;
            answer(&site, &Query::new(&query.unwrap_or_default()))
        };
        let answered = tokio::task::spawn_blocking(work).await.unwrap_or_else(|_| Err(lost()));
        answered.map_or_else(Refused::response, Answer::response)
    })
}

/// The answer to a question whose work has ended without an answer.
fn lost() -> Refused {
    Refused::new(
        axum::http::StatusCode::INTERNAL_SERVER_ERROR,
        "the answer was lost; this is a mistake of granum",
    )
}

/// A part of the page.
async fn asset(uri: Uri) -> Response<Body> {
    let found =
        assets::find(uri.path()).ok_or_else(|| Refused::not_found("there is nothing at this address"));
    found.map_or_else(Refused::response, Answer::response)
}

async fn guarded(State(guard): State<Guard>, request: Request, next: Next) -> AxumResponse {
    let (head, body) = request.into_parts();
    match guard.check(&head) {
        Ok(()) => next.run(Request::from_parts(head, body)).await,
        Err(refused) => refused.response(),
    }
}
