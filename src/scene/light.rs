//! Light sources: points with radiant intensity in W/sr, disks with radiance in W/m²/sr.

use super::Rgb;
use crate::math::{DVec3, direction_of};

/// A source of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Shines equally in all directions from one point; not seen itself.
    Point {
        /// Where it is.
        position: DVec3,
        /// Radiant intensity in W/sr: the irradiance at distance `d` is `intensity · cos θ / d²`.
        intensity: Rgb,
    },
    /// A flat disk that shines on the side its normal points to, equally in all directions; black on its back.
    Disk {
        /// Its middle.
        center: DVec3,
        /// Which way it shines.
        facing: Facing,
        /// In scene units, more than 0.
        radius: f64,
        /// Emitted radiance in W/m²/sr.
        radiance: Rgb,
        /// Whether rays meet it. Where not, only the light it gives is there.
        visible: bool,
    },
}

/// Which way a disk light shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Facing {
    /// Towards this point.
    Target(DVec3),
    /// Along this direction, of any length but 0.
    Normal(DVec3),
}

impl Facing {
    /// The unit vector along which a disk around `center` shines; `None` where there is none.
    #[must_use]
    pub fn normal(self, center: DVec3) -> Option<DVec3> {
        match self {
            Self::Target(target) => direction_of(target - center),
            Self::Normal(normal) => direction_of(normal),
        }
    }
}

impl Light {
    /// Where its middle is.
    #[must_use]
    pub fn position(&self) -> DVec3 {
        match self {
            Self::Point { position, .. } => *position,
            Self::Disk { center, .. } => *center,
        }
    }

    /// Puts its middle elsewhere.
    pub fn move_to(&mut self, place: DVec3) {
        match self {
            Self::Point { position, .. } => *position = place,
            Self::Disk { center, .. } => *center = place,
        }
    }

    /// The point it is turned towards, where it has one.
    #[must_use]
    pub fn target(&self) -> Option<DVec3> {
        match self {
            Self::Disk {
                facing: Facing::Target(target),
                ..
            } => Some(*target),
            Self::Disk { .. } | Self::Point { .. } => None,
        }
    }

    /// Turns it towards `place`, where it shines in one direction.
    pub fn turn_to(&mut self, place: DVec3) {
        if let Self::Disk { facing, .. } = self {
            *facing = Facing::Target(place);
        }
    }

    /// Its colour and strength, in the unit of its kind.
    #[must_use]
    pub fn emission(&self) -> Rgb {
        match self {
            Self::Point { intensity, .. } => *intensity,
            Self::Disk { radiance, .. } => *radiance,
        }
    }

    /// Whether it gives any light.
    #[must_use]
    pub fn shines(&self) -> bool {
        self.emission() != Rgb::ZERO
    }

    /// Whether it shines from more than one point.
    #[must_use]
    pub fn has_area(&self) -> bool {
        matches!(self, Self::Disk { .. })
    }

    /// Whether rays meet it.
    #[must_use]
    pub fn is_visible(&self) -> bool {
        matches!(self, Self::Disk { visible: true, .. })
    }

    /// A disk of radius 1 at the origin that shines down, for files that say no more.
    #[must_use]
    pub fn disk() -> Self {
        Self::Disk {
            center: DVec3::ZERO,
            facing: Facing::Normal(-DVec3::Z),
            radius: 1.0,
            radiance: Rgb::ONE,
            visible: true,
        }
    }
}

impl Default for Light {
    fn default() -> Self {
        Self::Point {
            position: DVec3::ZERO,
            intensity: Rgb::ONE,
        }
    }
}
