//! A written result can be read back to the bit, and its report needs nothing but itself.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::output_support::{MadeUp, Number, OUTPUTS, record};
use crate::support::without_pictures;
use thurible::output::{Frames, OutputError, Samples};
use thurible::report::{Facts, RunRecord, write_numbers, write_pictures};
use thurible_core::Status;
use thurible_core::output::{DENSITY, FORCE, VELOCITY};

fn write<T: Number>(
    folder: &Path,
    frames: &MadeUp<T>,
    record: &RunRecord,
    images: bool,
) -> Result<(), OutputError> {
    write_numbers(folder, folder, &mut frames.clone(), record)?;
    assert!(
        write_pictures(folder, folder, record, images)?,
        "no memory for pictures"
    );
    Ok(())
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("output_{name}"));
    let _ = fs::remove_dir_all(&folder);
    folder
}

/// The header and the data of an array of an archive.
fn array(folder: &Path, name: &str) -> (String, Vec<u8>) {
    let mut archive = zip::ZipArchive::new(File::open(folder.join("result.npz")).unwrap()).unwrap();
    let mut bytes = Vec::new();
    archive
        .by_name(&format!("{name}.npy"))
        .unwrap()
        .read_to_end(&mut bytes)
        .unwrap();
    let length = u16::from_le_bytes([bytes[8], bytes[9]]) as usize;
    assert_eq!((10 + length) % 64, 0);
    (
        String::from_utf8(bytes[10..10 + length].to_vec())
            .unwrap()
            .trim_end()
            .to_owned(),
        bytes[10 + length..].to_vec(),
    )
}

fn bytes(samples: &Samples) -> Vec<u8> {
    match samples {
        Samples::F32(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        Samples::F64(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
    }
}

fn fields(count: usize, field: impl Fn(usize, &mut Samples)) -> Vec<u8> {
    let mut samples = Samples::F32(Vec::new());
    let one = |index| {
        field(index, &mut samples);
        bytes(&samples)
    };
    (0..count).flat_map(one).collect()
}

fn check_archive<T: Number>(name: &str, kind: &str) {
    let folder = folder(name);
    let frames = MadeUp::<T>::new(&[12, 10, 8], &[false, true, false], 3, &[2, 3]);
    write(&folder, &frames, &record(&frames, 2), false).unwrap();
    let head = |shape: &str| format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    assert_eq!(
        array(&folder, "density"),
        (
            head("(4, 8, 10, 12,)"),
            fields(4, |step, out| frames.read(&DENSITY, step, 0, out))
        )
    );
    assert_eq!(
        array(&folder, "velocity_x"),
        (
            head("(3, 8, 10, 13,)"),
            fields(3, |step, out| frames.read(&VELOCITY, step, 0, out))
        )
    );
    assert_eq!(
        array(&folder, "velocity_y"),
        (
            head("(3, 8, 10, 12,)"),
            fields(3, |step, out| frames.read(&VELOCITY, step, 1, out))
        )
    );
    assert_eq!(
        array(&folder, "velocity_z"),
        (
            head("(3, 9, 10, 12,)"),
            fields(3, |step, out| frames.read(&VELOCITY, step, 2, out))
        )
    );
    assert_eq!(
        array(&folder, "force_z"),
        (
            head("(2, 9, 10, 12,)"),
            fields(2, |step, out| frames.read(&FORCE, step, 2, out))
        )
    );
    // An output that no method of today gives.
    assert_eq!(
        array(&folder, "smoke_age"),
        (
            head("(3, 8, 10, 12,)"),
            fields(3, |step, out| frames.read(&OUTPUTS[3], step, 0, out))
        )
    );
    assert_eq!(
        array(&folder, "keyframe_density"),
        (
            head("(2, 8, 10, 12,)"),
            fields(2, |index, out| frames.keyframe(index, out))
        )
    );
    let steps = [2_i64, 3]
        .iter()
        .flat_map(|step| step.to_le_bytes())
        .collect::<Vec<u8>>();
    assert_eq!(
        array(&folder, "keyframe_step"),
        (
            "{'descr': '<i8', 'fortran_order': False, 'shape': (2,), }".into(),
            steps
        )
    );
    assert!(!folder.join("frames").exists() && !folder.join("animation.png").exists());
}

#[test]
fn arrays_come_back_bit_by_bit() {
    check_archive::<f32>("f32", "<f4");
    check_archive::<f64>("f64", "<f8");
}

#[test]
fn the_record_is_json_and_what_is_not_finite_is_null() {
    let folder = folder("json");
    let frames = MadeUp::<f32>::new(&[16, 16], &[false, false], 4, &[4]);
    let mut record = record(&frames, 3);
    record.objective.force = f64::NAN;
    record.history[1].objective.data = f64::INFINITY;
    record.history[2].facts = Facts::default();
    write(&folder, &frames, &record, false).unwrap();
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.join("report.json")).unwrap()).unwrap();
    assert_eq!(
        (
            json["format"].as_u64(),
            json["steps"].as_u64(),
            json["cells"][1].as_u64()
        ),
        (Some(1), Some(4), Some(16))
    );
    assert!(json["objective"]["force"].is_null() && json["objective"]["total"].is_null());
    assert!(json["history"][1]["data"].is_null());
    assert!(json["history"][0]["total"].is_number() && json["history"][0]["nso_residuals"].is_array());
    assert!(json["history"][2].get("kkt").is_none());
    assert_eq!(json["memory"]["ledger"][0]["name"], "whole block");
    assert_eq!(json["keyframes"][0]["step"], 4);
    assert_eq!(json["boundary"][0], "wall");
}

#[test]
fn pictures_are_there_and_left_overs_are_not() {
    let folder = folder("pictures");
    let long = MadeUp::<f32>::new(&[16, 12], &[false, false], 5, &[5]);
    write(&folder, &long, &record(&long, 1), true).unwrap();
    let short = MadeUp::<f32>::new(&[16, 12], &[false, false], 3, &[3]);
    write(&folder, &short, &record(&short, 1), true).unwrap();
    let mut names: Vec<String> = fs::read_dir(folder.join("frames"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(
        names,
        [
            "frame_0000.png",
            "frame_0001.png",
            "frame_0002.png",
            "frame_0003.png"
        ]
    );
    let decoder = png::Decoder::new(std::io::BufReader::new(
        File::open(folder.join("animation.png")).unwrap(),
    ));
    let mut reader = decoder.read_info().unwrap();
    let control = *reader.info().animation_control().unwrap();
    assert_eq!(
        (
            reader.info().width,
            reader.info().height,
            control.num_frames,
            control.num_plays
        ),
        (384, 288, 4, 0)
    );
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    for _ in 0..4 {
        reader.next_frame(&mut pixels).unwrap();
    }
    assert!(
        !fs::read_dir(&folder)
            .unwrap()
            .any(|entry| entry.unwrap().path().extension() == Some("part".as_ref()))
    );
}

#[test]
fn the_page_links_to_nothing_and_escapes_the_scene() {
    let folder = folder("page");
    let frames = MadeUp::<f32>::new(&[16, 16], &[true, false], 4, &[2, 4]);
    write(&folder, &frames, &record(&frames, 30), true).unwrap();
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    let text = without_pictures(&page);
    assert!(!page.contains("No pictures were drawn"));
    for forbidden in [
        "http:", "https:", "<script", "<link", "url(", "src=\"f", "NaN", "inf,",
    ] {
        assert!(!text.contains(forbidden), "{forbidden}");
    }
    assert!(page.contains("&lt;not&gt; a &quot;tag&quot;"));
    assert!(page.matches("data:image/png;base64,").count() >= 1 + 4 + 6);
    assert_eq!(page.matches("<svg").count(), 4);
}

/// What is killed before its pictures are drawn has a page all the same.
#[test]
fn numbers_alone_have_a_page() {
    let folder = folder("numbers");
    let frames = MadeUp::<f32>::new(&[8, 8], &[true, false], 2, &[2]);
    let named = Path::new("somewhere/plume");
    write_numbers(&folder, named, &mut frames.clone(), &record(&frames, 3)).unwrap();
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(page.contains("<title>plume"), "{page}");
    assert!(page.contains("No pictures were drawn. <code>thurible render</code>"));
    assert!(!page.contains("data:image"));
}

#[test]
fn an_empty_history_and_odd_numbers_still_make_a_page() {
    let folder = folder("odd");
    let frames = MadeUp::<f64>::new(&[4, 4, 4], &[false; 3], 2, &[2]);
    let mut odd = record(&frames, 0);
    odd.status = Status::NotFinite;
    odd.keyframes[0].relative_l2 = f64::NAN;
    odd.seconds.total = 0.0;
    odd.memory.planned_bytes = 0;
    write(&folder, &frames, &odd, false).unwrap();
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(page.contains("not finite") && page.contains("nothing to draw yet"));
    let mut constant = record(&frames, 3);
    for (index, entry) in constant.history.iter_mut().enumerate() {
        entry.objective.data = [f64::NAN, 1e-300, 1e300][index];
        entry.objective.force = 0.0;
    }
    write(&folder, &frames, &constant, false).unwrap();
}

#[test]
fn errors_name_the_file() {
    let folder = folder("errors");
    fs::create_dir_all(&folder).unwrap();
    let blocked = folder.join("blocked");
    fs::write(&blocked, "a file, not a folder").unwrap();
    let frames = MadeUp::<f32>::new(&[4, 4], &[false; 2], 2, &[2]);
    let error = write(&blocked, &frames, &record(&frames, 1), false).unwrap_err();
    assert!(
        matches!(&error, OutputError::Write { path, .. } if path == &blocked),
        "{error}"
    );
    let taken = folder.join("taken");
    fs::create_dir_all(taken.join("report.json")).unwrap();
    let error = write(&taken, &frames, &record(&frames, 1), false)
        .unwrap_err()
        .to_string();
    assert!(error.contains("report.json"), "{error}");
}
