//! Two objects with faces in the same place: how much that matters.

use super::mesh_use::is_glass;
use super::tally::Tally;
use super::{Hazard, HazardKind, Severity, Subject};
use crate::scene::{Object, Scene, SceneError};

/// Two objects, or one and a copy of it, and what the picture shows where both have a face.
pub struct Pair<'a> {
    objects: [&'a Object; 2],
    pub shows: Shows,
}

/// What is seen where two faces are in the same place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shows {
    /// Light bent by one of them only, where it should be by both.
    Glass,
    /// The same, whichever face is met.
    Alike,
    /// One of them or the other.
    Either,
}

impl<'a> Pair<'a> {
    /// The objects of these numbers.
    ///
    /// # Errors
    /// Materials that are not there.
    pub fn of(scene: &'a Scene, numbers: [usize; 2]) -> Result<Self, SceneError> {
        let objects = numbers.map(|number| &scene.objects[number]);
        let [a, b] = objects;
        let shows = if is_glass(scene, a)? || is_glass(scene, b)? {
            Shows::Glass
        } else if scene.material_of(a)? == scene.material_of(b)? {
            Shows::Alike
        } else {
            Shows::Either
        };
        Ok(Self { objects, shows })
    }

    /// A hazard of both with what `tally` holds: a note where the picture is right all the same.
    pub fn hazard(&self, kind: HazardKind, tally: Tally) -> Hazard {
        Hazard {
            kind,
            severity: match self.shows {
                Shows::Alike => Severity::Note,
                Shows::Glass | Shows::Either => Severity::Warning,
            },
            subject: Subject::Pair {
                objects: self.objects.map(|object| object.name.clone()),
                meshes: self.objects.map(|object| object.mesh.clone()),
            },
            count: tally.count,
            places: tally.places,
            figure: None,
            message: String::new(),
            advice: String::new(),
        }
    }
}
