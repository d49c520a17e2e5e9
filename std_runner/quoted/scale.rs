//! The scale of a publication's grids on the command line.

use crate::plan::scaled;

/// A publication's cells along each axis, divided by 1, 2, 4 or 8.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scale {
    divisor: usize,
}

impl Scale {
    /// Reads 1, 1/2, 1/4 or 1/8; the error says what is allowed.
    pub fn parse(text: &str) -> Result<Self, String> {
        let divisor = [("1", 1), ("1/2", 2), ("1/4", 4), ("1/8", 8)]
            .into_iter()
            .find(|(name, _)| *name == text.trim());
        divisor
            .map(|(_, divisor)| Self { divisor })
            .ok_or_else(|| format!("found \"{text}\", allowed is 1, 1/2, 1/4 or 1/8; write one of these"))
    }

    /// `cells` made smaller, each a multiple of 4.
    pub fn cells(self, cells: &[usize]) -> Vec<usize> {
        scaled(cells, 1, self.divisor, 4)
    }

    /// By how much cells along an axis are fewer.
    #[must_use]
    pub fn divisor(self) -> usize {
        self.divisor
    }

    /// The scale as it is written, as in "1/4".
    pub fn name(self) -> String {
        if self.divisor == 1 {
            "1".into()
        } else {
            format!("1/{}", self.divisor)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_stay_multiples_of_four() {
        assert_eq!(
            Scale::parse("1/4").map(|scale| scale.cells(&[128, 128])),
            Ok(vec![32, 32])
        );
        assert_eq!(
            Scale::parse("1/8").map(|scale| scale.cells(&[64, 64, 32])),
            Ok(vec![8, 8, 4])
        );
        assert_eq!(Scale::parse("1").map(Scale::name), Ok("1".into()));
        assert!(
            ["", "2", "0.5", "1/3", "1/0"]
                .into_iter()
                .all(|text| Scale::parse(text).is_err())
        );
    }
}
