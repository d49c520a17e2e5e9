//! EXR: its first layer, without depth, as large as the window that is shown.

use std::io::Cursor;

use exr::prelude::*;

use super::pixels::{Pixels, Samples};
use super::planes::Planes;
use super::room::check;
use crate::keyframes::error::Fault;

/// A layer with all of its channels.
type Shown = Image<Layer<AnyChannels<FlatSamples>>>;

/// Decodes an EXR file.
pub(super) fn decoded(bytes: &[u8]) -> core::result::Result<Pixels, Fault> {
    let broken = |error: Error| {
        Fault::content(
            format!("cannot be read as EXR ({error})"),
            "save it as EXR with half or float channels, or as PNG",
        )
    };
    let bytes_of_file = bytes.len();
    let about = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    for header in &about.headers {
        let levels = header.channels.list.iter();
        let pixel: usize = levels.map(|channel| channel.sample_type.bytes_per_sample()).sum();
        // Of what is shown nothing is kept, but all of it is looked at.
        for (size, pixel) in [
            (header.layer_size, pixel),
            (header.shared_attributes.display_window.size, 4),
        ] {
            let bytes = size.width().saturating_mul(size.height()).saturating_mul(pixel);
            check(size.width(), size.height(), bytes, bytes_of_file)?;
        }
    }
    let image: Shown = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(broken)?;
    shown(image)
}

/// The channels that say what is seen, where the window shows them.
fn shown(image: Shown) -> core::result::Result<Pixels, Fault> {
    let layer = image.layer_data;
    let mut channels = layer.channel_data.list;
    let short = |channel: &AnyChannel<FlatSamples>| {
        let name = channel.name.to_string();
        name.rsplit('.').next().unwrap_or_default().to_ascii_uppercase()
    };
    let names: Vec<String> = channels.iter().map(short).collect();
    let named = |wanted: &str| names.iter().position(|name| name == wanted);
    let colours: Vec<usize> = ["R", "G", "B"].into_iter().filter_map(named).collect();
    let mut taken = match (colours.as_slice(), named("Y"), names.len()) {
        ([_, _, _], ..) => colours,
        (_, Some(luminance), _) => vec![luminance],
        (_, None, 1) => vec![0],
        _ => {
            let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
            return Err(Fault::content(
                format!("has the channels {}", names.join(", ")),
                "save it with R, G and B, or with Y",
            ));
        }
    };
    let alpha = named("A").filter(|alpha| !taken.contains(alpha));
    taken.extend(alpha);
    let window = image.attributes.display_window;
    let offset = layer.attributes.layer_position - window.position;
    let mut plane = |channel: usize| {
        let channel = channels.get_mut(channel);
        let nothing = FlatSamples::F32(Vec::new());
        channel.map_or(FlatSamples::F32(Vec::new()), |channel| {
            core::mem::replace(&mut channel.sample_data, nothing)
        })
    };
    let planes = Planes {
        levels: taken.iter().map(|&channel| plane(channel)).collect(),
        has_alpha: alpha.is_some(),
        size: [layer.size.width(), layer.size.height()],
        window: [window.size.width(), window.size.height()],
        offset: [i64::from(offset.x()), i64::from(offset.y())],
    };
    let [width, height] = planes.window;
    Ok(Pixels {
        width,
        height,
        channels: planes.levels.len(),
        samples: Samples::Planes(planes),
        note: None,
    })
}
