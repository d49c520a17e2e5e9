//! `thurible devices`: the graphics cards on which a search can go.

use crate::console::print;
use crate::devices;
use crate::exit::{DONE, Failure};
use crate::progress::{Display, Mode};
use clap::Args;
use serde_json::json;

/// Arguments of `devices`.
#[derive(Args, Debug)]
pub struct DevicesArguments {
    /// Print a JSON line for each.
    #[arg(long)]
    pub json: bool,
}

/// Lists them; the answer is the exit code.
pub fn run(arguments: &DevicesArguments) -> Result<u8, Failure> {
    let all = devices::list()?;
    for listed in &all {
        if arguments.json {
            let fields = json!({ "name": listed.name, "software": listed.is_software });
            Display::new(Mode::Json, 0).event("device", fields);
        } else if listed.is_software {
            print(&format!(
                "{} (a program on the processors that plays a card: right, and slow)",
                listed.name
            ));
        } else {
            print(&listed.name);
        }
    }
    if all.is_empty() && !arguments.json {
        print("no device with Vulkan was found; searches go on the processors");
    }
    Ok(DONE)
}
