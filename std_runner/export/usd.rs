//! A USD stage beside OpenVDB files: frame rate, range, the axis that is up, and the unit of length.

use super::sink::Manner;

/// The text of a stage that plays `files`, each with its frame, whose grids are `fields`.
pub(super) fn stage(files: Vec<(usize, String)>, fields: &[&str], manner: &Manner) -> String {
    let frames = || files.iter().map(|&(frame, _)| frame);
    let (first, last) = (frames().min().unwrap_or(0), frames().max().unwrap_or(0));
    let mut text = format!(
        "#usda 1.0
(
    defaultPrim = \"smoke\"
    doc = \"Smoke by thurible {version}. Frame k shows step k - {zero}.\"
    endTimeCode = {last}
    framesPerSecond = {fps}
    metersPerUnit = 1
    startTimeCode = {first}
    timeCodesPerSecond = {fps}
    upAxis = \"{up}\"
)

def Volume \"smoke\"
{{
",
        version = env!("CARGO_PKG_VERSION"),
        fps = manner.time.fps,
        zero = manner.first_frame,
        up = manner.up_word().to_uppercase(),
    );
    for field in fields {
        text += &format!("    rel field:{field} = </smoke/{field}>\n");
    }
    for field in fields {
        text += &format!(
            "
    def OpenVDBAsset \"{field}\"
    {{
        token fieldName = \"{field}\"
        asset filePath.timeSamples = {{
"
        );
        for (frame, file) in &files {
            text += &format!("            {frame}: @./{file}@,\n");
        }
        text += "        }\n    }\n";
    }
    text + "}\n"
}
