//! EXR: its first layer, without depth, as large as the window that is shown.

use std::io::Cursor;

use exr::prelude::*;

use super::pixels::{Pixels, Samples};
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
    let about = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    for header in &about.headers {
        let channels = header.channels.list.len().max(1);
        check(
            header.layer_size.width(),
            header.layer_size.height(),
            4 * channels,
        )?;
        let shown = header.shared_attributes.display_window.size;
        check(shown.width(), shown.height(), 4 * channels)?;
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
    shown(&image)
}

/// The channels that say what is seen, where the window shows them.
fn shown(image: &Shown) -> core::result::Result<Pixels, Fault> {
    let layer = &image.layer_data;
    let named = |wanted: &str| {
        let channels = layer.channel_data.list.iter();
        let short = |name: String| name.rsplit('.').next().unwrap_or_default().to_ascii_uppercase();
        channels
            .into_iter()
            .find(|channel| short(channel.name.to_string()) == wanted)
    };
    let alpha = named("A");
    let colours: Vec<_> = ["R", "G", "B"].into_iter().filter_map(named).collect();
    let mut taken = match (colours.as_slice(), named("Y"), layer.channel_data.list.as_slice()) {
        ([red, green, blue], ..) => vec![*red, *green, *blue],
        (_, Some(luminance), _) => vec![luminance],
        (_, None, [one]) => vec![one],
        _ => {
            let names: Vec<String> = layer
                .channel_data
                .list
                .iter()
                .map(|channel| channel.name.to_string())
                .collect();
            return Err(Fault::content(
                format!("has the channels {}", names.join(", ")),
                "save it with R, G and B, or with Y",
            ));
        }
    };
    let alpha = alpha.filter(|alpha| !taken.iter().any(|channel| core::ptr::eq(*channel, *alpha)));
    taken.extend(alpha);
    let window = image.attributes.display_window;
    let (width, height) = (window.size.width(), window.size.height());
    let offset = layer.attributes.layer_position - window.position;
    let (offset_x, offset_y) = (i64::from(offset.x()), i64::from(offset.y()));
    let inside = |place: i64, count: usize| usize::try_from(place).ok().filter(|&place| place < count);
    let mut samples = Vec::with_capacity(width * height * taken.len());
    for y in 0..height as i64 {
        for x in 0..width as i64 {
            let at = inside(x - offset_x, layer.size.width()).zip(inside(y - offset_y, layer.size.height()));
            let index = at.map(|(x, y)| y * layer.size.width() + x);
            let first = samples.len();
            samples.extend(
                taken
                    .iter()
                    .map(|channel| index.map_or(0.0, |index| level(&channel.sample_data, index))),
            );
            if alpha.is_some() {
                straighten(samples.get_mut(first..).unwrap_or_default());
            }
        }
    }
    Ok(Pixels {
        width,
        height,
        channels: taken.len(),
        samples: Samples::Real(samples),
        note: None,
    })
}

/// Takes the alpha, which is last, out of the colours: EXR keeps them multiplied by it.
fn straighten(pixel: &mut [f32]) {
    if let Some((&mut alpha, colours)) = pixel.split_last_mut()
        && alpha > 0.0
    {
        colours.iter_mut().for_each(|colour| *colour /= alpha);
    }
}

fn level(samples: &FlatSamples, index: usize) -> f32 {
    let level = match samples {
        FlatSamples::F16(all) => all.get(index).map(|level| level.to_f32()),
        FlatSamples::F32(all) => all.get(index).copied(),
        FlatSamples::U32(all) => all.get(index).map(|&level| level as f32),
    };
    level.unwrap_or(0.0)
}
