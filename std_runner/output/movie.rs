//! Films: made by ffmpeg where there is one, or animated WebP.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use super::OutputError;
use super::picture::Picture;
use super::webp::Animated;

const PROGRAM: &str = "ffmpeg";

/// A film that is being written.
pub(crate) enum Movie {
    /// By ffmpeg.
    Encoded(Encoded),
    /// As WebP.
    Animated(Animated),
}

impl Movie {
    /// Whether there is an ffmpeg on the PATH.
    pub fn can_be_made() -> bool {
        let mut asked = Command::new(PROGRAM);
        asked.arg("-version").stdin(Stdio::null());
        let asked = asked.stdout(Stdio::null()).stderr(Stdio::null()).status();
        asked.is_ok_and(|ended| ended.success())
    }

    /// A film of pictures of this width and height, `pace` a second, of the kind that the ending of its name says.
    pub fn begin(path: &Path, size: [usize; 2], pace: f64) -> Result<Self, OutputError> {
        if path.extension().is_some_and(|ending| ending == "webp") {
            Animated::begin(path, size, pace).map(Self::Animated)
        } else {
            Encoded::begin(path, size, pace).map(Self::Encoded)
        }
    }

    /// Appends a picture in colours.
    pub fn push(&mut self, picture: &Picture) -> Result<(), OutputError> {
        match self {
            Self::Encoded(film) => film.push(picture),
            Self::Animated(film) => film.push(picture),
        }
    }

    /// Ends the film.
    pub fn finish(self) -> Result<(), OutputError> {
        match self {
            Self::Encoded(film) => film.finish(),
            Self::Animated(film) => film.finish(),
        }
    }
}

/// One that ffmpeg encodes.
pub(crate) struct Encoded {
    encoder: Child,
    path: PathBuf,
}

impl Encoded {
    /// A film of pictures of `width` by `height`, `pace` a second; H.264 has even sides, so a line or column more may be black.
    fn begin(path: &Path, [width, height]: [usize; 2], pace: f64) -> Result<Self, OutputError> {
        let size = format!("{width}x{height}");
        let mut encoder = Command::new(PROGRAM);
        encoder
            .args(["-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"])
            .args(["-s", &size, "-r", &pace.to_string(), "-i", "-", "-an"])
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264"])
            .args(["-crf", "16", "-pix_fmt", "yuv420p", "-movflags", "+faststart"])
            .arg(path)
            .stdin(Stdio::piped())
            .stdout(Stdio::null());
        // Ctrl-C is for this program, which ends the film with the pictures so far.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut encoder, 0);
        let encoder = encoder.spawn().map_err(OutputError::of(path))?;
        Ok(Self {
            encoder,
            path: path.to_owned(),
        })
    }

    /// Appends a picture in colours.
    fn push(&mut self, picture: &Picture) -> Result<(), OutputError> {
        let pipe = self.encoder.stdin.as_mut();
        let pipe = pipe.ok_or_else(|| io::Error::other("ffmpeg takes no pictures"));
        pipe.and_then(|pipe| pipe.write_all(&picture.bytes))
            .map_err(OutputError::of(&self.path))
    }

    /// Ends the film.
    fn finish(mut self) -> Result<(), OutputError> {
        drop(self.encoder.stdin.take());
        let ended = self.encoder.wait().and_then(|ended| {
            if ended.success() {
                Ok(())
            } else {
                Err(io::Error::other(format!("ffmpeg ended with {ended}")))
            }
        });
        ended.map_err(OutputError::of(&self.path))
    }
}
