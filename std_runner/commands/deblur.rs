//! `thurible deblur IMAGE --psf X`: a sharp image from a blurred one.

use super::options::Overwriting;
use super::words::one_of;
use crate::bytes;
use crate::deblur::{Light, Request, restore};
use crate::exit::Failure;
use crate::problem::Precision;
use crate::progress::Mode;
use clap::Args;
use std::path::PathBuf;
use thurible_core::Named;
use thurible_core::deblur::{ImagePrior, Moves, Restorer, Tuning};

/// Iterations after which primal-dual is near the optimum that the walk is judged by.
const TO_THE_OPTIMUM: usize = 1000;

/// Arguments of `deblur`.
#[derive(Args, Debug)]
pub struct DeblurArguments {
    /// The image: a picture (.png, .jpg, .tif, .webp), .npy, or .npz with an array `image`.
    pub image: PathBuf,
    /// What blurred it: disc:RADIUS, motion:LENGTH,DEGREES, gaussian:SIGMA, a .png or .npy of the kernel, or a .npz with `kernels` and `index`.
    #[arg(long, value_name = "X")]
    pub psf: String,
    /// The result folder.
    #[arg(short, long, value_name = "DIR", default_value = "out/deblur")]
    pub output: PathBuf,
    /// The walk, or a baseline: richardson_lucy, wiener, primal_dual.
    #[arg(long, value_name = "M", default_value = "walk", value_parser = one_of::<Restorer>(), hide_possible_values = true)]
    pub method: Restorer,
    /// What is charged: none, tv, atv, mtv, sparse, gamma or clusters [default: tv; of primal_dual atv, its only one].
    #[arg(long, value_name = "P", value_parser = one_of::<ImagePrior>(), hide_possible_values = true)]
    pub prior: Option<ImagePrior>,
    /// How much of it; of wiener the noise [default: 3e-4; of sparse and gamma 1e-4; of wiener 3e-3].
    #[arg(long, value_name = "X")]
    pub gamma: Option<f64>,
    /// Leave out pixels of at least this.
    #[arg(long, value_name = "LEVEL", num_args = 0..=1, default_missing_value = "1.0")]
    pub saturation: Option<f64>,
    /// Let pixels fall below 0.
    #[arg(long)]
    pub signed: bool,
    /// Mutations for each pixel and channel.
    #[arg(long, value_name = "N", default_value_t = Tuning::default().budget)]
    pub budget: f64,
    /// What a mutation changes: pixel, or patch: a rectangle of 1, 2, 4 or 8 pixels a side, which comes nearer to the optimum.
    #[arg(long = "move", value_name = "M", default_value = "pixel", value_parser = one_of::<Moves>(), hide_possible_values = true)]
    pub moves: Moves,
    /// Standard deviation of a mutation, in widths of the kernel.
    #[arg(long, value_name = "X", default_value_t = Tuning::default().sigma)]
    pub sigma: f64,
    /// By how much the first chain changes a pixel.
    #[arg(long, value_name = "X", default_value_t = Tuning::default().eps)]
    pub eps: f64,
    /// By what that is multiplied after a chain that recorded too little.
    #[arg(long, value_name = "X", default_value_t = Tuning::default().tau)]
    pub tau: f64,
    /// How small it gets.
    #[arg(long, value_name = "X", default_value_t = Tuning::default().eps_min)]
    pub eps_min: f64,
    /// Colours of the prior clusters.
    #[arg(long, value_name = "K", default_value_t = Tuning::default().colours)]
    pub colours: usize,
    /// What distance from them costs, in gamma.
    #[arg(long, value_name = "X", default_value_t = Tuning::default().mu)]
    pub mu: f64,
    /// Iterations of a baseline [default: 30; of primal_dual 1000].
    #[arg(long, value_name = "N")]
    pub iterations: Option<usize>,
    /// Which random numbers.
    #[arg(long, value_name = "N", default_value_t = Tuning::default().seed)]
    pub seed: u64,
    /// How the image stores light [default: srgb of .png, linear of arrays].
    #[arg(long, value_enum)]
    pub light: Option<Light>,
    /// The sharp image, to be compared with.
    #[arg(long, value_name = "FILE")]
    pub truth: Option<PathBuf>,
    /// Precision of all numbers.
    #[arg(long, value_enum, default_value_t = Precision::F32)]
    pub precision: Precision,
    /// Ceiling for the one block of memory, as in 1GiB [default: the machine's memory].
    #[arg(long, value_name = "SIZE", value_parser = bytes::parse)]
    pub memory_limit: Option<usize>,
    /// Print the memory that it takes, to the byte, and stop.
    #[arg(long)]
    pub plan: bool,
    /// What becomes of a result that is there.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Print nothing but errors.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// Print JSON lines.
    #[arg(long)]
    pub json: bool,
    /// The options that the command line names.
    #[arg(skip)]
    pub chosen: Vec<String>,
}

/// Restores the image; the answer is the exit code.
pub fn run(arguments: &DeblurArguments) -> Result<u8, Failure> {
    if !arguments.plan {
        arguments.overwriting.check(&arguments.output)?;
    }
    let prior = prior(arguments)?;
    refuse_idle(arguments, prior)?;
    let whole = matches!(arguments.method, Restorer::RichardsonLucy | Restorer::Wiener);
    if whole && arguments.saturation.is_some() {
        return Err(Failure::Input(format!(
            "--saturation: {} takes every pixel; leave it out, or take --method walk or primal_dual",
            arguments.method.name()
        )));
    }
    let iterations = match arguments.method {
        Restorer::PrimalDual => TO_THE_OPTIMUM,
        _ => Tuning::default().iterations,
    };
    let default = match (arguments.method, prior) {
        (Restorer::Wiener, _) => 3e-3,
        (_, ImagePrior::Sparse | ImagePrior::Gamma) => 1e-4,
        _ => Tuning::default().gamma,
    };
    restore(&Request {
        image: arguments.image.clone(),
        psf: arguments.psf.clone(),
        light: arguments.light,
        truth: arguments.truth.clone(),
        folder: arguments.output.clone(),
        tuning: Tuning {
            method: arguments.method,
            prior,
            gamma: arguments.gamma.unwrap_or(default),
            nonnegative: !arguments.signed,
            saturation: arguments.saturation,
            moves: arguments.moves,
            sigma: arguments.sigma,
            budget: arguments.budget,
            eps: arguments.eps,
            tau: arguments.tau,
            eps_min: arguments.eps_min,
            colours: arguments.colours,
            mu: arguments.mu,
            iterations: arguments.iterations.unwrap_or(iterations),
            seed: arguments.seed,
        },
        precision: arguments.precision,
        limit: arguments.memory_limit,
        plan: arguments.plan,
        mode: match (arguments.quiet, arguments.json) {
            (true, _) => Mode::Quiet,
            (_, true) => Mode::Json,
            _ => Mode::Human,
        },
    })
}

/// Refuses an option that the method, or the prior, does not know.
fn refuse_idle(arguments: &DeblurArguments, prior: ImagePrior) -> Result<(), Failure> {
    let method = arguments.method;
    let walk = method == Restorer::Walk;
    let clusters = walk && prior == ImagePrior::Clusters;
    let signed = walk || method == Restorer::PrimalDual;
    let of_the_walk = ["budget", "move", "sigma", "eps", "tau", "eps-min", "seed"];
    let of_the_walk = of_the_walk.map(|name| (name, walk, "the walk", "--method walk"));
    let others = [
        ("colours", clusters, "the prior clusters", "--prior clusters"),
        ("mu", clusters, "the prior clusters", "--prior clusters"),
        ("iterations", !walk, "the baselines", "--budget"),
        (
            "gamma",
            method != Restorer::RichardsonLucy,
            "what charges or has noise",
            "another --method",
        ),
        (
            "signed",
            signed,
            "the walk and primal_dual",
            "one of these as --method",
        ),
    ];
    let idle = |&(name, matters, ..): &(&str, bool, &str, &str)| {
        !matters && arguments.chosen.iter().any(|chosen| chosen == name)
    };
    match of_the_walk.into_iter().chain(others).find(idle) {
        Some((name, _, of, instead)) => Err(Failure::Input(format!(
            "--{name} is of {of}, and does nothing here; leave it out, or take {instead}"
        ))),
        None => Ok(()),
    }
}

/// The prior that is asked for; the convex optimum that the walk is judged by is that of `atv`.
fn prior(arguments: &DeblurArguments) -> Result<ImagePrior, Failure> {
    match (arguments.method, arguments.prior) {
        (Restorer::PrimalDual, None | Some(ImagePrior::Atv)) => Ok(ImagePrior::Atv),
        (Restorer::PrimalDual, Some(other)) => Err(Failure::Input(format!(
            "--prior {}: primal_dual knows atv alone; leave it out, or take --method walk",
            other.name()
        ))),
        (method @ (Restorer::RichardsonLucy | Restorer::Wiener), Some(_)) => Err(Failure::Input(format!(
            "--prior: {} knows none; leave it out, or take --method walk",
            method.name()
        ))),
        (_, asked) => Ok(asked.unwrap_or_default()),
    }
}
