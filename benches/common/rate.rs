//! The factor by which residuals shrink.

/// The geometric mean of the last half of the ratios between neighbours, those before the rounding floor.
///
/// The floor begins where a residual is below `floor` times the largest.
pub fn asymptotic(residuals: &[f64], floor: f64) -> f64 {
    let largest = residuals.iter().copied().fold(0.0, f64::max);
    let count = residuals.iter().take_while(|&&r| r > floor * largest).count();
    let kept = &residuals[..count];
    match kept {
        [] | [_] => f64::NAN,
        _ => {
            let from = (count - 1) / 2;
            (kept[count - 1] / kept[from]).powf(1.0 / (count - 1 - from) as f64)
        }
    }
}

/// The ratios between neighbours, in two digits.
pub fn listed(residuals: &[f64]) -> String {
    residuals
        .windows(2)
        .map(|pair| format!("{:.2}", pair[1] / pair[0]))
        .collect::<Vec<_>>()
        .join(" ")
}
