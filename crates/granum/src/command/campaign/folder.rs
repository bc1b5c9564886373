//! The folder of a campaign that a command was given.

use std::path::Path;

use granum_campaign::Campaign;
use granum_io::shell::ShowPath;

use crate::context::Context;
use crate::failure::Failure;

/// The campaign in a folder.
pub fn campaign_in(context: &Context, folder: &Path) -> Result<Campaign, Failure> {
    let missing = || Failure::new(format!("{}: there is no campaign in this folder", folder.shown()));
    Campaign::read(folder, context.vocabulary())?.ok_or_else(missing)
}
