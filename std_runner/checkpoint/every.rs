//! How often the state of a solve is kept.

/// `--checkpoint`
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Every {
    /// Of solves that take more than five minutes, or are expected to, once a minute; more rarely where that would cost more than a
    /// twentieth of the time.
    #[default]
    ByItself,
    /// Never.
    Off,
    /// After so many seconds.
    Seconds(f64),
    /// After so many iterations.
    Iterations(usize),
}

impl Every {
    /// Whether the user asked for it.
    pub fn is_asked_for(self) -> bool {
        matches!(self, Self::Seconds(_) | Self::Iterations(_))
    }
}

/// Reads `every=60s`, `every=5m`, `every=20` or `off`; the error says what is allowed.
pub fn parse(text: &str) -> Result<Every, String> {
    let refuse = || {
        format!(
            "found \"{text}\", allowed is every=60s, with s, m or h, every=20 for a number of iterations, or off"
        )
    };
    let plain = text.trim();
    if plain == "off" {
        return Ok(Every::Off);
    }
    let given = plain.strip_prefix("every=").unwrap_or(plain);
    let units = [("s", 1.0), ("m", 60.0), ("h", 3600.0)];
    let timed = units
        .iter()
        .find_map(|&(unit, seconds)| Some((given.strip_suffix(unit)?, seconds)));
    if let Some((number, unit)) = timed {
        let seconds = number.trim().parse::<f64>().map_err(|_| refuse())? * unit;
        return if (0.0..1e7).contains(&seconds) {
            Ok(Every::Seconds(seconds))
        } else {
            Err(refuse())
        };
    }
    match given.parse::<usize>() {
        Ok(count) if count > 0 => Ok(Every::Iterations(count)),
        _ => Err(refuse()),
    }
}

impl core::str::FromStr for Every {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        parse(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_asked_for_is_a_time_or_a_number() {
        let asked = [
            Every::ByItself,
            Every::Off,
            Every::Seconds(9.0),
            Every::Iterations(2),
        ];
        assert_eq!(asked.map(Every::is_asked_for), [false, false, true, true]);
    }

    #[test]
    fn reads_what_people_write() {
        for (text, every) in [
            ("every=60s", Every::Seconds(60.0)),
            ("every=1.5m", Every::Seconds(90.0)),
            ("2h", Every::Seconds(7200.0)),
            ("every=20", Every::Iterations(20)),
            ("off", Every::Off),
        ] {
            assert_eq!(parse(text), Ok(every), "{text}");
        }
        for text in [
            "",
            "every=",
            "every=0",
            "every=-1s",
            "every=1d",
            "often",
            "every=nans",
            "s",
        ] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
