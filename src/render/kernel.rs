//! The forms of the code that takes samples.
//!
//! It is compiled once for each form, and chosen once for a render; all forms give the same picture. There are as few as pay: what a
//! scene does not need is left out by the [`Plan`](super::plan::Plan) while the code runs, as code that lacks lens, shadows, mirrors
//! and glass was measured to gain less than 2 % by it. Only what is kept of every sample makes a difference, and textures, which are
//! looked up at every surface.

use std::marker::PhantomData;

use super::layers::{AllParts, NoParts, Parts};
use super::run::RayCounts;
use super::tally::{Tally, WorkTally};
use super::texturing::{Textured, Texturing};

/// A form of the code that takes samples.
pub trait Kernel {
    /// What it keeps of a sample beside its radiance.
    type Parts: Parts;
    /// What it keeps of rays and random numbers.
    type Tally: Tally;
    /// What it knows of textures.
    type Texturing: Texturing;
}

/// Takes samples for a picture.
pub struct Plain<T>(PhantomData<T>);

/// Takes samples for a picture and its layers.
pub struct Layered<T>(PhantomData<T>);

/// Tells what a sample takes: for whoever wants to know about single ones.
pub enum Watched {}

impl<T: Texturing> Kernel for Plain<T> {
    type Parts = NoParts;
    type Tally = RayCounts;
    type Texturing = T;
}

impl<T: Texturing> Kernel for Layered<T> {
    type Parts = AllParts;
    type Tally = RayCounts;
    type Texturing = T;
}

impl Kernel for Watched {
    type Parts = NoParts;
    type Tally = WorkTally;
    type Texturing = Textured;
}
