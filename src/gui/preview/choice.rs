//! What is drawn of a scene so that a frame has no more than so many triangles.
//!
//! What is out of sight is left out. Where the rest is too much, everything is drawn as coarsely as needed for it to look the same but for
//! details of half a pixel, or where that is still too much of larger and larger ones; and where there are more copies than that helps
//! with, some of them.

use std::ops::Range;

use super::ball::Ball;
use crate::math::{DVec3, ScaledRotation, SceneFrame};
use crate::scene::{Camera, Move};

/// The finest details that are left out, in pixels.
const FINEST: f64 = 0.5;
/// How much larger what is left out becomes from one attempt to the next.
const STEP: f64 = 1.5;
/// The coarsest.
const COARSEST: f64 = 64.0;
/// What is nearer, in radii of the ball it is in, counts as that far away.
const NEAREST: f64 = 0.25;
/// Levels with fewer triangles are drawn as a whole, all blocks at once.
const WHOLE: usize = 4096;

/// What there is to draw, as far as a choice needs it.
#[derive(Debug, Default)]
pub struct Stock {
    /// What objects are made of.
    pub parts: Vec<Part>,
    /// The objects in the order of the scene.
    pub objects: Vec<Placed>,
}

/// Triangles at several levels of detail.
#[derive(Debug)]
pub struct Part {
    /// The finest first. All have as many blocks.
    pub levels: Vec<Grain>,
    /// Balls around the blocks, in the coordinates of the triangles.
    pub blocks: Vec<Ball>,
    /// One around all.
    pub ball: Ball,
}

/// How coarse a level is.
#[derive(Debug)]
pub struct Grain {
    /// What is smaller is left out, in the units of the triangles.
    pub cell: f64,
    /// Where each block begins among the triangles, and where the last one ends.
    pub starts: Vec<usize>,
}

/// Where the copies of an object are.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Number of its part.
    pub part: usize,
    /// From the part's directions to those of the prepared scene.
    pub turn: ScaledRotation,
    /// Copies that are near each other.
    pub groups: Vec<Group>,
}

/// Copies that are near each other.
#[derive(Clone, Debug)]
pub struct Group {
    /// Their places among all.
    pub places: Range<u32>,
    /// A ball around their places.
    pub ball: Ball,
}

/// Some copies of some blocks of an object, at a level of detail.
#[derive(Clone, Debug, PartialEq)]
pub struct Pick {
    /// Number of the object.
    pub object: usize,
    /// Number of the level of its part.
    pub level: usize,
    /// Numbers of the blocks.
    pub blocks: Range<usize>,
    /// Places of the copies among all.
    pub places: Range<u32>,
}

/// What is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choice {
    /// All of it.
    pub picks: Vec<Pick>,
    /// How many triangles that is.
    pub triangles: u64,
    /// What is left out.
    pub omission: Omission,
}

/// What is left out of what is in sight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Omission {
    /// Details smaller than this, in pixels; 0 where none are.
    pub pixels: f64,
    /// Of how many copies one is drawn; 1 or less where all are.
    pub copies: u32,
}

impl Omission {
    /// Whether anything is left out.
    #[must_use]
    pub fn is_any(&self) -> bool {
        self.pixels > 0.0 || self.copies > 1
    }
}

/// From where a scene is seen.
#[derive(Clone, Debug)]
pub struct Sight {
    eye: DVec3,
    forward: DVec3,
    /// Inward normals of the sides of what is seen.
    sides: [DVec3; 4],
    /// How many pixels something as wide as it is far away has.
    pixels: f64,
}

impl Sight {
    /// What `camera` sees of the scene prepared with `frame` in a picture whose sides are as `ratio` (width to height), `height` pixels high.
    /// `None` where the camera is none.
    #[must_use]
    pub fn new(camera: &Camera, frame: &SceneFrame, ratio: f64, height: f64) -> Option<Self> {
        let axes = camera.axes()?;
        let half_height = (camera.vertical_fov.radians() * 0.5).tan();
        let half_width = half_height * ratio;
        let side = |half: f64, axis: DVec3| (axes.forward * half + axis).normalize_or_zero();
        Some(Self {
            eye: frame.prepared_from_world(camera.eye),
            forward: axes.forward,
            sides: [
                side(half_width, axes.right),
                side(half_width, -axes.right),
                side(half_height, axes.up),
                side(half_height, -axes.up),
            ],
            pixels: height * 0.5 / half_height,
        })
    }

    /// Whether anything of a ball, whose middle is given relative to the eye, may be seen.
    fn sees(&self, ball: &Ball) -> bool {
        let is_inside = |normal: &DVec3| normal.dot(ball.center) >= -ball.radius;
        is_inside(&self.forward) && self.sides.iter().all(is_inside)
    }

    /// How many pixels something of size 1 in a ball has at the most. Of balls about the eye, only what is a way off counts: else all in
    /// them would keep its details, and leave nothing for what is behind.
    fn pixels_in(&self, ball: &Ball) -> f64 {
        let nearest = ball.center.length() - ball.radius;
        self.pixels / nearest.max(ball.radius * NEAREST)
    }
}

impl Stock {
    /// Everything in all detail.
    #[must_use]
    pub fn all(&self) -> Vec<Pick> {
        let objects = self.objects.iter().enumerate();
        let picks = objects.filter_map(|(object, placed)| {
            let (first, last) = (placed.groups.first()?, placed.groups.last()?);
            Some(Pick {
                object,
                level: 0,
                blocks: 0..self.parts[placed.part].blocks.len(),
                places: first.places.start..last.places.end,
            })
        });
        picks.collect()
    }

    /// What to draw of what `sight` sees so that there are no more than `most` triangles, if that can be. `moves`: what happened to each object
    /// since; those beyond the end stay. `camera_eye`: in the world, of `frame`.
    #[must_use]
    pub fn choose(
        &self,
        sight: &Sight,
        (camera_eye, frame): (DVec3, &SceneFrame),
        moves: &[Option<Move>],
        most: u64,
    ) -> Choice {
        let move_of = |object: usize| {
            let moved = moves.get(object).copied().flatten();
            moved.map(|moved| moved.seen_from(camera_eye, frame))
        };
        let moves: Vec<_> = (0..self.objects.len()).map(move_of).collect();
        let mut choosing = Choosing {
            stock: self,
            sight,
            moves: &moves,
            pixels: 0.0,
            one_of: 1,
            picks: Vec::new(),
            triangles: 0,
            copies: [0; 2],
        };
        choosing.choose();
        let mut pixels = FINEST;
        while choosing.triangles > most && pixels <= COARSEST {
            choosing.pixels = pixels;
            choosing.choose();
            pixels *= STEP;
        }
        if choosing.triangles > most {
            choosing.one_of = choosing.triangles.div_ceil(most.max(1));
            choosing.choose();
        }
        let [seen, drawn] = choosing.copies;
        Choice {
            picks: choosing.picks,
            triangles: choosing.triangles,
            omission: Omission {
                pixels: choosing.pixels,
                copies: u32::try_from(seen / drawn.max(1)).unwrap_or(u32::MAX),
            },
        }
    }
}

/// A choice that is being made.
struct Choosing<'a> {
    stock: &'a Stock,
    sight: &'a Sight,
    /// For each object, a turn about the eye and what is added to it.
    moves: &'a [Option<(ScaledRotation, DVec3)>],
    /// Details smaller than this may be left out, in pixels.
    pixels: f64,
    /// Of how many copies that are near each other one is drawn.
    one_of: u64,
    picks: Vec<Pick>,
    triangles: u64,
    /// How many copies are in sight, and how many of them are drawn.
    copies: [u64; 2],
}

impl Choosing<'_> {
    fn choose(&mut self) {
        self.picks.clear();
        (self.triangles, self.copies) = (0, [0; 2]);
        for (object, placed) in self.stock.objects.iter().enumerate() {
            let part = &self.stock.parts[placed.part];
            for group in &placed.groups {
                self.choose_group(object, placed, part, group);
            }
        }
    }

    fn choose_group(&mut self, object: usize, placed: &Placed, part: &Part, group: &Group) {
        let seen = |ball: &Ball| self.seen(object, placed, group, *ball);
        let whole = seen(&part.ball);
        if !self.sight.sees(&whole) {
            return;
        }
        let Range { start, end } = group.places;
        let count = u64::from(end - start);
        let kept = count.div_ceil(self.one_of);
        self.copies[0] += count;
        self.copies[1] += kept;
        // No more than there are.
        let end = start + u32::try_from(kept).unwrap_or(u32::MAX);
        let level = self.level_for(part, placed, &whole, object);
        let block_count = part.blocks.len();
        if block_count == 1 || part.levels[level].triangles(0..block_count) < WHOLE {
            self.add(part, object, level, 0..block_count, start..end);
            return;
        }
        for (number, block) in part.blocks.iter().enumerate() {
            let ball = self.seen(object, placed, group, *block);
            if self.sight.sees(&ball) {
                let level = self.level_for(part, placed, &ball, object);
                self.add(part, object, level, number..number + 1, start..end);
            }
        }
    }

    /// A ball around what is in `ball` in all copies of a group, relative to the eye.
    fn seen(&self, object: usize, placed: &Placed, group: &Group, ball: Ball) -> Ball {
        let ball = ball
            .moved(&placed.turn, -self.sight.eye)
            .at_places(&group.ball);
        match &self.moves[object] {
            Some((turn, shift)) => ball.moved(turn, *shift),
            None => ball,
        }
    }

    /// The coarsest level that leaves out nothing larger than it may in `ball`.
    fn level_for(&self, part: &Part, placed: &Placed, ball: &Ball, object: usize) -> usize {
        let moved = self.moves[object].as_ref();
        let scale = placed.turn.scale() * moved.map_or(1.0, |(turn, _)| turn.scale());
        let pixels = self.sight.pixels_in(ball) * scale;
        let is_fine = |grain: &Grain| grain.cell == 0.0 || grain.cell * pixels <= self.pixels;
        part.levels.iter().rposition(is_fine).unwrap_or(0)
    }

    fn add(
        &mut self,
        part: &Part,
        object: usize,
        level: usize,
        blocks: Range<usize>,
        places: Range<u32>,
    ) {
        let triangles = part.levels[level].triangles(blocks.clone());
        if triangles == 0 {
            return;
        }
        self.triangles += triangles as u64 * u64::from(places.end - places.start);
        // What follows the last pick is drawn with it.
        if let Some(last) = self.picks.last_mut()
            && (last.object, last.level) == (object, level)
        {
            if last.blocks == blocks && last.places.end == places.start {
                last.places.end = places.end;
                return;
            }
            if last.places == places && last.blocks.end == blocks.start {
                last.blocks.end = blocks.end;
                return;
            }
        }
        self.picks.push(Pick {
            object,
            level,
            blocks,
            places,
        });
    }
}

impl Grain {
    /// How many triangles blocks have.
    fn triangles(&self, blocks: Range<usize>) -> usize {
        self.starts[blocks.end] - self.starts[blocks.start]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Bounds, DBounds, DMat3, Vec3};

    /// A part of two levels, of 1000 triangles and 10, a unit wide.
    fn part() -> Part {
        let unit = Bounds {
            min: Vec3::splat(-0.5),
            max: Vec3::splat(0.5),
        };
        let ball = Ball::around(&unit);
        let grain = |cell, count| Grain {
            cell,
            starts: vec![0, count],
        };
        Part {
            levels: vec![grain(0.0, 1000), grain(0.1, 10)],
            blocks: vec![ball],
            ball,
        }
    }

    /// One object with copies, a group for each place.
    fn stock(places: &[DVec3]) -> Stock {
        let group = |(number, &center): (u32, &DVec3)| Group {
            places: number..number + 1,
            ball: Ball {
                center,
                radius: 0.0,
            },
        };
        Stock {
            parts: vec![part()],
            objects: vec![Placed {
                part: 0,
                turn: ScaledRotation::new(DMat3::IDENTITY),
                groups: (0..).zip(places).map(group).collect(),
            }],
        }
    }

    /// Looks along y from the origin in a square picture of 100 pixels, 90 degrees wide.
    fn choose(stock: &Stock, moves: &[Option<Move>], most: u64) -> Choice {
        let camera = Camera {
            eye: DVec3::ZERO,
            target: DVec3::Y,
            vertical_fov: crate::math::Degrees(90.0),
            ..Camera::default()
        };
        // Lengths are those of the world.
        let frame = SceneFrame::around(&DBounds {
            min: DVec3::splat(-0.5),
            max: DVec3::splat(0.5),
        });
        let sight = Sight::new(&camera, &frame, 1.0, 100.0).unwrap();
        assert_eq!(frame.scale(), 1.0);
        stock.choose(&sight, (camera.eye, &frame), moves, most)
    }

    #[test]
    fn what_is_out_of_sight_is_left_out_and_nothing_else() {
        let seen = DVec3::new(0.0, 10.0, 0.0);
        // Just within the right side and just beyond: the ball has a radius of √0.75, and the side leans by 45°.
        let reach = 0.75_f64.sqrt() * 2.0_f64.sqrt();
        let [inside, outside] = [0.99, 1.01].map(|x| DVec3::new(10.0 + x * reach, 10.0, 0.0));
        let behind = DVec3::new(0.0, -0.9, 0.0);
        let choice = choose(&stock(&[behind, seen, inside, outside]), &[], 1 << 20);
        assert_eq!(choice.triangles, 2000);
        assert!(!choice.omission.is_any());
        let [pick] = &*choice.picks else {
            panic!("{choice:?}")
        };
        assert_eq!(pick.places, 1..3);
    }

    #[test]
    fn what_is_far_is_coarse_where_all_would_be_too_much() {
        let [near, far] = [5.0, 40.0].map(|y| DVec3::new(0.0, y, 0.0));
        let both = stock(&[near, far]);
        assert_eq!(choose(&both, &[], 2000).triangles, 2000);
        // A cell of 0.1 is 50 · 0.1 / distance pixels wide: less than half of one beyond a distance of 10.
        let choice = choose(&both, &[], 1999);
        assert_eq!((choice.triangles, choice.omission.pixels), (1010, FINEST));
        let choice = choose(&both, &[], 1000);
        // The nearer one has a cell of one pixel and a fifth, as its ball begins at 4.13.
        let enough = FINEST * STEP.powi(3);
        assert_eq!((choice.triangles, choice.omission.pixels), (20, enough));
        assert_eq!(choice.omission.copies, 1);
    }

    #[test]
    fn what_is_about_the_eye_may_be_coarse_too() {
        let about = stock(&[DVec3::new(0.0, 0.5, 0.0)]);
        assert_eq!(choose(&about, &[], 1000).triangles, 1000);
        // A cell of 0.1 a quarter of a radius of √0.75 away has 23 pixels.
        let choice = choose(&about, &[], 999);
        let enough = FINEST * STEP.powi(10);
        assert_eq!((choice.triangles, choice.omission.pixels), (10, enough));
    }

    #[test]
    fn copies_are_left_out_where_even_the_coarsest_are_too_many() {
        let mut many = stock(&[]);
        many.objects[0].groups.push(Group {
            places: 0..1000,
            ball: Ball {
                center: DVec3::new(0.0, 100.0, 0.0),
                radius: 1.0,
            },
        });
        let choice = choose(&many, &[], 1000);
        assert_eq!(choice.triangles, 1000);
        assert_eq!(
            (choice.omission.copies, choice.omission.pixels),
            (10, FINEST * STEP.powi(11))
        );
        assert_eq!(choice.picks[0].places, 0..100);
    }

    #[test]
    fn what_was_moved_is_looked_for_where_it_is_now() {
        let behind = stock(&[DVec3::new(0.0, -10.0, 0.0)]);
        assert_eq!(choose(&behind, &[], 1 << 20).triangles, 0);
        let before = crate::scene::Object::default();
        let after = crate::scene::Object {
            translate: DVec3::new(0.0, 20.0, 0.0),
            ..before.clone()
        };
        let moves = [Move::between(&before, &after)];
        assert_eq!(choose(&behind, &moves, 1 << 20).triangles, 1000);
    }

    #[test]
    fn neighbours_at_one_level_are_drawn_together() {
        let places = [0.0, 1.0, 2.0, 30.0].map(|x| DVec3::new(x - 1.0, 40.0, 0.0));
        let choice = choose(&stock(&places), &[], 1999);
        assert_eq!(choice.picks.len(), 1);
        assert_eq!(choice.picks[0].places, 0..4);
        assert_eq!(choice.picks[0].level, 1);
    }
}
