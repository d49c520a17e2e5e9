//! Films: made by ffmpeg where there is one, or animated WebP.

use std::io::{self, BufRead, BufReader, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::thread::{self, JoinHandle};

use super::OutputError;
use super::picture::Picture;
use super::webp::Animated;
use crate::exit::Failure;

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

    /// Writes no more. What there is of it is nobody's.
    pub fn give_up(self) {
        if let Self::Encoded(film) = self {
            film.stop();
        }
    }
}

/// Even sides, and the colours of high definition (BT.709), which players take for granted in large pictures, and are told of in small ones.
const FILTERS: &str = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv";

/// One that ffmpeg encodes.
pub(crate) struct Encoded {
    encoder: Child,
    /// The last line that it said.
    said: Option<JoinHandle<String>>,
    path: PathBuf,
}

/// The last line of what a program says, which never has to wait to say it.
fn last_line(said: ChildStderr) -> String {
    let lines = BufReader::new(said).lines().map_while(Result::ok);
    lines
        .filter(|line| !line.trim().is_empty())
        .last()
        .unwrap_or_default()
}

impl Encoded {
    /// A film of pictures of `width` by `height`, `pace` a second; H.264 has even sides, so a line or column more may be black.
    fn begin(path: &Path, [width, height]: [usize; 2], pace: f64) -> Result<Self, OutputError> {
        let size = format!("{width}x{height}");
        let mut encoder = Command::new(PROGRAM);
        encoder
            .args(["-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"])
            .args(["-s", &size, "-r", &pace.to_string(), "-i", "-", "-an"])
            .args([
                "-vf", FILTERS, "-c:v", "libx264", "-crf", "16", "-pix_fmt", "yuv420p",
            ])
            .args([
                "-colorspace",
                "bt709",
                "-color_primaries",
                "bt709",
                "-color_trc",
                "bt709",
            ])
            .args(["-color_range", "tv", "-movflags", "+faststart"])
            .arg(path)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        // Ctrl-C is for this program, which ends the film with the pictures so far.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut encoder, 0);
        let mut encoder = encoder.spawn().map_err(OutputError::of(path))?;
        let said = encoder.stderr.take();
        Ok(Self {
            encoder,
            said: said.map(|said| thread::spawn(|| last_line(said))),
            path: path.to_owned(),
        })
    }

    /// Appends a picture in colours.
    fn push(&mut self, picture: &Picture) -> Result<(), OutputError> {
        let pipe = self.encoder.stdin.as_mut();
        let pipe = pipe.ok_or_else(|| io::Error::other("ffmpeg takes no pictures"));
        let written = pipe.and_then(|pipe| pipe.write_all(&picture.bytes));
        match written {
            // It has ended, and knows why.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => match self.end() {
                Ok(()) => Err(self.failed("before the film did")),
                failed => failed,
            },
            written => written.map_err(OutputError::of(&self.path)),
        }
    }

    /// Ends the film.
    fn finish(mut self) -> Result<(), OutputError> {
        self.end()
    }

    fn end(&mut self) -> Result<(), OutputError> {
        drop(self.encoder.stdin.take());
        let ended = self.encoder.wait().map_err(OutputError::of(&self.path))?;
        if ended.success() {
            Ok(())
        } else {
            Err(self.failed(&format!("with {ended}")))
        }
    }

    /// How it ended, and what it said.
    fn failed(&mut self, how: &str) -> OutputError {
        let said = self.said.take().and_then(|said| said.join().ok());
        let said = said.filter(|line| !line.is_empty());
        let said = said.map_or(String::new(), |line| format!(" and says: {line}"));
        OutputError::Source(Failure::File(format!(
            "--format mp4: ffmpeg ended {how}{said}; take a build of it with libx264, see that the disc has room, or write --format webp"
        )))
    }

    /// Ends the encoder, whatever it has.
    fn stop(mut self) {
        drop(self.encoder.stdin.take());
        // It is of no use any more.
        let _ = self.encoder.kill();
        let _ = self.encoder.wait();
    }
}
