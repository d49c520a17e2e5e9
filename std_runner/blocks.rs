//! How ranks cut a box: into slabs, or into blocks.

use crate::exit::Failure;
use thurible_core::Params;
use thurible_core::grid::Share;
use thurible_core::method::registry::reach;

/// Slabs are taken by up to so many ranks, with so many planes each: blocks would save fewer copies than their additional messages cost.
const FEW: usize = 8;
const THICK: usize = 8;

/// Ranks side by side along y, and along z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blocks {
    y: usize,
    z: usize,
}

/// Reads the value of `--blocks`, as in 2x4; the error says what is allowed.
pub fn parse(text: &str) -> Result<Blocks, String> {
    let numbers = text
        .split_once('x')
        .and_then(|(y, z)| Some((y.parse().ok()?, z.parse().ok()?)));
    match numbers {
        Some((y, z)) if y > 0 && z > 0 => Ok(Blocks { y, z }),
        _ => Err(format!(
            "found \"{text}\", allowed are two whole numbers from 1 on, the ranks along y and along z, as in 2x4"
        )),
    }
}

impl Blocks {
    /// Refuses blocks that are not one for each of so many ranks.
    pub(crate) fn check(self, ranks: Option<usize>) -> Result<(), Failure> {
        let Self { y, z } = self;
        let why = match ranks {
            Some(ranks) if y.checked_mul(z) == Some(ranks) => return Ok(()),
            Some(ranks) => format!("has {y} times {z} blocks, but there are {ranks} ranks; give two numbers with that product"),
            None if y.checked_mul(z) == Some(1) => return Ok(()),
            None => "is for ranks that share a scene; start `thurible-mpi` by mpirun, give `plan` the number of them by --ranks N, or leave it out".into(),
        };
        Err(Failure::Input(format!("--blocks {y}x{z} {why}")))
    }
}

/// The share of a box of so many cells that a rank has for what `params` ask for: in `blocks` where they are given, else in slabs, unless these would be
/// many or thin: then in the blocks with the fewest copies.
pub(crate) fn cut(share: Share, blocks: Option<Blocks>, cells: &[usize], params: &Params) -> Share {
    let beside = match (blocks, cells) {
        // With two axes rows are planes.
        (Some(Blocks { z: 1, .. }), &[_, _]) => 1,
        (Some(blocks), _) => blocks.y,
        (None, &[_, y, z]) if share.ranks > FEW || z < THICK * share.ranks => {
            fewest_copies([y, z], share.ranks, reach(params).unwrap_or(share.reach))
        }
        _ => 1,
    };
    share.in_blocks(beside)
}

/// How many of so many ranks are beside each other along the first of two axes, so that they have the fewest copies; 1 where the box has no such blocks.
fn fewest_copies([y, z]: [usize; 2], ranks: usize, reach: usize) -> usize {
    let held = |cells: usize, ranks: usize| {
        let copies = if ranks > 1 { 2 * reach * ranks } else { 0 };
        cells + copies
    };
    let has_room = |beside: &usize| y >= reach * beside && z >= reach * (ranks / beside);
    let pairs = (1..).take_while(|beside| beside * beside <= ranks);
    pairs
        .filter(|beside| ranks.is_multiple_of(*beside))
        .flat_map(|beside| [beside, ranks / beside])
        .filter(|beside| *beside < ranks)
        .filter(has_room)
        .min_by_key(|&beside| (held(y, beside).saturating_mul(held(z, ranks / beside)), beside))
        .unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use thurible_core::Method;

    fn beside(cells: &[usize], ranks: usize, method: Method) -> usize {
        let params = Params {
            method,
            ..Params::default()
        };
        cut(Share::new(0, ranks), None, cells, &params).beside
    }

    #[test]
    fn slabs_that_would_be_many_or_thin_are_blocks() {
        for (cells, ranks, expected) in [
            (&[64, 64, 64][..], 1, 1),
            (&[64, 64, 64], 8, 1),
            (&[64, 64, 64], 16, 4),
            (&[512, 512, 512], 8, 1),
            (&[512, 512, 512], 64, 8),
            (&[16, 64, 16], 4, 2),
            // 7 ranks are no blocks.
            (&[16, 64, 16], 7, 1),
            // One plane for each of them is none.
            (&[4, 4, 4], 64, 1),
            (&[64, 64], 16, 1),
        ] {
            assert_eq!(
                beside(cells, ranks, Method::Direct),
                expected,
                "{cells:?} on {ranks}"
            );
        }
        // Slabs of four planes are too thin for its copies.
        assert_eq!(beside(&[64, 16, 64], 16, Method::Direct), 1);
        assert_eq!(beside(&[64, 16, 64], 16, Method::Admm), 2);
    }

    #[test]
    fn blocks_are_as_many_as_ranks() {
        assert_eq!(parse("2x4"), Ok(Blocks { y: 2, z: 4 }));
        for wrong in ["", "2", "2x", "0x4", "2x4x1", "-1x2", "99999999999999999999x1"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
        let blocks = Blocks { y: 2, z: 4 };
        assert!(blocks.check(Some(8)).is_ok());
        for (ranks, said) in [(Some(6), "there are 6 ranks"), (None, "thurible-mpi")] {
            let refused = blocks.check(ranks).map_err(|error| error.to_string());
            assert!(
                refused.as_ref().is_err_and(|error| error.contains(said)),
                "{refused:?}"
            );
        }
        let many = Blocks { y: usize::MAX, z: 2 };
        assert!(many.check(Some(8)).is_err());
    }
}
