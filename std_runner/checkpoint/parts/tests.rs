//! Parts of a state in files, written by ranks that are threads.

use super::super::PART;
use super::super::sealed::Unsealed;
use super::*;
use thurible_core::checkpoint::Source;

#[path = "../../../tests/numerics/fields/channels.rs"]
#[expect(dead_code, reason = "the numerics' tests take all of it")]
mod channels;

const CUT: [usize; 2] = [3, 1];

/// What rank `rank` has of a state.
fn bytes_of(rank: usize) -> Vec<u8> {
    (0..5000 + 70_000 * rank)
        .map(|byte| (byte * (rank + 3) % 251) as u8)
        .collect()
}

fn fresh(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("thurible-parts-{name}-{}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn place(number: u64) -> Place {
    Place {
        number,
        ..Place::default()
    }
}

/// What all ranks say of parts that each writes, the first one into `folder`.
fn written(folder: &Path, number: u64) -> Vec<(Option<Vec<u64>>, Option<String>)> {
    let ranks = channels::ranks(3).into_iter().map(|ranks| {
        let mut files = match ranks.rank() {
            0 => PartFiles::new(Some(Box::leak(Box::new(ranks))), folder, place(number)),
            _ => PartFiles::following(Some(Box::leak(Box::new(ranks)))),
        };
        std::thread::spawn(move || {
            let own = bytes_of(files.ranks.rank());
            let _ = files.write(&mut |sink| sink.put(&own));
            (files.sums, files.trouble)
        })
    });
    let ranks: Vec<_> = ranks.collect();
    ranks.into_iter().map(|rank| rank.join().unwrap()).collect()
}

/// A manifest of parts that were written.
fn manifest(folder: &Path, number: u64, sums: Option<Vec<u64>>) -> PathBuf {
    let ranks = channels::ranks(3).swap_remove(0);
    let mut files = PartFiles::new(Some(Box::leak(Box::new(ranks))), folder, place(number));
    files.sums = sums;
    let slot = folder.join("state.1");
    Sealed::write(&slot, &folder.join(PART), &mut |file| {
        file.put(b"what is remembered")?;
        files.seal(file)
    })
    .unwrap();
    slot
}

#[test]
fn every_part_is_read_and_every_damage_found() {
    let folder = fresh("read");
    let sums = written(&folder, 7).swap_remove(0).0.unwrap();
    let slot = manifest(&folder, 7, Some(sums.clone()));
    let cut = Cut::try_from(CUT).unwrap();
    assert!(are_whole(&slot, 7, cut).unwrap());
    assert!(!are_whole(&slot, 6, cut).unwrap(), "there are no such parts");
    assert_eq!(super::sums(&slot, Some(cut)).unwrap(), Some(sums.clone()));
    let read = Place {
        cut: Some(cut),
        sums,
        ..place(7)
    };
    let mut files = PartFiles::new(None, &folder, read.clone());
    files
        .read(&mut |saved| {
            for rank in [2, 0, 1] {
                let expected = bytes_of(rank);
                // Backwards, too.
                for begin in [expected.len() - 9, 100, 4000] {
                    let mut bytes = [0; 9];
                    saved.take(rank, begin as u64, &mut bytes).unwrap();
                    assert_eq!(bytes, expected[begin..begin + 9]);
                }
            }
            let after = bytes_of(0).len() as u64;
            assert_eq!(saved.take(0, after, &mut [0; 9]), Err(Refused));
            Err(SavedError::Refused)
        })
        .unwrap_err();
    assert!(files.trouble.unwrap().starts_with("cannot read "));
    for rank in 0..3 {
        let path = part_at(&folder, 7, rank);
        let whole = fs::read(&path).unwrap();
        let mut changed = whole.clone();
        changed[2000] ^= 4;
        for damaged in [&changed, &whole[..whole.len() - 1].to_vec()] {
            fs::write(&path, damaged).unwrap();
            assert!(!are_whole(&slot, 7, cut).unwrap(), "rank {rank}");
        }
        fs::remove_file(&path).unwrap();
        assert!(!are_whole(&slot, 7, cut).unwrap(), "rank {rank} is gone");
        fs::write(&path, whole).unwrap();
    }
    // Whole, but of another state.
    fs::copy(part_at(&folder, 7, 0), part_at(&folder, 7, 1)).unwrap();
    assert!(!are_whole(&slot, 7, cut).unwrap());
    let mut files = PartFiles::new(None, &folder, read);
    let taken = files.read(&mut |saved| {
        let taken = saved.take(1, 0, &mut [0]);
        taken.map_err(|Refused| SavedError::Refused)
    });
    assert_eq!(taken, Err(SavedError::Refused));
    assert!(
        files
            .trouble
            .unwrap()
            .ends_with("it is not what the first rank sees there")
    );
    // Between two windows a state has no parts.
    assert!(are_whole(&manifest(&folder, 8, None), 8, cut).unwrap());
    let mut remembered = [0; 18];
    Unsealed::open(&slot)
        .unwrap()
        .unwrap()
        .take(&mut remembered)
        .unwrap();
    assert_eq!(&remembered, b"what is remembered");
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn parts_that_are_not_needed_go() {
    let folder = fresh("clean");
    for number in 4..7 {
        written(&folder, number);
    }
    fs::write(folder.join("state.9.2.part"), b"of a run that was killed").unwrap();
    fs::write(folder.join(format!("state.{}.0", u64::MAX)), b"of nobody").unwrap();
    fs::write(folder.join("density"), b"of windows").unwrap();
    clean(&folder, 6);
    let mut left: Vec<_> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.sort();
    let numbers = [5, 6].map(|number| [0, 1, 2].map(|rank| format!("state.{number}.{rank}")));
    assert_eq!(left, [&["density".to_owned()], numbers.as_flattened()].concat());
    fs::remove_dir_all(&folder).unwrap();
}

/// What goes wrong in one rank all hear, and in which.
#[test]
fn a_rank_that_cannot_write_is_named() {
    let folder = fresh("trouble");
    fs::create_dir(part_at(&folder, 1, 2)).unwrap();
    for (sums, trouble) in written(&folder, 1) {
        let trouble = trouble.unwrap();
        assert!(
            sums.is_none() && trouble.starts_with("rank 2: cannot write "),
            "{trouble}"
        );
    }
    for (_, trouble) in written(&folder.join("elsewhere"), 1) {
        let trouble = trouble.unwrap();
        assert!(trouble.contains("is not seen from this machine"), "{trouble}");
    }
    fs::remove_dir_all(&folder).unwrap();
}

/// All parts are as long as the longest.
#[test]
fn parts_take_more_than_the_whole() {
    let cut = |ranks, beside| Cut::try_from([ranks, beside]).unwrap();
    assert_eq!(cut(4, 1).parts_bytes(1000, &[8, 8, 16]), 1000);
    assert_eq!(cut(8, 1).parts_bytes(1700, &[8, 8, 17]), 2400);
    assert_eq!(cut(4, 2).parts_bytes(2500, &[8, 5, 5]), 3600);
    assert!(Cut::try_from([6, 4]).is_err() && Cut::try_from([1, 1]).is_err());
}
