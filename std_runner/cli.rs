//! The command line: which commands there are. The arguments of each are defined with its body in [`commands`](crate::commands).

use crate::commands::check_gradient::CheckGradientArguments;
use crate::commands::compare::CompareArguments;
use crate::commands::completions::{CompletionsArguments, ManArguments};
use crate::commands::condense::CondenseArguments;
use crate::commands::deblur::DeblurArguments;
use crate::commands::devices::DevicesArguments;
use crate::commands::export::ExportArguments;
use crate::commands::guide::GuideArguments;
use crate::commands::new::NewArguments;
use crate::commands::paper::PaperArguments;
use crate::commands::photograph::PhotographArguments;
use crate::commands::plan::PlanArguments;
use crate::commands::readvect::ReadvectArguments;
use crate::commands::remap::RemapArguments;
use crate::commands::render::RenderArguments;
use crate::commands::resume::ResumeArguments;
use crate::commands::scene::SceneCommand;
use crate::commands::schema::SchemaArguments;
use crate::commands::simulate::SimulateArguments;
use crate::commands::solve::SolveArguments;
use crate::commands::sweep::SweepArguments;
use crate::commands::thesis::ThesisArguments;
use crate::commands::tomography::TomographyArguments;
use crate::commands::track::TrackArguments;
use crate::commands::upsample::UpsampleArguments;
use clap::{Parser, Subcommand};

/// Finds the smallest force field that makes an incompressible flow of smoke pass through keyframes.
#[derive(Debug, Parser)]
#[command(name = "thurible", version, about, arg_required_else_help = true)]
#[command(
    after_help = "Exit codes: 0 done, 1 not finite, 2 bad input or usage, 3 does not fit in memory,\n4 a file could not be read or written, 5 stalled (result written), 130 interrupted (result written)."
)]
pub struct Cli {
    /// What to do; each command has its own arguments.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands of the program.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Solve a scene and write the result folder.
    Solve(SolveArguments),
    /// Go on with a solve that was not finished, bit for bit.
    Resume(ResumeArguments),
    /// Simulate the flow of a scene without control; its keyframes and method are left out.
    Simulate(SimulateArguments),
    /// Simulate the flow of a scene, guided by that of a result.
    Guide(GuideArguments),
    /// Carry the smoke of a result again by its flow, on finer cells if asked.
    Readvect(ReadvectArguments),
    /// Take the flow of a result to finer cells, with turbulence that its own were too coarse for.
    Upsample(UpsampleArguments),
    /// Put the flow of a result among other solid cells.
    Remap(RemapArguments),
    /// Find the flow behind frames of smoke.
    Track(TrackArguments),
    /// Draw the steps of a result as large pictures, or as a film.
    Render(RenderArguments),
    /// Write a result as files that other programs open: OpenVDB, USD, VTK, Zarr, vector fields, NumPy.
    Export(ExportArguments),
    /// Print the memory that a scene needs, to the byte; allocates nothing.
    Plan(PlanArguments),
    /// List the graphics cards on which a search can go.
    Devices(DevicesArguments),
    /// Check the gradient of a scene's simulation by Taylor's test.
    ///
    /// What is checked is the simulation that lbfgs and templates search with, and that `Operator` is in Rust and Python. J is the data
    /// term of the keyframes, a plain sum of squares over cells, or that of the last density where there is none. It is differentiated by
    /// all that the simulation follows from at once: the density and the velocity at the start, the force of every step, buoyancy, and
    /// rates, targets, velocities and shapes of emitters. The point is near the scene's start, with some haze and stir, since transport has
    /// kinks at sharp edges and at rest.
    ///
    /// Of a scene of the method stable_fluids the search is checked: J is its objective, differentiated by the unknowns of its controls,
    /// the velocity at the start, forces, templates.
    ///
    /// Always in f64. The exit code is 1 where the remainder is of first order at the steps 1e-6 and 1e-7 too.
    CheckGradient(CheckGradientArguments),
    /// Look at a scene before it is solved.
    #[command(subcommand)]
    Scene(SceneCommand),
    /// Solve a scene by several methods, one after the other, and compare them on one page.
    Compare(CompareArguments),
    /// Solve a scene with every value of some keys, and put the results on one page.
    Sweep(SweepArguments),
    /// Solve the scenes of Pan & Manocha's paper and put the results beside its own.
    Paper(PaperArguments),
    /// Make the figures of Gregson's thesis on captures, photographs and images, and put them beside its own.
    Thesis(ThesisArguments),
    /// Reconstruct the density of smoke from what several cameras see of it.
    Tomography(TomographyArguments),
    /// Take photographs of a result from several sides, for tomography.
    Photograph(PhotographArguments),
    /// Restore a sharp image from a blurred one and what blurred it.
    Deblur(DeblurArguments),
    /// Minimise the energy of an elastic body by coordinate condensation, and compare it with other methods.
    Condense(CondenseArguments),
    /// Print the JSON schema of a scene, for editors.
    Schema(SchemaArguments),
    /// Write a commented scene to start from.
    New(NewArguments),
    /// Print a script by which a shell completes commands and options.
    Completions(CompletionsArguments),
    /// Write manual pages, one for each command.
    Man(ManArguments),
}
